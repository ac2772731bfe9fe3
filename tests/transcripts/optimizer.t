Learning curves, regions and schedules from a table of accuracies.

  $ cat >points.csv <<'END'
  > sensing_slots,accuracy,tested
  > 200,0.7885,500
  > 300,0.9016,500
  > 400,0.9142,500
  > 500,0.9309,500
  > 1000,0.9554,500
  > END

  $ sdp3 predict --points points.csv
  model                          sse     rmse            aicc           loo    cp
  pow3                 2.1711e-4 (2)   0.0066               -    0.0408 (1)     1
  log_power            2.5078e-4 (4)   0.0071               -    0.0414 (3)     2
  pow4                 1.2077e-4 (1)   0.0049               -    0.0427 (4)     3
  exp4                 2.1713e-4 (3)   0.0066               -    0.0461 (5)     4
  vapor_pressure       1.5491e-3 (5)   0.0176    -10.3975 (1)    0.0409 (2)     5
  ilog2                2.9775e-3 (6)   0.0244     -7.1306 (2)    0.0496 (6)     6
  log_log_linear       3.7607e-3 (7)   0.0274     -5.9629 (3)    0.0528 (7)     7
  best: pow3; in brackets the place by each figure of merit
  95 % band by 400 draws from test counts: at most 0.072 wide from N_s = 200 on

  $ sdp3 predict --points nothing.csv
  sdp3: nothing.csv: No such file or directory (os error 2)
  [2]

  $ sdp3 predict
  sdp3: out/run.json: cannot be read: No such file or directory (os error 2); `sdp3 run` with the same --out makes it
  [2]

  $ sdp3 optimize -q --points points.csv --accuracy 0.9
  most throughput with accuracy at least 0.9 by pow3, rmse 0.0066
  case 1: N_s = 318, N_c = [1228, 1227, 1227], accuracy 0.9004 (0.884 to 0.921), 22920360 bit per period (22.920 Mbit/s), adversarial
    467 sub-carriers with 8.00, 8.00, 8.00 bit a symbol, 100 %, 100 %, 100 % of them at the modulation's limit
    adversarial from N_s = 204
    sensing-saturation from N_s = 521
  case 2: N_s = 318, N_c = [1228, 1227, 1227], accuracy 0.9004 (0.884 to 0.921), 22920360 bit per period (22.920 Mbit/s), adversarial
    467 sub-carriers with 8.00, 8.00, 8.00 bit a symbol, 100 %, 100 %, 100 % of them at the modulation's limit
    adversarial from N_s = 204
    sensing-saturation from N_s = 521
  zones: |dA / dR|, both over their span, above 5.000, between, below 0.2; every N_s in boundary.csv
  The people of the scenario are in the users' channels.

  $ sdp3 optimize -q --points points.csv --accuracy -0.1
  sdp3: command line: --accuracy is -0.1, must be 0 to 1
  [2]

  $ sdp3 optimize -q --points points.csv --weights 0,0
  sdp3: command line: --weights is 0,0, must be two numbers, at least one of them above 0
  [2]

  $ sdp3 optimize -q --points points.csv --sweep users=1 --sweep users=2
  sdp3: command line: --sweep is users twice, must be each axis once, with all its values
  [2]

  $ sdp3 predict --points points.csv --threads 20000
  error: invalid value '20000' for '--threads <THREADS>': 20000 is not in 0..=1024
  
  For more information, try '--help'.
  [2]

  $ sdp3 verify --firmware nowhere
  sdp3: command line: --firmware is nowhere, must be a folder that firmware-sim/build made
  [2]

  $ sdp3 run -q --set frame.sensing_slots=[200] --out one
  sdp3: frame.sensing_slots is [200], must be at least 2 numbers: a learning curve goes through their accuracies; `sdp3 train` takes 1
  [2]

  $ sdp3 optimize -q --points points.csv --set communication.power_w=0.1 --sweep users=1,2
  carrier_hz\tpower_w\tusers\tdistance\tcase\tsensing_slots\taccuracy\tthroughput_bit\tthroughput_mbit_s (esc)
  3500000000\t0.1\t1\t1\t1\t326\t0.9034692688492608\t68630320\t68.63032 (esc)
  3500000000\t0.1\t1\t1\t2\t326\t0.9034692688492608\t68630320\t68.63032 (esc)
  3500000000\t0.1\t2\t1\t1\t326\t0.9034692688492608\t34315160\t34.31516 (esc)
  3500000000\t0.1\t2\t1\t2\t326\t0.9034692688492608\t34315160\t34.31516 (esc)

  $ sdp3 optimize --points points.csv --accuracy 1.5
  sdp3: command line: --accuracy is 1.5, must be 0 to 1
  [2]

  $ sdp3 optimize --points points.csv --curve spline
  error: invalid value 'spline' for '--curve <NAME>'
    [possible values: vapor_pressure, pow3, log_power, exp4, log_log_linear, ilog2, pow4]
  
  For more information, try '--help'.
  [2]

  $ sdp3 optimize -q --points points.csv --accuracy 0.99
  sdp3: no point of the boundary satisfies: most throughput with accuracy at least 0.99; it offers accuracies 0.6347 to 0.9498 and at most 23947760 bit
  [2]

  $ sdp3 optimize -q --points points.csv --accuracy 0.9 --set frame.slot_s=0.001 | head -2
  most throughput with accuracy at least 0.9 by pow3, rmse 0.0066
  case 1: N_s = 318, N_c = [1228, 1227, 1227], accuracy 0.9004 (0.884 to 0.921), 91681440 bit per period (22.920 Mbit/s), adversarial

  $ cat >many.csv <<'END'
  > sensing_slots,accuracy,tested
  > 1200,0.7,500
  > 2000,0.8,500
  > 3500,0.85,500
  > END

  $ sdp3 optimize -q --points many.csv | head -3
  largest 0.5 A + 0.5 R, both over their span on the boundary by vapor_pressure, rmse 0.0057
  case 1: N_s = 490, N_c = [1170, 1170, 1170], accuracy 0.4583 (0.378 to 0.567), 21855600 bit per period (21.856 Mbit/s), adversarial, extrapolated: no accuracy was measured there
    467 sub-carriers with 8.00, 8.00, 8.00 bit a symbol, 100 %, 100 %, 100 % of them at the modulation's limit

  $ head -2 out/boundary.csv
  case,sensing_slots,accuracy,throughput_bit,throughput_mbit_s,closed_form_bit,pareto,zone,extrapolated,communication_slots
  1,152,0.09148368233752534,23947760,23.94776,23960213.333333336,false,adversarial,true,1283 1283 1282

  $ sdp3 schedule -q --periods 5 --sensing-slots 300
  5 periods, 20000 decisions: 1500 sensing, 0 idle
  5 new plans: 1 joined, 0 left, 0 rates, 0 targets, 7 slots lost and 2 of sensing, 0 given back
  user       periods        slots  bit a period    Mbit/s       offered      wait   bound
  1                5         5551      20734800    20.735      20734800         5      21
  2                5         5551      20727328    20.727      20727328         5      21
  3                5         5550      20719856    20.720      20719856         5      21
  6                2         1848      17260320    17.260      17260320         5      23
  The people of the scenario are in the users' channels.
  every property held

  $ sdp3 schedule -q --periods 5 --sensing-slots 5000
  sdp3: command line: --sensing-slots is 5000, must be 0 to 1000
  [2]

  $ sdp3 schedule
  sdp3: out/run.json: cannot be read: No such file or directory (os error 2); `sdp3 run` with the same --out makes it
  [2]

  $ sdp3 early-exits
  sdp3: out/scenario.toml: No such file or directory (os error 2)
  [2]

  $ sdp3 optimize --points points.csv --set room.size_m=[4,5,3] 2>&1 | head -2
    optimize  accuracy against throughput
    optimize  N_s = 325: accuracy 0.903, 22883000 bit per period (22.883 Mbit/s) to the worst user. The people of the scenario are in the users' channels.

  $ head -8 out/optimize.json
  {
    "provenance": {
      "program": "sdp3 0.1.0",
      "commit": "*", (glob)
      "commit_date": "*", (glob)
      "seed": 1,
      "sha256": "*" (glob)
    },
