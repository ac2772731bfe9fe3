//! Learn: images, networks, int8 models, and their accuracy, one after the other.
//!
//! Section IV of the paper; one network for each N_s of the scenario.

use super::Job;
use crate::dataset::Stored;
use crate::error::Failure;
use crate::network::checkpoint::Checkpoint;
use crate::network::evaluation::{confusion, test};
use crate::network::interchange::header;
use crate::network::parameters::Parameters;
use crate::network::spectrograms::{Collected, Part, collect_from};
use crate::network::training::{self, Backend, train_all};
use crate::network::tuning::quantize_tuned;
use crate::results::{Accuracy, Confusion, Epoch, Training};
use crate::scenario::{Class, Scenario};
use crate::store::record::{self, Fault};
use std::sync::atomic::Ordering;

/// Float networks of every N_s.
pub struct Trained {
    /// Parameters in the order of `frame.sensing_slots`.
    pub parameters: Vec<Parameters>,
    /// Histories; the loss on the test set is filled in by [`Job::learn`].
    pub training: Vec<Training>,
}

/// How networks are trained, beside the scenario's settings.
#[derive(Debug, Clone)]
pub struct How<'a> {
    pub backend: Backend,
    /// Whether to go on from the checkpoints that are there.
    pub resume: bool,
    /// Names of the classes, in the order of the labels.
    pub classes: &'a [String],
    /// Folder of checkpoints and of what the quantisation reports, within the output's.
    pub folder: String,
    /// Networks to go on from, in the order of `frame.sensing_slots`; absent: random weights.
    pub start: Option<&'a [Parameters]>,
}

impl<'a> How<'a> {
    /// Networks from random weights, into the folder `models`.
    pub fn new(backend: Backend, resume: bool, classes: &'a [String]) -> Self {
        How { backend, resume, classes, folder: "models".into(), start: None }
    }
}

/// Names of the simulator's classes.
pub fn class_names() -> Vec<String> {
    Class::ALL.iter().map(|class| class.name().to_owned()).collect()
}

/// Networks and how well they recognise.
pub struct Learned {
    /// Model files in the order of `frame.sensing_slots`.
    pub models: Vec<Vec<u8>>,
    pub accuracy: Vec<Accuracy>,
    pub confusion: Vec<Confusion>,
}

impl Job {
    /// Images of the recordings learned from or tested with, with progress.
    pub(super) fn collect(&self, rho: f64, part: Part, what: &str) -> Collected {
        let l = &self.scenario.learning;
        let count = if part == Part::Test { l.test_per_class } else { l.train_per_class };
        let stage = self.progress.stage("simulate", what);
        let found = self.recordings(rho, part, count).images(&|done, all| stage.at(done, all));
        stage.finish(&format!("{what}: {count} of each class at rho = {rho}"));
        found
    }

    /// Images of a dataset's recordings, with progress.
    ///
    /// # Errors
    ///
    /// A part that cannot be used.
    pub(super) fn collect_stored(&self, stored: &Stored) -> Result<Collected, Failure> {
        let stage = self.progress.stage("read", "training recordings");
        let (mut found, mut done) = (Collected { images: Vec::new() }, 0);
        stored.each(|recordings| {
            done += recordings.len() as u64;
            found.extend(&collect_from(&self.scenario, recordings));
            stage.at(done, u64::from(stored.recordings()));
        })?;
        stage.finish(&format!("training recordings: {done} of a dataset"));
        Ok(found)
    }

