//! The main job, [`Job::main_job`], and its stages in their order.
//!
//! Simulate, calibrate, train, run, verify, optimize, schedule, report. Every stage is also a command of its own. A command line is
//! made a request elsewhere; what is done for it, and which files it leaves, is decided here.

mod budget;
#[cfg(feature = "cli")]
pub mod classes_over_time;
#[cfg(feature = "train")]
mod expected;
#[cfg(feature = "train")]
mod folds;
#[cfg(feature = "cli")]
mod inspect;
#[cfg(feature = "train")]
mod labelled_recordings;
#[cfg(feature = "train")]
mod learn;
#[cfg(all(feature = "cli", feature = "train"))]
pub(crate) mod main_job;
mod notes;
#[cfg(feature = "cli")]
mod optimize;
#[cfg(all(feature = "cli", feature = "train"))]
mod quantize;
#[cfg(all(feature = "cli", feature = "train"))]
pub(crate) mod reproduce;
#[cfg(feature = "cli")]
mod schedule;
#[cfg(feature = "cli")]
mod simulate;
#[cfg(feature = "cli")]
mod stored;
#[cfg(all(feature = "cli", feature = "train"))]
pub(crate) mod study;
#[cfg(feature = "cli")]
pub(crate) mod sweep;
#[cfg(all(feature = "cli", feature = "train"))]
mod sweep_cost;
#[cfg(feature = "cli")]
mod targets;
#[cfg(feature = "train")]
pub(crate) mod train;
#[cfg(feature = "train")]
pub(crate) mod train_recordings;
#[cfg(feature = "cli")]
pub(crate) mod verify;

use crate::error::Failure;
use crate::network::spectrograms::{Part, Recordings};
use crate::progress::Progress;
use crate::scenario::budget::Budget;
use crate::scenario::{Override, Scenario};
use crate::simulator::{calibration, validity};
use crate::store::output::Output;
use std::path::{Path, PathBuf};
#[cfg(feature = "train")]
use std::sync::{Arc, atomic::AtomicBool};

#[cfg(feature = "cli")]
pub use simulate::{Dataset, Measured, calibrate_table};
#[cfg(feature = "cli")]
pub use targets::{INDEX, Targets};

/// What every stage needs.
#[derive(Debug, Clone)]
pub struct Job {
    pub scenario: Scenario,
    /// Seed of everything random.
    pub seed: u64,
    /// How to show progress.
    pub progress: Progress,
    pub output: Output,
    /// What it may take.
    pub budget: Budget,
    /// Threads to train on.
    #[cfg(feature = "train")]
    pub workers: usize,
    /// Set from elsewhere to end trainings after the epochs that they are in.
    #[cfg(feature = "train")]
    pub stop: Arc<AtomicBool>,
    pub given: Given,
}

/// What was stated of scenario and seed; what is absent may be that of an earlier run.
#[derive(Debug, Clone)]
pub struct Given {
    /// The scenario's file or name.
    pub scenario: Option<PathBuf>,
    /// Fields that are set over it.
    pub set: Vec<Override>,
    pub seed: Option<u64>,
}

impl Job {
    /// The scenario's rho, or the stored one.
    fn rho(&self) -> f64 {
        calibration::rho_of(&self.scenario)
    }

    /// The first `per_class` recordings of every class of a part.
    fn recordings(&self, rho: f64, part: Part, per_class: u32) -> Recordings<'_> {
        Recordings { scenario: &self.scenario, rho, seed: self.seed, part, per_class }
    }
}

/// Everything that is wrong with a scenario's file; if it alone is right, what other files or a simulation show, such as a motion
/// capture.
///
/// # Errors
///
/// A file that was right a moment ago.
pub fn scenario_errors(file: &Path, set: &[Override]) -> Result<Vec<String>, Failure> {
    let errors = Scenario::errors_of(file, set);
    if errors.is_empty() {
        let found = validity::check(&Scenario::resolve(Some(file), set)?);
        return Ok(found.err().map(|error| error.to_string()).into_iter().collect());
    }
    Ok(errors.iter().map(ToString::to_string).collect())
}

/// Why a command that needs training fails in a build that cannot.
#[cfg(not(feature = "train"))]
pub fn untrained<T>(what: &str) -> Result<T, Failure> {
    Err(format!("this build cannot {what}: build it with the feature `train`").into())
}
