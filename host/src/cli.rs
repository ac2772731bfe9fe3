//! The command line: what can be asked, in words; nothing is decided here.

use clap::{Args, Parser, Subcommand, ValueEnum};
use sdp3::formats::dataset::{PER_CLASS, Shard};
use sdp3::optimizer::sweep::Sweep;
use std::path::PathBuf;

/// How many slots must be spent on radar to recognise how a person moves, and what does that cost in throughput?
#[derive(Debug, Parser)]
#[command(version, about, after_help = EXAMPLES)]
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

/// Options of every command.
#[derive(Debug, Clone, Args)]
pub struct Common {
    /// Scenario in TOML; absent: the paper's conference room.
    #[arg(long, global = true, value_name = "FILE.toml")]
    pub scenario: Option<PathBuf>,
    /// Seed of everything random.
    #[arg(long, global = true, default_value_t = 1)]
    pub seed: u64,
    /// Folder for results.
    #[arg(long, global = true, default_value = "out", value_name = "DIR")]
    pub out: PathBuf,
    /// Threads; 0 takes all processors. Results do not depend on it.
    #[arg(long, global = true, default_value_t = 0)]
    pub threads: usize,
    /// Print results as JSON, and nothing else, on stdout.
    #[arg(long, global = true)]
    pub json: bool,
    /// Say more on stderr.
    #[arg(short, long, global = true)]
    pub verbose: bool,
    /// Say nothing on stderr but errors.
    #[arg(short, long, global = true)]
    pub quiet: bool,
}

/// Size of the main job.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Preset {
    /// Minutes: fewer recordings, a strided network.
    Quick,
    /// The paper's sizes: 200 recordings per class to train, 100 to test.
    Paper,
}

/// Measured signal.
#[derive(Debug, Clone, Args)]
pub struct MeasuredArgs {
    /// A measured signal: WAV (CW Doppler), NPY, NPZ, SigMF, HDF5.
    #[arg(long, value_name = "FILE")]
    pub measured: Option<PathBuf>,
    /// Its carrier in Hz, if the file does not say.
    #[arg(long, value_name = "HZ", requires = "measured")]
    pub carrier: Option<f64>,
    /// Its sampling or slow-time rate in Hz, if the file does not say.
    #[arg(long, value_name = "HZ", requires = "measured")]
    pub rate: Option<f64>,
    /// Gain of the sensor in dB, taken off.
    #[arg(long, value_name = "DB", requires = "measured", allow_negative_numbers = true)]
    pub gain: Option<f64>,
    /// Which array of an NPZ or which dataset of an HDF5 file.
    #[arg(long, value_name = "NAME", requires = "measured")]
    pub dataset: Option<String>,
    /// How the person in it moves: a class, such as adult-walking or standing.
    #[arg(long, value_name = "CLASS", requires = "measured", default_value = "adult-walking")]
    pub motion: String,
}

/// How to train.
#[derive(Debug, Clone, Args)]
pub struct TrainArgs {
    /// A dataset that `sdp3 simulate` wrote, instead of simulating: its room, radar, people and rho.
    #[arg(long, value_name = "DIR")]
    pub data: Option<PathBuf>,
    /// Optimiser, learning rate and batch in one; absent: the scenario's.
    #[arg(long, value_enum)]
    pub recipe: Option<Recipe>,
    /// Go on from the checkpoints in --out, with the same result as without the interruption.
    #[arg(long)]
    pub resume: bool,
    /// Where to train: the processor, or a GPU in a build with that feature.
    #[arg(long, value_enum, default_value_t = Backend::Flex)]
    pub backend: Backend,
}

/// A way to train.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Recipe {
    /// AdamW, peak 5e-3, one cycle, batch 50.
    AdamwOneCycle,
    /// The paper's: Adam, 0.01, batch 500.
    PaperAdam,
    /// The paper's: momentum 0.9, 0.06, batch 300.
    PaperMomentum,
}

/// A study.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Study {
    /// Accuracy over the number of sensing slots, and the curves of Table III.
    LearningCurve,
    /// Accuracy under other headings, rho, power, d, people and carriers.
    Robustness,
    /// Divergence and recognition against ray tracing, a richer model and measured recordings.
    Fidelity,
    /// Accuracy of the network, a plain convolutional network and a support vector machine over the number of sensing slots.
    Baselines,
}

/// Where to train.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Backend {
    /// The processor.
    Flex,
    /// A GPU through Vulkan, Metal, DirectX 12 or WebGPU; needs the feature `wgpu`.
    Wgpu,
    /// An NVIDIA GPU; needs the feature `cuda`.
    Cuda,
}

/// Targets of the proof.
#[derive(Debug, Clone, Args)]
pub struct ProofArgs {
    /// Targets to compare.
    #[arg(long, value_delimiter = ',', default_values = crate::TARGET_NAMES)]
    pub targets: Vec<String>,
    /// Folder of ready-built firmware; absent: firmware-sim/build makes it.
    #[arg(long, value_name = "DIR")]
    pub firmware: Option<PathBuf>,
}

