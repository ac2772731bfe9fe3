The property tests of every channel model.

  $ sdp3 channels -q | head -1
  Table I from data, 3.5 GHz, seed 1

  $ sdp3 channels --set room.size_m=\[0,4,3\]
  sdp3: command line: --set: room.size_m (x) is 0, must be 1 to 100
  [2]
