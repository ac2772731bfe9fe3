The property tests of every channel model.

  $ sdp3 channels

  $ sdp3 channels --set room.size_m=\[0,4,3\]
