//! Simulate and calibrate: recordings as a dataset, rho, the property tests of the channels, the page of spectrograms.

use super::Job;
use crate::dataset::{Shard, Work, Written};
use crate::error::{Failure, Invalid};
use crate::network::spectrograms;
use crate::progress::Progress;
use crate::recordings;
use crate::report;
use crate::results::{Calibration, ChannelTable};
use crate::scenario::Class;
use crate::simulator::calibration::{self, stored};
use crate::simulator::channel::properties;
use crate::store::output::Output;
use std::path::{Path, PathBuf};

/// A measured signal to calibrate on.
#[derive(Debug, Clone)]
pub struct Measured {
    pub file: PathBuf,
    /// What was stated about it.
    pub stated: recordings::Stated,
    /// How the person in it moves.
    pub motion: Class,
}

/// A dataset to simulate.
#[derive(Debug, Clone)]
pub struct Dataset {
    /// Recordings of each class.
    pub per_class: u32,
    /// Absent: all.
    pub classes: Option<Vec<Class>>,
    /// Whether the parts hold the raw slots too.
    pub raw: bool,
    /// Whether the raw slots are written as SigMF too.
    pub sigmf: bool,
    pub shard: Shard,
}

/// Writes the look-up table of rho again.
///
/// # Errors
///
/// A file that cannot be written.
pub fn calibrate_table(file: &Path, seed: u64, progress: Progress) -> Result<stored::Table, Failure> {
    let stage = progress.stage("calibrate", "the table of rho");
    let table = stored::regenerate(seed, &|done, all| stage.at(done, all));
    let text = format!("{}{}", stored::HEADER, toml::to_string(&table)?);
    Output::write_file(file, text.as_bytes())?;
    stage.finish(&format!("{} entries in {}", table.entry.len(), file.display()));
    Ok(table)
}

impl Job {
    /// Writes a dataset, or a shard of it.
    ///
    /// # Errors
    ///
    /// A folder of another dataset, or that cannot be written.
    pub fn simulate(&self, dataset: Dataset) -> Result<Written, Failure> {
        let Dataset { per_class, classes, raw, sigmf, shard } = dataset;
        let classes = classes.unwrap_or_else(|| Class::ALL.to_vec());
        if let Some(twice) = classes.iter().enumerate().find(|(k, class)| classes[..*k].contains(class)) {
            let value = format!("{} twice", twice.1.name());
            return Err(Invalid::option("--classes", value, "each class once").into());
        }
        if self.scenario.target.capture.is_some() && classes.len() > 1 {
            let names: Vec<_> = classes.iter().map(|class| class.name()).collect();
            let legal = "one class: target.capture is one motion";
            return Err(Invalid::option("--classes", names.join(","), legal).into());
        }
        self.warn_of_aliasing(&classes);
        self.note_near_field();
        self.warn_of_rho();
        let stage = self.progress.stage("simulate", "recordings");
        let work = Work::new(&self.scenario, self.rho(), self.seed, per_class, classes, raw, sigmf);
        let written = work.write(shard, &self.output, &|done, all| stage.at(done, all))?;
        let state = if written.manifest.is_some() { "complete" } else { "not yet complete" };
        stage.finish(&format!(
            "{} parts made, {} kept; {} recordings in {}, {state}",
            written.made,
            written.kept,
            written.recordings,
            self.output.folder().display()
        ));
        Ok(written)
    }

    /// Finds rho and writes `calibration.json`; its path is returned too.
    ///
    /// # Errors
    ///
    /// As [`Self::calibrate`]; a folder that cannot be written.
    pub fn calibration(&self, measured: Option<&Measured>) -> Result<(Calibration, PathBuf), Failure> {
        if measured.is_none() {
            self.warn_of_rho();
        }
        let found = self.calibrate(measured)?;
        self.record("calibrate")?;
        let path = self.output.write_result("calibration.json", &found)?;
        Ok((found, path))
    }

    /// Finds rho: from a measured signal, from the scenario, or from the stored table.
    ///
    /// # Errors
    ///
    /// An unreadable measurement.
    pub(super) fn calibrate(&self, measured: Option<&Measured>) -> Result<Calibration, Failure> {
        let s = &self.scenario;
        if let Some(measured) = measured {
            let signal = recordings::read(&measured.file, &measured.stated)?;
            let stage = self.progress.stage("calibrate", "rho on the measured signal");
            let found =
                calibration::calibrate_measured(s, &signal, measured.motion, self.seed, &|done, all| {
                    stage.at(done, all)
                })
                .map_err(|error| format!("{}: {error}", measured.file.display()))?;
            stage.finish(&format!(
                "rho = {} with KL {:.4}, {:.4} without uncertainty",
                found.rho,
                found.kl.unwrap_or(f64::NAN),
                found.kl_without_uncertainty.unwrap_or(f64::NAN)
            ));
            return Ok(found);
        }
        let (rho, source) = match s.channel.rho {
            Some(rho) => (rho, format!("scenario: channel.rho = {rho}")),
            None => calibration::stored_rho(s),
        };
        let stage = self.progress.stage("calibrate", "self-check of the stored rho");
        let found = calibration::recover(s, rho, &source, self.seed, &|done, all| stage.at(done, all));
        stage.finish(&format!("rho = {rho}: {source}"));
        Ok(found)
    }

    /// Every channel model through the property tests of the paper's Table I: `channels.json`.
    ///
    /// # Errors
    ///
    /// A folder that cannot be written.
    pub fn channels(&self) -> Result<ChannelTable, Failure> {
        let stage = self.progress.stage("channels", "models through the property tests");
        let table = properties::table(&self.scenario, self.seed, &|done, all| stage.at(done, all));
        stage.finish(&format!("{} models", table.models.len()));
        self.record("channels")?;
        self.output.write_result("channels.json", &table)?;
        Ok(table)
    }

    /// The page of spectrograms: class by carrier by channel model.
    ///
    /// # Errors
    ///
    /// A folder that cannot be written.
    pub fn gallery_page(&self) -> Result<PathBuf, Failure> {
        let stage = self.progress.stage("gallery", "spectrograms");
        let shown = spectrograms::gallery(&self.scenario, self.seed, &|done, all| stage.at(done, all));
        self.record("gallery")?;
        let page = self.output.write("gallery.html", report::gallery::page(&shown).as_bytes())?;
        stage.finish(&format!("{} of them", shown.len()));
        Ok(page)
    }
}
