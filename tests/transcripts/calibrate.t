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
  sdp3: nothing.wav: not a readable recording file: No such file or directory (os error 2)
  [2]

  $ sdp3 calibrate --measured short.toml
  sdp3: short.toml: extension is "toml", must be WAV, CSV, NPY, NPZ, MATLAB (.mat), SigMF (.sigmf-meta), HDF5 (.h5), a folder of Infineon's radar SDK (config.json and radar.npy), Infineon's raw data (.raw.txt, .raw.bin) or a DCA1000 capture (.bin)
  [2]

  $ sdp3 calibrate --carrier 24e9
  error: the following required arguments were not provided:
    --measured <PATH>
  
  Usage: sdp3 calibrate --measured <PATH> --carrier <HZ>
  
  For more information, try '--help'.
  [2]

  $ sdp3 calibrate --measured nothing.wav --motion flying
  error: invalid value 'flying' for '--motion <CLASS>'
    [possible values: standing, child-walking, child-pacing, adult-walking, adult-pacing, child-stepping, adult-stepping, child-running, adult-running, sitting-down, standing-up, falling, bending, waving, jumping]
  
    tip: a similar value exists: 'falling'
  
  For more information, try '--help'.
  [2]
