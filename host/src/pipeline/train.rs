//! Train as a command of its own: networks from simulated recordings or a dataset.

use super::expected::Work;
use super::learn::{How, Trained, class_names};
use super::{Job, budget};
use crate::dataset::Stored;
use crate::error::Failure;
use crate::formats::{model_file, table};
use crate::network::recipe::Recipe;
use crate::network::spectrograms::{Collected, Part};
use crate::network::training::Backend;
use crate::results::{Epoch, Training, TrainingHistory};
use crate::scenario::Scenario;
use crate::store::output::OutputError;
use std::path::PathBuf;

/// How to train, beside the scenario.
#[derive(Debug, Clone)]
pub struct Train {
    /// Whether sizes that nobody stated are the quick ones.
    pub quick: bool,
    /// A dataset; `None`: recordings are simulated.
    pub data: Option<PathBuf>,
    /// `None`: the scenario's.
    pub recipe: Option<Recipe>,
    /// Whether to go on from the checkpoints that are there.
    pub resume: bool,
    pub backend: Backend,
}

/// Where the folder has the float network of so many sensing slots.
pub(super) fn network_name(sensing_slots: u32) -> String {
    format!("models/dsn-{sensing_slots}.json")
}

/// Histories as CSV: one row per network and epoch; the validation's columns stay empty without one.
fn history(training: &[Training]) -> String {
    let number = |v: Option<f64>| v.map_or_else(String::new, |v| v.to_string());
    let row = |n: u32, k: usize, e: &Epoch| {
        let Epoch { loss, accuracy, validation_loss, validation_accuracy } = e;
        let learned = [n.to_string(), (k + 1).to_string(), loss.to_string(), accuracy.to_string()];
        learned.into_iter().chain([validation_loss, validation_accuracy].map(|&v| number(v))).collect()
    };
    let rows = training
        .iter()
        .flat_map(|t| t.epochs.iter().enumerate().map(move |(k, e)| row(t.sensing_slots, k, e)));
    let header = ["sensing_slots", "epoch", "loss", "accuracy", "validation_loss", "validation_accuracy"];
    table::csv(&header, rows)
}

impl Job {
    /// Takes the quick sizes, if asked to, and notes those that it set.
    pub(super) fn size(&mut self, quick: bool) -> Result<(), Failure> {
        if quick {
            let (scenario, sizes) = Scenario::quick(self.given.scenario.as_deref(), &self.given.set)?;
            self.scenario = scenario;
            if !sizes.is_empty() {
                let text = format!("quick: {sizes}; --preset paper takes the scenario's sizes");
                self.progress.note("preset", &text);
            }
        }
        Ok(())
    }

    /// Images of the training recordings that the scenario asks for.
    pub(super) fn simulated(&self) -> Collected {
        self.collect(self.rho(), Part::Train, "training recordings")
    }

    /// Trains the networks and writes their parameters and histories.
    ///
    /// # Errors
    ///
    /// A dataset or checkpoints that do not fit; a folder that cannot be written.
    pub fn train_networks(mut self, ask: &Train) -> Result<Vec<Training>, Failure> {
        self.size(ask.quick)?;
        if let Some(recipe) = ask.recipe {
            recipe.apply(&mut self.scenario.learning);
        }
        let images = match &ask.data {
            Some(folder) => {
                let stored = Stored::open(folder)?;
                let asked = self.scenario.learning.recording_slots;
                if self.given.scenario.is_none() {
                    // what is set stands over the dataset's own scenario
                    let learning = self.scenario.learning.clone();
                    let own = Scenario { learning, ..stored.own_scenario().clone() };
                    self.scenario = own.with(&self.given.set, &folder.display().to_string())?;
                }
                self.scenario = stored.scenario(&self.scenario)?;
                if self.scenario.learning.recording_slots != asked {
                    let slots = stored.slots();
                    let text =
                        format!("recordings have {slots} slots, not learning.recording_slots = {asked}");
                    self.progress.note("read", &text);
                }
                self.budget.check_memory(&budget::training(&self.scenario, 0, self.workers))?;
                self.collect_stored(&stored)?
            }
            None => {
                self.warn_of_rho();
                self.check_cost(Work::Train, self.rho())?;
                self.simulated()
            }
        };
        let trained = self.train(&images, &How::new(ask.backend, ask.resume, &class_names()))?;
        self.write_networks(&trained)?;
        Ok(trained.training)
    }

    /// Writes float networks and their histories.
    pub(super) fn write_networks(&self, trained: &Trained) -> Result<(), Failure> {
        self.output.write("training.csv", history(&trained.training).as_bytes())?;
        for (parameters, n) in trained.parameters.iter().zip(&self.scenario.frame.sensing_slots) {
            self.output.write_json(&network_name(*n), parameters)?;
        }
        self.output
            .write_result(TrainingHistory::FILE, &TrainingHistory { networks: trained.training.clone() })?;
        Ok(())
    }

    /// Writes the models of every N_s of the scenario.
    pub(super) fn write_models(&self, models: &[Vec<u8>]) -> Result<Vec<PathBuf>, OutputError> {
        let slots = &self.scenario.frame.sensing_slots;
        models.iter().zip(slots).map(|(bytes, &n)| self.output.write(&model_file::name(n), bytes)).collect()
    }
}
