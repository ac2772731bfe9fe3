//! The effect of a threshold: accuracy, sensing slots, and where recordings stop.

use crate::network::evaluation::ExitLogits;
use crate::results::{EarlyExitPoint, FittedExit};
use sdp3_core::early_exit::{add_evidence, decide};

/// Exits and the weights of their logits.
#[derive(Debug, Clone, PartialEq)]
pub struct Policy {
    pub exits: Vec<FittedExit>,
}

/// Class and confidence of one recording at every exit.
pub type ExitClasses = Vec<(u8, f32)>;

impl Policy {
    /// Of weights fitted to logits of the exits.
    pub fn new(slots: &[u32], weights: Vec<Vec<i32>>) -> Self {
        let exits = slots.iter().zip(weights);
        let exits = exits.map(|(&sensing_slots, weights)| FittedExit { sensing_slots, weights });
        Policy { exits: exits.collect() }
    }

    /// Class and confidence of every exit for every recording.
    pub fn exit_classes(&self, exit_logits: &ExitLogits) -> Vec<ExitClasses> {
        let classify = |logits: &Vec<Vec<i8>>, exit: usize| {
            let mut evidence = vec![0; logits[exit].len()];
            for (logits, &weight) in logits.iter().zip(&self.exits[exit].weights) {
                add_evidence(&mut evidence, logits, weight);
            }
            decide(&evidence)
        };
        let of_exits = |logits| (0..self.exits.len()).map(|exit| classify(logits, exit)).collect();
        exit_logits.logits.iter().map(of_exits).collect()
    }

    /// Accuracy and sensing slots of stopping at `threshold`, at `last` at the latest.
    pub fn evaluate(
        &self,
        exit_classes: &[ExitClasses],
        truth: &[u8],
        threshold: f64,
        last: usize,
    ) -> EarlyExitPoint {
        let mut stops = vec![0_u32; last + 1];
        let (mut correct, mut slots, mut confidence) = (0_u32, 0.0, 0.0);
        for (of_exits, &truth) in exit_classes.iter().zip(truth) {
            let stop = (0..last).find(|&exit| of_exits[exit].1 >= threshold as f32).unwrap_or(last);
            stops[stop] += 1;
            correct += u32::from(of_exits[stop].0 == truth);
            slots += f64::from(self.exits[stop].sensing_slots);
            confidence += f64::from(of_exits[stop].1);
        }
        let n = truth.len().max(1) as f64;
        EarlyExitPoint {
            threshold,
            most_sensing_slots: self.exits[last].sensing_slots,
            accuracy: f64::from(correct) / n,
            confidence: confidence / n,
            sensing_slots: slots / n,
            stops,
        }
    }

    /// Thresholds worth trying, ascending: from 0.25 to 1 - 3e-4, ever closer to 1; the last never stops early.
    pub fn thresholds() -> Vec<f64> {
        let mut all: Vec<f64> = (0..100).map(|k| 1.0 - 0.75 * libm::pow(0.925, f64::from(k))).collect();
        all.push(2.0);
        all
    }

    /// The point of fewest slots on `exit_classes` that is at least as right as `accuracy`; threshold and last exit vary.
    pub fn cheapest(
        &self,
        exit_classes: &[ExitClasses],
        truth: &[u8],
        accuracy: f64,
    ) -> Option<(f64, usize)> {
        let mut best: Option<(f64, f64, usize)> = None;
        for last in 0..self.exits.len() {
            for threshold in Self::thresholds() {
                let point = self.evaluate(exit_classes, truth, threshold, last);
                let better = best.is_none_or(|(slots, ..)| point.sensing_slots < slots);
                if point.accuracy >= accuracy && better {
                    best = Some((point.sensing_slots, threshold, last));
                }
            }
        }
        best.map(|(_, threshold, last)| (threshold, last))
    }
}
