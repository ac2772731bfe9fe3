Training by steps. Needs the feature `train`.

  $ cat >small.toml <<'END'
  > name = "small"
  > [frame]
  > sensing_slots = [200, 300]
  > [learning]
  > train_per_class = 8
  > test_per_class = 4
  > windows = 2
  > epochs = 2
  > batch = 10
  > channels = 4
  > blocks = 2
  > [communication]
  > draws = 20
  > END

  $ sdp3 train -q --scenario small.toml

  $ sdp3 train -q --scenario small.toml --resume --json | head -1
  [

  $ sdp3 train -q --data nowhere
  sdp3: nowhere* (glob)
  [2]

  $ sdp3 quantize -q
  out/models/dsn-200.sdp3
  out/models/dsn-300.sdp3

  $ sdp3 quantize --out nowhere
  sdp3: nowhere/scenario.toml: No such file or directory (os error 2)
  [2]

  $ sdp3 study learning-curve -q --seeds 2 --scenario small.toml --out study >study.txt

  $ sdp3 study weather 2>&1 | head -1
  error: invalid value 'weather' for '<NAME>'

  $ sdp3 study robustness --measured folder
  sdp3: command line: --measured belongs to the studies fidelity and sim-to-real
  [2]

  $ sed '/^channels/d' small.toml >free.toml

  $ sdp3 train --scenario free.toml --out noted 2>&1 | head -3
      preset  quick: channels = 8; --preset paper takes the scenario's sizes
    expected  about * on * processors, a rough estimate: 40 recordings to train, 0 to test, 2 epochs of 80 images for each of 2 networks (glob)
    simulate  training recordings

  $ sdp3 train --preset paper --scenario free.toml --set learning.channels=8 --out paper 2>&1 | head -2
    expected  about * on * processors, a rough estimate: 40 recordings to train, 0 to test, 2 epochs of 80 images for each of 2 networks (glob)
    simulate  training recordings

  $ cmp noted/scenario.toml paper/scenario.toml

  $ cmp noted/models/dsn-200.json paper/models/dsn-200.json
