//! The accuracy-throughput boundary: for every N_s the largest worst throughput.
//!
//! Theorem 1 of the paper, and beside its closed form the exact integer optimum over N_c,k with N_s (N_m + 1) <= N.

use super::OptimizerError;
use crate::predictor::learning_curve::evaluate;
use crate::results::Curve;
use crate::scenario::Scenario;
use sdp3_core::schedule::apportion;

/// A point of the boundary before its zone is known.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// N_s.
    pub sensing_slots: u32,
    /// N_c,k.
    pub shares: Vec<u32>,
    /// Predicted accuracy.
    pub accuracy: f64,
    /// Worst receiver's bits per period.
    pub throughput_bit: f64,
}

/// Steps of the grid over N_s.
const STEPS: u32 = 96;

/// R of Theorem 1: (N - N_s) / sum over receivers of 1 / r_k, in bits per period.
pub fn closed_form(period: u32, sensing: u32, slot_bits: &[f64]) -> f64 {
    let inverse: f64 = slot_bits.iter().map(|r| 1.0 / r).sum();
    f64::from(period.saturating_sub(sensing)) / inverse
}

/// One point: the exact integer division of what sensing leaves.
pub fn point(scenario: &Scenario, curve: &Curve, slot_bits: &[f64], sensing: u32) -> Point {
    // rates in units that fill 31 bits: ratios to 1e-9
    let most = slot_bits.iter().copied().fold(0.0, f64::max);
    let rates: Vec<u32> =
        slot_bits.iter().map(|r| ((r / most * f64::from(i32::MAX)).round() as u32).max(1)).collect();
    let mut shares = vec![0; rates.len()];
    apportion(&rates, scenario.frame.period_slots - sensing, &mut shares);
    let worst = shares.iter().zip(slot_bits).map(|(&n, r)| f64::from(n) * r).fold(f64::INFINITY, f64::min);
    let accuracy = evaluate(curve, f64::from(sensing)).unwrap_or(0.0);
    Point { sensing_slots: sensing, shares, accuracy, throughput_bit: worst }
}

/// The boundary over a grid of N_s from one window to the most that fit, the studied ones included.
///
/// # Errors
///
/// [`OptimizerError::Period`] if not even one window fits; [`OptimizerError::Curve`] if the curve's model is unknown.
pub fn boundary(scenario: &Scenario, curve: &Curve, slot_bits: &[f64]) -> Result<Vec<Point>, OptimizerError> {
    let f = &scenario.frame;
    let window = u32::from(scenario.spectrogram.window);
    let most = f.period_slots / (f.spacing_slots + 1);
    if most < window {
        return Err(OptimizerError::Period { period: f.period_slots, least: window * (f.spacing_slots + 1) });
    }
    if evaluate(curve, f64::from(most)).is_none() {
        return Err(OptimizerError::Curve { model: curve.model.clone() });
    }
    let mut grid: Vec<u32> = (0..=STEPS).map(|s| window + (most - window) * s / STEPS).collect();
    grid.extend(f.sensing_slots.iter().copied().filter(|n| (window..=most).contains(n)));
    grid.sort_unstable();
    grid.dedup();
    Ok(grid.into_iter().map(|n| point(scenario, curve, slot_bits, n)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::Parameters;
    use crate::simulator::random::Random;

    fn curve() -> Curve {
        let parameters = Parameters { alpha: 61906.0, beta: 2.4297, gamma: Some(0.9499), epsilon: None };
        Curve { model: "pow3".into(), parameters, rmse: 0.0 }
    }

    #[test]
    fn integers_lose_less_than_a_slot_against_the_closed_form() {
        let mut random = Random::new(4, 0, 0, 0);
        let scenario = Scenario::default();
        for _ in 0..200 {
            let bits: Vec<f64> = (0..3).map(|_| 500.0 + 3000.0 * random.uniform()).collect();
            for p in boundary(&scenario, &curve(), &bits).unwrap() {
                let exact = closed_form(4000, p.sensing_slots, &bits);
                assert!(p.throughput_bit <= exact * (1.0 + 1e-9));
                assert!(p.throughput_bit >= exact * (1.0 - 2e-3), "{} {exact}", p.throughput_bit);
                assert_eq!(p.shares.iter().sum::<u32>() + p.sensing_slots, 4000);
            }
        }
    }

    #[test]
    fn a_period_without_a_window_is_refused() {
        let mut scenario = Scenario::default();
        scenario.frame.period_slots = 400;
        assert!(matches!(boundary(&scenario, &curve(), &[1.0]), Err(OptimizerError::Period { .. })));
    }
}
