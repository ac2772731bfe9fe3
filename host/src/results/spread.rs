//! What several seeds say of one number.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Mean and sample standard deviation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Spread {
    /// Mean.
    pub mean: f64,
    /// Standard deviation over the seeds, 0 for one.
    pub deviation: f64,
    /// How many seeds.
    pub seeds: u32,
}

impl Spread {
    /// Of some values.
    pub fn of(values: &[f64]) -> Self {
        let n = values.len().max(1) as f64;
        let mean = values.iter().sum::<f64>() / n;
        let squares: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
        let deviation = if values.len() > 1 { (squares / (n - 1.0)).sqrt() } else { 0.0 };
        Spread { mean, deviation, seeds: values.len() as u32 }
    }

    /// Standard error of the mean; none of a single seed, or where all agree.
    pub fn standard_error(&self) -> Option<f64> {
        (self.deviation > 0.0).then(|| self.deviation / f64::from(self.seeds).sqrt())
    }
}

impl std::fmt::Display for Spread {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self.seeds {
            1 => write!(f, "{:.3}", self.mean),
            _ => write!(f, "{:.3} ± {:.3}", self.mean, self.deviation),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spread_is_that_of_a_sample() {
        let spread = Spread::of(&[1.0, 2.0, 3.0, 4.0]);
        assert!((spread.mean - 2.5).abs() < 1e-12 && (spread.deviation - 1.290_994).abs() < 1e-6);
        assert_eq!(Spread::of(&[0.7, 0.7]).to_string(), "0.700 ± 0.000");
        assert_eq!(Spread::of(&[0.7]).to_string(), "0.700");
    }
}
