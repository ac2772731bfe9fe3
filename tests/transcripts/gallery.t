A page of spectrograms.

  $ sdp3 gallery -q --json
  [
    "out/gallery.html"
  ]

  $ sdp3 gallery --out /proc/sdp3
  sdp3: /proc/sdp3: cannot be written: No such file or directory (os error 2); --out needs a folder this user may write to
  [2]
