Scenarios: listed, shown, written, checked, set field by field.

  $ cat >bad.toml <<'END'
  > [radar]
  > carrier_hz = 1.0
  > colour = "red"
  > power_w = "much"
  > [channel]
  > rho = 1.5
  > [frame]
  > sensing_slots = [400, 300, 5000]
  > END

  $ sdp3 scenario list
  conference-room  The paper's conference room: one person, 3.5 GHz, three users in two placements.
  as-printed       The paper as printed: a room that fades while it is recorded and is seen at the antenna's maximum in every direction, an ideal front end, d = 2, 64 sub-carriers without a largest modulation; Kaiser beta 10, 50 dB, Adam with a batch of 500, one window a recording, no mask.
  second-person    The paper's scenario 2: a second person walks in the conference room and disturbs its channel.
  small-radar      A battery's budget: up to 240 sensing slots in a quarter of a second, small networks that fit a microcontroller.
  child-safe-room  Is it a child that moves? A playroom in which people walk in any direction, an adult walks behind them, and accuracy counts more than throughput.
  busy-office      An office of 3GPP's TR 38.901 with eight users: throughput counts more, and sensing has to be short.
  radar-24ghz      The conference room sensed at 24 GHz, the carrier of cheap Doppler modules: every other slot may sense, so that limbs do not alias.
  radar-60ghz      The conference room at 60 GHz with IEEE 802.11ay's clusters: sensing slots follow one another, or limbs would alias.
  doppler-24ghz    The conference room sensed by a 24 GHz Doppler sensor with one output, as sold for door openers: no sweep, so no range; a sample every 0.5 ms, behind an amplifier that blocks what stands still. 16 dBm EIRP, 8 dB antennas in the package, noise figure 12 dB: assumed. Every slot senses, or limbs would alias.
  bgt60            The conference room sensed by a 60 GHz module of the Infineon BGT60TR13C class: 1 GHz in 64 us, 128 real samples of 12 bits, range gate 0.9 to 5.7 m. 5 dBm, 5 dB antennas in the package, noise figure 12 dB: typical values of its data sheet, rounded; sampling at 2 MHz: Infineon's example configurations, with chirps 0.3 ms apart. Every slot of 0.25 ms senses, or limbs would alias.
  iwr              The conference room sensed by a 77 GHz sensor of the TI IWR1443 and IWR1843 class: 4 GHz in 51.2 us, 256 complex samples of 16 bits at 5 MHz, range gate 0.9 to 5.7 m. 12 dBm, noise figure 15 dB and slopes up to 100 MHz/us: the data sheet (TI SWRS211); 10 dB antennas: the evaluation board. Every slot of 0.2 ms senses, or limbs would alias.

  $ sdp3 scenario show small-radar
  # Name shown in results. Legal: 1 to 100 printable characters, the first a letter or digit.
  name = "small-radar"
  
  # The room's walls.
  [room]
  # Length (x), width (y), height (z) in m. Positions and walks stay inside. Links, and with them the
  # throughput, depend on it only where the channel model reflects at walls. Legal: x: 1 to 100; y: 1 to 100; z:
  # 1 to 100.
  size_m = [3.0, 4.5, 3.0]
  
  # What the four walls are made of (the hybrid channel with `mode = "rician"`, `ray-tracing`, `metis`).
  [room.walls]
  # Its material. Legal: one of concrete, brick, plasterboard, wood, glass, ceiling-board, chipboard, plywood,
  # marble, metal.
  material = "concrete"
  # Its thickness in m. Legal: 0.001 to 10.
  thickness_m = 0.2
  
  # What the floor is made of.
  [room.floor]
  # Its material. Legal: one of concrete, brick, plasterboard, wood, glass, ceiling-board, chipboard, plywood,
  # marble, metal.
  material = "concrete"
  # Its thickness in m. Legal: 0.001 to 10.
  thickness_m = 0.2
  
  # What the ceiling is made of.
  [room.ceiling]
  # Its material. Legal: one of concrete, brick, plasterboard, wood, glass, ceiling-board, chipboard, plywood,
  # marble, metal.
  material = "plasterboard"
  # Its thickness in m. Legal: 0.001 to 10.
  thickness_m = 0.0125
  
  # What stands in the room.
  [[room.furniture]]
  centre_m = [0.6, 3.2, 0.7]
  cross_section_dbsm = -5.0
  
  # What stands in the room.
  [[room.furniture]]
  centre_m = [0.5, 1.8, 0.5]
  cross_section_dbsm = -10.0
  
  # What stands in the room.
  [[room.furniture]]
  centre_m = [2.6, 2.2, 0.5]
  cross_section_dbsm = -10.0
  
  # The monostatic radar.
  [radar]
  # Position in m. Legal: inside the room [0, 0, 0] to [3.0, 4.5, 3.0].
  position_m = [1.5, 1.0, 1.0]
  # Carrier frequency in Hz, at which the sweep begins. Legal: 500000000 to 100000000000.
  carrier_hz = 3500000000.0
  # Swept bandwidth in Hz. Legal: 1000000 to 10000000000.
  bandwidth_hz = 10000000.0
  # Duration of the sampled part of a sweep in s. Legal: 0.000001 to 0.00025, at most a slot.
  sweep_s = 0.0001
  # Sampling rate in Hz, which is the bandwidth of the receiver's noise. Legal: 100000 to 100000000; 10000000
  # (fixed): digital dechirp samples at radar.bandwidth_hz.
  sample_rate_hz = 10000000.0
  # Samples of a sweep; 1 of a Doppler sensor, which sends a constant frequency. Legal: 64 to 2048; 1000
  # (fixed): radar.sweep_s times radar.sample_rate_hz.
  samples = 1000
  # What a sample is. Legal: one of complex, real.
  format = "complex"
  # Significant bits of a value. Legal: 8 to 16.
  converter_bits = 16
  # Whether they are the upper bits of 16, the lower ones zero; else the value is sign-extended.
  left_justified = false
  # Where the received sweep is mixed with the sent one. Legal: one of digital, analog.
  dechirp = "digital"
  # Range samples kept of a slot: blocks of the sweep, or cells of the range gate. Legal: 1 to 8; a divisor of
  # radar.samples = 1000: blocks are equally long.
  range_samples = 8
  # First bin of the range gate, in bins of c / (2 B); 0 without a gate. Legal: 0 (fixed), radar.bins_per_sample
  # = 0 says there is no gate.
  first_bin = 0
  # Bins of each range sample of the gate; 0: no gate, the sweep's blocks are summed. Legal: 0 (fixed), a gate
  # needs analog dechirp.
  bins_per_sample = 0
  # Corner in Hz of the AC coupling of a Doppler sensor, two sections of first order; 0: none. Legal: 0 (fixed),
  # a Doppler sensor's, of radar.samples = 1, up to a quarter of the rate of sensing slots.
  ac_coupling_hz = 0.0
  # Transmit power in W. Legal: 0.000000000001 to 1000.
  power_w = 0.1
  # Gain of the transmit antenna and of the receive antenna, each, in dB. Legal: -10 to 60; below
  # radar.sidelobe_db = 30, or no element has this gain.
  antenna_gain_db = 25.0
  # How the gain depends on the direction. Legal: one of constant, element, table.
  antenna_pattern = "element"
  # Level of the side lobes below the main lobe in dB, each way: the lowest gain of `element`; with `constant`,
  # how others than the person sensed are seen. Legal: 0 to 60.
  sidelobe_db = 30.0
  # Receiver noise figure in dB (290 K), both sidebands of the mixer counted. Legal: 0 to 40.
  noise_figure_db = 10.0
  # Head room between the strongest expected echo and the converter's full scale in dB. Legal: 0 to 60.
  headroom_db = 12.0
  # Values of the analogue front end that are not stated: none, or a real module's. Legal: one of ideal,
  # typical.
  front_end = "typical"
  # Standard deviation of a further phase from slot to slot, white and the same for every delay, in degrees.
  # Legal: 0 to 90.
  phase_noise_deg = 0.0
  
  # The time frame shared by sensing and communication.
  [frame]
  # Slot duration T_s in s. Legal: 0.0001 to 0.1.
  slot_s = 0.00025
  # Slots in a scheduling period, N. Legal: 1 to 1000000; at least 512: one STFT window of 128 sensing slots,
  # N_m = 3 slots apart.
  period_slots = 1000
  # Communication slots between two sensing slots, N_m. Legal: 0 to 1000.
  spacing_slots = 3
  # The numbers of sensing slots N_s that are studied, ascending. Legal: a non-empty ascending list; 152 to 250:
  # N_s must fill four windows and N_s (N_m + 1) <= N = 1000 with N_m = 3.
  sensing_slots = [160, 200, 240]
  
  # The channel model.
  [channel]
  # Which model. Legal: one of dahc, primitive, ray-tracing, statistical, 80211ay, 80211ax, 38901, quadriga,
  # metis.
  model = "dahc"
  # The recursion. Legal: one of paper, variance-preserving, consistent, rician.
  mode = "rician"
  # Power of the room's mean over that of its fluctuation in dB, as received (`mode = "rician"`). Legal: -20 to
  # 80.
  k_factor_db = 15.0
  # Power of the room's echoes over what its geometry and materials give in dB (`mode = "rician"`): more or less
  # clutter. Legal: -60 to 60.
  clutter_gain_db = 0.0
  # Where the room's responses come from. Legal: one of 80211ay, 80211ax, by-carrier.
  clusters = "by-carrier"
  # When the recursion advances. Legal: one of sensing-slot, slot.
  advance = "sensing-slot"
  # Whether the room's response starts with the power it settles at instead of Upsilon's.
  stationary_start = false
  # Taps of `80211ax` and of the hybrid channel with those statistics. Legal: one of A, B, C, D, E, F.
  tgn = "B"
  # Whether people and furniture may block reflections (`80211ay` and the hybrid channel with those statistics).
  blockage = false
  # Whether people stand in the way of the room's reflections and of each other's echoes (the hybrid channel
  # with `mode = "rician"`, `ray-tracing`, `metis`, `38901`).
  shadowing = true
  # Whether a torso hides the limbs behind it (the hybrid channel, `ray-tracing`).
  occlusion = true
  # Rays within a cluster (`80211ay` and the hybrid channel with those statistics). Legal: one of
  # conference-room, living-room, cubicle, hotel-lobby, open-area.
  environment = "conference-room"
  # Polarisation of transmitter and receiver (`80211ay`, `38901`). Legal: one of vertical, horizontal, crossed.
  polarisation = "vertical"
  # How taps change in time (`statistical`). Legal: one of redrawn, bell, clarke.
  doppler = "bell"
  # What `ray-tracing` and `metis` know of the room. Legal: one of bare, furnished.
  interior = "furnished"
  # Scattering coefficient S of surfaces, 0 to 1: the share S^2 of what a surface reflects is diffuse
  # (`ray-tracing`, `metis`). Legal: 0 to 1.
  scattering = 0.2
  # Whether waves bend around people and furniture (`ray-tracing`): Kirchhoff's integral over a screen;
  # otherwise a screen hides what is behind it.
  diffraction = true
  # Whether echoes of a person have two reflections at surfaces besides those with one (`ray-tracing`; it takes
  # five times as long).
  double_bounce = false
  # Whether links may be in line of sight: in `38901` with the probability of an open office, in `quadriga` all
  # are.
  line_of_sight = true
  # Whether a second person walks in the room (the paper's scenario 2).
  interferer = false
  
  # The person sensed.
  [target]
  # Ground position at the start in m. Legal: inside the room [0, 0] to [3.0, 4.5].
  start_m = [2.7, 4.2]
  # Way points on the ground in m; with two or more the walk leads through them and the heading is theirs.
  waypoints_m = []
  # Whether who comes near a wall turns; else the walk goes straight on.
  turns = true
  # Headings are uniform within plus or minus this many degrees around the direction to the radar. Legal: 0 to
  # 180.
  heading_spread_deg = 15.0
  # Standard deviation of the walking speed relative to its mean. Legal: 0 to 0.5.
  speed_jitter = 0.05
  # Range of an adult's height in m. Legal: [a, b] with 0.5 <= a <= b <= 2.5.
  adult_height_m = [1.6, 1.9]
  # Range of a child's height in m. Legal: [a, b] with 0.5 <= a <= b <= 2.5.
  child_height_m = [0.9, 1.2]
  # Further people in the room. Legal: how many: 0 to 8.
  others = []
  
  # From slow time to the network's image.
  [spectrogram]
  # First singular component kept, the paper's d; 1 keeps the clutter; 0: decided per recording, components with
  # a static slow-time signal are dropped. Legal: 0 to 8.
  first_kept = 0
  # Last singular component kept (of 8). Legal: 1 to 8, at least the first.
  last_kept = 8
  # Kaiser window length N_w in sensing slots. Legal: 2 to 256.
  window = 128
  # Kaiser window's beta. The paper has 10; 4 resolves slow bodies better and gains 4 points of accuracy at N_s
  # = 200. Legal: 0 to 40.
  beta = 4.0
  # Sensing slots between two frames. Legal: 1 to 128, at most the window.
  hop = 8
  # FFT bins averaged into one of the 64 rows: 1, 2 or 4. Legal: 1, 2 or 4.
  bins_per_row = 1
  # Dynamic range in dB; weaker is black. Legal: 1 to 190.
  range_db = 40.0
  
  # How networks are trained and tested.
  [learning]
  # Training recordings per class. Legal: 2 to 100000.
  train_per_class = 200
  # Sensing slots of a training recording; the largest N_s if that is more, or if it has one window. The paper's
  # have 1000, one scheduling period at 3.5 GHz. Legal: 1 to 8000.
  recording_slots = 1000
  # Windows of N_s slots of every training recording, each an image of its own, evenly spaced from its beginning
  # to its end. Legal: 1 to 100.
  windows = 8
  # Test recordings per class, never trained on. Legal: 2 to 100000.
  test_per_class = 500
  # Passes over the training set. Legal: 1 to 10000.
  epochs = 20
  # Recordings per step. Legal: 2 to 10000.
  batch = 50
  # How steps are taken. Legal: one of adamw, adam, momentum.
  optimizer = "adamw"
  # How the learning rate goes. Legal: one of one-cycle, constant.
  schedule = "one-cycle"
  # Learning rate: the peak of the one-cycle schedule, or the constant. Legal: 0.0000001 to 1.
  learning_rate = 0.005
  # AdamW's weight decay. Legal: 0 to 1.
  weight_decay = 0.01
  # Images of a batch are mixed in pairs by a share drawn from Beta(mixup, mixup), 0 to 1; 0: never. Legal: 0 to
  # 1.
  mixup = 0.0
  # Widest band of rows that goes dark in an image learned from; 0: none. Legal: 0 to 32.
  mask_rows = 0
  # Share of the training recordings kept for validation, 0 to 0.5; the best epoch on them is kept. Legal: 0 to
  # 0.5.
  validation = 0.0
  # Epochs without a better loss on the validation recordings before training stops; 0: never. Legal: 0 unless
  # learning.validation is above 0.
  patience = 0
  # Cross entropy in nats that int8 may add on training images; above it the network is tuned with int8's
  # rounding. Legal: 0 to 10.
  qat_above = 0.01
  # Images, counted as often as they are shown, of such a tuning. Legal: 1 to 1000000.
  qat_images = 2000
  # Channels of every convolution: a multiple of 4, 4 to 32. Legal: a multiple of 4 in 4 to 32.
  channels = 8
  # Residual blocks. Legal: 1 to 8.
  blocks = 3
  # Stride of the input convolution: 1 or 2. Legal: 1 to 2.
  stem_stride = 2
  
  # The communication side.
  [communication]
  # OFDM sub-carriers M; 0: as many as fit, floor(bandwidth_hz x (symbol_s - prefix_s)). Legal: 0 to 65536; at
  # most the 467 that fit bandwidth_hz x (symbol_s - prefix_s), or 0 where 1 to 65536 fit.
  subcarriers = 0
  # Bandwidth that they share in Hz. Legal: 10000 to 10000000000.
  bandwidth_hz = 10000000.0
  # Duration of an OFDM symbol with its prefix T_o in s. Legal: 0.0000001 to 0.00025, at most a slot.
  symbol_s = 0.00005
  # Cyclic prefix of an OFDM symbol in s, a part of symbol_s. Legal: at least 0, below communication.symbol_s.
  prefix_s = 0.0000033
  # Most bits that a sub-carrier carries in a symbol: 8 for 256-QAM; 0: no limit. Legal: 0 to 12; 0 (no limit)
  # or at least 1.
  modulation_bit = 8.0
  # Error vector magnitude of the transmitter in percent: signal over noise and error is at most -20 log10(EVM /
  # 100) dB; 0: an ideal transmitter. 3GPP TS 38.104 table 6.5.2.2-1 allows 3.5 for 256-QAM. Legal: 0 to 50.
  evm_percent = 3.5
  # Transmit power in W, shared by the sub-carriers. Legal: 0.000000001 to 1000.
  power_w = 1.0
  # Noise figure of the users' receivers in dB. Legal: 0 to 40.
  noise_figure_db = 10.0
  # User positions in m, one list per case. Legal: how many: 1 to 16; users: 1 to 8; each: inside the room [0,
  # 0, 0] to [3.0, 4.5, 3.0]; each: at least 0.1 m from the base station.
  cases = [[[1.5, 3.0, 1.0], [2.5, 1.0, 1.0], [0.5, 1.0, 1.0]], [[1.5, 2.8, 1.0], [2.3, 1.0, 1.0], [0.7, 1.0, 1.0]]]
  # Channel draws averaged for the expected gain of a sub-carrier. Legal: 1 to 1000000.
  draws = 200
  # Whether the person sensed and everybody else of the scenario are in the users' channels, in every draw at
  # another moment of a motion of a random class; false: these channels are empty of people.
  people = true
  
  # Zones of the accuracy-throughput region and the operating point in it.
  [optimizer]
  # Weight of normalised accuracy in the operating point's weighted sum (throughput has the rest). Legal: 0 to
  # 1.
  accuracy_weight = 0.5
  # Case (1-based) of the operating point that the scheduler takes. Legal: 1 to 2, one of communication.cases.
  case = 1
  # A point is saturated where the smaller normalised marginal rate is below this share of the larger. Legal:
  # 0.000001 to 1.
  zone_ratio = 0.2

  $ sdp3 scenario new room.toml --set radar.carrier_hz=5.8e9
  room.toml

  $ sdp3 scenario new room.toml
  sdp3: room.toml: File exists (os error 17); an existing file is kept
  [2]

  $ sdp3 scenario check room.toml
    scenario  room.toml: nothing is wrong

  $ sdp3 scenario check room.toml --json
  {
    "file": "room.toml",
    "errors": []
  }
    scenario  room.toml: nothing is wrong

  $ sdp3 scenario check bad.toml
  sdp3: bad.toml: TOML parse error at line 3, column 1
      |
    3 | colour = "red"
      | ^^^^^^
    unknown field `colour`, expected one of `position_m`, `carrier_hz`, `bandwidth_hz`, `sweep_s`, `sample_rate_hz`, `samples`, `format`, `converter_bits`, `left_justified`, `dechirp`, `range_samples`, `first_bin`, `bins_per_sample`, `ac_coupling_hz`, `power_w`, `antenna_gain_db`, `antenna_pattern`, `antenna_table`, `boresight_m`, `sidelobe_db`, `noise_figure_db`, `headroom_db`, `front_end`, `phase_noise_dbc_hz`, `phase_noise_loop_hz`, `phase_noise_floor_dbc_hz`, `phase_noise_deg`, `isolation_db`, `compression_dbm`, `iq_gain_db`, `iq_phase_deg`, `dc_offset`
  sdp3: bad.toml: TOML parse error at line 4, column 11
      |
    4 | power_w = "much"
      |           ^^^^^^
    invalid type: string "much", expected f64
  sdp3: bad.toml: radar.carrier_hz is 1, must be 500000000 to 100000000000
  sdp3: bad.toml: channel.rho is 1.5, must be 0 to 1
  sdp3: bad.toml: frame.sensing_slots is [400, 300, 5000], must be a non-empty ascending list
  sdp3: bad.toml: frame.sensing_slots is 5000, must be 152 to 1000: N_s must fill four windows and N_s (N_m + 1) <= N = 4000 with N_m = 3
  [2]

  $ sdp3 scenario check bad.toml --json
  {
    "file": "bad.toml",
    "errors": [
      "bad.toml: TOML parse error at line 3, column 1\n    |\n  3 | colour = \"red\"\n    | ^^^^^^\n  unknown field `colour`, expected one of `position_m`, `carrier_hz`, `bandwidth_hz`, `sweep_s`, `sample_rate_hz`, `samples`, `format`, `converter_bits`, `left_justified`, `dechirp`, `range_samples`, `first_bin`, `bins_per_sample`, `ac_coupling_hz`, `power_w`, `antenna_gain_db`, `antenna_pattern`, `antenna_table`, `boresight_m`, `sidelobe_db`, `noise_figure_db`, `headroom_db`, `front_end`, `phase_noise_dbc_hz`, `phase_noise_loop_hz`, `phase_noise_floor_dbc_hz`, `phase_noise_deg`, `isolation_db`, `compression_dbm`, `iq_gain_db`, `iq_phase_deg`, `dc_offset`",
      "bad.toml: TOML parse error at line 4, column 11\n    |\n  4 | power_w = \"much\"\n    |           ^^^^^^\n  invalid type: string \"much\", expected f64",
      "bad.toml: radar.carrier_hz is 1, must be 500000000 to 100000000000",
      "bad.toml: channel.rho is 1.5, must be 0 to 1",
      "bad.toml: frame.sensing_slots is [400, 300, 5000], must be a non-empty ascending list",
      "bad.toml: frame.sensing_slots is 5000, must be 152 to 1000: N_s must fill four windows and N_s (N_m + 1) <= N = 4000 with N_m = 3"
    ]
  }
  sdp3: bad.toml: TOML parse error at line 3, column 1
      |
    3 | colour = "red"
      | ^^^^^^
    unknown field `colour`, expected one of `position_m`, `carrier_hz`, `bandwidth_hz`, `sweep_s`, `sample_rate_hz`, `samples`, `format`, `converter_bits`, `left_justified`, `dechirp`, `range_samples`, `first_bin`, `bins_per_sample`, `ac_coupling_hz`, `power_w`, `antenna_gain_db`, `antenna_pattern`, `antenna_table`, `boresight_m`, `sidelobe_db`, `noise_figure_db`, `headroom_db`, `front_end`, `phase_noise_dbc_hz`, `phase_noise_loop_hz`, `phase_noise_floor_dbc_hz`, `phase_noise_deg`, `isolation_db`, `compression_dbm`, `iq_gain_db`, `iq_phase_deg`, `dc_offset`
  sdp3: bad.toml: TOML parse error at line 4, column 11
      |
    4 | power_w = "much"
      |           ^^^^^^
    invalid type: string "much", expected f64
  sdp3: bad.toml: radar.carrier_hz is 1, must be 500000000 to 100000000000
  sdp3: bad.toml: channel.rho is 1.5, must be 0 to 1
  sdp3: bad.toml: frame.sensing_slots is [400, 300, 5000], must be a non-empty ascending list
  sdp3: bad.toml: frame.sensing_slots is 5000, must be 152 to 1000: N_s must fill four windows and N_s (N_m + 1) <= N = 4000 with N_m = 3
  [2]

  $ sdp3 scenario check missing.toml
  sdp3: missing.toml: No such file or directory (os error 2)
  [2]

  $ sdp3 scenario show nowhere
  sdp3: nowhere: No such file or directory (os error 2); `sdp3 scenario list` has the names of scenarios that come with the tool
  [2]

  $ sdp3 scenario show --set radar.carrier_hz=fast
  sdp3: command line: --set: radar.carrier_hz is fast, must be a number, 500000000 to 100000000000
  [2]

  $ sdp3 scenario show --set radar.carier_hz=1e9
  sdp3: command line: --set: radar.carier_hz is no field, must be one of `position_m`, `carrier_hz`, `bandwidth_hz`, `sweep_s`, `sample_rate_hz`, `samples`, `format`, `converter_bits`, `left_justified`, `dechirp`, `range_samples`, `first_bin`, `bins_per_sample`, `ac_coupling_hz`, `power_w`, `antenna_gain_db`, `antenna_pattern`, `antenna_table`, `boresight_m`, `sidelobe_db`, `noise_figure_db`, `headroom_db`, `front_end`, `phase_noise_dbc_hz`, `phase_noise_loop_hz`, `phase_noise_floor_dbc_hz`, `phase_noise_deg`, `isolation_db`, `compression_dbm`, `iq_gain_db`, `iq_phase_deg`, `dc_offset`
  [2]

  $ sdp3 scenario show --set channel.rho
  error: invalid value 'channel.rho' for '--set <FIELD=VALUE>': expected FIELD=VALUE, such as radar.carrier_hz=60e9 or frame.sensing_slots=[200,300]
  
  For more information, try '--help'.
  [2]

  $ sdp3 scenario show --set channel.rho=1.5
  sdp3: command line: --set: channel.rho is 1.5, must be 0 to 1
  [2]

  $ sdp3 scenario show --set channel.model=38901 | grep '^model'
  model = "38901"

  $ sdp3 scenario show --set channel.model=38902
  sdp3: command line: --set: channel.model is 38902, must be one of dahc, primitive, ray-tracing, statistical, 80211ay, 80211ax, 38901, quadriga, metis
  [2]
