//! The command line: one subcommand, one function; a file for each group of them.

mod context;
mod job;
mod models;
mod simulator;
mod trader;
#[cfg(feature = "train")]
mod trainer;
#[cfg(not(feature = "train"))]
#[path = "untrained.rs"]
mod trainer;
mod training;

use clap::{Parser, Subcommand};
use context::{Common, Context};
use sdp3::pipeline::Failure;

/// How many slots must be spent on radar to recognise how a person moves, and what does that cost in throughput?
#[derive(Debug, Parser)]
#[command(name = "sdp3", version, about, after_help = EXAMPLES)]
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
Exit code: 0 done, 1 a check failed, 2 usage, input or I/O error.";

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// The main job: simulate, calibrate, learn, run, prove, trade, schedule, report.
    Run(job::RunArgs),
    /// Simulate recordings and write them as a dataset: parts of 100 recordings in NPZ, and a manifest.
    ///
    /// Interrupted, the same command resumes; complete, it changes nothing.
    Simulate(simulator::SimulateArgs),
    /// Find the room's memory rho that a measured signal shows.
    Calibrate(simulator::CalibrateArgs),
    /// Run every channel model through the property tests of the paper's Table I.
    Channels,
    /// Draw a page of spectrograms: class by carrier by channel model.
    Gallery,
    /// Train the networks and save their float parameters and the history of their losses.
    Train(training::TrainArgs),
    /// Answer a question that takes many trainings; the same command goes on where it was interrupted.
    Study(training::StudyArgs),
    /// Turn trained networks into int8 model files.
    Quantize(training::QuantizeArgs),
    /// Write a network for other programs: a model file as .tflite, float parameters as .safetensors.
    Export(models::ExportArgs),
    /// Read another program's network: int8 .tflite of this topology, or float .safetensors, which is quantised.
    Import(models::ImportArgs),
    /// Tell what a model file holds: envelope, network, memory it needs. Exit code 1 if --key is given and did not sign it.
    Model(models::ModelArgs),
    /// Sign a model file, for firmware that takes signed models only.
    Sign(models::SignArgs),
    /// Make a key pair for `sign`: NAME.key, to be kept secret, and NAME.pub, to build firmware with.
    Key(models::KeyArgs),
    /// Compare the core with its reference and its firmware, bit for bit, on the models of --out.
    Verify(job::ProofArgs),
    /// Fit the seven learning curves to accuracies.
    Predict(trader::PredictArgs),
    /// Draw the accuracy-throughput region and choose a point on it.
    Optimize(trader::OptimizeArgs),
    /// Fit anytime sensing to the models of --out and draw its region beside the static one.
    Anytime(trader::AnytimeArgs),
    /// Play the operating point of --out's run through the core's scheduler: one period, or many in a world that changes.
    Schedule(trader::WorldArgs),
    /// Write the report page of --out's run again, and its figures as SVG and PNG.
    Report,
}

/// Runs the command; `false` if a check failed.
pub fn execute(cli: Cli) -> Result<bool, Failure> {
    let context = Context::new(cli.common)?;
    let context = &context;
    match cli.command.unwrap_or_else(main_job) {
        Command::Run(args) => trainer::run(context, args),
        Command::Simulate(args) => simulator::simulate(context, args),
        Command::Calibrate(args) => simulator::calibrate(context, args),
        Command::Channels => simulator::channels(context),
        Command::Gallery => simulator::gallery(context),
        Command::Train(args) => trainer::train(context, args),
        Command::Study(args) => trainer::study(context, args),
        Command::Quantize(args) => trainer::quantize(context, args),
        Command::Export(args) => models::export(context, &args),
        Command::Import(args) => models::import(context, &args),
        Command::Model(args) => models::model(context, &args),
        Command::Sign(args) => models::sign(context, &args),
        Command::Key(args) => models::key(context, &args),
        Command::Verify(args) => job::verify(context, &args),
        Command::Predict(args) => trader::predict(context, &args),
        Command::Optimize(args) => trader::optimize(context, args),
        Command::Anytime(args) => trader::anytime(context, &args),
        Command::Schedule(args) => trader::schedule(context, &args),
        Command::Report => job::report(context),
    }
}

/// What is done if no command is named: the main job with its defaults.
fn main_job() -> Command {
    match Cli::parse_from(["sdp3", "run"]).command {
        Some(command) => command,
        None => Command::Report,
    }
}
