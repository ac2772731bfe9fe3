//! The command line: one subcommand, one function; a file for each group of them.

mod cluster;
mod context;
mod job;
mod models;
mod optimizer;
mod program;
mod recordings;
mod reference;
mod scenarios;
mod simulator;
#[cfg(feature = "train")]
mod trainer;
mod training;

pub use program::main;

use crate::error::Failure;
use clap::{Parser, Subcommand};
use context::{Common, Context};

/// How many slots must be spent on radar to recognise how a person moves, and what does that cost in throughput?
#[derive(Debug, Parser)]
#[command(name = "sdp3", version = crate::VERSION, about, after_help = EXAMPLES)]
pub struct Cli {
    /// What to do; without one, `run`.
    #[command(subcommand)]
    pub command: Option<Command>,
    /// Options of every command.
    #[command(flatten)]
    pub common: Common,
}

const EXAMPLES: &str = "Examples:
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
Exit code: 0 done, 1 a check failed, 2 usage, input or I/O error, 130 interrupted.";

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run the main job: simulate, calibrate, train, run, verify, optimize, schedule, report.
    #[command(after_help = "Examples:
  sdp3 run
  sdp3 run --preset paper --threads 8 --resume
  sdp3 run --measured walk.wav --carrier 24.125e9 --targets host-reference
  sdp3 run --scenario small-radar --set radar.carrier_hz=5.8e9 --out small --json")]
    Run(job::RunArgs),
    /// Simulate recordings and write them as a dataset.
    ///
    /// The dataset is parts of 100 recordings in NPZ, and a manifest. After an interruption the same command resumes. A complete
    /// dataset is not changed.
    #[command(after_help = "Examples:
  sdp3 simulate --out data
  sdp3 simulate --channel ray-tracing --classes adult-walking,adult-running --per-class 200 --out data
  sdp3 simulate --per-class 1000 --raw --sigmf --shard 2/8 --out data")]
    Simulate(simulator::SimulateArgs),
    /// Write the moving person as point targets for other radar simulators.
    ///
    /// One CSV file for every class has position, velocity, radar cross section and phase of the sixteen primitives over time. What is
    /// left out is the channel's: room, occlusion, antenna pattern.
    #[command(after_help = "Examples:
  sdp3 targets --out targets
  sdp3 targets --classes adult-walking --every-s 0.01 --duration-s 2 --out targets
  sdp3 targets --scenario bgt60 --classes adult-running --index 3 --seed 7 --json")]
    Targets(simulator::TargetsArgs),
    /// Find the channel correlation rho that a measured signal shows.
    #[command(after_help = "Examples:
  sdp3 calibrate --measured walk.wav --carrier 24.125e9
  sdp3 calibrate --measured sitting.npy --rate 20 --carrier 60e9 --motion standing --json
  sdp3 calibrate --table rho.toml")]
    Calibrate(simulator::CalibrateArgs),
    /// Show what a recording holds: format, shape, sensor, rate, pictures over time, and the scenario that matches the sensor.
    ///
    /// The pictures are doppler-time and, of a radar module, range-time, of the antenna and the chirp stated, or of the first.
    #[command(after_help = "Examples:
  sdp3 inspect walk.wav --carrier 24.125e9
  sdp3 inspect RadarIfxAvian_00 --antenna 2
  sdp3 inspect adc_data.bin --config profile.cfg --chirp all --json")]
    Inspect(recordings::InspectArgs),
    /// Classify recordings of a radar by the radar module's own chain, window by window.
    ///
    /// The recording must be of the model's radar: samples of a slot, slot interval and carrier.
    #[command(after_help = "Examples:
  sdp3 classify out/models/dsn-1000.sdp3 walk.sigmf-meta --picture walk.png
  sdp3 classify out/models/dsn-1000.sdp3 walk.sigmf-meta --early-exits out --threshold 0.95
  sdp3 classify sensor.sdp3 RadarIfxAvian_00 --antenna 1 --chirp 1 --step 100 --guard --json
  sensor | sdp3 classify sensor.sdp3 -")]
    Classify(recordings::ClassifyArgs),
    /// Run every channel model through the property tests of the paper's Table I.
    #[command(after_help = "Examples:
  sdp3 channels
  sdp3 channels --scenario radar-60ghz --json")]
    Channels,
    /// Draw a page of spectrograms: class by carrier by channel model.
    #[command(after_help = "Examples:
  sdp3 gallery --out pictures
  sdp3 gallery --scenario child-safe-room")]
    Gallery,
    /// Train the networks and save their float parameters.
    ///
    /// The history of the losses is saved beside them.
    #[command(after_help = "Examples:
  sdp3 train
  sdp3 train --preset paper --recipe paper-adam --resume
  sdp3 train --data data --set learning.epochs=40 --out trained")]
    Train(training::TrainArgs),
    /// Run a study that takes many trainings: learning curve, robustness, fidelity, sim to real, baselines, ablation, clutter, selection.
    ///
    /// After an interruption the same command resumes.
    #[command(after_help = "Examples:
  sdp3 study learning-curve --out curve
  sdp3 study robustness --seeds 3 --out robustness
  sdp3 study ablation --seeds 5 --out ablation
  sdp3 study fidelity --measured recordings --carrier 24.125e9 --out fidelity
  sdp3 study sim-to-real --measured recordings --carrier 24.125e9 --out sim-to-real")]
    Study(training::StudyArgs),
    /// Make the paper's tables and figures again, beside its numbers, each with a verdict.
    ///
    /// Everything is made twice: with the settings as printed and with the scenario's. Writes a result, a figure and, when all items
    /// are there, one page, reproduction.md. After an interruption the same command resumes.
    #[command(after_help = "Examples:
  sdp3 reproduce all --size quick
  sdp3 reproduce region learning-curve --out paper
  sdp3 reproduce --size paper --seed 1001 --shard 2/8 --out paper")]
    Reproduce(training::ReproduceArgs),
    /// Measure a plan of scenarios x carriers x rho x N_s x seeds, here or on a cluster.
    ///
    /// Every cell simulates, trains, quantises and tests. After an interruption the same command resumes. The shard is --shard's,
    /// else that of SLURM_ARRAY_TASK_ID (with SLURM_ARRAY_TASK_MIN and _COUNT), else that of JOB_COMPLETION_INDEX (with
    /// JOB_COMPLETIONS), else the whole.
    #[command(after_help = "Examples:
  sdp3 sweep docs/plans/quick.toml --out quick
  sdp3 sweep plan.toml --shard 2/8 --out sweep
  sdp3 sweep plan.toml --status --shards 8 --out sweep
  sdp3 sweep plan.toml --slurm --shards 60 --sbatch=--partition=long --out sweep
  sdp3 sweep plan.toml --kubernetes --shards 60 --image registry.example/sdp3:0.1.0 --out sweep")]
    Sweep(cluster::SweepArgs),
    /// Join the cells of a sweep.
    ///
    /// Writes merged.csv and merged.json if every cell is there, complete and of the same plan, and draws accuracy and throughput
    /// over every axis of the plan that varies.
    #[command(after_help = "Examples:
  sdp3 merge quick
  sdp3 merge quick --partial
  sdp3 merge quick --json")]
    Merge(cluster::MergeArgs),
    /// Convert trained networks into int8 model files.
    #[command(after_help = "Examples:
  sdp3 quantize
  sdp3 quantize --data data --out trained")]
    Quantize(training::QuantizeArgs),
    /// Write a network for other programs (.tflite, .safetensors).
    ///
    /// A model file is written as .tflite, float parameters as .safetensors.
    #[command(after_help = "Examples:
  sdp3 export out/models/dsn-1000.sdp3 --to dsn.tflite
  sdp3 export out/models/dsn-1000.json --to dsn.safetensors")]
    Export(models::ExportArgs),
    /// Read a network of another program.
    ///
    /// The file is int8 .tflite of convolutions, poolings, additions, fully connected layers and softmax, or float .safetensors of the
    /// paper's topology, which is quantised.
    #[command(after_help = "Examples:
  sdp3 import dsn.tflite --to dsn.sdp3
  sdp3 import resnet8.tflite --to resnet8.graph
  sdp3 import dsn.safetensors --to dsn.sdp3 --slots 1000")]
    Import(models::ImportArgs),
    /// Run an int8 network on arrays, with the bits of the radar module.
    #[command(after_help = "Examples:
  sdp3 infer resnet8.graph images.npy --to probabilities.npy
  sdp3 infer dsn.sdp3 images.npy --to layers.npy --layers")]
    Infer(models::InferArgs),
    /// Show, sign and verify model files, make keys.
    #[command(after_help = "Examples:
  sdp3 model show out/models/dsn-1000.sdp3
  sdp3 model keygen radio
  sdp3 model sign out/models/dsn-1000.sdp3 --key radio.key --revision 7 --to signed.sdp3
  sdp3 model verify signed.sdp3 --key radio.pub --oldest 7")]
    Model(models::ModelArgs),
    /// Compare the core with its reference and its firmware, bit for bit.
    ///
    /// The models are those of --out.
    #[command(after_help = "Examples:
  sdp3 verify
  sdp3 verify --targets host-reference,cortex-m4f --json")]
    Verify(job::VerifyArgs),
    /// Fit the seven learning curves to accuracies.
    #[command(after_help = "Examples:
  sdp3 predict
  sdp3 predict --points points.csv --json")]
    Predict(optimizer::PredictArgs),
    /// Draw the accuracy-throughput region and choose a point on it.
    #[command(after_help = "Examples:
  sdp3 optimize --accuracy 0.9
  sdp3 optimize --points points.csv --weights 1,1e-5 --json
  sdp3 optimize --sweep power_w=1e-6,1 --sweep users=1,2,3")]
    Optimize(optimizer::OptimizeArgs),
    /// Fit early exits and draw their region beside the static one.
    ///
    /// The models are those of --out.
    #[command(after_help = "Examples:
  sdp3 early-exits
  sdp3 early-exits --calibrate-per-class 500 --accuracy 0.9")]
    EarlyExits(optimizer::EarlyExitsArgs),
    /// Play the operating point through the core's scheduler.
    ///
    /// Plays one period of the operating point of --out's run, or with --periods many, with traffic, churn, fading and loss.
    #[command(after_help = "Examples:
  sdp3 schedule
  sdp3 schedule --periods 1000 --sensing-slots 300 --load 0.8
  sdp3 schedule --periods 200 --recognise-every 10 --threshold 0.9")]
    Schedule(optimizer::ScheduleArgs),
    /// Write the report page and its figures again.
    ///
    /// They are those of --out's run. The figures are SVG and PNG.
    #[command(after_help = "Examples:
  sdp3 report
  sdp3 report --out small
  sdp3 report --program sdp3-page.wasm")]
    Report(job::ReportArgs),
    /// List, print, write and check scenarios.
    #[command(after_help = "Examples:
  sdp3 scenario list
  sdp3 scenario show child-safe-room
  sdp3 scenario new room.toml
  sdp3 scenario check room.toml")]
    Scenario(scenarios::ScenarioArgs),
    /// Print the JSON Schema of what a command prints with --json.
    #[command(after_help = "Examples:
  sdp3 schema
  sdp3 schema run
  sdp3 schema scenario-check")]
    Schema(reference::SchemaArgs),
    /// Print a script that completes commands in a shell.
    #[command(after_help = "Examples:
  sdp3 completions bash > /etc/bash_completion.d/sdp3
  sdp3 completions zsh > ~/.zfunc/_sdp3
  sdp3 completions fish > ~/.config/fish/completions/sdp3.fish")]
    Completions(reference::CompletionsArgs),
    /// Write manual pages.
    ///
    /// There is one page for the tool and one for every command.
    #[command(after_help = "Examples:
  sdp3 man /usr/local/share/man/man1
  sdp3 man pages --json")]
    Man(reference::ManArgs),
}

