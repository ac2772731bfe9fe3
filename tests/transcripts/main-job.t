The main job in short, and every command about its results. Needs the feature `train`.

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

  $ sdp3 run --scenario small.toml --targets host-reference

  $ sdp3 run --scenario small.toml --targets z80

  $ sdp3 run -q --scenario small.toml --targets host-reference --resume

  $ sdp3 verify -q --targets host-reference

  $ sdp3 verify --set channel.rho=0.5

  $ sdp3 predict

  $ sdp3 optimize -q

  $ sdp3 schedule

  $ sdp3 schedule -q --periods 4 --recognise-every 2

  $ sdp3 anytime -q --calibrate-per-class 4

  $ sdp3 report

  $ sdp3 model out/models/dsn-200.sdp3

  $ sdp3 model small.toml

  $ sdp3 export out/models/dsn-200.sdp3 --to dsn.tflite

  $ sdp3 export out/models/dsn-200.sdp3 --to dsn.onnx

  $ sdp3 import -q dsn.tflite --to again.sdp3 --scenario small.toml

  $ sdp3 import small.toml --to again.sdp3

  $ sdp3 key radio

  $ sdp3 key radio

  $ sdp3 sign again.sdp3 --key radio.key --to signed.sdp3

  $ sdp3 sign again.sdp3 --key radio.pub --to other.sdp3

  $ sdp3 model signed.sdp3 --key radio.pub
