//! Balanced accuracy over recordings, with a bootstrap interval.
//!
//! Windows of one recording resemble each other, so recordings are redrawn as wholes, within their class, then windows within each, and
//! the networks for all of them (Davison and Hinkley, 1997, section 3.8). Where a class has one recording, the interval covers its windows
//! alone.

use crate::numerics::random::Random;
use crate::results::Estimate;
use rayon::prelude::*;
use std::collections::BTreeSet;

/// Redrawn sets of answers.
pub const DRAWS: u32 = 2000;

/// Share of them within an interval.
pub const COVERAGE: f64 = 0.95;

/// Stream number of what is redrawn.
const STREAM: u64 = 206;

/// Predictions for the windows of a recording.
#[derive(Debug, Clone)]
pub struct Predictions {
    /// Its class.
    pub label: u8,
    /// `[network][window]`.
    pub each: Vec<Vec<u8>>,
}

impl Predictions {
    fn correct(&self, network: usize, window: usize) -> f64 {
        f64::from(u8::from(self.each[network][window] == self.label))
    }

    fn windows(&self) -> usize {
        self.each.first().map_or(0, Vec::len)
    }

    /// Share of its windows that is recognised, mean of the networks.
    pub fn share(&self) -> f64 {
        let all: f64 = (0..self.each.len())
            .map(|network| (0..self.windows()).map(|window| self.correct(network, window)).sum::<f64>())
            .sum();
        all / (self.each.len() * self.windows()).max(1) as f64
    }
}

/// Mean over the classes present of the share of their windows that is recognised. `pick(n, count)` is the index drawn in place of n.
fn balanced(recordings: &[Predictions], mut pick: impl FnMut(usize, usize) -> usize) -> f64 {
    let networks = recordings.first().map_or(0, |r| r.each.len());
    let chosen: Vec<usize> = (0..networks).map(|n| pick(n, networks)).collect();
    let (mut sum, mut classes) = (0.0, 0.0);
    let labels: BTreeSet<u8> = recordings.iter().map(|r| r.label).collect();
    for label in labels {
        let of: Vec<&Predictions> =
            recordings.iter().filter(|r| r.label == label && r.windows() > 0).collect();
        let (mut correct, mut all) = (0.0, 0.0);
        for n in 0..of.len() {
            let recording = of[pick(n, of.len())];
            for window in 0..recording.windows() {
                let window = pick(window, recording.windows());
                correct += chosen.iter().map(|&network| recording.correct(network, window)).sum::<f64>();
                all += networks as f64;
            }
        }
        if all > 0.0 {
            sum += correct / all;
            classes += 1.0;
        }
    }
    sum / f64::max(classes, 1.0)
}

/// Balanced accuracy, mean of the networks, with its 95 % interval.
pub fn balanced_accuracy(recordings: &[Predictions], seed: u64) -> Estimate {
    let mut drawn: Vec<f64> = (0..DRAWS)
        .into_par_iter()
        .map(|draw| {
            let mut random = Random::new(seed, STREAM, 0, u64::from(draw));
            balanced(recordings, |_, count| (random.uniform() * count as f64) as usize)
        })
        .collect();
    drawn.sort_by(f64::total_cmp);
    let outside = (0.5 * (1.0 - COVERAGE) * f64::from(DRAWS)) as usize;
    Estimate {
        mean: balanced(recordings, |n, _| n),
        low: drawn[outside],
        high: drawn[drawn.len() - 1 - outside],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn predictions(label: u8, each: &[&[u8]]) -> Predictions {
        Predictions { label, each: each.iter().map(|of| of.to_vec()).collect() }
    }

    #[test]
    fn classes_count_alike_and_windows_within_them() {
        let recordings = [
            predictions(0, &[&[0, 0, 0, 0, 0, 1], &[0; 6]]),
            predictions(0, &[&[1, 1], &[0, 0]]),
            predictions(1, &[&[1, 0], &[1, 1]]),
        ];
        let found = balanced_accuracy(&recordings, 1);
        // 13 of 16 and 3 of 4
        assert!((found.mean - 0.5 * (13.0 / 16.0 + 0.75)).abs() < 1e-12);
        assert!(0.0 <= found.low && found.low < found.mean && found.mean < found.high && found.high <= 1.0);
        assert_eq!(recordings[0].share(), 11.0 / 12.0);
    }

    #[test]
    fn one_class_for_all_scores_one_over_the_classes() {
        let recordings =
            [predictions(0, &[&[0; 30]]), predictions(1, &[&[0; 7]]), predictions(2, &[&[0; 7]])];
        let found = balanced_accuracy(&recordings, 1);
        assert_eq!((found.mean, found.low, found.high), (1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0));
    }

    #[test]
    fn recordings_as_wholes_widen_the_interval() {
        // ten recordings, each wholly recognised or not, against as many seconds of two recordings
        let whole: Vec<Predictions> =
            (0..10).map(|n| predictions(0, &[&[u8::from(n % 5 == 0); 20]])).collect();
        let width = |found: Estimate| found.high - found.low;
        let mixed: Vec<u8> = (0..20).map(|n| u8::from(n % 5 == 0)).collect();
        let seconds: Vec<Predictions> = (0..10).map(|_| predictions(0, &[&mixed])).collect();
        assert!(width(balanced_accuracy(&whole, 1)) > 2.0 * width(balanced_accuracy(&seconds, 1)));
    }
}