    /// Trains one network per N_s, several side by side, with a checkpoint after every epoch and the scenario beside them; the
    /// result does not depend on the number of threads.
    ///
    /// # Errors
    ///
    /// Images that do not fit the settings; checkpoints of other trainings, or that cannot be written or read.
    pub(super) fn train(&self, train: &Collected, how: &How) -> Result<Trained, Failure> {
        let s = &self.scenario;
        let slots = &s.frame.sensing_slots;
        let name = |n: u32| format!("{}/dsn-{n}.checkpoint.json", how.folder);
        let (mut jobs, mut identities) = (Vec::new(), Vec::new());
        for (index, (&n, images)) in slots.iter().zip(&train.images).enumerate() {
            let seed = self.seed ^ (u64::from(n) << 32);
            let start = how.start.map(|networks| networks[index].clone());
            let mut job = training::Job { seed, backend: how.backend, start, resume: None };
            let identity = job.identity(images, &s.learning, how.classes.len());
            if how.resume {
                let path = self.output.path(&name(n));
                job.resume = match record::read(&path, &identity)? {
                    Err(Fault::Missing) => None,
                    found => Some(
                        found.map_err(|fault| fault.refusal(&path, "train without --resume to restart"))?,
                    ),
                };
            }
            jobs.push(job);
            identities.push(identity);
        }
        // what the checkpoints are of; those that are there have been checked
        self.output.write(Scenario::FILE, s.to_toml().as_bytes())?;
        let stage = self.progress.stage("train", "networks");
        let total = jobs.len() as u64 * u64::from(s.learning.epochs);
        let done: u64 = jobs.iter().flat_map(|j| &j.resume).map(|c| c.epochs.len() as u64).sum();
        stage.at(done, total);
        let after_epoch = |job: usize, state: &dyn Fn() -> Checkpoint, epochs: &[Epoch]| {
            record::write(&self.output, &name(slots[job]), &identities[job], &state())
                .map_err(|e| e.to_string())?;
            if let Some(e) = epochs.last() {
                let validation = e.validation_loss.zip(e.validation_accuracy);
                let validation = validation.map(|(l, a)| format!(", validation {l:.3} {a:.3}"));
                let (n, k, words) = (slots[job], epochs.len(), validation.unwrap_or_default());
                stage
                    .say(&format!("N_s {n} epoch {k}: loss {:.3} accuracy {:.3}{words}", e.loss, e.accuracy));
            }
            stage.step(total);
            if self.stop.load(Ordering::Relaxed) { Err("stopped".to_owned()) } else { Ok(()) }
        };
        let trained =
            train_all(&train.images, &jobs, &s.learning, how.classes.len(), self.workers, &after_epoch)?;
        let last = trained.last().and_then(|t| t.epochs.last());
        let (loss, accuracy) = last.map_or((f64::NAN, f64::NAN), |e| (e.loss, e.accuracy));
        stage.finish(&format!("{} networks, last loss {loss:.3}, accuracy {accuracy:.3}", trained.len()));
        let training = trained
            .iter()
            .zip(&s.frame.sensing_slots)
            .map(|(t, &sensing_slots)| Training {
                sensing_slots,
                parameters: t.parameters.count() as u32,
                epochs: t.epochs.clone(),
                float_loss: 0.0,
            })
            .collect();
        Ok(Trained { parameters: trained.into_iter().map(|t| t.parameters).collect(), training })
    }

    /// Converts networks into model files, ranges measured on training images.
    ///
    /// # Errors
    ///
    /// Weights that do not fit the format.
    pub(super) fn quantize(
        &self,
        networks: &[Parameters],
        train: &Collected,
        how: &How,
    ) -> Result<Vec<Vec<u8>>, Failure> {
        let stage = self.progress.stage("quantize", "int8 models");
        let mut models = Vec::new();
        for (index, network) in networks.iter().enumerate() {
            let slots = self.scenario.frame.sensing_slots[index];
            let header = header(&self.scenario, slots);
            let (quantized, report) =
                quantize_tuned(network, header, how.classes, &train.images[index], &self.scenario.learning)?;
            self.output.write_json(&format!("{}/dsn-{slots}-quantization.json", how.folder), &report)?;
            models.push(quantized.to_bytes()?);
            stage.step(networks.len() as u64);
        }
        let bytes = models.iter().map(Vec::len).max().unwrap_or(0);
        stage.finish(&format!("{} models of at most {bytes} bytes", models.len()));
        Ok(models)
    }

    /// All steps: train, quantise, test in float and through the core.
    ///
    /// # Errors
    ///
    /// Any of the steps'.
    pub(super) fn learn(&self, rho: f64, how: &How) -> Result<(Learned, Vec<Training>), Failure> {
        let train = self.collect(rho, Part::Train, "training recordings");
        let mut trained = self.train(&train, how)?;
        let models = self.quantize(&trained.parameters, &train, how)?;
        let images = self.collect(rho, Part::Test, "test recordings").images;
        let stage = self.progress.stage("run", "networks on the test recordings");
        let slots = &self.scenario.frame.sensing_slots;
        let (mut accuracy, mut confusions) = (Vec::new(), Vec::new());
        let tested = test(&trained.parameters, &models, slots, &images)?;
        for ((tested, images), training) in tested.into_iter().zip(&images).zip(&mut trained.training) {
            training.float_loss = tested.float.loss;
            for (arithmetic, answers) in [("float", &tested.float.classes), ("int8", &tested.int8)] {
                let counts = confusion(&images.labels, answers, how.classes.len());
                let sensing_slots = training.sensing_slots;
                confusions.push(Confusion { sensing_slots, arithmetic: arithmetic.into(), counts });
            }
            accuracy.push(tested.accuracy);
        }
        let words: Vec<String> =
            accuracy.iter().map(|a| format!("{} {:.3}", a.sensing_slots, a.int8)).collect();
        stage.finish(&format!("int8 accuracy by N_s: {}", words.join(", ")));
        Ok((Learned { models, accuracy, confusion: confusions }, trained.training))
    }
}
