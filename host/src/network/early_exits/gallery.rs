//! The gallery's recordings with early exits: what every exit says, and where the core stops.

use super::super::accuracy::AccuracyError;
use super::super::spectrograms::GALLERY_RECORDING;
use super::calibration::weights;
use super::{Part, Policy, collect};
use crate::network::memory::OwnedMemory;
use crate::results::{AnytimeGallery, AnytimeRecording, AnytimeVerdict};
use crate::scenario::{Class, Scenario};
use crate::simulator::dataset::{Set, recording};
use sdp3_core::dsn::{Classification, Model};
use sdp3_core::early_exit::{EVIDENCE_BITS, EXITS, EarlyExit, add_evidence};

/// Weights and threshold from `per_class` recordings of every class behind those trained on, the threshold that reaches `accuracy`
/// there with the fewest slots; then one recording of every class through the core's own pipeline. `None` if there are more
/// networks than it takes.
///
/// # Errors
///
/// [`AccuracyError`] if the core refuses a model.
pub fn gallery(
    scenario: &Scenario,
    rho: f64,
    seed: u64,
    models: &[Vec<u8>],
    (per_class, accuracy): (u32, f64),
    progress: &(dyn Fn(u64, u64) + Sync),
) -> Result<Option<AnytimeGallery>, AccuracyError> {
    if models.is_empty() || models.len() > EXITS {
        return Ok(None);
    }
    let exit_logits = collect(scenario, rho, seed, models, (Part::Calibration, per_class), progress)?;
    let policy = Policy::new(&exit_logits.slots, weights(&exit_logits));
    let last = models.len() - 1;
    let courses = policy.courses(&exit_logits);
    let (threshold, last) = policy.cheapest(&courses, &exit_logits.truth, accuracy).unwrap_or((2.0, last));
    let classified = |&class: &Class| -> Result<AnytimeRecording, AccuracyError> {
        let exits = classify(scenario, rho, seed, models, &policy, class)?;
        let stop = exits[..last].iter().find(|exit| exit.confidence >= f64::from(threshold as f32));
        let stops_after = stop.map_or(policy.exits[last].sensing_slots, |exit| exit.sensing_slots);
        Ok(AnytimeRecording { truth: class.name().into(), exits, stops_after })
    };
    Ok(Some(AnytimeGallery {
        threshold,
        most_sensing_slots: policy.exits[last].sensing_slots,
        calibrated_on: exit_logits.truth.len() as u32,
        recordings: Class::ALL.iter().map(classified).collect::<Result<_, _>>()?,
    }))
}

/// Classifications of all exits on one recording: nothing stops.
fn classify(
    scenario: &Scenario,
    rho: f64,
    seed: u64,
    models: &[Vec<u8>],
    policy: &Policy,
    class: Class,
) -> Result<Vec<AnytimeVerdict>, AccuracyError> {
    let mut exits = Vec::new();
    for (bytes, own) in models.iter().zip(&policy.exits) {
        let refused = |source| AccuracyError::Model { sensing_slots: own.sensing_slots, source };
        let mut weights = [0; EXITS];
        weights.iter_mut().zip(&own.weights).for_each(|(to, from)| *to = *from);
        exits.push(EarlyExit { model: Model::parse(bytes).map_err(refused)?, weights });
    }
    let models: Vec<_> = exits.iter().map(|exit| exit.model).collect();
    let Some(largest) = models.last() else { return Ok(Vec::new()) };
    let mut memory = OwnedMemory::for_model(largest);
    let mut pipeline = memory.early_exits(exits, 2.0)?;
    let slots = scenario.largest_sensing_slots();
    let recorded = recording(scenario, rho, seed, Set::Demo, class, GALLERY_RECORDING, slots).slots;
    let mut found: Vec<Classification> = Vec::new();
    for slot in &recorded {
        if pipeline.stopped() {
            break;
        }
        pipeline.push(slot, &mut ())?;
        found.extend(pipeline.classify(&mut ()));
    }
    let verdicts = found.iter().zip(&models).zip(&policy.exits).enumerate().map(|(k, ((v, model), exit))| {
        AnytimeVerdict {
            sensing_slots: exit.sensing_slots,
            frames: model.frames() as u32,
            class: model.class_name(usize::from(v.class)).to_owned(),
            confidence: f64::from(v.confidence),
            probabilities: probabilities(&found[..=k], &exit.weights),
        }
    });
    Ok(verdicts.collect())
}

/// Softmax of the evidence of the exits so far.
fn probabilities(passed: &[Classification], weights: &[i32]) -> Vec<f64> {
    let mut evidence = vec![0; passed.first().map_or(0, |found| found.logits.len())];
    for (found, &weight) in passed.iter().zip(weights) {
        add_evidence(&mut evidence, &found.logits, weight);
    }
    let most = evidence.iter().copied().max().unwrap_or(0);
    let nat = |value: i32| (f64::from(value) - f64::from(most)) / f64::from(1_u32 << EVIDENCE_BITS);
    let shares: Vec<f64> = evidence.iter().map(|&value| libm::exp(nat(value))).collect();
    let sum: f64 = shares.iter().sum();
    shares.into_iter().map(|share| share / sum).collect()
}
