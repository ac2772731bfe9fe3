Calibration: the stored table with its self-check, and measured signals that cannot be.

  $ cat >short.toml <<'END'
  > name = "short"
  > [frame]
  > sensing_slots = [64]
  > [spectrogram]
  > window = 32
  > hop = 8
  > END

  $ sdp3 calibrate -q

  $ sdp3 calibrate --measured nothing.wav

  $ sdp3 calibrate --measured short.toml

  $ sdp3 calibrate --carrier 24e9

  $ sdp3 calibrate --measured nothing.wav --motion flying