/// How the operating point is chosen; absent: the scenario's weight.
#[derive(Debug, Clone, Copy, Args)]
#[group(multiple = false)]
pub struct RuleArgs {
    /// Accuracy of at least this, 0..=1.
    #[arg(long)]
    pub accuracy: Option<f64>,
    /// Throughput of at least this, in bits per period.
    #[arg(long)]
    pub throughput: Option<f64>,
    /// Weight of accuracy, 0..=1; throughput has the rest, both over their span on the boundary.
    #[arg(long)]
    pub weight: Option<f64>,
    /// w_A and w_R of the paper's sum w_A A + w_R R, R in bits per period.
    #[arg(long, value_name = "WA,WR", value_parser = pair)]
    pub weights: Option<(f64, f64)>,
}

fn pair(text: &str) -> Result<(f64, f64), String> {
    let numbers = text.split_once(',').and_then(|(a, b)| Some((a.parse().ok()?, b.parse().ok()?)));
    numbers.ok_or_else(|| "two numbers with a comma between them".into())
}

/// A world for the scheduler. With --periods its promises are checked in every one.
#[derive(Debug, Clone, Args)]
pub struct WorldArgs {
    /// Periods; absent: one, in a world that does not change.
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    pub periods: Option<u32>,
    /// N_s; absent: that of the run's operating point.
    #[arg(long, value_name = "N", requires = "periods")]
    pub sensing_slots: Option<u32>,
    /// Mean time in s that a channel stays as it is.
    #[arg(long, value_name = "S", default_value_t = 5.0, requires = "periods")]
    pub coherence: f64,
    /// Mean arrivals of a receiver over its fair share; absent: always something to send.
    #[arg(long, value_name = "SHARE", requires = "periods")]
    pub load: Option<f64>,
    /// Probability that a receiver joins or leaves in a period.
    #[arg(long, value_name = "P", default_value_t = 0.02, requires = "periods")]
    pub churn: f64,
    /// Probability that a slot is lost.
    #[arg(long, value_name = "P", default_value_t = 0.0005, requires = "periods")]
    pub loss: f64,
    /// Probability that N_s becomes another of the scenario's in a period.
    #[arg(long, value_name = "P", default_value_t = 0.02, requires = "periods")]
    pub retarget: f64,
    /// Every so many periods somebody moves before the radar: raw I/Q through the core with the models of --out; 0: never.
    #[arg(long, value_name = "PERIODS", default_value_t = 0, requires = "periods")]
    pub recognise_every: u32,
    /// Confidence that ends sensing early, with the weights that `sdp3 anytime` wrote to --out.
    #[arg(long, value_name = "CONFIDENCE", requires = "recognise_every")]
    pub threshold: Option<f64>,
    /// Periods drawn slot by slot in trace.json, which Perfetto opens.
    #[arg(long, value_name = "PERIODS", default_value_t = 3, requires = "periods")]
    pub traced: u32,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// The main job: simulate, calibrate, learn, run, prove, trade, schedule, report.
    Run {
        /// Size of the job.
        #[arg(long, value_enum, default_value_t = Preset::Quick)]
        preset: Preset,
        #[command(flatten)]
        measured: MeasuredArgs,
        #[command(flatten)]
        proof: ProofArgs,
    },
    /// Simulate recordings and write them as a dataset: parts of 100 recordings in NPZ, and a manifest.
    ///
    /// Interrupted, the same command resumes; complete, it changes nothing.
    Simulate {
        /// Recordings of each class.
        #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u32).range(PER_CLASS))]
        per_class: u32,
        /// Channel model: dahc, primitive, ray-tracing, statistical, 80211ay, 80211ax, 38901, quadriga or metis; absent:
        /// the scenario's.
        #[arg(long, value_name = "NAME")]
        channel: Option<String>,
        /// Classes, by name; absent: the paper's five. Also child-stepping, adult-stepping, child-running, adult-running.
        #[arg(long, value_delimiter = ',', value_name = "NAMES")]
        classes: Option<Vec<String>>,
        /// Store the raw slots in the parts too.
        #[arg(long)]
        raw: bool,
        /// Write each recording's raw slots as SigMF too.
        #[arg(long)]
        sigmf: bool,
        /// Make only the I-th of N shards of the parts; whichever comes last writes the manifest.
        #[arg(long, value_name = "I/N", default_value = "1/1")]
        shard: Shard,
    },
    /// Find the room's memory rho that a measured signal shows.
    Calibrate {
        #[command(flatten)]
        measured: MeasuredArgs,
        /// Write the look-up table of rho again, to this file.
        #[arg(long, value_name = "FILE.toml", conflicts_with = "measured")]
        table: Option<PathBuf>,
    },
    /// Run every channel model through the property tests of the paper's Table I.
    Channels,
    /// Draw a page of spectrograms: class by carrier by channel model.
    Gallery,
    /// Train the networks and save their float parameters and the history of their losses.
    Train {
        /// Size of the job.
        #[arg(long, value_enum, default_value_t = Preset::Quick)]
        preset: Preset,
        #[command(flatten)]
        how: TrainArgs,
    },
    /// Answer a question that takes many trainings; the same command goes on where it was interrupted.
    Study {
        /// Which question.
        #[arg(value_enum)]
        name: Study,
        /// Seeds, from --seed upwards.
        #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
        seeds: u32,
        /// Of `fidelity`: a folder of measured recordings, in any depth, whose names tell the motion (walk, run, still, stand, sit).
        #[arg(long, value_name = "FOLDER")]
        measured: Option<PathBuf>,
        /// Carrier in Hz of recordings that do not say theirs.
        #[arg(long, value_name = "HZ", requires = "measured")]
        carrier: Option<f64>,
        /// Rate in Hz of recordings that do not say theirs.
        #[arg(long, value_name = "HZ", requires = "measured")]
        rate: Option<f64>,
    },
    /// Turn trained networks into int8 model files.
    Quantize {
        /// The dataset they were trained on, to measure ranges on; absent: training recordings are simulated.
        #[arg(long, value_name = "DIR")]
        data: Option<PathBuf>,
    },
    /// Write a network for other programs: a model file as .tflite, float parameters as .safetensors.
    Export {
        /// MODEL.sdp3, or NETWORK.json as `sdp3 train` writes it.
        #[arg(value_name = "FILE")]
        from: PathBuf,
        /// FILE.tflite of a model file, FILE.safetensors of float parameters.
        #[arg(long, value_name = "FILE")]
        to: PathBuf,
    },
    /// Read another program's network: int8 .tflite of this topology, or float .safetensors, which is quantised.
    Import {
        /// FILE.tflite or FILE.safetensors.
        #[arg(value_name = "FILE")]
        from: PathBuf,
        /// MODEL.sdp3; of .safetensors also NETWORK.json, float parameters as `sdp3 quantize` reads them.
        #[arg(long, value_name = "FILE")]
        to: PathBuf,
        /// Sensing slots it was trained with, where the file does not say.
        #[arg(long, value_name = "N")]
        slots: Option<u16>,
    },
    /// Tell what a model file holds: envelope, network, memory it needs. Exit code 1 if --key is given and did not sign it.
    Model {
        /// MODEL.sdp3.
        #[arg(value_name = "FILE")]
        file: PathBuf,
        /// Public key that must have signed it.
        #[arg(long, value_name = "NAME.pub")]
        key: Option<PathBuf>,
    },
    /// Sign a model file, for firmware that takes signed models only.
    Sign {
        /// MODEL.sdp3.
        #[arg(value_name = "FILE")]
        file: PathBuf,
        /// Secret key.
        #[arg(long, value_name = "NAME.key")]
        key: PathBuf,
        /// Where the signed model goes.
        #[arg(long, value_name = "FILE")]
        to: PathBuf,
    },
    /// Make a key pair for `sign`: NAME.key, to be kept secret, and NAME.pub, to build firmware with.
    Key {
        /// NAME; existing files are kept.
        #[arg(value_name = "NAME")]
        name: PathBuf,
    },
    /// Compare the core with its reference and its firmware, bit for bit, on the models of --out.
    Verify {
        #[command(flatten)]
        proof: ProofArgs,
    },
    /// Fit the seven learning curves to accuracies.
    Predict {
        /// CSV or JSON with sensing_slots, accuracy[, tested], or results of this tool; absent: the accuracies of --out's run.
        #[arg(long, value_name = "FILE")]
        points: Option<PathBuf>,
    },
    /// Draw the accuracy-throughput region and choose a point on it.
    Optimize {
        /// CSV or JSON with sensing_slots, accuracy[, tested], or results of this tool; absent: the accuracies of --out's run.
        #[arg(long, value_name = "FILE")]
        points: Option<PathBuf>,
        /// Learning curve; absent: the best one.
        #[arg(long, value_name = "NAME")]
        curve: Option<String>,
        #[command(flatten)]
        rule: RuleArgs,
        /// Vary carrier_hz, power_w, receivers (K) or distance (a factor): AXIS=VALUE,VALUE,... May be given several times.
        #[arg(long, value_name = "AXIS=VALUES")]
        sweep: Vec<Sweep>,
    },
    /// Fit anytime sensing to the models of --out and draw its region beside the static one.
    Anytime {
        /// Recordings of each class to fit and choose on, behind those trained on.
        #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u32).range(2..=100_000))]
        calibrate_per_class: u32,
        #[command(flatten)]
        rule: RuleArgs,
    },
    /// Play the operating point of --out's run through the core's scheduler: one period, or many in a world that changes.
    Schedule {
        #[command(flatten)]
        world: WorldArgs,
    },
    /// Write the report page of --out's run again.
    Report,
}
