A sweep of four cells: where it stands, merged with and without all of them. Needs the feature `train`.

  $ cat >plan.toml <<'END'
  > name = "small"
  > rho = [0.99, 1.0]
  > sensing_slots = [64, 80]
  > [[scenario]]
  > name = "small"
  > [scenario.spectrogram]
  > window = 32
  > hop = 8
  > [scenario.learning]
  > train_per_class = 4
  > test_per_class = 2
  > windows = 1
  > epochs = 2
  > batch = 10
  > channels = 4
  > blocks = 1
  > [scenario.communication]
  > draws = 10
  > END

  $ sdp3 sweep plan.toml --status --out small
  shard       cells    done  missing  unusable
  1/1             4       0        4         0
  0 of 4 cells are there

  $ sdp3 sweep -q plan.toml --out small --shard 1/2
  shard 1/2: 2 cells made, 0 kept; of 4 cells in all 2 are missing

  $ sdp3 sweep plan.toml --status --shards 2 --out small
  shard       cells    done  missing  unusable
  1/2             2       2        0         0
  2/2             2       0        2         0
  2 of 4 cells are there

  $ sdp3 merge small
  sdp3: small: 2 of 4 cells cannot be used:
    small/cells/00001.json: missing (small, carrier_hz = 3500000000, rho = 0.99, N_s = 80, seed 1)
    small/cells/00003.json: missing (small, carrier_hz = 3500000000, rho = 1, N_s = 80, seed 1)
    `sdp3 sweep small/sweep.toml --out small` makes what is missing or damaged; remove what is foreign; --partial joins the others
  [2]

  $ sdp3 merge small --partial | tail -2
  The people of the scenario are in the users' channels.
  2 of 4 cells are missing: 1, 3

  $ sdp3 sweep -q plan.toml --out small
  shard 1/1: 2 cells made, 2 kept; of 4 cells in all `sdp3 merge small` joins them

  $ echo '{' >small/cells/00003.json

  $ sdp3 sweep plan.toml --status --out small
  shard       cells    done  missing  unusable
  1/1             4       3        0         1
  3 of 4 cells are there, about * left (glob)
  small/cells/00003.json: damaged: EOF while parsing an object at line 2 column 0

  $ sdp3 sweep -q plan.toml --out small
  shard 1/1: 1 cells made, 3 kept; of 4 cells in all `sdp3 merge small` joins them

  $ sdp3 merge small
  scenario                       GHz      rho    N_s  int8             float             tested  case 1, Mbit/s  case 2, Mbit/s
  small                        3.500     0.99     64  0.200            0.200                 10          24.508          24.508
  small                        3.500     0.99     80  0.200            0.200                 10          24.396          24.396
  small                        3.500        1     64  0.200            0.200                 10          24.508          24.508
  small                        3.500        1     80  0.200            0.200                 10          24.396          24.396
  by guessing: 0.200
  The people of the scenario are in the users' channels.

  $ head -1 small/merged.csv
  cell,scenario,carrier_hz,rho,sensing_slots,seed,float,int8,tested,chance,throughput_bit_1,throughput_bit_2,throughput_mbit_s_1,throughput_mbit_s_2

  $ ls small
  accuracy-over-rho.pdf
  accuracy-over-rho.png
  accuracy-over-rho.svg
  accuracy-over-sensing-slots.pdf
  accuracy-over-sensing-slots.png
  accuracy-over-sensing-slots.svg
  cells
  merged.csv
  merged.json
  partial-accuracy-over-rho.pdf
  partial-accuracy-over-rho.png
  partial-accuracy-over-rho.svg
  partial-throughput-over-rho.pdf
  partial-throughput-over-rho.png
  partial-throughput-over-rho.svg
  partial.csv
  partial.json
  sweep.toml
  throughput-over-rho.pdf
  throughput-over-rho.png
  throughput-over-rho.svg
  throughput-over-sensing-slots.pdf
  throughput-over-sensing-slots.png
  throughput-over-sensing-slots.svg

  $ sdp3 sweep plan.toml --status --slurm
  error: the argument '--status' cannot be used with '--slurm'
  
  Usage: sdp3 sweep --status <PLAN.toml>
  
  For more information, try '--help'.
  [2]

  $ sdp3 sweep plan.toml --status --shards 5 --out small
  sdp3: command line: --shards is 5, must be 1 to 4, the plan's cells
  [2]
