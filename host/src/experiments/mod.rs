//! Studies: questions that take many trainings. Each is cut into cells that are kept, so that an interrupted study goes on where
//! it was; each writes its resolved configuration, a table, a picture and a page.
//!
//! [`learning_curve`] (Table III of the paper and its figure), [`robustness`] (changed conditions), [`fidelity`]
//! (how near simulated recordings are to others), [`sim_to_real`] (recognition of measured recordings), [`baselines`] (other ways to
//! recognise), [`ablation`] (one effect at a time), [`clutter`] (adaptive or fixed clutter removal over clutter to target), [`selection`]
//! (candidates for the hyper-parameters).

pub mod ablation;
#[cfg(feature = "train")]
pub(crate) mod baselines;
pub(crate) mod carriers;
#[cfg(feature = "train")]
pub(crate) mod cells;
#[cfg(feature = "train")]
pub(crate) mod clutter;
#[cfg(feature = "train")]
pub(crate) mod fidelity;
#[cfg(feature = "train")]
pub(crate) mod labelled;
#[cfg(feature = "train")]
pub(crate) mod learning_curve;
pub mod paired;
#[cfg(feature = "train")]
pub(crate) mod robustness;
pub(crate) mod seeds;
#[cfg(feature = "train")]
pub(crate) mod selection;
#[cfg(feature = "train")]
pub(crate) mod sim_to_real;
pub mod sweep;
#[cfg(feature = "train")]
pub(crate) mod trained;

#[cfg(feature = "train")]
pub(crate) use crate::network::score;
#[cfg(feature = "train")]
pub use crate::results::Spread;

use crate::progress::Progress;
use crate::scenario::budget::Budget;
use crate::scenario::{Override, Scenario, ScenarioError};
use clap::ValueEnum;
use serde::{Deserialize, Serialize};

/// A study.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Study {
    /// Accuracy over the number of sensing slots, and the curves of Table III.
    LearningCurve,
    /// Accuracy under other headings, rho, power, d, people and carriers.
    Robustness,
    /// Divergence from ray tracing, a richer model and measured recordings, and recognition across the first two.
    Fidelity,
    /// Recognition of measured recordings by networks that learned from simulated ones alone, with baselines.
    SimToReal,
    /// Accuracy of the network, a plain convolutional network and a support vector machine over the number of sensing slots.
    Baselines,
    /// Accuracy with and without each effect of the simulation, the processing and the training, at 3.5 and 60 GHz, on seeds from 101 upwards.
    Ablation,
    /// Accuracy with adaptive and with fixed clutter removal, at clutter-to-target ratios of -20 to 40 dB, on seeds from 101 upwards.
    Clutter,
    /// Accuracy of candidates for the hyper-parameters at the paper's carriers, at the scenario's full sizes, on seeds from 101 upwards.
    Selection,
}

impl Study {
    /// Its name on the command line and in `study.json`.
    #[cfg(feature = "train")]
    pub fn name(self) -> String {
        self.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default()
    }
}

/// What a study is made of.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Request {
    /// Which study.
    pub study: String,
    /// First seed.
    pub seed: u64,
    /// How many seeds, one after the other.
    pub seeds: u32,
    /// The resolved scenario.
    pub scenario: Scenario,
}

impl Request {
    /// How many seeds, in words.
    pub fn seeds_label(&self) -> String {
        match self.seeds {
            1 => format!("seed {}", self.seed),
            many => format!("{many} seeds from {}", self.seed),
        }
    }

    /// The seeds.
    pub fn each_seed(&self) -> impl Iterator<Item = u64> + use<> {
        let first = self.seed;
        (0..u64::from(self.seeds)).map(move |n| first + n)
    }
}

/// A scenario with a few fields changed, each as `--set` takes it.
///
/// # Errors
///
/// A field that is unknown or a value that is illegal in this scenario.
pub(crate) fn changed(scenario: &Scenario, fields: &[&str], origin: &str) -> Result<Scenario, ScenarioError> {
    let fields: Vec<Override> = fields.iter().filter_map(|field| field.parse().ok()).collect();
    scenario.clone().with(&fields, origin)
}

/// How a study's work is done; nothing of it changes a result.
#[derive(Debug, Clone, Copy)]
pub struct RunContext {
    /// How to show progress.
    pub progress: Progress,
    /// Threads.
    pub workers: usize,
    /// What it may take.
    pub budget: Budget,
}
