//! Anytime sensing: classify after some slots, and after more, and stop as soon as the answer is sure enough.
//!
//! Every exit has a network of its own for its number of slots; the front end is shared, so a slot is dechirped once. An exit's
//! evidence is a weighted sum of its and the earlier exits' logits: with one weight that is temperature scaling (Guo, Pleiss, Sun
//! and Weinberger, 2017), with several stacking. Its softmax is the calibrated confidence. Evidence is exact integer arithmetic.

use crate::dims::{ROWS, Slot};
use crate::dsn::head::{MAX_CLASSES, softmax_confidence};
use crate::dsn::{Classification, Kernels, Model, ModelError, WinogradF2, infer, scratch_bytes};
use crate::math::roundf;
use crate::pipeline::{Buffers, ReceiverError};
use crate::probe::Probe;
use crate::signal::front_end::FrontEnd;
use crate::signal::stft::{NativeStft, Stft};
use heapless::Vec;

/// Most exits.
pub const EXITS: usize = 12;

/// Fraction bits of evidence: 2^16 are one nat.
pub const EVIDENCE_BITS: u32 = 16;

/// Largest weight of a logit step: 8 nat, so that sums stay below 2^31.
pub const MAX_WEIGHT: i32 = 1 << 19;

/// Log-odds of every class up to a constant, in 2^-16 nat.
pub type Evidence = Vec<i32, MAX_CLASSES>;

/// A network and how much its logits and the earlier exits' count.
#[derive(Debug, Clone)]
pub struct Exit<'m, K> {
    /// Network for this exit's number of sensing slots.
    pub model: Model<'m>,
    /// What it is computed by.
    pub kernels: K,
    /// Weight of a logit step of each exit so far, first to own, in 2^-16 nat; |w| <= [`MAX_WEIGHT`].
    pub weights: [i32; EXITS],
}

impl<'m, K> Exit<'m, K> {
    /// The only exit: its network's own softmax.
    pub fn alone(model: Model<'m>, kernels: K) -> Self {
        let mut weights = [0; EXITS];
        if let Some(own) = weights.first_mut() {
            let weight = roundf(model.logit_scale() * (1_i32 << EVIDENCE_BITS) as f32);
            *own = (weight as i32).min(MAX_WEIGHT);
        }
        Exit { model, kernels, weights }
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

/// What an exit says.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Verdict {
    /// Number of the exit, from 0.
    pub exit: u8,
    /// Class with the most evidence.
    pub class: u8,
    /// Its calibrated probability, 0..=1.
    pub confidence: f32,
    /// Whether that is enough, or this is the last exit: no more slots are needed.
    pub stop: bool,
    /// The exit's own network's answer.
    pub answer: Classification,
}

/// Raw slots in, verdicts out.
#[derive(Debug)]
pub struct Anytime<'m, 'b, K = WinogradF2<'b>, T = NativeStft> {
    front_end: FrontEnd<'b, T>,
    scratch: &'b mut [i8],
    exits: Vec<Exit<'m, K>, EXITS>,
    threshold: f32,
    /// Logits of the exits passed.
    passed: Vec<Vec<i8, MAX_CLASSES>, EXITS>,
    stopped: bool,
}

impl<'m, 'b, K: Kernels> Anytime<'m, 'b, K> {
    /// Joins exits, fewest slots first, and memory for the last, by the target's [`NativeStft`]; `threshold` is the confidence
    /// that stops.
    ///
    /// # Errors
    ///
    /// [`ReceiverError::Memory`] as of a receiver of the largest model; [`ReceiverError::Exits`] if there is none or more than
    /// [`EXITS`], they are not ascending, a weight is too large, or they do not agree on preprocessing and classes.
    pub fn new(
        wanted: impl IntoIterator<Item = Exit<'m, K>>,
        threshold: f32,
        buffers: Buffers<'b>,
    ) -> Result<Self, ReceiverError> {
        Self::with_transform(wanted, threshold, buffers)
    }
}

