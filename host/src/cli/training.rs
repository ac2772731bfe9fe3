//! The options of `train`, `quantize` and `study`, the same in a build that cannot train.

use super::context::{Preset, count};
use super::recordings::StatedArgs;
use crate::dataset::Shard;
use crate::experiments::Study;
use crate::reproduce::{Item, Size};
use clap::builder::PossibleValue;
use clap::{Args, ValueEnum};
use std::path::PathBuf;
use std::sync::LazyLock;

/// How to train.
#[derive(Debug, Clone, Args)]
pub struct TrainArgs {
    /// Size of the job.
    #[arg(long, value_enum, default_value_t = Preset::Quick)]
    pub preset: Preset,
    /// A dataset that `sdp3 simulate` wrote, instead of simulating: its room, radar, people and rho.
    #[arg(long, value_name = "DIR")]
    pub data: Option<PathBuf>,
    /// A folder of labelled recordings of the scenario's radar: folders named as their class, or labels.csv (file, class; person, from_s and to_s are optional).
    #[arg(id = "measured", long = "recordings", value_name = "FOLDER", conflicts_with = "data")]
    pub recordings: Option<PathBuf>,
    /// What networks learn from.
    #[arg(long, value_enum, requires = "measured", default_value_t = Method::Recordings)]
    pub method: Method,
    /// Parts of the cross-validation, at most; a person, or else a recording, is in one of them.
    #[arg(long, requires = "measured", default_value_t = 5, value_parser = count(2..=1000))]
    pub folds: u32,
    /// Hold out each class in turn too: the confidence below which a window is of none of the classes.
    #[arg(long, requires = "measured")]
    pub hold_out_classes: bool,
    #[command(flatten)]
    pub stated: StatedArgs,
    /// Optimiser, learning rate and batch in one; absent: the scenario's.
    #[arg(long, value_enum)]
    pub recipe: Option<Recipe>,
    /// Go on from the checkpoints in --out, with the same result as without the interruption.
    #[arg(long)]
    pub resume: bool,
    /// Where to train: the processor, or a GPU in a build with that feature.
    #[arg(long, value_enum, default_value_t = Backend::Cpu)]
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

/// What networks learn from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Method {
    /// The recordings alone.
    Recordings,
    /// Simulated and measured recordings together; their classes are the simulator's.
    WithSimulation,
    /// Simulated recordings first, then the measured ones at a tenth of the learning rate.
    FineTuning,
}

/// Where to train.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Backend {
    /// The processor.
    Cpu,
    /// A GPU through Vulkan, Metal, DirectX 12 or WebGPU; needs the feature `wgpu`.
    Wgpu,
    /// An NVIDIA GPU; needs the feature `cuda`.
    Cuda,
}

/// Networks to quantise.
#[derive(Debug, Clone, Args)]
pub struct QuantizeArgs {
    /// The dataset they were trained on, to measure ranges on; absent: training recordings are simulated.
    #[arg(long, value_name = "DIR")]
    pub data: Option<PathBuf>,
}

/// Every table and figure, or one.
#[derive(Debug, Clone, Copy)]
pub enum Items {
    All,
    One(Item),
}

impl ValueEnum for Items {
    fn value_variants<'a>() -> &'a [Self] {
        static EVERY: LazyLock<Vec<Items>> = LazyLock::new(|| {
            let each = Item::value_variants().iter().map(|&item| Items::One(item));
            std::iter::once(Items::All).chain(each).collect()
        });
        &EVERY
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        match self {
            Items::All => Some(PossibleValue::new("all").help("Every one of them")),
            Items::One(item) => item.to_possible_value(),
        }
    }
}

impl Items {
    /// The items that are named; all where none is.
    pub fn named(items: &[Items]) -> Vec<Item> {
        let one = |items: &Items| match items {
            Items::All => None,
            Items::One(item) => Some(*item),
        };
        let each: Option<Vec<Item>> = items.iter().map(one).collect();
        each.filter(|items| !items.is_empty()).unwrap_or_else(|| Item::value_variants().to_vec())
    }
}

/// Tables and figures of the paper to make again.
#[derive(Debug, Clone, Args)]
pub struct ReproduceArgs {
    /// Which; absent: all.
    #[arg(value_enum, value_name = "ITEM")]
    pub items: Vec<Items>,
    /// How large.
    #[arg(long, value_enum, default_value_t = Size::Quick)]
    pub size: Size,
    /// Seeds, from --seed upwards (from 101 where --seed is absent); absent: one of a quick size, else five.
    #[arg(long, value_parser = count(1..=1000))]
    pub seeds: Option<u32>,
    /// A folder of measured recordings to set beside the experiment (`kl-divergence`), in any depth, with the motion in their names.
    #[arg(long, value_name = "FOLDER")]
    pub measured: Option<PathBuf>,
    /// Carrier in Hz of recordings that do not say theirs.
    #[arg(long, value_name = "HZ", requires = "measured")]
    pub carrier: Option<f64>,
    /// Do only the I-th of N shards of the computations, and put nothing together.
    #[arg(long, value_name = "I/N")]
    pub shard: Option<Shard>,
}

/// A study to make.
#[derive(Debug, Clone, Args)]
pub struct StudyArgs {
    /// Which question.
    #[arg(value_enum)]
    pub name: Study,
    /// Seeds, from --seed upwards; of `ablation`, `clutter` and `selection` from 101 where --seed is absent.
    #[arg(long, default_value_t = 5, value_parser = count(1..=1000))]
    pub seeds: u32,
    /// Of `fidelity` and `sim-to-real`: a folder of measured recordings, in any depth, with the motion in their names (walk, run, still, stand, sit).
    #[arg(long, value_name = "FOLDER")]
    pub measured: Option<PathBuf>,
    /// Carrier in Hz of recordings that do not say theirs.
    #[arg(long, value_name = "HZ", requires = "measured")]
    pub carrier: Option<f64>,
    /// Rate in Hz of recordings that do not say theirs.
    #[arg(long, value_name = "HZ", requires = "measured")]
    pub rate: Option<f64>,
}
