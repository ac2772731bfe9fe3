//! Studies: questions that take many trainings. Each is cut into cells that are kept, so that an interrupted study goes on where
//! it was; each writes its resolved configuration, a table, a picture and a page.
//!
//! [`learning_curve`] (Table III of the paper and its figure), [`robustness`] (what the room and the person may do), [`fidelity`]
//! (how near simulated recordings are to others, [`sim_to_real`] to measured ones), [`baselines`] (other ways to recognise).

pub mod baselines;
pub mod cells;
pub mod fidelity;
pub mod learning_curve;
pub mod recordings;
pub mod robustness;
pub mod sim_to_real;
pub mod trained;

use crate::progress::Progress;
use crate::scenario::Scenario;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What a study is made of.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Request {
    /// Which study.
    pub study: String,
    /// First seed.
    pub seed: u64,
    /// How many seeds, one after the other.
    pub seeds: u32,
    /// The resolved scenario.
    pub scenario: Scenario,
}

impl Request {
    /// The seeds.
    pub fn each_seed(&self) -> impl Iterator<Item = u64> + use<> {
        let first = self.seed;
        (0..u64::from(self.seeds)).map(move |n| first + n)
    }
}

/// How a study's work is done; nothing of it changes a result.
#[derive(Debug, Clone, Copy)]
pub struct Workshop {
    /// How to show progress.
    pub progress: Progress,
    /// Threads.
    pub workers: usize,
}

/// Mean and sample standard deviation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Spread {
    /// Mean.
    pub mean: f64,
    /// Standard deviation over the seeds, 0 for one.
    pub deviation: f64,
}

impl Spread {
    /// Of some values.
    pub fn of(values: &[f64]) -> Self {
        let n = values.len().max(1) as f64;
        let mean = values.iter().sum::<f64>() / n;
        let squares: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
        Spread { mean, deviation: if values.len() > 1 { (squares / (n - 1.0)).sqrt() } else { 0.0 } }
    }
}

impl std::fmt::Display for Spread {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "{:.3} ± {:.3}", self.mean, self.deviation)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spread_is_that_of_a_sample() {
        let spread = Spread::of(&[1.0, 2.0, 3.0, 4.0]);
        assert!((spread.mean - 2.5).abs() < 1e-12 && (spread.deviation - 1.290_994).abs() < 1e-6);
        assert_eq!(Spread::of(&[0.7]).to_string(), "0.700 ± 0.000");
    }
}