impl<'m, 'b, K: Kernels, T: Stft> Anytime<'m, 'b, K, T> {
    /// [`Anytime::new`] with the transform that `T` names.
    ///
    /// # Errors
    ///
    /// As [`Anytime::new`].
    pub fn with_transform(
        wanted: impl IntoIterator<Item = Exit<'m, K>>,
        threshold: f32,
        buffers: Buffers<'b>,
    ) -> Result<Self, ReceiverError> {
        let mut exits: Vec<Exit<'m, K>, EXITS> = Vec::new();
        for exit in wanted {
            exits.push(exit).map_err(|_| ReceiverError::Exits)?;
        }
        let Some(last) = exits.last() else { return Err(ReceiverError::Exits) };
        let agrees = |a: &Model<'_>, b: &Model<'_>| {
            a.preprocessing() == b.preprocessing() && a.classes() == b.classes()
        };
        let ascending = exits.windows(2).all(|pair| match pair {
            [a, b] => a.model.sensing_slots() < b.model.sensing_slots() && agrees(&a.model, &b.model),
            _ => true,
        });
        let light = |exit: &Exit<'m, K>| exit.weights.iter().all(|w| w.unsigned_abs() <= MAX_WEIGHT as u32);
        if !ascending || !exits.iter().all(light) {
            return Err(ReceiverError::Exits);
        }
        let (slots, cells) = (last.model.sensing_slots(), ROWS * last.model.frames());
        let need = |exit: &Exit<'m, K>| {
            let m = &exit.model;
            scratch_bytes(m.frames(), m.channels(), m.stem_stride())
        };
        let scratch = exits.iter().map(need).max().unwrap_or(0);
        buffers.check(slots, cells, scratch)?;
        let error = ReceiverError::Model(ModelError::Field { name: "preprocessing", value: 0 });
        let front_end = FrontEnd::new(last.model.preprocessing(), buffers.front_end).ok_or(error)?;
        let scratch = buffers.scratch;
        Ok(Anytime { front_end, scratch, exits, threshold, passed: Vec::new(), stopped: false })
    }

    /// The exits.
    pub fn exits(&self) -> &[Exit<'m, K>] {
        &self.exits
    }

    /// Whether a verdict has stopped this recording.
    pub fn stopped(&self) -> bool {
        self.stopped
    }

    /// Stops from the next verdict on at this confidence; above 1 never before the last exit.
    pub fn set_threshold(&mut self, threshold: f32) {
        self.threshold = threshold;
    }

    /// Takes one slot. Answers at the exits; after a verdict that stops, slots are not used until [`Anytime::reset`].
    pub fn push(&mut self, slot: &Slot, probe: &mut impl Probe) -> Option<Verdict> {
        if self.stopped || !self.front_end.push(slot, probe) {
            return None;
        }
        let number = self.passed.len();
        let last = number + 1 >= self.exits.len();
        let exit = self.exits.get_mut(number)?;
        if self.front_end.taken() < exit.model.sensing_slots() {
            return None;
        }
        let image = self.front_end.image(probe)?;
        let answer = infer(&exit.model, image, self.scratch, &mut exit.kernels, probe);
        let _ = self.passed.push(answer.logits.clone()); // as many as there are exits
        let mut evidence = Evidence::new();
        let _ = evidence.resize(answer.logits.len(), 0); // at most MAX_CLASSES: the parser has checked
        for (logits, &weight) in self.passed.iter().zip(&exit.weights) {
            add_evidence(&mut evidence, logits, weight);
        }
        let (class, confidence) = decide(&evidence);
        self.stopped = last || confidence >= self.threshold;
        Some(Verdict { exit: number as u8, class, confidence, stop: self.stopped, answer })
    }

    /// Forgets the recording.
    pub fn reset(&mut self) {
        self.front_end.reset();
        self.passed.clear();
        self.stopped = false;
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;

    #[test]
    fn one_weight_is_a_temperature() {
        // logits 0.1 nat a step at temperature 2: 0.05 nat a step
        let weight = (0.05 * 65536.0) as i32;
        let mut evidence = [0; 3];
        add_evidence(&mut evidence, &[40, -10, 20], weight);
        let (class, confidence) = decide(&evidence);
        let exact = 1.0 / (1.0 + libm::exp(-2.5) + libm::exp(-1.0));
        assert_eq!(class, 0);
        assert!((f64::from(confidence) / exact - 1.0).abs() < 6e-3, "{confidence} {exact}");
        add_evidence(&mut evidence, &[-40, 10, 120], weight);
        assert_eq!(decide(&evidence).0, 2);
        assert_eq!(decide(&[5, 5]), (0, 0.5));
        assert_eq!(decide(&[i32::MAX, i32::MIN]), (0, 1.0));
    }
}
