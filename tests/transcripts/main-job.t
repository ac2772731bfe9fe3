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

  $ sdp3 run -q --scenario small.toml --targets host-reference
  target              compared  mismatches    instructions
  host-reference* 0               - (glob)
  report: out/report.html

  $ sdp3 run --scenario small.toml --targets z80
  error: invalid value 'z80' for '--targets <NAMES>'
    [possible values: host-reference, cortex-m3, cortex-m4f, cortex-m7, cortex-m33, cortex-m55, riscv32imac, riscv32imafc, cortex-a53]
  
  For more information, try '--help'.
  [2]

  $ sdp3 run -q --scenario small.toml --targets host-reference --resume --json | head -2
  {
    "scenario": "small",

  $ sdp3 verify -q --targets host-reference
  target              compared  mismatches    instructions
  host-reference* 0               - (glob)

  $ sdp3 verify -q --targets host-reference --scenario small.toml
  target              compared  mismatches    instructions
  host-reference* 0               - (glob)

  $ sdp3 verify --scenario small.toml --set channel.rho=0.5
  sdp3: out/scenario.toml: channel.rho = null, but the command line says 0.5: what has been made is not changed; another --out takes another scenario
  [2]

  $ head -9 out/run.json
  {
    "provenance": {
      "program": "sdp3 0.1.0",
      "commit": "*", (glob)
      "commit_date": "*", (glob)
      "seed": 1,
      "scenario_sha256": "*", (glob)
      "sha256": "*" (glob)
    },

  $ sdp3 verify --seed 5
  sdp3: command line: --seed is 5, must be 1, the seed of run.json
  [2]

  $ sdp3 verify --set channel.rho=0.5
  sdp3: out/scenario.toml: channel.rho = null, but the command line says 0.5: what has been made is not changed; another --out takes another scenario
  [2]

  $ sdp3 predict | head -1
  model * sse * (glob)

  $ sdp3 optimize -q | head -1
  * by *, rmse * (glob)

  $ grep ^name out/optimize-scenario.toml
  name = "small"

  $ sdp3 schedule
  N = 4000: * sensing, * communication, longest waits * slots (glob)
  The people of the scenario are in the users' channels.

  $ sdp3 schedule --set frame.period_slots=8000
  sdp3: out/scenario.toml: frame.period_slots = 4000, but the command line says 8000: * (glob)
  [2]

  $ sdp3 schedule -q --periods 4 --sensing-slots 200 --recognise-every 2 | head -1
  4 periods, 16000 decisions: * sensing, * idle (glob)

  $ sdp3 schedule -q --periods 4 --sensing-slots 152 --recognise-every 2
  sdp3: command line: --sensing-slots is 152, must be at least 200, as the smallest model of --out; without the option it is that of the operating point
  [2]

  $ sdp3 early-exits -q --calibrate-per-class 4 >early-exits.txt

  $ sdp3 report
  out/report.html

  $ sdp3 model show out/models/dsn-200.sdp3 | head -1
  model file, version * (glob)

  $ sdp3 model show small.toml
  sdp3: small.toml: * (glob)
  [2]

  $ sdp3 export out/models/dsn-200.sdp3 --to dsn.tflite >export.txt

  $ sdp3 export out/models/dsn-200.sdp3 --to dsn.onnx
  sdp3: * (glob)
  [2]

  $ sdp3 import -q dsn.tflite --to again.sdp3 --scenario small.toml >import.txt

  $ sdp3 import small.toml --to other.sdp3
  sdp3: * (glob)
  [2]

  $ sdp3 model keygen radio
  radio.key
  radio.pub

  $ sdp3 model keygen radio
  sdp3: *radio.key* (glob)
  [2]

  $ sdp3 model sign again.sdp3 --key radio.key --to signed.sdp3
  ./signed.sdp3

  $ sdp3 model sign again.sdp3 --key small.toml --to other.sdp3
  sdp3: small.toml: length of the key is *, must be 32 bytes (glob)
  [2]

  $ sdp3 model sign again.sdp3 --key radio.pub --to other.sdp3
  sdp3: command line: --key is radio.pub, must be a secret key, NAME.key
  [2]

  $ sdp3 model verify signed.sdp3 --key radio.pub
  signed.sdp3: accepted: revision 0

  $ sdp3 model verify signed.sdp3 --key radio.pub --oldest 1
  signed.sdp3: refused: revision 0 is a rollback* (glob)
  [1]
