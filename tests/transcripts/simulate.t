Datasets: made, complete, refused.

  $ cat >short.toml <<'END'
  > name = "short"
  > [frame]
  > sensing_slots = [64]
  > [spectrogram]
  > window = 32
  > hop = 8
  > END

  $ sdp3 simulate --scenario short.toml --per-class 2
    simulate  recordings
    simulate  1 parts made, 0 kept; 10 recordings in out, complete

  $ sdp3 simulate --scenario short.toml --per-class 2 --json
    simulate  recordings
    simulate  0 parts made, 1 kept; 10 recordings in out, complete
  {
    "recordings": 10,
    "parts": 1,
    "made": 0,
    "kept": 1,
    "manifest": "manifest.json"
  }

  $ sdp3 simulate --channel fog
  sdp3: command line: --channel is fog, must be one of dahc, primitive, ray-tracing, statistical, 80211ay, 80211ax, 38901, quadriga, metis
  [2]

  $ sdp3 simulate --classes flying
  sdp3: command line: --classes is flying, must be one of standing, child-walking, child-pacing, adult-walking, adult-pacing, child-stepping, adult-stepping, child-running, adult-running
  [2]

  $ sdp3 simulate --per-class 0
  error: invalid value '0' for '--per-class <PER_CLASS>': 0 is not in 1 to 2000000
  
  For more information, try '--help'.
  [2]

  $ sdp3 simulate --shard 4/3
  error: invalid value '4/3' for '--shard <I/N>': 4/3 is not in 1/N to N/N: the I-th of N shards, for example 2/3
  
  For more information, try '--help'.
  [2]

  $ sdp3 simulate --out /proc/sdp3
  sdp3: /proc/sdp3: cannot be written: No such file or directory (os error 2); --out needs a folder this user may write to
  [2]