impl Cli {
    /// How to go on after an interruption.
    pub fn resumption(&self) -> &'static str {
        match self.command {
            Some(Command::Simulate(_) | Command::Study(_) | Command::Reproduce(_) | Command::Sweep(_)) => {
                "the same command goes on where it was"
            }
            None | Some(Command::Run(_) | Command::Train(_)) => {
                "the same command with --resume goes on after the last whole epoch"
            }
            _ => "the same command begins again",
        }
    }
}

/// Runs the command; `false` if a check failed.
pub fn execute(cli: Cli) -> Result<bool, Failure> {
    let context = &Context::new(cli.common)?;
    match cli.command.unwrap_or_else(main_job) {
        #[cfg(feature = "train")]
        Command::Run(args) => trainer::run(context, args),
        #[cfg(feature = "train")]
        Command::Train(args) => trainer::train(context, args),
        #[cfg(feature = "train")]
        Command::Study(args) => trainer::study(context, &args),
        #[cfg(feature = "train")]
        Command::Reproduce(args) => trainer::reproduce(context, args),
        #[cfg(feature = "train")]
        Command::Quantize(args) => trainer::quantize(context, &args),
        #[cfg(not(feature = "train"))]
        Command::Run(_) | Command::Train(_) | Command::Study(_) | Command::Reproduce(_) => {
            crate::pipeline::untrained("train")
        }
        #[cfg(not(feature = "train"))]
        Command::Quantize(_) => crate::pipeline::untrained("quantize"),
        Command::Simulate(args) => simulator::simulate(context, args),
        Command::Targets(args) => simulator::targets(context, args),
        Command::Calibrate(args) => simulator::calibrate(context, args),
        Command::Inspect(args) => recordings::inspect(context, args),
        Command::Classify(args) => recordings::classify(context, args),
        Command::Channels => simulator::channels(context),
        Command::Gallery => simulator::gallery(context),
        Command::Sweep(args) => cluster::sweep(context, &args),
        Command::Merge(args) => cluster::merge(context, &args),
        Command::Export(args) => models::export(context, &args),
        Command::Import(args) => models::import(context, &args),
        Command::Infer(args) => models::infer(context, &args),
        Command::Model(args) => models::model(context, &args),
        Command::Verify(args) => job::verify(context, args),
        Command::Predict(args) => optimizer::predict(context, &args),
        Command::Optimize(args) => optimizer::optimize(context, &args),
        Command::EarlyExits(args) => optimizer::early_exits(context, &args),
        Command::Schedule(args) => optimizer::schedule(context, &args),
        Command::Report(args) => job::report(context, &args),
        Command::Scenario(args) => scenarios::scenario(context, &args),
        Command::Schema(args) => reference::schema(context, &args),
        Command::Completions(args) => reference::completions(&args),
        Command::Man(args) => reference::man(context, &args),
    }
}

