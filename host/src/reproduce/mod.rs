//! The paper's tables and figures, made again: one file each, with the paper's numbers and statements beside those found.
//!
//! Everything is found twice: with the settings as printed (the scenario `as-printed`) and with those of the scenario. `work` computes and
//! keeps what several items need, `settings` says what is simulated, `items` judges, `page` writes the results as one page.

#[cfg(feature = "train")]
mod accuracy_over_epochs;
#[cfg(feature = "train")]
mod channel_models;
#[cfg(feature = "train")]
mod intensities;
#[cfg(feature = "train")]
pub(crate) mod items;
#[cfg(feature = "train")]
mod kl_divergence;
#[cfg(feature = "train")]
mod learning_curve;
#[cfg(feature = "train")]
mod learning_curve_models;
#[cfg(feature = "train")]
mod made;
#[cfg(feature = "train")]
pub mod page;
#[cfg(feature = "train")]
mod region;
#[cfg(feature = "train")]
pub(crate) mod settings;
#[cfg(feature = "train")]
mod spectrograms;
#[cfg(feature = "train")]
mod training;
#[cfg(feature = "train")]
pub(crate) mod work;

use clap::ValueEnum;

/// A table or figure of the paper, in its order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Item {
    /// Table I: which channel model has which property.
    ChannelModels,
    /// Spectrograms of standing, pacing and walking, with one and with two people.
    Spectrograms,
    /// KL divergence over rho, and that of ray tracing.
    KlDivergence,
    /// Distributions of intensity of experiment, hybrid channel and ray tracing.
    Intensities,
    /// Accuracy over epochs of networks of three origins.
    AccuracyOverEpochs,
    /// Training loss and test accuracy over epochs for every number of sensing slots.
    Training,
    /// Accuracy over the number of sensing slots.
    LearningCurve,
    /// Tables II and III: seven curves and their errors.
    LearningCurveModels,
    /// The accuracy-throughput region of both cases with its zones.
    Region,
}

/// How large it is made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Size {
    /// Minutes: one seed, a smaller network, fewer recordings.
    Quick,
    /// The paper's sizes; hours.
    Paper,
}

impl Size {
    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Size::Quick => "quick",
            Size::Paper => "paper",
        }
    }
}

impl Item {
    /// Its name on the command line and of its files.
    pub fn name(self) -> String {
        self.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default()
    }
}
