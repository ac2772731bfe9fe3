Help: the tool and every command, with examples.

  $ sdp3 --help
  Simulate radar sensing of a person, train a deep spectrogram network, verify the radar module's bits, and optimize recognition accuracy against throughput
  
  Usage: sdp3 [OPTIONS] [COMMAND]
  
  Commands:
    run          Run the main job: simulate, calibrate, train, run, verify, optimize, schedule, report
    simulate     Simulate recordings and write them as a dataset
    targets      Write the moving person as point targets for other radar simulators
    calibrate    Find the channel correlation rho that a measured signal shows
    inspect      Show what a recording holds: format, shape, sensor, rate, pictures over time, and the scenario that matches the sensor
    classify     Classify recordings of a radar by the radar module's own chain, window by window
    channels     Run every channel model through the property tests of the paper's Table I
    gallery      Draw a page of spectrograms: class by carrier by channel model
    train        Train the networks and save their float parameters
    study        Run a study that takes many trainings: learning curve, robustness, fidelity, sim to real, baselines, ablation, clutter, selection
    reproduce    Make the paper's tables and figures again, beside its numbers, each with a verdict
    sweep        Measure a plan of scenarios x carriers x rho x N_s x seeds, here or on a cluster
    merge        Join the cells of a sweep
    quantize     Convert trained networks into int8 model files
    export       Write a network for other programs (.tflite, .safetensors)
    import       Read a network of another program
    infer        Run an int8 network on arrays, with the bits of the radar module
    model        Show, sign and verify model files, make keys
    verify       Compare the core with its reference and its firmware, bit for bit
    predict      Fit the seven learning curves to accuracies
    optimize     Draw the accuracy-throughput region and choose a point on it
    early-exits  Fit early exits and draw their region beside the static one
    schedule     Play the operating point through the core's scheduler
    report       Write the report page and its figures again
    scenario     List, print, write and check scenarios
    schema       Print the JSON Schema of what a command prints with --json
    completions  Print a script that completes commands in a shell
    man          Write manual pages
    help         Print this message or the help of the given subcommand(s)
  
  Options:
        --scenario <FILE.toml|NAME>  Scenario in TOML, or the name of one that `sdp3 scenario list` lists; absent: the paper's conference room
        --set <FIELD=VALUE>          Set a field over the scenario, such as radar.carrier_hz=24e9 or frame.sensing_slots=[200,300]. May be given several times; the resolved scenario beside the results has it
        --seed <SEED>                Seed of everything random [default: 1]
        --out <DIR>                  Folder for results [default: out]
        --threads <THREADS>          Threads, at most 1024; 0 takes all processors. Results do not depend on it [default: 0]
        --max-memory <SIZE>          Refuse what would need more memory by its estimate, before it begins; such as 500M or 8GiB [default: 4GiB]
        --max-time <TIME>            Refuse what would take longer by its estimate, before it begins; such as 90s, 10m, 12h or 30d [default: 30d]
        --json                       Print results as JSON, and nothing else, on stdout
    -v, --verbose                    Print more on stderr
    -q, --quiet                      Print only errors on stderr
    -h, --help                       Print help
    -V, --version                    Print version
  
  Examples:
    sdp3                                     the main job, quick, results in ./out
    sdp3 run --measured walk.wav --carrier 24.125e9
    sdp3 simulate --channel ray-tracing --per-class 100
    sdp3 channels --json
    sdp3 train --recipe paper-adam --resume
    sdp3 predict --points points.csv --json
    sdp3 optimize --accuracy 0.9
    sdp3 export out/models/dsn-1000.sdp3 --to dsn.tflite
    sdp3 sweep docs/plans/quick.toml --out quick
    sdp3 scenario new room.toml
  `sdp3 COMMAND --help` has examples of every command, `sdp3 schema COMMAND` what it prints with --json.
  Exit code: 0 done, 1 a check failed, 2 usage, input or I/O error, 130 interrupted.

  $ sdp3 run --help
  Run the main job: simulate, calibrate, train, run, verify, optimize, schedule, report
  
  Usage: sdp3 run [OPTIONS]
  
  Options:
        --preset <PRESET>
            Size of the job
  
            Possible values:
            - quick: Minutes: fewer recordings and epochs, a smaller network. A size that the scenario's file or --set states is kept
            - paper: The scenario's sizes; where it states none the paper's: 200 recordings per class to train, 500 to test
            
            [default: quick]
  
        --resume
            Go on from the checkpoints in --out, with the same result as without the interruption
  
        --measured <PATH>
            A measured signal: a file or folder that `sdp3 inspect` reads
  
        --carrier <HZ>
            Carrier in Hz, instead of what the file says
  
        --rate <HZ>
            Sampling or slow-time rate in Hz, instead of what the file says
  
        --gain <DB>
            Gain of the sensor in dB, which is subtracted
  
        --dataset <NAME>
            Which array of an NPZ or MATLAB file, or which dataset of an HDF5 file
  
        --antenna <N>
            Receive antenna of a radar module, from 1
  
        --chirp <N|all>
            Chirp of every frame of a radar module, from 1, or all
  
        --config <FILE>
            Description of a DCA1000 capture: the sensor's .cfg or mmWave Studio's .mmwave.json; absent: the one beside it
  
        --motion <CLASS>
            How the person in it moves: rho is found for this motion, and a wrong one changes it
            
            [default: adult-walking]
            [possible values: standing, child-walking, child-pacing, adult-walking, adult-pacing, child-stepping, adult-stepping, child-running, adult-running, sitting-down, standing-up, falling, bending, waving, jumping]
  
        --targets <NAMES>
            Targets to compare
            
            [default: host-reference cortex-m4f riscv32imac]
            [possible values: host-reference, cortex-m3, cortex-m4f, cortex-m7, cortex-m33, cortex-m55, riscv32imac, riscv32imafc, cortex-a53]
  
        --firmware <DIR>
            Folder of ready-built firmware; absent: firmware-sim/build makes it
  
        --scenario <FILE.toml|NAME>
            Scenario in TOML, or the name of one that `sdp3 scenario list` lists; absent: the paper's conference room
  
        --set <FIELD=VALUE>
            Set a field over the scenario, such as radar.carrier_hz=24e9 or frame.sensing_slots=[200,300]. May be given several times; the resolved scenario beside the results has it
  
        --seed <SEED>
            Seed of everything random [default: 1]
  
        --out <DIR>
            Folder for results
            
            [default: out]
  
        --threads <THREADS>
            Threads, at most 1024; 0 takes all processors. Results do not depend on it
            
            [default: 0]
  
        --max-memory <SIZE>
            Refuse what would need more memory by its estimate, before it begins; such as 500M or 8GiB
            
            [default: 4GiB]
  
        --max-time <TIME>
            Refuse what would take longer by its estimate, before it begins; such as 90s, 10m, 12h or 30d
            
            [default: 30d]
  
        --json
            Print results as JSON, and nothing else, on stdout
  
    -v, --verbose
            Print more on stderr
  
    -q, --quiet
            Print only errors on stderr
  
    -h, --help
            Print help (see a summary with '-h')
  
  Examples:
    sdp3 run
    sdp3 run --preset paper --threads 8 --resume
    sdp3 run --measured walk.wav --carrier 24.125e9 --targets host-reference
    sdp3 run --scenario small-radar --set radar.carrier_hz=5.8e9 --out small --json

  $ sdp3 simulate --help
  Simulate recordings and write them as a dataset.
  
  The dataset is parts of 100 recordings in NPZ, and a manifest. After an interruption the same command resumes. A complete dataset is not changed.
  
  Usage: sdp3 simulate [OPTIONS]
  
  Options:
        --per-class <PER_CLASS>
            Recordings of each class
            
            [default: 20]
  
        --channel <NAME>
            Channel model; absent: the scenario's
            
            [possible values: dahc, primitive, ray-tracing, statistical, 80211ay, 80211ax, 38901, quadriga, metis]
  
        --classes <NAMES>
            Classes; absent: the paper's five
            
            [possible values: standing, child-walking, child-pacing, adult-walking, adult-pacing, child-stepping, adult-stepping, child-running, adult-running, sitting-down, standing-up, falling, bending, waving, jumping]
  
        --raw
            Store the raw slots in the parts too
  
        --sigmf
            Write each recording's raw slots as SigMF too
  
        --shard <I/N>
            Make only the I-th of N shards of the parts; whichever comes last writes the manifest
            
            [default: 1/1]
  
        --scenario <FILE.toml|NAME>
            Scenario in TOML, or the name of one that `sdp3 scenario list` lists; absent: the paper's conference room
  
        --set <FIELD=VALUE>
            Set a field over the scenario, such as radar.carrier_hz=24e9 or frame.sensing_slots=[200,300]. May be given several times; the resolved scenario beside the results has it
  
        --seed <SEED>
            Seed of everything random [default: 1]
  
        --out <DIR>
            Folder for results
            
            [default: out]
  
        --threads <THREADS>
            Threads, at most 1024; 0 takes all processors. Results do not depend on it
            
            [default: 0]
  
        --max-memory <SIZE>
            Refuse what would need more memory by its estimate, before it begins; such as 500M or 8GiB
            
            [default: 4GiB]
  
        --max-time <TIME>
            Refuse what would take longer by its estimate, before it begins; such as 90s, 10m, 12h or 30d
            
            [default: 30d]
  
        --json
            Print results as JSON, and nothing else, on stdout
  
    -v, --verbose
            Print more on stderr
  
    -q, --quiet
            Print only errors on stderr
  
    -h, --help
            Print help (see a summary with '-h')
  
  Examples:
    sdp3 simulate --out data
    sdp3 simulate --channel ray-tracing --classes adult-walking,adult-running --per-class 200 --out data
    sdp3 simulate --per-class 1000 --raw --sigmf --shard 2/8 --out data

  $ sdp3 calibrate --help
  Find the channel correlation rho that a measured signal shows
  
  Usage: sdp3 calibrate [OPTIONS]
  
  Options:
        --measured <PATH>            A measured signal: a file or folder that `sdp3 inspect` reads
        --carrier <HZ>               Carrier in Hz, instead of what the file says
        --rate <HZ>                  Sampling or slow-time rate in Hz, instead of what the file says
        --gain <DB>                  Gain of the sensor in dB, which is subtracted
        --dataset <NAME>             Which array of an NPZ or MATLAB file, or which dataset of an HDF5 file
        --antenna <N>                Receive antenna of a radar module, from 1
        --chirp <N|all>              Chirp of every frame of a radar module, from 1, or all
        --config <FILE>              Description of a DCA1000 capture: the sensor's .cfg or mmWave Studio's .mmwave.json; absent: the one beside it
        --motion <CLASS>             How the person in it moves: rho is found for this motion, and a wrong one changes it [default: adult-walking] [possible values: standing, child-walking, child-pacing, adult-walking, adult-pacing, child-stepping, adult-stepping, child-running, adult-running, sitting-down, standing-up, falling, bending, waving, jumping]
        --table <FILE.toml>          Write the look-up table of rho again, to this file
        --scenario <FILE.toml|NAME>  Scenario in TOML, or the name of one that `sdp3 scenario list` lists; absent: the paper's conference room
        --set <FIELD=VALUE>          Set a field over the scenario, such as radar.carrier_hz=24e9 or frame.sensing_slots=[200,300]. May be given several times; the resolved scenario beside the results has it
        --seed <SEED>                Seed of everything random [default: 1]
        --out <DIR>                  Folder for results [default: out]
        --threads <THREADS>          Threads, at most 1024; 0 takes all processors. Results do not depend on it [default: 0]
        --max-memory <SIZE>          Refuse what would need more memory by its estimate, before it begins; such as 500M or 8GiB [default: 4GiB]
        --max-time <TIME>            Refuse what would take longer by its estimate, before it begins; such as 90s, 10m, 12h or 30d [default: 30d]
        --json                       Print results as JSON, and nothing else, on stdout
    -v, --verbose                    Print more on stderr
    -q, --quiet                      Print only errors on stderr
    -h, --help                       Print help
  
  Examples:
    sdp3 calibrate --measured walk.wav --carrier 24.125e9
    sdp3 calibrate --measured sitting.npy --rate 20 --carrier 60e9 --motion standing --json
    sdp3 calibrate --table rho.toml

  $ sdp3 inspect --help
  Show what a recording holds: format, shape, sensor, rate, pictures over time, and the scenario that matches the sensor.
  
  The pictures are doppler-time and, of a radar module, range-time, of the antenna and the chirp stated, or of the first.
  
  Usage: sdp3 inspect [OPTIONS] <PATH>
  
  Arguments:
    <PATH>
            A recording: WAV, CSV, NPY, NPZ, MATLAB, SigMF, HDF5, a folder of Infineon's radar SDK, a capture of TI's DCA1000
  
  Options:
        --carrier <HZ>
            Carrier in Hz, instead of what the file says
  
        --rate <HZ>
            Sampling or slow-time rate in Hz, instead of what the file says
  
        --gain <DB>
            Gain of the sensor in dB, which is subtracted
  
        --dataset <NAME>
            Which array of an NPZ or MATLAB file, or which dataset of an HDF5 file
  
        --antenna <N>
            Receive antenna of a radar module, from 1
  
        --chirp <N|all>
            Chirp of every frame of a radar module, from 1, or all
  
        --config <FILE>
            Description of a DCA1000 capture: the sensor's .cfg or mmWave Studio's .mmwave.json; absent: the one beside it
  
        --scenario <FILE.toml|NAME>
            Scenario in TOML, or the name of one that `sdp3 scenario list` lists; absent: the paper's conference room
  
        --set <FIELD=VALUE>
            Set a field over the scenario, such as radar.carrier_hz=24e9 or frame.sensing_slots=[200,300]. May be given several times; the resolved scenario beside the results has it
  
        --seed <SEED>
            Seed of everything random [default: 1]
  
        --out <DIR>
            Folder for results
            
            [default: out]
  
        --threads <THREADS>
            Threads, at most 1024; 0 takes all processors. Results do not depend on it
            
            [default: 0]
  
        --max-memory <SIZE>
            Refuse what would need more memory by its estimate, before it begins; such as 500M or 8GiB
            
            [default: 4GiB]
  
        --max-time <TIME>
            Refuse what would take longer by its estimate, before it begins; such as 90s, 10m, 12h or 30d
            
            [default: 30d]
  
        --json
            Print results as JSON, and nothing else, on stdout
  
    -v, --verbose
            Print more on stderr
  
    -q, --quiet
            Print only errors on stderr
  
    -h, --help
            Print help (see a summary with '-h')
  
  Examples:
    sdp3 inspect walk.wav --carrier 24.125e9
    sdp3 inspect RadarIfxAvian_00 --antenna 2
    sdp3 inspect adc_data.bin --config profile.cfg --chirp all --json

  $ sdp3 classify --help
  Classify recordings of a radar by the radar module's own chain, window by window.
  
  The recording must be of the model's radar: samples of a slot, slot interval and carrier.
  
  Usage: sdp3 classify [OPTIONS] <MODEL> <PATH>...
  
  Arguments:
    <MODEL>
            Model file
  
    <PATH>...
            Recordings of raw slots, as `sdp3 inspect` reads them; or `-`: slots from standard input, little-endian int16 without pauses
  
  Options:
        --carrier <HZ>
            Carrier in Hz, instead of what the file says
  
        --rate <HZ>
            Sampling or slow-time rate in Hz, instead of what the file says
  
        --gain <DB>
            Gain of the sensor in dB, which is subtracted
  
        --dataset <NAME>
            Which array of an NPZ or MATLAB file, or which dataset of an HDF5 file
  
        --antenna <N>
            Receive antenna of a radar module, from 1
  
        --chirp <N|all>
            Chirp of every frame of a radar module, from 1, or all
  
        --config <FILE>
            Description of a DCA1000 capture: the sensor's .cfg or mmWave Studio's .mmwave.json; absent: the one beside it
  
        --step <SLOTS>
            Slots from window to window; absent: the model's sensing slots, so that windows do not overlap
  
        --early-exits <DIR>
            End a window as soon as an exit is sure: the models in this folder with fewer slots than MODEL, which is one of them, with the weights that `sdp3 early-exits` wrote there
  
        --threshold <CONFIDENCE>
            Confidence that ends a window; absent: that of the operating point that `sdp3 early-exits` found. Above 1, up to 2, none does
  
        --guard
            Also say which slots the module's supervision of samples would refuse: silent, stuck, saturated or offset converters
  
        --picture <FILE>
            Picture to draw, .svg, .png or .pdf: each recording's spectrogram, with class and confidence over time below it
  
        --format <FORMAT>
            What is printed, where --json is not given
  
            Possible values:
            - text:  A line a window: its time in s, its class, its confidence, the slots it used
            - csv:   A table with the logits
            - sigmf: The description of a SigMF recording with the windows as its annotations
            
            [default: text]
  
        --least-confidence <0..1>
            Windows of less confidence are `unknown`
            
            [default: 0]
  
        --scenario <FILE.toml|NAME>
            Scenario in TOML, or the name of one that `sdp3 scenario list` lists; absent: the paper's conference room
  
        --set <FIELD=VALUE>
            Set a field over the scenario, such as radar.carrier_hz=24e9 or frame.sensing_slots=[200,300]. May be given several times; the resolved scenario beside the results has it
  
        --seed <SEED>
            Seed of everything random [default: 1]
  
        --out <DIR>
            Folder for results
            
            [default: out]
  
        --threads <THREADS>
            Threads, at most 1024; 0 takes all processors. Results do not depend on it
            
            [default: 0]
  
        --max-memory <SIZE>
            Refuse what would need more memory by its estimate, before it begins; such as 500M or 8GiB
            
            [default: 4GiB]
  
        --max-time <TIME>
            Refuse what would take longer by its estimate, before it begins; such as 90s, 10m, 12h or 30d
            
            [default: 30d]
  
        --json
            Print results as JSON, and nothing else, on stdout
  
    -v, --verbose
            Print more on stderr
  
    -q, --quiet
            Print only errors on stderr
  
    -h, --help
            Print help (see a summary with '-h')
  
  Examples:
    sdp3 classify out/models/dsn-1000.sdp3 walk.sigmf-meta --picture walk.png
    sdp3 classify out/models/dsn-1000.sdp3 walk.sigmf-meta --early-exits out --threshold 0.95
    sdp3 classify sensor.sdp3 RadarIfxAvian_00 --antenna 1 --chirp 1 --step 100 --guard --json
    sensor | sdp3 classify sensor.sdp3 -

  $ sdp3 channels --help
  Run every channel model through the property tests of the paper's Table I
  
  Usage: sdp3 channels [OPTIONS]
  
  Options:
        --scenario <FILE.toml|NAME>  Scenario in TOML, or the name of one that `sdp3 scenario list` lists; absent: the paper's conference room
        --set <FIELD=VALUE>          Set a field over the scenario, such as radar.carrier_hz=24e9 or frame.sensing_slots=[200,300]. May be given several times; the resolved scenario beside the results has it
        --seed <SEED>                Seed of everything random [default: 1]
        --out <DIR>                  Folder for results [default: out]
        --threads <THREADS>          Threads, at most 1024; 0 takes all processors. Results do not depend on it [default: 0]
        --max-memory <SIZE>          Refuse what would need more memory by its estimate, before it begins; such as 500M or 8GiB [default: 4GiB]
        --max-time <TIME>            Refuse what would take longer by its estimate, before it begins; such as 90s, 10m, 12h or 30d [default: 30d]
        --json                       Print results as JSON, and nothing else, on stdout
    -v, --verbose                    Print more on stderr
    -q, --quiet                      Print only errors on stderr
    -h, --help                       Print help
  
  Examples:
    sdp3 channels
    sdp3 channels --scenario radar-60ghz --json

  $ sdp3 gallery --help
  Draw a page of spectrograms: class by carrier by channel model
  
  Usage: sdp3 gallery [OPTIONS]
  
  Options:
        --scenario <FILE.toml|NAME>  Scenario in TOML, or the name of one that `sdp3 scenario list` lists; absent: the paper's conference room
        --set <FIELD=VALUE>          Set a field over the scenario, such as radar.carrier_hz=24e9 or frame.sensing_slots=[200,300]. May be given several times; the resolved scenario beside the results has it
        --seed <SEED>                Seed of everything random [default: 1]
        --out <DIR>                  Folder for results [default: out]
        --threads <THREADS>          Threads, at most 1024; 0 takes all processors. Results do not depend on it [default: 0]
        --max-memory <SIZE>          Refuse what would need more memory by its estimate, before it begins; such as 500M or 8GiB [default: 4GiB]
        --max-time <TIME>            Refuse what would take longer by its estimate, before it begins; such as 90s, 10m, 12h or 30d [default: 30d]
        --json                       Print results as JSON, and nothing else, on stdout
    -v, --verbose                    Print more on stderr
    -q, --quiet                      Print only errors on stderr
    -h, --help                       Print help
  
  Examples:
    sdp3 gallery --out pictures
    sdp3 gallery --scenario child-safe-room

  $ sdp3 train --help
  Train the networks and save their float parameters.
  
  The history of the losses is saved beside them.
  
  Usage: sdp3 train [OPTIONS]
  
  Options:
        --preset <PRESET>
            Size of the job
  
            Possible values:
            - quick: Minutes: fewer recordings and epochs, a smaller network. A size that the scenario's file or --set states is kept
            - paper: The scenario's sizes; where it states none the paper's: 200 recordings per class to train, 500 to test
            
            [default: quick]
  
        --data <DIR>
            A dataset that `sdp3 simulate` wrote, instead of simulating: its room, radar, people and rho
  
        --recordings <FOLDER>
            A folder of labelled recordings of the scenario's radar: folders named as their class, or labels.csv (file, class; person, from_s and to_s are optional)
  
        --method <METHOD>
            What networks learn from
  
            Possible values:
            - recordings:      The recordings alone
            - with-simulation: Simulated and measured recordings together; their classes are the simulator's
            - fine-tuning:     Simulated recordings first, then the measured ones at a tenth of the learning rate
            
            [default: recordings]
  
        --folds <FOLDS>
            Parts of the cross-validation, at most; a person, or else a recording, is in one of them
            
            [default: 5]
  
        --hold-out-classes
            Hold out each class in turn too: the confidence below which a window is of none of the classes
  
        --carrier <HZ>
            Carrier in Hz, instead of what the file says
  
        --rate <HZ>
            Sampling or slow-time rate in Hz, instead of what the file says
  
        --gain <DB>
            Gain of the sensor in dB, which is subtracted
  
        --dataset <NAME>
            Which array of an NPZ or MATLAB file, or which dataset of an HDF5 file
  
        --antenna <N>
            Receive antenna of a radar module, from 1
  
        --chirp <N|all>
            Chirp of every frame of a radar module, from 1, or all
  
        --config <FILE>
            Description of a DCA1000 capture: the sensor's .cfg or mmWave Studio's .mmwave.json; absent: the one beside it
  
        --recipe <RECIPE>
            Optimiser, learning rate and batch in one; absent: the scenario's
  
            Possible values:
            - adamw-one-cycle: AdamW, peak 5e-3, one cycle, batch 50
            - paper-adam:      The paper's: Adam, 0.01, batch 500
            - paper-momentum:  The paper's: momentum 0.9, 0.06, batch 300
  
        --resume
            Go on from the checkpoints in --out, with the same result as without the interruption
  
        --backend <BACKEND>
            Where to train: the processor, or a GPU in a build with that feature
  
            Possible values:
            - cpu:  The processor
            - wgpu: A GPU through Vulkan, Metal, DirectX 12 or WebGPU; needs the feature `wgpu`
            - cuda: An NVIDIA GPU; needs the feature `cuda`
            
            [default: cpu]
  
        --scenario <FILE.toml|NAME>
            Scenario in TOML, or the name of one that `sdp3 scenario list` lists; absent: the paper's conference room
  
        --set <FIELD=VALUE>
            Set a field over the scenario, such as radar.carrier_hz=24e9 or frame.sensing_slots=[200,300]. May be given several times; the resolved scenario beside the results has it
  
        --seed <SEED>
            Seed of everything random [default: 1]
  
        --out <DIR>
            Folder for results
            
            [default: out]
  
        --threads <THREADS>
            Threads, at most 1024; 0 takes all processors. Results do not depend on it
            
            [default: 0]
  
        --max-memory <SIZE>
            Refuse what would need more memory by its estimate, before it begins; such as 500M or 8GiB
            
            [default: 4GiB]
  
        --max-time <TIME>
            Refuse what would take longer by its estimate, before it begins; such as 90s, 10m, 12h or 30d
            
            [default: 30d]
  
        --json
            Print results as JSON, and nothing else, on stdout
  
    -v, --verbose
            Print more on stderr
  
    -q, --quiet
            Print only errors on stderr
  
    -h, --help
            Print help (see a summary with '-h')
  
  Examples:
    sdp3 train
    sdp3 train --preset paper --recipe paper-adam --resume
    sdp3 train --data data --set learning.epochs=40 --out trained

  $ sdp3 study --help
  Run a study that takes many trainings: learning curve, robustness, fidelity, sim to real, baselines, ablation, clutter, selection.
  
  After an interruption the same command resumes.
  
  Usage: sdp3 study [OPTIONS] <NAME>
  
  Arguments:
    <NAME>
            Which question
  
            Possible values:
            - learning-curve: Accuracy over the number of sensing slots, and the curves of Table III
            - robustness:     Accuracy under other headings, rho, power, d, people and carriers
            - fidelity:       Divergence from ray tracing, a richer model and measured recordings, and recognition across the first two
            - sim-to-real:    Recognition of measured recordings by networks that learned from simulated ones alone, with baselines
            - baselines:      Accuracy of the network, a plain convolutional network and a support vector machine over the number of sensing slots
            - ablation:       Accuracy with and without each effect of the simulation, the processing and the training, at 3.5 and 60 GHz, on seeds from 101 upwards
            - clutter:        Accuracy with adaptive and with fixed clutter removal, at clutter-to-target ratios of -20 to 40 dB, on seeds from 101 upwards
            - selection:      Accuracy of candidates for the hyper-parameters at the paper's carriers, at the scenario's full sizes, on seeds from 101 upwards
  
  Options:
        --seeds <SEEDS>
            Seeds, from --seed upwards; of `ablation`, `clutter` and `selection` from 101 where --seed is absent
            
            [default: 5]
  
        --measured <FOLDER>
            Of `fidelity` and `sim-to-real`: a folder of measured recordings, in any depth, with the motion in their names (walk, run, still, stand, sit)
  
        --carrier <HZ>
            Carrier in Hz of recordings that do not say theirs
  
        --rate <HZ>
            Rate in Hz of recordings that do not say theirs
  
        --scenario <FILE.toml|NAME>
            Scenario in TOML, or the name of one that `sdp3 scenario list` lists; absent: the paper's conference room
  
        --set <FIELD=VALUE>
            Set a field over the scenario, such as radar.carrier_hz=24e9 or frame.sensing_slots=[200,300]. May be given several times; the resolved scenario beside the results has it
  
        --seed <SEED>
            Seed of everything random [default: 1]
  
        --out <DIR>
            Folder for results
            
            [default: out]
  
        --threads <THREADS>
            Threads, at most 1024; 0 takes all processors. Results do not depend on it
            
            [default: 0]
  
        --max-memory <SIZE>
            Refuse what would need more memory by its estimate, before it begins; such as 500M or 8GiB
            
            [default: 4GiB]
  
        --max-time <TIME>
            Refuse what would take longer by its estimate, before it begins; such as 90s, 10m, 12h or 30d
            
            [default: 30d]
  
        --json
            Print results as JSON, and nothing else, on stdout
  
    -v, --verbose
            Print more on stderr
  
    -q, --quiet
            Print only errors on stderr
  
    -h, --help
            Print help (see a summary with '-h')
  
  Examples:
    sdp3 study learning-curve --out curve
    sdp3 study robustness --seeds 3 --out robustness
    sdp3 study ablation --seeds 5 --out ablation
    sdp3 study fidelity --measured recordings --carrier 24.125e9 --out fidelity
    sdp3 study sim-to-real --measured recordings --carrier 24.125e9 --out sim-to-real

  $ sdp3 reproduce --help
  Make the paper's tables and figures again, beside its numbers, each with a verdict.
  
  Everything is made twice: with the settings as printed and with the scenario's. Writes a result, a figure and, when all items are there, one page, reproduction.md. After an interruption the same command resumes.
  
  Usage: sdp3 reproduce [OPTIONS] [ITEM]...
  
  Arguments:
    [ITEM]...
            Which; absent: all
  
            Possible values:
            - all:                   Every one of them
            - channel-models:        Table I: which channel model has which property
            - spectrograms:          Spectrograms of standing, pacing and walking, with one and with two people
            - kl-divergence:         KL divergence over rho, and that of ray tracing
            - intensities:           Distributions of intensity of experiment, hybrid channel and ray tracing
            - accuracy-over-epochs:  Accuracy over epochs of networks of three origins
            - training:              Training loss and test accuracy over epochs for every number of sensing slots
            - learning-curve:        Accuracy over the number of sensing slots
            - learning-curve-models: Tables II and III: seven curves and their errors
            - region:                The accuracy-throughput region of both cases with its zones
  
  Options:
        --size <SIZE>
            How large
  
            Possible values:
            - quick: Minutes: one seed, a smaller network, fewer recordings
            - paper: The paper's sizes; hours
            
            [default: quick]
  
        --seeds <SEEDS>
            Seeds, from --seed upwards (from 101 where --seed is absent); absent: one of a quick size, else five
  
        --measured <FOLDER>
            A folder of measured recordings to set beside the experiment (`kl-divergence`), in any depth, with the motion in their names
  
        --carrier <HZ>
            Carrier in Hz of recordings that do not say theirs
  
        --shard <I/N>
            Do only the I-th of N shards of the computations, and put nothing together
  
        --scenario <FILE.toml|NAME>
            Scenario in TOML, or the name of one that `sdp3 scenario list` lists; absent: the paper's conference room
  
        --set <FIELD=VALUE>
            Set a field over the scenario, such as radar.carrier_hz=24e9 or frame.sensing_slots=[200,300]. May be given several times; the resolved scenario beside the results has it
  
        --seed <SEED>
            Seed of everything random [default: 1]
  
        --out <DIR>
            Folder for results
            
            [default: out]
  
        --threads <THREADS>
            Threads, at most 1024; 0 takes all processors. Results do not depend on it
            
            [default: 0]
  
        --max-memory <SIZE>
            Refuse what would need more memory by its estimate, before it begins; such as 500M or 8GiB
            
            [default: 4GiB]
  
        --max-time <TIME>
            Refuse what would take longer by its estimate, before it begins; such as 90s, 10m, 12h or 30d
            
            [default: 30d]
  
        --json
            Print results as JSON, and nothing else, on stdout
  
    -v, --verbose
            Print more on stderr
  
    -q, --quiet
            Print only errors on stderr
  
    -h, --help
            Print help (see a summary with '-h')
  
  Examples:
    sdp3 reproduce all --size quick
    sdp3 reproduce region learning-curve --out paper
    sdp3 reproduce --size paper --seed 1001 --shard 2/8 --out paper

  $ sdp3 sweep --help
  Measure a plan of scenarios x carriers x rho x N_s x seeds, here or on a cluster.
  
  Every cell simulates, trains, quantises and tests. After an interruption the same command resumes. The shard is --shard's, else that of SLURM_ARRAY_TASK_ID (with SLURM_ARRAY_TASK_MIN and _COUNT), else that of JOB_COMPLETION_INDEX (with JOB_COMPLETIONS), else the whole.
  
  Usage: sdp3 sweep [OPTIONS] <PLAN.toml>
  
  Arguments:
    <PLAN.toml>
            The plan: name, scenarios, carrier_hz, rho, sensing_slots, seeds
  
  Options:
        --shard <I/N>
            Make only the I-th of N shards of the cells; overrides the environment
  
        --slurm
            Write a Slurm array job and the merge that depends on it, and submit both
  
        --dry-run
            Only write them
  
        --sbatch <OPTION>
            An option of sbatch for both jobs, such as --sbatch=--partition=long; may be given several times
  
        --kubernetes
            Write a Kubernetes Indexed Job with the plan in it, and the merge to apply after it
  
        --image <IMAGE>
            Container image that has sdp3 as its entry point
  
        --claim <NAME>
            Persistent volume claim, writable by many nodes, for the results
            
            [default: sdp3]
  
        --status
            Say where the sweep of --out stands and compute nothing: cells that are there, missing and unusable, of every shard with --shards, and the time that is left at the pace of the last 20 cells
  
        --shards <N>
            Shards of the job, at most one a cell; absent: one a cell, at most 100. With --status, shards to count apart
  
        --scenario <FILE.toml|NAME>
            Scenario in TOML, or the name of one that `sdp3 scenario list` lists; absent: the paper's conference room
  
        --set <FIELD=VALUE>
            Set a field over the scenario, such as radar.carrier_hz=24e9 or frame.sensing_slots=[200,300]. May be given several times; the resolved scenario beside the results has it
  
        --seed <SEED>
            Seed of everything random [default: 1]
  
        --out <DIR>
            Folder for results
            
            [default: out]
  
        --threads <THREADS>
            Threads, at most 1024; 0 takes all processors. Results do not depend on it
            
            [default: 0]
  
        --max-memory <SIZE>
            Refuse what would need more memory by its estimate, before it begins; such as 500M or 8GiB
            
            [default: 4GiB]
  
        --max-time <TIME>
            Refuse what would take longer by its estimate, before it begins; such as 90s, 10m, 12h or 30d
            
            [default: 30d]
  
        --json
            Print results as JSON, and nothing else, on stdout
  
    -v, --verbose
            Print more on stderr
  
    -q, --quiet
            Print only errors on stderr
  
    -h, --help
            Print help (see a summary with '-h')
  
  Examples:
    sdp3 sweep docs/plans/quick.toml --out quick
    sdp3 sweep plan.toml --shard 2/8 --out sweep
    sdp3 sweep plan.toml --status --shards 8 --out sweep
    sdp3 sweep plan.toml --slurm --shards 60 --sbatch=--partition=long --out sweep
    sdp3 sweep plan.toml --kubernetes --shards 60 --image registry.example/sdp3:0.1.0 --out sweep

  $ sdp3 merge --help
  Join the cells of a sweep.
  
  Writes merged.csv and merged.json if every cell is there, complete and of the same plan, and draws accuracy and throughput over every axis of the plan that varies.
  
  Usage: sdp3 merge [OPTIONS] <DIR>
  
  Arguments:
    <DIR>
            The folder that `sdp3 sweep` was given as --out
  
  Options:
        --partial
            Join the cells that are there and list those that are not: partial.csv, partial.json
  
        --scenario <FILE.toml|NAME>
            Scenario in TOML, or the name of one that `sdp3 scenario list` lists; absent: the paper's conference room
  
        --set <FIELD=VALUE>
            Set a field over the scenario, such as radar.carrier_hz=24e9 or frame.sensing_slots=[200,300]. May be given several times; the resolved scenario beside the results has it
  
        --seed <SEED>
            Seed of everything random [default: 1]
  
        --out <DIR>
            Folder for results
            
            [default: out]
  
        --threads <THREADS>
            Threads, at most 1024; 0 takes all processors. Results do not depend on it
            
            [default: 0]
  
        --max-memory <SIZE>
            Refuse what would need more memory by its estimate, before it begins; such as 500M or 8GiB
            
            [default: 4GiB]
  
        --max-time <TIME>
            Refuse what would take longer by its estimate, before it begins; such as 90s, 10m, 12h or 30d
            
            [default: 30d]
  
        --json
            Print results as JSON, and nothing else, on stdout
  
    -v, --verbose
            Print more on stderr
  
    -q, --quiet
            Print only errors on stderr
  
    -h, --help
            Print help (see a summary with '-h')
  
  Examples:
    sdp3 merge quick
    sdp3 merge quick --partial
    sdp3 merge quick --json

  $ sdp3 quantize --help
  Convert trained networks into int8 model files
  
  Usage: sdp3 quantize [OPTIONS]
  
  Options:
        --data <DIR>                 The dataset they were trained on, to measure ranges on; absent: training recordings are simulated
        --scenario <FILE.toml|NAME>  Scenario in TOML, or the name of one that `sdp3 scenario list` lists; absent: the paper's conference room
        --set <FIELD=VALUE>          Set a field over the scenario, such as radar.carrier_hz=24e9 or frame.sensing_slots=[200,300]. May be given several times; the resolved scenario beside the results has it
        --seed <SEED>                Seed of everything random [default: 1]
        --out <DIR>                  Folder for results [default: out]
        --threads <THREADS>          Threads, at most 1024; 0 takes all processors. Results do not depend on it [default: 0]
        --max-memory <SIZE>          Refuse what would need more memory by its estimate, before it begins; such as 500M or 8GiB [default: 4GiB]
        --max-time <TIME>            Refuse what would take longer by its estimate, before it begins; such as 90s, 10m, 12h or 30d [default: 30d]
        --json                       Print results as JSON, and nothing else, on stdout
    -v, --verbose                    Print more on stderr
    -q, --quiet                      Print only errors on stderr
    -h, --help                       Print help
  
  Examples:
    sdp3 quantize
    sdp3 quantize --data data --out trained

  $ sdp3 export --help
  Write a network for other programs (.tflite, .safetensors).
  
  A model file is written as .tflite, float parameters as .safetensors.
  
  Usage: sdp3 export [OPTIONS] --to <FILE> <FILE>
  
  Arguments:
    <FILE>
            MODEL.sdp3, or NETWORK.json as `sdp3 train` writes it
  
  Options:
        --to <FILE>
            FILE.tflite of a model file, FILE.safetensors of float parameters
  
        --scenario <FILE.toml|NAME>
            Scenario in TOML, or the name of one that `sdp3 scenario list` lists; absent: the paper's conference room
  
        --set <FIELD=VALUE>
            Set a field over the scenario, such as radar.carrier_hz=24e9 or frame.sensing_slots=[200,300]. May be given several times; the resolved scenario beside the results has it
  
        --seed <SEED>
            Seed of everything random [default: 1]
  
        --out <DIR>
            Folder for results
            
            [default: out]
  
        --threads <THREADS>
            Threads, at most 1024; 0 takes all processors. Results do not depend on it
            
            [default: 0]
  
        --max-memory <SIZE>
            Refuse what would need more memory by its estimate, before it begins; such as 500M or 8GiB
            
            [default: 4GiB]
  
        --max-time <TIME>
            Refuse what would take longer by its estimate, before it begins; such as 90s, 10m, 12h or 30d
            
            [default: 30d]
  
        --json
            Print results as JSON, and nothing else, on stdout
  
    -v, --verbose
            Print more on stderr
  
    -q, --quiet
            Print only errors on stderr
  
    -h, --help
            Print help (see a summary with '-h')
  
  Examples:
    sdp3 export out/models/dsn-1000.sdp3 --to dsn.tflite
    sdp3 export out/models/dsn-1000.json --to dsn.safetensors

  $ sdp3 import --help
  Read a network of another program.
  
  The file is int8 .tflite of convolutions, poolings, additions, fully connected layers and softmax, or float .safetensors of the paper's topology, which is quantised.
  
  Usage: sdp3 import [OPTIONS] --to <FILE> <FILE>
  
  Arguments:
    <FILE>
            FILE.tflite or FILE.safetensors
  
  Options:
        --to <FILE>
            MODEL.sdp3; of .tflite also NETWORK.graph, a network of any input that is not the radar's; of .safetensors also NETWORK.json, float parameters as `sdp3 quantize` reads them
  
        --slots <N>
            Sensing slots it was trained with, where the file does not say
  
        --scenario <FILE.toml|NAME>
            Scenario in TOML, or the name of one that `sdp3 scenario list` lists; absent: the paper's conference room
  
        --set <FIELD=VALUE>
            Set a field over the scenario, such as radar.carrier_hz=24e9 or frame.sensing_slots=[200,300]. May be given several times; the resolved scenario beside the results has it
  
        --seed <SEED>
            Seed of everything random [default: 1]
  
        --out <DIR>
            Folder for results
            
            [default: out]
  
        --threads <THREADS>
            Threads, at most 1024; 0 takes all processors. Results do not depend on it
            
            [default: 0]
  
        --max-memory <SIZE>
            Refuse what would need more memory by its estimate, before it begins; such as 500M or 8GiB
            
            [default: 4GiB]
  
        --max-time <TIME>
            Refuse what would take longer by its estimate, before it begins; such as 90s, 10m, 12h or 30d
            
            [default: 30d]
  
        --json
            Print results as JSON, and nothing else, on stdout
  
    -v, --verbose
            Print more on stderr
  
    -q, --quiet
            Print only errors on stderr
  
    -h, --help
            Print help (see a summary with '-h')
  
  Examples:
    sdp3 import dsn.tflite --to dsn.sdp3
    sdp3 import resnet8.tflite --to resnet8.graph
    sdp3 import dsn.safetensors --to dsn.sdp3 --slots 1000

  $ sdp3 model --help
  Show, sign and verify model files, make keys
  
  Usage: sdp3 model [OPTIONS] <COMMAND>
  
  Commands:
    show    Show what a model file holds: envelope, network, memory it needs
    keygen  Make a key pair: NAME.key, to be kept secret, signs; NAME.pub is what firmware is built with. Existing files are kept
    sign    Sign a model file, for firmware that accepts only signed models
    verify  Check whether firmware built with a public key accepts the model: exit code 1 and the reason if it does not
    help    Print this message or the help of the given subcommand(s)
  
  Options:
        --scenario <FILE.toml|NAME>  Scenario in TOML, or the name of one that `sdp3 scenario list` lists; absent: the paper's conference room
        --set <FIELD=VALUE>          Set a field over the scenario, such as radar.carrier_hz=24e9 or frame.sensing_slots=[200,300]. May be given several times; the resolved scenario beside the results has it
        --seed <SEED>                Seed of everything random [default: 1]
        --out <DIR>                  Folder for results [default: out]
        --threads <THREADS>          Threads, at most 1024; 0 takes all processors. Results do not depend on it [default: 0]
        --max-memory <SIZE>          Refuse what would need more memory by its estimate, before it begins; such as 500M or 8GiB [default: 4GiB]
        --max-time <TIME>            Refuse what would take longer by its estimate, before it begins; such as 90s, 10m, 12h or 30d [default: 30d]
        --json                       Print results as JSON, and nothing else, on stdout
    -v, --verbose                    Print more on stderr
    -q, --quiet                      Print only errors on stderr
    -h, --help                       Print help
  
  Examples:
    sdp3 model show out/models/dsn-1000.sdp3
    sdp3 model keygen radio
    sdp3 model sign out/models/dsn-1000.sdp3 --key radio.key --revision 7 --to signed.sdp3
    sdp3 model verify signed.sdp3 --key radio.pub --oldest 7

  $ sdp3 model show --help
  Show what a model file holds: envelope, network, memory it needs
  
  Usage: sdp3 model show [OPTIONS] <FILE>
  
  Arguments:
    <FILE>  MODEL.sdp3 or NETWORK.graph
  
  Options:
        --scenario <FILE.toml|NAME>  Scenario in TOML, or the name of one that `sdp3 scenario list` lists; absent: the paper's conference room
        --set <FIELD=VALUE>          Set a field over the scenario, such as radar.carrier_hz=24e9 or frame.sensing_slots=[200,300]. May be given several times; the resolved scenario beside the results has it
        --seed <SEED>                Seed of everything random [default: 1]
        --out <DIR>                  Folder for results [default: out]
        --threads <THREADS>          Threads, at most 1024; 0 takes all processors. Results do not depend on it [default: 0]
        --max-memory <SIZE>          Refuse what would need more memory by its estimate, before it begins; such as 500M or 8GiB [default: 4GiB]
        --max-time <TIME>            Refuse what would take longer by its estimate, before it begins; such as 90s, 10m, 12h or 30d [default: 30d]
        --json                       Print results as JSON, and nothing else, on stdout
    -v, --verbose                    Print more on stderr
    -q, --quiet                      Print only errors on stderr
    -h, --help                       Print help
  
  Examples:
    sdp3 model show out/models/dsn-1000.sdp3
    sdp3 model show signed.sdp3 --json

  $ sdp3 model keygen --help
  Make a key pair: NAME.key, to be kept secret, signs; NAME.pub is what firmware is built with. Existing files are kept
  
  Usage: sdp3 model keygen [OPTIONS] <NAME>
  
  Arguments:
    <NAME>  NAME; existing files are kept
  
  Options:
        --scenario <FILE.toml|NAME>  Scenario in TOML, or the name of one that `sdp3 scenario list` lists; absent: the paper's conference room
        --set <FIELD=VALUE>          Set a field over the scenario, such as radar.carrier_hz=24e9 or frame.sensing_slots=[200,300]. May be given several times; the resolved scenario beside the results has it
        --seed <SEED>                Seed of everything random [default: 1]
        --out <DIR>                  Folder for results [default: out]
        --threads <THREADS>          Threads, at most 1024; 0 takes all processors. Results do not depend on it [default: 0]
        --max-memory <SIZE>          Refuse what would need more memory by its estimate, before it begins; such as 500M or 8GiB [default: 4GiB]
        --max-time <TIME>            Refuse what would take longer by its estimate, before it begins; such as 90s, 10m, 12h or 30d [default: 30d]
        --json                       Print results as JSON, and nothing else, on stdout
    -v, --verbose                    Print more on stderr
    -q, --quiet                      Print only errors on stderr
    -h, --help                       Print help
  
  Examples:
    sdp3 model keygen radio
    sdp3 model keygen keys/release --json

  $ sdp3 model sign --help
  Sign a model file, for firmware that accepts only signed models
  
  Usage: sdp3 model sign [OPTIONS] --key <NAME.key> --to <FILE> <FILE>
  
  Arguments:
    <FILE>  MODEL.sdp3
  
  Options:
        --key <NAME.key>             Secret key
        --revision <N>               Its revision: firmware that ran a later one refuses it [default: 0]
        --to <FILE>                  Where the signed model goes
        --scenario <FILE.toml|NAME>  Scenario in TOML, or the name of one that `sdp3 scenario list` lists; absent: the paper's conference room
        --set <FIELD=VALUE>          Set a field over the scenario, such as radar.carrier_hz=24e9 or frame.sensing_slots=[200,300]. May be given several times; the resolved scenario beside the results has it
        --seed <SEED>                Seed of everything random [default: 1]
        --out <DIR>                  Folder for results [default: out]
        --threads <THREADS>          Threads, at most 1024; 0 takes all processors. Results do not depend on it [default: 0]
        --max-memory <SIZE>          Refuse what would need more memory by its estimate, before it begins; such as 500M or 8GiB [default: 4GiB]
        --max-time <TIME>            Refuse what would take longer by its estimate, before it begins; such as 90s, 10m, 12h or 30d [default: 30d]
        --json                       Print results as JSON, and nothing else, on stdout
    -v, --verbose                    Print more on stderr
    -q, --quiet                      Print only errors on stderr
    -h, --help                       Print help
  
  Examples:
    sdp3 model sign out/models/dsn-1000.sdp3 --key radio.key --revision 7 --to signed.sdp3

  $ sdp3 model verify --help
  Check whether firmware built with a public key accepts the model: exit code 1 and the reason if it does not
  
  Usage: sdp3 model verify [OPTIONS] --key <NAME.pub> <FILE>
  
  Arguments:
    <FILE>  MODEL.sdp3
  
  Options:
        --key <NAME.pub>             Public key that must have signed it
        --oldest <N>                 The largest revision the radio has run: an older one is a rollback [default: 0]
        --scenario <FILE.toml|NAME>  Scenario in TOML, or the name of one that `sdp3 scenario list` lists; absent: the paper's conference room
        --set <FIELD=VALUE>          Set a field over the scenario, such as radar.carrier_hz=24e9 or frame.sensing_slots=[200,300]. May be given several times; the resolved scenario beside the results has it
        --seed <SEED>                Seed of everything random [default: 1]
        --out <DIR>                  Folder for results [default: out]
        --threads <THREADS>          Threads, at most 1024; 0 takes all processors. Results do not depend on it [default: 0]
        --max-memory <SIZE>          Refuse what would need more memory by its estimate, before it begins; such as 500M or 8GiB [default: 4GiB]
        --max-time <TIME>            Refuse what would take longer by its estimate, before it begins; such as 90s, 10m, 12h or 30d [default: 30d]
        --json                       Print results as JSON, and nothing else, on stdout
    -v, --verbose                    Print more on stderr
    -q, --quiet                      Print only errors on stderr
    -h, --help                       Print help
  
  Examples:
    sdp3 model verify signed.sdp3 --key radio.pub
    sdp3 model verify signed.sdp3 --key radio.pub --oldest 7 --json

  $ sdp3 verify --help
  Compare the core with its reference and its firmware, bit for bit.
  
  The models are those of --out.
  
  Usage: sdp3 verify [OPTIONS]
  
  Options:
        --targets <NAMES>
            Targets to compare
            
            [default: host-reference cortex-m4f riscv32imac]
            [possible values: host-reference, cortex-m3, cortex-m4f, cortex-m7, cortex-m33, cortex-m55, riscv32imac, riscv32imafc, cortex-a53]
  
        --firmware <DIR>
            Folder of ready-built firmware; absent: firmware-sim/build makes it
  
        --scenario <FILE.toml|NAME>
            Scenario in TOML, or the name of one that `sdp3 scenario list` lists; absent: the paper's conference room
  
        --set <FIELD=VALUE>
            Set a field over the scenario, such as radar.carrier_hz=24e9 or frame.sensing_slots=[200,300]. May be given several times; the resolved scenario beside the results has it
  
        --seed <SEED>
            Seed of everything random [default: 1]
  
        --out <DIR>
            Folder for results
            
            [default: out]
  
        --threads <THREADS>
            Threads, at most 1024; 0 takes all processors. Results do not depend on it
            
            [default: 0]
  
        --max-memory <SIZE>
            Refuse what would need more memory by its estimate, before it begins; such as 500M or 8GiB
            
            [default: 4GiB]
  
        --max-time <TIME>
            Refuse what would take longer by its estimate, before it begins; such as 90s, 10m, 12h or 30d
            
            [default: 30d]
  
        --json
            Print results as JSON, and nothing else, on stdout
  
    -v, --verbose
            Print more on stderr
  
    -q, --quiet
            Print only errors on stderr
  
    -h, --help
            Print help (see a summary with '-h')
  
  Examples:
    sdp3 verify
    sdp3 verify --targets host-reference,cortex-m4f --json

  $ sdp3 predict --help
  Fit the seven learning curves to accuracies
  
  Usage: sdp3 predict [OPTIONS]
  
  Options:
        --points <FILE>              CSV or JSON with sensing_slots, accuracy[, tested][, std], or results of this tool; absent: the accuracies of --out's run
        --scenario <FILE.toml|NAME>  Scenario in TOML, or the name of one that `sdp3 scenario list` lists; absent: the paper's conference room
        --set <FIELD=VALUE>          Set a field over the scenario, such as radar.carrier_hz=24e9 or frame.sensing_slots=[200,300]. May be given several times; the resolved scenario beside the results has it
        --seed <SEED>                Seed of everything random [default: 1]
        --out <DIR>                  Folder for results [default: out]
        --threads <THREADS>          Threads, at most 1024; 0 takes all processors. Results do not depend on it [default: 0]
        --max-memory <SIZE>          Refuse what would need more memory by its estimate, before it begins; such as 500M or 8GiB [default: 4GiB]
        --max-time <TIME>            Refuse what would take longer by its estimate, before it begins; such as 90s, 10m, 12h or 30d [default: 30d]
        --json                       Print results as JSON, and nothing else, on stdout
    -v, --verbose                    Print more on stderr
    -q, --quiet                      Print only errors on stderr
    -h, --help                       Print help
  
  Examples:
    sdp3 predict
    sdp3 predict --points points.csv --json

  $ sdp3 optimize --help
  Draw the accuracy-throughput region and choose a point on it
  
  Usage: sdp3 optimize [OPTIONS]
  
  Options:
        --points <FILE>              CSV or JSON with sensing_slots, accuracy[, tested][, std], or results of this tool; absent: the accuracies of --out's run. Of points with several N_m in spacing_slots, the best N_m is chosen
        --retest                     Test --out's int8 models again on test recordings of the scenario with what --set changes, such as channel.rho, and take those accuracies. Nothing is trained
        --curve <NAME>               Learning curve; absent: the best one [possible values: vapor_pressure, pow3, log_power, exp4, log_log_linear, ilog2, pow4]
        --accuracy <ACCURACY>        Accuracy of at least this, 0 to 1
        --throughput <THROUGHPUT>    Throughput of at least this, in bits per period
        --weight <WEIGHT>            Weight of accuracy, 0 to 1; throughput has the rest, both over their span on the boundary
        --weights <WA,WR>            w_A and w_R of the paper's sum w_A A + w_R R, R in bits per period
        --sweep <AXIS=VALUES>        Vary carrier_hz, power_w, users (their number) or distance (a factor): AXIS=VALUE,VALUE,... May be given several times
        --scenario <FILE.toml|NAME>  Scenario in TOML, or the name of one that `sdp3 scenario list` lists; absent: the paper's conference room
        --set <FIELD=VALUE>          Set a field over the scenario, such as radar.carrier_hz=24e9 or frame.sensing_slots=[200,300]. May be given several times; the resolved scenario beside the results has it
        --seed <SEED>                Seed of everything random [default: 1]
        --out <DIR>                  Folder for results [default: out]
        --threads <THREADS>          Threads, at most 1024; 0 takes all processors. Results do not depend on it [default: 0]
        --max-memory <SIZE>          Refuse what would need more memory by its estimate, before it begins; such as 500M or 8GiB [default: 4GiB]
        --max-time <TIME>            Refuse what would take longer by its estimate, before it begins; such as 90s, 10m, 12h or 30d [default: 30d]
        --json                       Print results as JSON, and nothing else, on stdout
    -v, --verbose                    Print more on stderr
    -q, --quiet                      Print only errors on stderr
    -h, --help                       Print help
  
  Examples:
    sdp3 optimize --accuracy 0.9
    sdp3 optimize --points points.csv --weights 1,1e-5 --json
    sdp3 optimize --sweep power_w=1e-6,1 --sweep users=1,2,3

  $ sdp3 early-exits --help
  Fit early exits and draw their region beside the static one.
  
  The models are those of --out.
  
  Usage: sdp3 early-exits [OPTIONS]
  
  Options:
        --calibrate-per-class <CALIBRATE_PER_CLASS>
            Recordings of each class to fit and choose on. They follow those trained on
            
            [default: 200]
  
        --accuracy <ACCURACY>
            Accuracy of at least this, 0 to 1
  
        --throughput <THROUGHPUT>
            Throughput of at least this, in bits per period
  
        --weight <WEIGHT>
            Weight of accuracy, 0 to 1; throughput has the rest, both over their span on the boundary
  
        --weights <WA,WR>
            w_A and w_R of the paper's sum w_A A + w_R R, R in bits per period
  
        --scenario <FILE.toml|NAME>
            Scenario in TOML, or the name of one that `sdp3 scenario list` lists; absent: the paper's conference room
  
        --set <FIELD=VALUE>
            Set a field over the scenario, such as radar.carrier_hz=24e9 or frame.sensing_slots=[200,300]. May be given several times; the resolved scenario beside the results has it
  
        --seed <SEED>
            Seed of everything random [default: 1]
  
        --out <DIR>
            Folder for results
            
            [default: out]
  
        --threads <THREADS>
            Threads, at most 1024; 0 takes all processors. Results do not depend on it
            
            [default: 0]
  
        --max-memory <SIZE>
            Refuse what would need more memory by its estimate, before it begins; such as 500M or 8GiB
            
            [default: 4GiB]
  
        --max-time <TIME>
            Refuse what would take longer by its estimate, before it begins; such as 90s, 10m, 12h or 30d
            
            [default: 30d]
  
        --json
            Print results as JSON, and nothing else, on stdout
  
    -v, --verbose
            Print more on stderr
  
    -q, --quiet
            Print only errors on stderr
  
    -h, --help
            Print help (see a summary with '-h')
  
  Examples:
    sdp3 early-exits
    sdp3 early-exits --calibrate-per-class 500 --accuracy 0.9

  $ sdp3 schedule --help
  Play the operating point through the core's scheduler.
  
  Plays one period of the operating point of --out's run, or with --periods many, with traffic, churn, fading and loss.
  
  Usage: sdp3 schedule [OPTIONS]
  
  Options:
        --periods <PERIODS>
            Periods; absent: one, in which nothing changes
  
        --sensing-slots <N>
            N_s; absent: that of the run's operating point
  
        --coherence <S>
            Mean time in s between changes of a channel (fading)
            
            [default: 5]
  
        --load <SHARE>
            Mean arrivals of a user over its fair share; absent: always something to send
  
        --churn <P>
            Probability that a user joins or leaves in a period
            
            [default: 0.02]
  
        --loss <P>
            Probability that a slot is lost
            
            [default: 0.0005]
  
        --retarget <P>
            Probability that N_s becomes another of the scenario's in a period
            
            [default: 0.02]
  
        --recognise-every <N>
            Run a recognition every N periods (0 disables it): raw I/Q through the core with the models of --out
            
            [default: 0]
  
        --threshold <CONFIDENCE>
            Confidence that ends sensing early, with the weights that `sdp3 early-exits` wrote to --out
  
        --traced <PERIODS>
            Periods written slot by slot to trace.json, for Perfetto
            
            [default: 3]
  
        --scenario <FILE.toml|NAME>
            Scenario in TOML, or the name of one that `sdp3 scenario list` lists; absent: the paper's conference room
  
        --set <FIELD=VALUE>
            Set a field over the scenario, such as radar.carrier_hz=24e9 or frame.sensing_slots=[200,300]. May be given several times; the resolved scenario beside the results has it
  
        --seed <SEED>
            Seed of everything random [default: 1]
  
        --out <DIR>
            Folder for results
            
            [default: out]
  
        --threads <THREADS>
            Threads, at most 1024; 0 takes all processors. Results do not depend on it
            
            [default: 0]
  
        --max-memory <SIZE>
            Refuse what would need more memory by its estimate, before it begins; such as 500M or 8GiB
            
            [default: 4GiB]
  
        --max-time <TIME>
            Refuse what would take longer by its estimate, before it begins; such as 90s, 10m, 12h or 30d
            
            [default: 30d]
  
        --json
            Print results as JSON, and nothing else, on stdout
  
    -v, --verbose
            Print more on stderr
  
    -q, --quiet
            Print only errors on stderr
  
    -h, --help
            Print help (see a summary with '-h')
  
  Examples:
    sdp3 schedule
    sdp3 schedule --periods 1000 --sensing-slots 300 --load 0.8
    sdp3 schedule --periods 200 --recognise-every 10 --threshold 0.9

  $ sdp3 report --help
  Write the report page and its figures again.
  
  They are those of --out's run. The figures are SVG and PNG.
  
  Usage: sdp3 report [OPTIONS]
  
  Options:
        --program <FILE.wasm>
            `sdp3-page` in WebAssembly, for the page to compute with: it classifies recordings that are dropped on it, and computes the region for other links. Without this option it is taken from the folder of `sdp3`, if it is there
  
        --scenario <FILE.toml|NAME>
            Scenario in TOML, or the name of one that `sdp3 scenario list` lists; absent: the paper's conference room
  
        --set <FIELD=VALUE>
            Set a field over the scenario, such as radar.carrier_hz=24e9 or frame.sensing_slots=[200,300]. May be given several times; the resolved scenario beside the results has it
  
        --seed <SEED>
            Seed of everything random [default: 1]
  
        --out <DIR>
            Folder for results
            
            [default: out]
  
        --threads <THREADS>
            Threads, at most 1024; 0 takes all processors. Results do not depend on it
            
            [default: 0]
  
        --max-memory <SIZE>
            Refuse what would need more memory by its estimate, before it begins; such as 500M or 8GiB
            
            [default: 4GiB]
  
        --max-time <TIME>
            Refuse what would take longer by its estimate, before it begins; such as 90s, 10m, 12h or 30d
            
            [default: 30d]
  
        --json
            Print results as JSON, and nothing else, on stdout
  
    -v, --verbose
            Print more on stderr
  
    -q, --quiet
            Print only errors on stderr
  
    -h, --help
            Print help (see a summary with '-h')
  
  Examples:
    sdp3 report
    sdp3 report --out small
    sdp3 report --program sdp3-page.wasm

  $ sdp3 scenario --help
  List, print, write and check scenarios
  
  Usage: sdp3 scenario [OPTIONS] <COMMAND>
  
  Commands:
    list   List the scenarios that come with the tool
    show   Print a scenario, every field with its meaning, unit and legal range
    new    Write a scenario to a new file, every field with its meaning, unit and legal range. An existing file is kept
    check  Report everything that is wrong with a scenario file: exit code 2 if anything is
    help   Print this message or the help of the given subcommand(s)
  
  Options:
        --scenario <FILE.toml|NAME>  Scenario in TOML, or the name of one that `sdp3 scenario list` lists; absent: the paper's conference room
        --set <FIELD=VALUE>          Set a field over the scenario, such as radar.carrier_hz=24e9 or frame.sensing_slots=[200,300]. May be given several times; the resolved scenario beside the results has it
        --seed <SEED>                Seed of everything random [default: 1]
        --out <DIR>                  Folder for results [default: out]
        --threads <THREADS>          Threads, at most 1024; 0 takes all processors. Results do not depend on it [default: 0]
        --max-memory <SIZE>          Refuse what would need more memory by its estimate, before it begins; such as 500M or 8GiB [default: 4GiB]
        --max-time <TIME>            Refuse what would take longer by its estimate, before it begins; such as 90s, 10m, 12h or 30d [default: 30d]
        --json                       Print results as JSON, and nothing else, on stdout
    -v, --verbose                    Print more on stderr
    -q, --quiet                      Print only errors on stderr
    -h, --help                       Print help
  
  Examples:
    sdp3 scenario list
    sdp3 scenario show child-safe-room
    sdp3 scenario new room.toml
    sdp3 scenario check room.toml

  $ sdp3 schema --help
  Print the JSON Schema of what a command prints with --json
  
  Usage: sdp3 schema [OPTIONS] [COMMAND]
  
  Arguments:
    [COMMAND]  A command, with hyphens between its words, or `scenario`; absent: the names there are [possible values: calibrate, channels, classify, early-exits, export, gallery, import, infer, inspect, man, merge, model-keygen, model-show, model-sign, model-verify, optimize, predict, quantize, report, reproduce, run, scenario, scenario-check, scenario-list, scenario-new, scenario-show, schedule, schema, simulate, study, sweep, targets, train, verify]
  
  Options:
        --scenario <FILE.toml|NAME>  Scenario in TOML, or the name of one that `sdp3 scenario list` lists; absent: the paper's conference room
        --set <FIELD=VALUE>          Set a field over the scenario, such as radar.carrier_hz=24e9 or frame.sensing_slots=[200,300]. May be given several times; the resolved scenario beside the results has it
        --seed <SEED>                Seed of everything random [default: 1]
        --out <DIR>                  Folder for results [default: out]
        --threads <THREADS>          Threads, at most 1024; 0 takes all processors. Results do not depend on it [default: 0]
        --max-memory <SIZE>          Refuse what would need more memory by its estimate, before it begins; such as 500M or 8GiB [default: 4GiB]
        --max-time <TIME>            Refuse what would take longer by its estimate, before it begins; such as 90s, 10m, 12h or 30d [default: 30d]
        --json                       Print results as JSON, and nothing else, on stdout
    -v, --verbose                    Print more on stderr
    -q, --quiet                      Print only errors on stderr
    -h, --help                       Print help
  
  Examples:
    sdp3 schema
    sdp3 schema run
    sdp3 schema scenario-check

  $ sdp3 completions --help
  Print a script that completes commands in a shell
  
  Usage: sdp3 completions [OPTIONS] <SHELL>
  
  Arguments:
    <SHELL>  The shell [possible values: bash, elvish, fish, powershell, zsh]
  
  Options:
        --scenario <FILE.toml|NAME>  Scenario in TOML, or the name of one that `sdp3 scenario list` lists; absent: the paper's conference room
        --set <FIELD=VALUE>          Set a field over the scenario, such as radar.carrier_hz=24e9 or frame.sensing_slots=[200,300]. May be given several times; the resolved scenario beside the results has it
        --seed <SEED>                Seed of everything random [default: 1]
        --out <DIR>                  Folder for results [default: out]
        --threads <THREADS>          Threads, at most 1024; 0 takes all processors. Results do not depend on it [default: 0]
        --max-memory <SIZE>          Refuse what would need more memory by its estimate, before it begins; such as 500M or 8GiB [default: 4GiB]
        --max-time <TIME>            Refuse what would take longer by its estimate, before it begins; such as 90s, 10m, 12h or 30d [default: 30d]
        --json                       Print results as JSON, and nothing else, on stdout
    -v, --verbose                    Print more on stderr
    -q, --quiet                      Print only errors on stderr
    -h, --help                       Print help
  
  Examples:
    sdp3 completions bash > /etc/bash_completion.d/sdp3
    sdp3 completions zsh > ~/.zfunc/_sdp3
    sdp3 completions fish > ~/.config/fish/completions/sdp3.fish

  $ sdp3 man --help
  Write manual pages.
  
  There is one page for the tool and one for every command.
  
  Usage: sdp3 man [OPTIONS] <DIR>
  
  Arguments:
    <DIR>
            The folder, which is created if it does not exist
  
  Options:
        --scenario <FILE.toml|NAME>
            Scenario in TOML, or the name of one that `sdp3 scenario list` lists; absent: the paper's conference room
  
        --set <FIELD=VALUE>
            Set a field over the scenario, such as radar.carrier_hz=24e9 or frame.sensing_slots=[200,300]. May be given several times; the resolved scenario beside the results has it
  
        --seed <SEED>
            Seed of everything random [default: 1]
  
        --out <DIR>
            Folder for results
            
            [default: out]
  
        --threads <THREADS>
            Threads, at most 1024; 0 takes all processors. Results do not depend on it
            
            [default: 0]
  
        --max-memory <SIZE>
            Refuse what would need more memory by its estimate, before it begins; such as 500M or 8GiB
            
            [default: 4GiB]
  
        --max-time <TIME>
            Refuse what would take longer by its estimate, before it begins; such as 90s, 10m, 12h or 30d
            
            [default: 30d]
  
        --json
            Print results as JSON, and nothing else, on stdout
  
    -v, --verbose
            Print more on stderr
  
    -q, --quiet
            Print only errors on stderr
  
    -h, --help
            Print help (see a summary with '-h')
  
  Examples:
    sdp3 man /usr/local/share/man/man1
    sdp3 man pages --json

  $ sdp3 scenario list --help
  List the scenarios that come with the tool
  
  Usage: sdp3 scenario list [OPTIONS]
  
  Options:
        --scenario <FILE.toml|NAME>  Scenario in TOML, or the name of one that `sdp3 scenario list` lists; absent: the paper's conference room
        --set <FIELD=VALUE>          Set a field over the scenario, such as radar.carrier_hz=24e9 or frame.sensing_slots=[200,300]. May be given several times; the resolved scenario beside the results has it
        --seed <SEED>                Seed of everything random [default: 1]
        --out <DIR>                  Folder for results [default: out]
        --threads <THREADS>          Threads, at most 1024; 0 takes all processors. Results do not depend on it [default: 0]
        --max-memory <SIZE>          Refuse what would need more memory by its estimate, before it begins; such as 500M or 8GiB [default: 4GiB]
        --max-time <TIME>            Refuse what would take longer by its estimate, before it begins; such as 90s, 10m, 12h or 30d [default: 30d]
        --json                       Print results as JSON, and nothing else, on stdout
    -v, --verbose                    Print more on stderr
    -q, --quiet                      Print only errors on stderr
    -h, --help                       Print help
  
  Examples:
    sdp3 scenario list
    sdp3 scenario list --json

  $ sdp3 scenario show --help
  Print a scenario, every field with its meaning, unit and legal range
  
  Usage: sdp3 scenario show [OPTIONS] [NAME|FILE]
  
  Arguments:
    [NAME|FILE]  A file, or the name of a scenario that comes with the tool; absent: that of --scenario, or else the paper's room
  
  Options:
        --set <FIELD=VALUE>  Set a field over the scenario, such as radar.carrier_hz=24e9 or frame.sensing_slots=[200,300]. May be given several times; the resolved scenario beside the results has it
        --seed <SEED>        Seed of everything random [default: 1]
        --out <DIR>          Folder for results [default: out]
        --threads <THREADS>  Threads, at most 1024; 0 takes all processors. Results do not depend on it [default: 0]
        --max-memory <SIZE>  Refuse what would need more memory by its estimate, before it begins; such as 500M or 8GiB [default: 4GiB]
        --max-time <TIME>    Refuse what would take longer by its estimate, before it begins; such as 90s, 10m, 12h or 30d [default: 30d]
        --json               Print results as JSON, and nothing else, on stdout
    -v, --verbose            Print more on stderr
    -q, --quiet              Print only errors on stderr
    -h, --help               Print help
  
  Examples:
    sdp3 scenario show
    sdp3 scenario show small-radar
    sdp3 scenario show room.toml --set radar.carrier_hz=24e9 --json

  $ sdp3 scenario new --help
  Write a scenario to a new file, every field with its meaning, unit and legal range. An existing file is kept
  
  Usage: sdp3 scenario new [OPTIONS] <FILE.toml>
  
  Arguments:
    <FILE.toml>  The file to make
  
  Options:
        --from <NAME|FILE>           A file, or the name of a scenario that comes with the tool, to begin with; absent: that of --scenario, or else the paper's room
        --scenario <FILE.toml|NAME>  Scenario in TOML, or the name of one that `sdp3 scenario list` lists; absent: the paper's conference room
        --set <FIELD=VALUE>          Set a field over the scenario, such as radar.carrier_hz=24e9 or frame.sensing_slots=[200,300]. May be given several times; the resolved scenario beside the results has it
        --seed <SEED>                Seed of everything random [default: 1]
        --out <DIR>                  Folder for results [default: out]
        --threads <THREADS>          Threads, at most 1024; 0 takes all processors. Results do not depend on it [default: 0]
        --max-memory <SIZE>          Refuse what would need more memory by its estimate, before it begins; such as 500M or 8GiB [default: 4GiB]
        --max-time <TIME>            Refuse what would take longer by its estimate, before it begins; such as 90s, 10m, 12h or 30d [default: 30d]
        --json                       Print results as JSON, and nothing else, on stdout
    -v, --verbose                    Print more on stderr
    -q, --quiet                      Print only errors on stderr
    -h, --help                       Print help
  
  Examples:
    sdp3 scenario new room.toml
    sdp3 scenario new cheap.toml --from small-radar --set name=cheap

  $ sdp3 scenario check --help
  Report everything that is wrong with a scenario file: exit code 2 if anything is
  
  Usage: sdp3 scenario check [OPTIONS] <FILE.toml>
  
  Arguments:
    <FILE.toml>  The file
  
  Options:
        --scenario <FILE.toml|NAME>  Scenario in TOML, or the name of one that `sdp3 scenario list` lists; absent: the paper's conference room
        --set <FIELD=VALUE>          Set a field over the scenario, such as radar.carrier_hz=24e9 or frame.sensing_slots=[200,300]. May be given several times; the resolved scenario beside the results has it
        --seed <SEED>                Seed of everything random [default: 1]
        --out <DIR>                  Folder for results [default: out]
        --threads <THREADS>          Threads, at most 1024; 0 takes all processors. Results do not depend on it [default: 0]
        --max-memory <SIZE>          Refuse what would need more memory by its estimate, before it begins; such as 500M or 8GiB [default: 4GiB]
        --max-time <TIME>            Refuse what would take longer by its estimate, before it begins; such as 90s, 10m, 12h or 30d [default: 30d]
        --json                       Print results as JSON, and nothing else, on stdout
    -v, --verbose                    Print more on stderr
    -q, --quiet                      Print only errors on stderr
    -h, --help                       Print help
  
  Examples:
    sdp3 scenario check room.toml
    sdp3 scenario check room.toml --json
