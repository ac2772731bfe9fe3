//! Logits of every exit for many recordings, through the core's int8 networks.

use super::super::accuracy::AccuracyError;
use super::super::spectrograms::{images_of, images_of_beats, item};
use crate::network::inference::Classifier;
use crate::scenario::Scenario;
use crate::simulator::dataset::{Set, beats, recording};
use rayon::prelude::*;
use sdp3_core::dsn::Model;
use std::sync::atomic::{AtomicU64, Ordering};

/// Which recordings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// Recordings behind those trained on, for fitting weights and choosing thresholds; through beats.
    Calibration,
    /// The test set, through raw slots.
    Test,
}

/// What the exits' networks say.
#[derive(Debug, Clone, PartialEq)]
pub struct ExitLogits {
    /// Number of sensing slots of every exit, ascending.
    pub slots: Vec<u32>,
    /// What a logit step is worth, in nat, for every exit.
    pub scales: Vec<f64>,
    /// Label of every recording.
    pub truth: Vec<u8>,
    /// `[recording][exit][class]`.
    pub logits: Vec<Vec<Vec<i8>>>,
}

impl ExitLogits {
    /// Share of the recordings that an exit's own network classifies correctly.
    pub fn alone(&self, exit: usize) -> f64 {
        let right = |(logits, &truth): (&Vec<Vec<i8>>, &u8)| {
            sdp3_core::dsn::head::arg_max(&logits[exit]) == usize::from(truth)
        };
        let count = self.logits.iter().zip(&self.truth).filter(|&x| right(x)).count();
        count as f64 / self.truth.len().max(1) as f64
    }
}

/// Runs `per_class` recordings of every class through `models`, one for each N_s of the scenario.
///
/// # Errors
///
/// [`AccuracyError`] if the core refuses a model.
pub fn collect(
    scenario: &Scenario,
    rho: f64,
    seed: u64,
    models: &[Vec<u8>],
    (part, per_class): (Part, u32),
    progress: &(dyn Fn(u64, u64) + Sync),
) -> Result<ExitLogits, AccuracyError> {
    let slots = scenario.frame.sensing_slots.clone();
    let parsed = models
        .iter()
        .zip(&slots)
        .map(|(bytes, &sensing_slots)| {
            Model::parse(bytes).map_err(|source| AccuracyError::Model { sensing_slots, source })
        })
        .collect::<Result<Vec<_>, _>>()?;
    let most = scenario.largest_sensing_slots();
    let count = per_class * crate::scenario::Class::ALL.len() as u32;
    let done = AtomicU64::new(0);
    let answer = |classifiers: &mut Vec<Classifier>, index: u32| {
        let (class, n) = item(index);
        let images = match part {
            Part::Test => {
                images_of(scenario, &recording(scenario, rho, seed, Set::Test, class, n, most).slots)
            }
            Part::Calibration => {
                let n = scenario.learning.train_per_class + n;
                images_of_beats(scenario, &beats(scenario, rho, seed, Set::Train, class, n, most).0)
            }
        };
        let networks = classifiers.iter_mut().zip(&images);
        let logits: Vec<_> =
            networks.map(|(network, image)| network.classify(image, &mut ()).logits.to_vec()).collect();
        progress(done.fetch_add(1, Ordering::Relaxed) + 1, u64::from(count));
        (class as u8, logits)
    };
    let classifiers = || parsed.iter().copied().map(Classifier::new).collect();
    let (truth, logits) = (0..count).into_par_iter().map_init(classifiers, answer).unzip();
    Ok(ExitLogits {
        slots,
        scales: parsed.iter().map(|m| f64::from(m.logit_scale())).collect(),
        truth,
        logits,
    })
}
