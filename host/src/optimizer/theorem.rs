//! Theorem 1: the boundary in closed form, and the weighted sum's optimum on it, over real numbers of slots.
//!
//! T_s Theta^-1(A) + [sum over users of T_s / r_k] R = N T_s, r_k being user k's bits in one slot: R falls linearly in
//! N_s. Theta need not be concave; the weighted sum is maximised over every interval between zeros of its derivative.

use crate::numerics::bisection::bisect;
use crate::predictor::{evaluate, slope};
use crate::results::Curve;

/// What Theorem 1 needs: N and the users' bits per slot.
#[derive(Debug, Clone)]
pub struct Theorem {
    period: f64,
    /// Slots that one bit for every user takes: sum of 1 / r_k.
    slots_per_bit: f64,
}

/// A point on the continuous boundary.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Optimum {
    /// N_s, a real number.
    pub sensing_slots: f64,
    /// Accuracy.
    pub accuracy: f64,
    /// Worst throughput in bits per period.
    pub throughput_bit: f64,
}

impl Theorem {
    /// For a period of N slots and bits per slot, all positive.
    pub fn new(period: u32, slot_bits: &[f64]) -> Self {
        Theorem { period: f64::from(period), slots_per_bit: slot_bits.iter().map(|r| 1.0 / r).sum() }
    }

    /// R at N_s, bits per period.
    pub fn throughput_bit(&self, sensing_slots: f64) -> f64 {
        (self.period - sensing_slots).max(0.0) / self.slots_per_bit
    }

    /// N_s that leaves R, may be negative.
    pub fn sensing_slots(&self, throughput_bit: f64) -> f64 {
        self.period - throughput_bit * self.slots_per_bit
    }

    /// The maximum of `accuracy_weight` A + `throughput_weight` R over `range` of N_s.
    pub fn weighted(&self, curve: &Curve, weights: (f64, f64), range: (f64, f64)) -> Optimum {
        const STEPS: u32 = 512;
        let at = |n: f64| evaluate(curve, n).unwrap_or(0.0);
        let value = |n: f64| weights.0 * at(n) + weights.1 * self.throughput_bit(n);
        let rise = |n: f64| weights.0 * slope(curve, n).unwrap_or(0.0) - weights.1 / self.slots_per_bit;
        let node = |step: u32| range.0 + (range.1 - range.0) * f64::from(step) / f64::from(STEPS);
        let mut best = range.0;
        for step in 0..STEPS {
            let (mut low, mut high) = (node(step), node(step + 1));
            if rise(low) > 0.0 && rise(high) < 0.0 {
                (low, high) = bisect(low, high, |n| rise(n) > 0.0);
            }
            for candidate in [low, high] {
                if value(candidate) > value(best) {
                    best = candidate;
                }
            }
        }
        Optimum { sensing_slots: best, accuracy: at(best), throughput_bit: self.throughput_bit(best) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::Parameters;

    #[test]
    fn the_weighted_optimum_has_the_slope_of_its_weights() {
        let parameters = Parameters { alpha: 61906.0, beta: 2.4297, gamma: Some(0.9499), epsilon: None };
        let curve = Curve { model: "pow3".into(), parameters, rmse: 0.0 };
        let theorem = Theorem::new(4000, &[1500.0, 2500.0, 3000.0]);
        let found = theorem.weighted(&curve, (1.0, 1e-6), (128.0, 1000.0));
        // alpha beta n^(-beta - 1) = w_R / sum 1/r
        let expected = libm::pow(61906.0 * 2.4297 * theorem.slots_per_bit / 1e-6, 1.0 / 3.4297);
        assert!((found.sensing_slots / expected - 1.0).abs() < 1e-9, "{found:?} {expected}");
        assert!((theorem.sensing_slots(found.throughput_bit) - found.sensing_slots).abs() < 1e-9);
        assert_eq!(theorem.weighted(&curve, (1.0, 0.0), (128.0, 1000.0)).sensing_slots, 1000.0);
        assert_eq!(theorem.weighted(&curve, (0.0, 1.0), (128.0, 1000.0)).sensing_slots, 128.0);
    }
}
