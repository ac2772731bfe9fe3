//! The gallery's recordings as anytime sensing hears them: what every exit says, and where the core stops.

use super::super::accuracy::AccuracyError;
use super::super::spectrograms::GALLERY_RECORDING;
use super::calibration::weights;
use super::{Part, Policy, collect};
use crate::predictor::receiver::OwnedBuffers;
use crate::results::{AnytimeGallery, AnytimeRecording, AnytimeVerdict};
use crate::scenario::{Class, Scenario};
use crate::simulator::dataset::{Set, recording};
use sdp3_core::dsn::{Model, Portable};
use sdp3_core::early_exit::{Anytime, EVIDENCE_BITS, EXITS, Exit, Verdict, add_evidence};

/// Weights and threshold from `per_class` recordings of every class behind those trained on, the threshold that reaches `accuracy`
/// there with the fewest slots; then one recording of every class through the core's own receiver. `None` if there are more
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
    let answers = collect(scenario, rho, seed, models, (Part::Calibration, per_class), progress)?;
    let policy = Policy::new(&answers.slots, weights(&answers));
    let last = models.len() - 1;
    let courses = policy.courses(&answers);
    let (threshold, last) = policy.cheapest(&courses, &answers.truth, accuracy).unwrap_or((2.0, last));
    let hear = |&class: &Class| -> Result<AnytimeRecording, AccuracyError> {
        let exits = hear(scenario, rho, seed, models, &policy, class)?;
        let stop = exits[..last].iter().find(|exit| exit.confidence >= f64::from(threshold as f32));
        let stops_after = stop.map_or(policy.exits[last].sensing_slots, |exit| exit.sensing_slots);
        Ok(AnytimeRecording { truth: class.name().into(), exits, stops_after })
    };
    Ok(Some(AnytimeGallery {
        threshold,
        most_sensing_slots: policy.exits[last].sensing_slots,
        calibrated_on: answers.truth.len() as u32,
        recordings: Class::ALL.iter().map(hear).collect::<Result<_, _>>()?,
    }))
}

/// Verdicts of all exits on one recording: nothing stops.
fn hear(
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
        exits.push(Exit { model: Model::parse(bytes).map_err(refused)?, kernels: Portable, weights });
    }
    let models: Vec<_> = exits.iter().map(|exit| exit.model.clone()).collect();
    let Some(largest) = models.last() else { return Ok(Vec::new()) };
    let mut buffers = OwnedBuffers::for_model(largest);
    let mut receiver = Anytime::new(exits, 2.0, buffers.view()).map_err(AccuracyError::Receiver)?;
    let slots = scenario.largest_sensing_slots();
    let heard = recording(scenario, rho, seed, Set::Demo, class, GALLERY_RECORDING, slots).slots;
    let verdicts: Vec<Verdict> = heard
        .iter()
        .filter_map(|slot| receiver.push(&crate::formats::slots::old_slot(slot), &mut ()))
        .collect();
    let told = verdicts.iter().zip(&models).zip(&policy.exits).enumerate().map(|(k, ((v, model), exit))| {
        AnytimeVerdict {
            sensing_slots: exit.sensing_slots,
            frames: model.frames() as u32,
            class: model.class_name(usize::from(v.class)).to_owned(),
            confidence: f64::from(v.confidence),
            probabilities: probabilities(&verdicts[..=k], &exit.weights),
        }
    });
    Ok(told.collect())
}

/// Softmax of the evidence of the verdicts so far.
fn probabilities(verdicts: &[Verdict], weights: &[i32]) -> Vec<f64> {
    let mut evidence = vec![0; verdicts.first().map_or(0, |v| v.answer.logits.len())];
    for (verdict, &weight) in verdicts.iter().zip(weights) {
        add_evidence(&mut evidence, &verdict.answer.logits, weight);
    }
    let most = evidence.iter().copied().max().unwrap_or(0);
    let nat = |value: i32| (f64::from(value) - f64::from(most)) / f64::from(1_u32 << EVIDENCE_BITS);
    let shares: Vec<f64> = evidence.iter().map(|&value| libm::exp(nat(value))).collect();
    let sum: f64 = shares.iter().sum();
    shares.into_iter().map(|share| share / sum).collect()
}
