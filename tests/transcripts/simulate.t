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
    simulate  the antenna's far field begins at 5.5 m (2 D^2 / lambda) and people come as near as 3.4 m, where its pattern and the radar equation are approximations
    simulate  recordings
    simulate  1 parts made, 0 kept; 10 recordings in out, complete

  $ sdp3 simulate --scenario short.toml --per-class 2 --json
    simulate  the antenna's far field begins at 5.5 m (2 D^2 / lambda) and people come as near as 3.4 m, where its pattern and the radar equation are approximations
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
  error: invalid value 'fog' for '--channel <NAME>'
    [possible values: dahc, primitive, ray-tracing, statistical, 80211ay, 80211ax, 38901, quadriga, metis]
  
  For more information, try '--help'.
  [2]

  $ sdp3 simulate --classes flying
  error: invalid value 'flying' for '--classes <NAMES>'
    [possible values: standing, child-walking, child-pacing, adult-walking, adult-pacing, child-stepping, adult-stepping, child-running, adult-running, sitting-down, standing-up, falling, bending, waving, jumping]
  
    tip: a similar value exists: 'falling'
  
  For more information, try '--help'.
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

  $ sdp3 simulate --channel ray-tracng
  error: invalid value 'ray-tracng' for '--channel <NAME>'
    [possible values: dahc, primitive, ray-tracing, statistical, 80211ay, 80211ax, 38901, quadriga, metis]
  
    tip: a similar value exists: 'ray-tracing'
  
  For more information, try '--help'.
  [2]

  $ sdp3 simulate --scenario short.toml --set radar.carrier_hz=5.8e9 --set frame.slot_s=0.001 --per-class 1 --out other
    simulate  warning: limbs at 4.7 m/s alias above 3.2 m/s at this carrier and spacing; frame.spacing_slots = 1 would not
    simulate  the antenna's far field begins at 3.3 m (2 D^2 / lambda) and people come as near as 3.2 m, where its pattern and the radar equation are approximations
   calibrate  warning: rho = 0.997 is the stored one of 3.500 GHz and 1 ms between sensing slots, but the scenario has 5.800 GHz and 4 ms between sensing slots, where rho may be another: `sdp3 calibrate --measured FILE` finds it on a recording, channel.rho states it
    simulate  recordings
    simulate  1 parts made, 0 kept; 5 recordings in other, complete
