//! The difference of two accuracies on the same recordings, with a bootstrap interval.
//!
//! Two levels (Davison and Hinkley, 1997, section 3.8): seeds are drawn again, and in each of them its test recordings, every recording
//! with both of its answers. The interval is that of the percentiles. With one seed it says nothing of what other trainings would
//! give; with few seeds it is narrow.

pub use crate::network::score::{COVERAGE, DRAWS};

use crate::numerics::random::Random;
use crate::results::Spread;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Stream number of the redrawn seeds and recordings.
const STREAM: u64 = 205;

/// Which test recordings were recognised, `[seed][recording]`.
pub type Marks = [Vec<bool>];

/// A difference of shares and its interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Difference {
    /// Mean over the seeds.
    pub mean: f64,
    /// Lower end of the 95 % interval.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// In points, with as many decimals as asked for, or one.
impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let decimals = f.precision().unwrap_or(1);
        let [mean, low, high] = [self.mean, self.low, self.high].map(|share| 100.0 * share);
        write!(f, "{mean:+.decimals$} [{low:+.decimals$}, {high:+.decimals$}]")
    }
}

/// Every recording's difference in a seed.
struct Seed(Vec<f64>);

impl Seed {
    fn of((first, second): (&Vec<f64>, &Vec<f64>)) -> Self {
        Seed(first.iter().zip(second).map(|(first, second)| first - second).collect())
    }

    fn difference(&self) -> f64 {
        self.0.iter().sum::<f64>() / self.0.len().max(1) as f64
    }

    /// The difference of as many recordings, each drawn from all of them.
    fn redrawn(&self, random: &mut Random) -> f64 {
        let n = self.0.len() as f64;
        let drawn = self.0.iter().map(|_| self.0[(n * random.uniform()) as usize]);
        drawn.sum::<f64>() / n.max(1.0)
    }
}

/// The accuracy over the seeds.
pub fn spread(marks: &Marks) -> Spread {
    let share =
        |marks: &Vec<bool>| marks.iter().filter(|mark| **mark).count() as f64 / marks.len().max(1) as f64;
    Spread::of(&marks.iter().map(share).collect::<Vec<_>>())
}

/// The accuracy of `first` less that of `second`, on the same recordings of the same seeds.
pub fn difference(first: &Marks, second: &Marks, seed: u64) -> Difference {
    let scores = |marks: &Marks| -> Vec<Vec<f64>> {
        marks.iter().map(|marks| marks.iter().map(|&mark| f64::from(u8::from(mark))).collect()).collect()
    };
    mean_difference(&scores(first), &scores(second), seed)
}

/// The mean score of `first` less that of `second`, `[seed][recording]`, on the same recordings of the same seeds.
pub fn mean_difference(first: &[Vec<f64>], second: &[Vec<f64>], seed: u64) -> Difference {
    let seeds: Vec<Seed> = first.iter().zip(second).map(Seed::of).collect();
    let count = seeds.len().max(1);
    let mean = seeds.iter().map(Seed::difference).sum::<f64>() / count as f64;
    let redraw = |draw: u32| {
        let mut random = Random::new(seed, STREAM, 0, u64::from(draw));
        let mut sum = 0.0;
        for _ in 0..seeds.len() {
            let chosen = (random.uniform() * count as f64) as usize;
            sum += seeds[chosen].redrawn(&mut random);
        }
        sum / count as f64
    };
    let mut drawn: Vec<f64> = (0..DRAWS).into_par_iter().map(redraw).collect();
    drawn.sort_by(f64::total_cmp);
    let outside = (0.5 * (1.0 - COVERAGE) * f64::from(DRAWS)) as usize;
    Difference { mean, low: drawn[outside], high: drawn[drawn.len() - 1 - outside] }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Recordings of which the first, and the second, recognises given shares; what the worse one recognises the better one does too.
    fn answers(seeds: u64, recordings: u32, shares: [f64; 2], number: u64) -> [Vec<Vec<bool>>; 2] {
        let mut found = [Vec::new(), Vec::new()];
        for seed in 0..seeds {
            let mut random = Random::new(number, 1, 2, seed);
            let hard: Vec<f64> = (0..recordings).map(|_| random.uniform()).collect();
            for (marks, share) in found.iter_mut().zip(shares) {
                marks.push(hard.iter().map(|hard| *hard < share).collect());
            }
        }
        found
    }

    #[test]
    fn equal_answers_differ_by_nothing() {
        let [first, _] = answers(3, 100, [0.8, 0.8], 1);
        assert_eq!(difference(&first, &first, 1), Difference { mean: 0.0, low: 0.0, high: 0.0 });
    }

    #[test]
    fn pairs_make_the_interval_narrow_and_it_holds_the_difference() {
        let [first, second] = answers(4, 500, [0.85, 0.80], 7);
        let found = difference(&first, &second, 1);
        assert!((found.mean - 0.05).abs() < 0.02, "{found:?}");
        assert!(found.low < found.mean && found.mean < found.high && found.low > 0.0, "{found:?}");
        // unpaired, 2000 recordings of 0.8 and 0.85 differ by 0.012, one standard deviation; paired by 0.005
        assert!(found.high - found.low < 0.03, "{found:?}");
        assert_eq!(found, difference(&first, &second, 1));
        let turned = difference(&second, &first, 1);
        assert!((turned.mean + found.mean).abs() < 1e-12);
    }

    #[test]
    fn the_interval_covers_the_truth_as_often_as_it_says() {
        let covered = (0..100).filter(|&number| {
            let [first, second] = answers(6, 200, [0.85, 0.80], 100 + number);
            let found = difference(&first, &second, number);
            (found.low..=found.high).contains(&0.05)
        });
        // seeds do not differ here but for their recordings, which both levels count: the interval is wide rather than narrow
        let covered = covered.count();
        assert!(covered >= 90, "{covered} of 100");
    }
}
