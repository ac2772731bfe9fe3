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

  $ sdp3 train --scenario small.toml --resume --seed 2

  $ sdp3 train --data nowhere

  $ sdp3 quantize -q

  $ sdp3 quantize --out nowhere

  $ sdp3 study learning-curve -q --seeds 2 --scenario small.toml --out study

  $ sdp3 study weather

  $ sdp3 study robustness --measured folder
