//! Random fields over the room: Gaussian, of unit variance, with exponential correlation exp(-d / D).
//!
//! A sum of plane waves with wave numbers from the spectrum of that correlation in two dimensions,
//! F(k) = 1 - 1 / sqrt(1 + (D k)^2) (as QuaDRiGa's sum of sinusoids does).

use crate::numerics::random::Random;
use crate::simulator::body::Vec3;
use std::f64::consts::TAU;

/// Plane waves of a field.
const WAVES: usize = 40;

#[derive(Debug, Clone)]
pub struct Field {
    /// Wave vector in rad/m and phase in rad.
    waves: Vec<([f64; 2], f64)>,
}

impl Field {
    /// A field with correlation distance `correlation_m`.
    pub fn new(correlation_m: f64, random: &mut Random) -> Self {
        let wave = |_| {
            let below = (1.0 - random.uniform()).max(1e-3);
            let k = (1.0 / (below * below) - 1.0).sqrt() / correlation_m;
            let angle = TAU * random.uniform();
            ([k * libm::cos(angle), k * libm::sin(angle)], TAU * random.uniform())
        };
        Field { waves: (0..WAVES).map(wave).collect() }
    }

    /// Its value at a point.
    pub fn at(&self, p: Vec3) -> f64 {
        let sum: f64 = self.waves.iter().map(|(k, phase)| libm::cos(k[0] * p[0] + k[1] * p[1] + phase)).sum();
        sum * (2.0 / WAVES as f64).sqrt()
    }

    /// Its value turned into a uniform one, strictly within 0..1.
    pub fn uniform_at(&self, p: Vec3) -> f64 {
        (0.5 * libm::erfc(-self.at(p) * std::f64::consts::FRAC_1_SQRT_2)).clamp(1e-9, 1.0 - 1e-9)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variance_is_one_and_correlation_exponential() {
        let distances = [0.0, 0.5, 2.0, 5.0, 10.0];
        let mut sums = [0.0; 5];
        let n = 20_000;
        for index in 0..n {
            let field = Field::new(5.0, &mut Random::new(8, 0, 0, index));
            let here = field.at([0.0; 3]);
            for (sum, d) in sums.iter_mut().zip(distances) {
                *sum += here * field.at([d * 0.6, d * 0.8, 0.0]) / n as f64;
            }
        }
        for (sum, d) in sums.iter().zip(distances) {
            assert!((sum - libm::exp(-d / 5.0)).abs() < 0.03, "{d}: {sum}");
        }
    }
}
