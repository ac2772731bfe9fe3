//! Accuracy through the core: raw I/Q in, classes out, by the very code that runs in the radar module.
//!
//! Every test recording is generated once and given to the pipeline of every model.

use super::spectrograms::item;
use crate::formats::slots::Slots;
use crate::network::memory::OwnedMemory;
use crate::scenario::{Class, Scenario};
use crate::simulator::dataset::{Set, recording};
use rayon::prelude::*;
use sdp3_core::Error;
use sdp3_core::dsn::{Model, ModelError};
use sdp3_core::signal::stft::NativeStft;
use std::sync::atomic::{AtomicU64, Ordering};

/// Why the core would not take a model.
#[derive(Debug, thiserror::Error)]
pub enum AccuracyError {
    /// The model is refused.
    #[error("model for {sensing_slots} sensing slots: {source}")]
    Model {
        /// N_s of the model.
        sensing_slots: u32,
        /// Why.
        source: ModelError,
    },
    /// The pipeline cannot run it.
    #[error("pipeline: {0}")]
    Pipeline(#[from] Error),
}

/// Counts `[truth][answer]` of every model, in the order given.
///
/// # Errors
///
/// [`AccuracyError`] if the core refuses a model.
pub fn through_core(
    scenario: &Scenario,
    rho: f64,
    seed: u64,
    models: &[Vec<u8>],
    progress: &(dyn Fn(u64, u64) + Sync),
) -> Result<Vec<Vec<Vec<u32>>>, AccuracyError> {
    for (bytes, &sensing_slots) in models.iter().zip(&scenario.frame.sensing_slots) {
        Model::parse(bytes).map_err(|source| AccuracyError::Model { sensing_slots, source })?;
    }
    let classes = Class::ALL.len();
    let count = scenario.learning.test_per_class * classes as u32;
    let done = AtomicU64::new(0);
    let answers: Vec<(u8, Vec<u8>)> = (0..count)
        .into_par_iter()
        .map(|index| {
            let slots = scenario.largest_sensing_slots();
            let (class, n) = item(index);
            let recording = recording(scenario, rho, seed, Set::Test, class, n, slots);
            let classes =
                models.iter().map(|model| classify(model, &recording.slots)).collect::<Result<_, _>>();
            progress(done.fetch_add(1, Ordering::Relaxed) + 1, u64::from(count));
            classes.map(|classes| (class as u8, classes))
        })
        .collect::<Result<_, AccuracyError>>()?;
    let mut counts = vec![vec![vec![0; classes]; classes]; models.len()];
    for (truth, answers) in &answers {
        for (counts, &answer) in counts.iter_mut().zip(answers) {
            counts[usize::from(*truth)][usize::from(answer)] += 1;
        }
    }
    Ok(counts)
}

/// Class of one recording; slots beyond the model's are not used.
fn classify(bytes: &[u8], slots: &Slots) -> Result<u8, AccuracyError> {
    let model = Model::parse(bytes).map_err(|source| AccuracyError::Model { sensing_slots: 0, source })?;
    let mut memory = OwnedMemory::for_model(&model);
    let mut pipeline = memory.pipeline::<NativeStft>(model)?;
    for slot in slots.iter().take(model.sensing_slots()) {
        pipeline.push(slot, &mut ())?;
    }
    Ok(pipeline.classify(&mut ()).ok_or(Error::Length)?.class)
}

/// Share on the diagonal of a confusion matrix.
pub fn share_right(counts: &[Vec<u32>]) -> f64 {
    let all: u32 = counts.iter().flatten().sum();
    let right: u32 = counts.iter().enumerate().filter_map(|(i, row)| row.get(i)).sum();
    f64::from(right) / f64::from(all.max(1))
}
