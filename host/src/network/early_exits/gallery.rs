//! The gallery's recordings with early exits: what every exit says, and where the core would stop.

use super::Policy;
use super::calibration::weights;
use super::policy::ExitClasses;
use crate::network::evaluation::{Networks, RefusedModel};
use crate::network::spectrograms::{Collected, Recordings};
use crate::results::{EarlyExitGallery, EarlyExitRecording, ExitClassification};
use crate::scenario::Class;
use sdp3_core::early_exit::{EVIDENCE_BITS, EXITS, add_evidence};

/// Weights and threshold from recordings that no network was trained on, the threshold that reaches `accuracy` there with the
/// fewest slots; then where the recordings of `shown` would stop. `None` if there are more networks than the core takes.
///
/// # Errors
///
/// [`RefusedModel`].
pub fn gallery(
    models: &[Vec<u8>],
    calibration: &Recordings<'_>,
    accuracy: f64,
    shown: &Collected,
    progress: &(dyn Fn(u64, u64) + Sync),
) -> Result<Option<EarlyExitGallery>, RefusedModel> {
    if models.is_empty() || models.len() > EXITS {
        return Ok(None);
    }
    let networks = Networks::parse(models, &calibration.scenario.frame.sensing_slots)?;
    let exit_logits = networks.recordings(calibration, progress);
    let policy = Policy::new(&exit_logits.slots, weights(&exit_logits));
    let last = models.len() - 1;
    let exit_classes = policy.exit_classes(&exit_logits);
    let (threshold, last) =
        policy.cheapest(&exit_classes, &exit_logits.truth, accuracy).unwrap_or((2.0, last));
    let found = networks.images(&shown.images);
    let recording = |(n, of_exits): (usize, ExitClasses)| {
        let stop = (0..last).find(|&exit| of_exits[exit].1 >= threshold as f32).unwrap_or(last);
        let exit = |(k, (class, confidence)): (usize, (u8, f32))| ExitClassification {
            sensing_slots: policy.exits[k].sensing_slots,
            frames: shown.images[k].frames as u32,
            class: Class::ALL[usize::from(class)].name().into(),
            confidence: f64::from(confidence),
            probabilities: probabilities(&found.logits[n][..=k], &policy.exits[k].weights),
        };
        EarlyExitRecording {
            truth: Class::ALL[usize::from(found.truth[n])].name().into(),
            exits: of_exits.into_iter().enumerate().map(exit).collect(),
            stops_after: policy.exits[stop].sensing_slots,
        }
    };
    Ok(Some(EarlyExitGallery {
        threshold,
        most_sensing_slots: policy.exits[last].sensing_slots,
        calibrated_on: exit_logits.truth.len() as u32,
        recordings: policy.exit_classes(&found).into_iter().enumerate().map(recording).collect(),
    }))
}

/// Softmax of the evidence of the exits so far.
fn probabilities(passed: &[Vec<i8>], weights: &[i32]) -> Vec<f64> {
    let mut evidence = vec![0; passed.first().map_or(0, Vec::len)];
    for (logits, &weight) in passed.iter().zip(weights) {
        add_evidence(&mut evidence, logits, weight);
    }
    let most = evidence.iter().copied().max().unwrap_or(0);
    let nat = |value: i32| (f64::from(value) - f64::from(most)) / f64::from(1_u32 << EVIDENCE_BITS);
    let shares: Vec<f64> = evidence.iter().map(|&value| libm::exp(nat(value))).collect();
    let sum: f64 = shares.iter().sum();
    shares.into_iter().map(|share| share / sum).collect()
}
