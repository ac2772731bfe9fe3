//! Quantise as a command of its own: model files from the float networks of the output folder.

use super::learn::{How, class_names};
use super::stored::TRAIN_FIRST;
use super::train::network_name;
use super::{Job, budget};
use crate::dataset::Stored;
use crate::error::Failure;
use crate::network::parameters::Parameters;
use crate::network::safetensors;
use crate::network::training::Backend;
use std::path::{Path, PathBuf};

impl Job {
    /// Converts the networks of the output folder into model files, ranges measured on a dataset or simulated recordings.
    ///
    /// # Errors
    ///
    /// Networks that are not there or damaged; a dataset that does not fit; a folder that cannot be written.
    pub fn quantize_networks(mut self, data: Option<&Path>) -> Result<Vec<PathBuf>, Failure> {
        self.scenario = self.run_scenario()?;
        self.seed = self.folder_seed()?;
        let networks = self
            .scenario
            .frame
            .sensing_slots
            .iter()
            .map(|n| {
                let name = network_name(*n);
                let network: Parameters = self.output.read_json(&name, TRAIN_FIRST)?;
                let checked = safetensors::check(&network);
                checked.map_err(|e| format!("{}: {e}", self.output.path(&name).display()))?;
                Ok(network)
            })
            .collect::<Result<Vec<_>, Failure>>()?;
        self.budget.check_memory(&budget::training(&self.scenario, 0, self.workers))?;
        let images = match data {
            Some(folder) => {
                let stored = Stored::open(folder)?;
                stored.scenario(&self.scenario)?;
                self.collect_stored(&stored)?
            }
            None => self.simulated(),
        };
        let classes = class_names();
        let how = How::new(Backend::default(), false, &classes);
        Ok(self.write_models(&self.quantize(&networks, &images, &how)?)?)
    }
}
