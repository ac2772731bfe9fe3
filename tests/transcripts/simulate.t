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

  $ sdp3 simulate --scenario short.toml --per-class 2 --json

  $ sdp3 simulate --channel fog

  $ sdp3 simulate --classes flying

  $ sdp3 simulate --per-class 0

  $ sdp3 simulate --shard 4/3

  $ sdp3 simulate --out /proc/sdp3