/// What is done if no command is named: the main job with its defaults.
fn main_job() -> Command {
    match Cli::parse_from(["sdp3", "run"]).command {
        Some(command) => command,
        None => Command::Report(job::ReportArgs { program: None }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::schemas::PUBLISHED;
    use clap::CommandFactory;

    /// Every command that does something, with its words and its help.
    fn commands() -> Vec<(Vec<String>, String)> {
        fn add(command: &clap::Command, words: &[String], found: &mut Vec<(Vec<String>, String)>) {
            for below in command.get_subcommands() {
                let words = [words, &[below.get_name().to_owned()]].concat();
                if !below.has_subcommands() {
                    found.push((words.clone(), below.clone().render_long_help().to_string()));
                }
                add(below, &words, found);
            }
        }
        let mut found = Vec::new();
        add(&Cli::command(), &[], &mut found);
        found
    }

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn every_command_has_examples_that_parse() {
        let all = commands();
        assert!(all.len() > 25, "{all:?}");
        let whole = (vec![String::new()], Cli::command().render_help().to_string());
        for (words, help) in all.iter().chain([&whole]) {
            let examples: Vec<&str> =
                help.lines().map(str::trim).filter(|line| line.starts_with("sdp3 ")).collect();
            assert!(!examples.is_empty(), "{words:?} has no example");
            for example in examples {
                let example = example.split("   ").next().unwrap_or_default();
                let arguments = example.split_whitespace().take_while(|word| *word != ">");
                let parsed = Cli::try_parse_from(arguments);
                assert!(parsed.is_ok(), "{example}: {}", parsed.unwrap_err());
                assert!(example.contains(&words.join(" ")), "{example} is no example of {words:?}");
            }
        }
    }

    #[test]
    fn every_command_that_answers_has_a_schema() {
        for (words, _) in commands() {
            let name = words.join("-");
            let published = PUBLISHED.iter().any(|(published, _)| *published == name);
            assert!(published || name == "completions", "{name} has no schema");
        }
    }
}
