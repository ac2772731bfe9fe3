//! The effect of a threshold: accuracy, sensing slots, and where recordings stop.

use crate::network::evaluation::ExitLogits;
use crate::results::{EarlyExitPoint, FittedExit};
use sdp3_core::early_exit::{add_evidence, decide};

/// Exits and their weights of evidence.
#[derive(Debug, Clone, PartialEq)]
pub struct Policy {
    pub exits: Vec<FittedExit>,
}

/// What one recording's exits say: class and confidence of each.
pub type Course = Vec<(u8, f32)>;

impl Policy {
    /// Of weights fitted to logits of the exits.
    pub fn new(slots: &[u32], weights: Vec<Vec<i32>>) -> Self {
        let exits = slots.iter().zip(weights);
        let exits = exits.map(|(&sensing_slots, weights)| FittedExit { sensing_slots, weights });
        Policy { exits: exits.collect() }
    }

    /// Verdicts of every exit for every recording.
    pub fn courses(&self, exit_logits: &ExitLogits) -> Vec<Course> {
        let verdict = |logits: &Vec<Vec<i8>>, exit: usize| {
            let mut evidence = vec![0; logits[exit].len()];
            for (logits, &weight) in logits.iter().zip(&self.exits[exit].weights) {
                add_evidence(&mut evidence, logits, weight);
            }
            decide(&evidence)
        };
        let course = |logits| (0..self.exits.len()).map(|exit| verdict(logits, exit)).collect();
        exit_logits.logits.iter().map(course).collect()
    }

    /// Stops at `threshold`, at `last` at the latest.
    pub fn play(&self, courses: &[Course], truth: &[u8], threshold: f64, last: usize) -> EarlyExitPoint {
        let mut stops = vec![0_u32; last + 1];
        let (mut right, mut slots, mut confidence) = (0_u32, 0.0, 0.0);
        for (course, &truth) in courses.iter().zip(truth) {
            let stop = (0..last).find(|&exit| course[exit].1 >= threshold as f32).unwrap_or(last);
            stops[stop] += 1;
            right += u32::from(course[stop].0 == truth);
            slots += f64::from(self.exits[stop].sensing_slots);
            confidence += f64::from(course[stop].1);
        }
        let n = truth.len().max(1) as f64;
        EarlyExitPoint {
            threshold,
            most_sensing_slots: self.exits[last].sensing_slots,
            accuracy: f64::from(right) / n,
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

    /// The point of fewest slots on `courses` that is at least as right as `accuracy`; threshold and last exit vary.
    pub fn cheapest(&self, courses: &[Course], truth: &[u8], accuracy: f64) -> Option<(f64, usize)> {
        let mut best: Option<(f64, f64, usize)> = None;
        for last in 0..self.exits.len() {
            for threshold in Self::thresholds() {
                let point = self.play(courses, truth, threshold, last);
                let better = best.is_none_or(|(slots, ..)| point.sensing_slots < slots);
                if point.accuracy >= accuracy && better {
                    best = Some((point.sensing_slots, threshold, last));
                }
            }
        }
        best.map(|(_, threshold, last)| (threshold, last))
    }
}
