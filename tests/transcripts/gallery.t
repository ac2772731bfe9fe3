A page of spectrograms.

  $ sdp3 gallery -q

  $ sdp3 gallery -q --json

  $ sdp3 gallery --out /proc/sdp3
