//! Early exits: classify after some slots, and after more, and stop as soon as the class is sure enough.
//!
//! Every exit has a network of its own for its number of slots; the front end is shared, so a slot is dechirped once. An exit's
//! evidence is a weighted sum of its and the earlier exits' logits: with one weight that is temperature scaling (Guo, Pleiss, Sun
//! and Weinberger, 2017), with several stacking. Its softmax is the calibrated confidence. Evidence is exact integer arithmetic.

use crate::dsn::Model;
use crate::dsn::head::{MAX_CLASSES, softmax_confidence};
use crate::math::roundf;
use heapless::Vec;

/// Most exits.
pub const EXITS: usize = 12;

/// Fraction bits of evidence: 2^16 are one nat.
pub const EVIDENCE_BITS: u32 = 16;

/// Largest weight of a logit step: 8 nat, so that sums stay below 2^31.
pub const MAX_WEIGHT: i32 = 1 << 19;

/// Log-odds of every class up to a constant, in 2^-16 nat.
pub(crate) type Evidence = Vec<i32, MAX_CLASSES>;

/// A network and how much its logits and the earlier exits' count.
#[derive(Debug, Clone, Copy)]
pub struct EarlyExit<'m> {
    /// Network for this exit's number of sensing slots.
    pub model: Model<'m>,
    /// Weight of a logit step of each exit so far, first to own, in 2^-16 nat; |w| <= [`MAX_WEIGHT`], the own one not 0.
    pub weights: [i32; EXITS],
}

impl<'m> EarlyExit<'m> {
    /// The only exit: its network's own softmax.
    pub fn single(model: Model<'m>) -> Self {
        let mut weights = [0; EXITS];
        let weight = roundf(model.logit_scale() * (1_i32 << EVIDENCE_BITS) as f32);
        let [own, ..] = &mut weights;
        *own = (weight as i32).min(MAX_WEIGHT);
        EarlyExit { model, weights }
    }

    /// Whether the weights are within their range for exit number `exit`.
    pub(crate) fn is_valid(&self, exit: usize) -> bool {
        let own = self.weights.get(exit).is_some_and(|&weight| weight != 0);
        own && self.weights.iter().all(|w| w.unsigned_abs() <= MAX_WEIGHT as u32)
    }
}

/// Adds `weight` times the logits.
pub fn add_evidence(evidence: &mut [i32], logits: &[i8], weight: i32) {
    for (sum, &logit) in evidence.iter_mut().zip(logits) {
        *sum = sum.wrapping_add(weight.wrapping_mul(i32::from(logit)));
    }
}

/// Class with the most evidence, the first of equals, and its probability by softmax; f32, relative error below 0.6 %.
pub fn decide(evidence: &[i32]) -> (u8, f32) {
    let mut top = (0, i32::MIN);
    for (class, &value) in evidence.iter().enumerate() {
        if value > top.1 {
            top = (class, value);
        }
    }
    let above = |&value: &i32| (i64::from(value) - i64::from(top.1)) as f32 / (1_i32 << EVIDENCE_BITS) as f32;
    (top.0 as u8, softmax_confidence(evidence.iter().map(above)))
}
