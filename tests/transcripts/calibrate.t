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
  rho = * (stored table, * motion at 3.500 GHz, 1 ms: *); curve in out/calibration.json (glob)

  $ sdp3 calibrate --measured nothing.wav
  sdp3: nothing.wav: not a readable WAV file: No such file or directory (os error 2)
  [2]

  $ sdp3 calibrate --measured short.toml
  sdp3: short.toml: extension is "toml", must be .wav, .npy, .npz, .sigmf-meta, .h5
  [2]

  $ sdp3 calibrate --carrier 24e9
  error: the following required arguments were not provided:
    --measured <FILE>
  
  Usage: sdp3 calibrate --measured <FILE> --carrier <HZ>
  
  For more information, try '--help'.
  [2]

  $ sdp3 calibrate --measured nothing.wav --motion flying
  error: invalid value 'flying' for '--motion <CLASS>'
    [possible values: standing, child-walking, child-pacing, adult-walking, adult-pacing, child-stepping, adult-stepping, child-running, adult-running]
  
  For more information, try '--help'.
  [2]
