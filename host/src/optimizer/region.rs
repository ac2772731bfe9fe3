//! The accuracy-throughput boundary in whole slots: for every N_s the largest worst throughput.
//!
//! Problem P of the paper over integers: N_s + sum N_c,k = N and N_s (N_m + 1) <= N. For a given N_s the shares that maximise the
//! worst throughput are known exactly ([`divide`]), so going through every N_s is exact too. The integer R lies below Theorem 1's
//! by at most the share (K - 1) / (N - N_s).

use super::OptimizerError;
use super::shares::divide;
use crate::error::Invalid;
use crate::predictor::evaluate;
use crate::results::Curve;
use crate::scenario::Scenario;

/// A point of the boundary before its zone is known.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// N_s.
    pub sensing_slots: u32,
    /// N_c,k.
    pub shares: Vec<u32>,
    /// Predicted accuracy.
    pub accuracy: f64,
    /// Worst user's bits per period.
    pub throughput_bit: f64,
}

/// Steps of the grid that stands for the boundary in results and pictures.
const STEPS: u32 = 96;

/// One point: the exact integer division of what sensing leaves.
pub fn point(period: u32, curve: &Curve, slot_bits: &[f64], sensing: u32) -> Point {
    let (shares, worst) = divide(slot_bits, period - sensing);
    let accuracy = evaluate(curve, f64::from(sensing)).unwrap_or(0.0);
    Point { sensing_slots: sensing, shares, accuracy, throughput_bit: worst }
}

/// Least and largest N_s: a recording of four windows, and the most that fit the period at the spacing `spacing` (N_m).
///
/// # Errors
///
/// [`OptimizerError::Invalid`] if not even the shortest recording fits.
pub fn range(scenario: &Scenario, spacing: u32) -> Result<(u32, u32), OptimizerError> {
    let period = scenario.frame.period_slots;
    let least = scenario.least_sensing_slots();
    let most = period / (spacing + 1);
    let legal = format!("at least {}, four STFT windows of sensing slots", least * (spacing + 1));
    Invalid::unless(most >= least, "frame.period_slots", period, legal)?;
    Ok((least, most))
}

/// The boundary at every N_s, ascending.
///
/// # Errors
///
/// [`OptimizerError::Invalid`] if not even the shortest recording fits, or the curve's model is unknown.
pub fn boundary(scenario: &Scenario, curve: &Curve, slot_bits: &[f64]) -> Result<Vec<Point>, OptimizerError> {
    let f = &scenario.frame;
    let (least, most) = range(scenario, f.spacing_slots)?;
    if evaluate(curve, f64::from(most)).is_none() {
        return Err(Invalid::new(
            "curve.model",
            format!("{:?}", curve.model),
            "one of the seven learning curves",
        )
        .into());
    }
    Ok((least..=most).map(|n| point(f.period_slots, curve, slot_bits, n)).collect())
}

/// Whether a boundary's point is worth showing: on a grid, or an N_s that was studied.
pub fn shown(scenario: &Scenario, (least, most): (u32, u32), sensing_slots: u32) -> bool {
    let on_grid = (0..=STEPS).any(|s| least + (most - least) * s / STEPS == sensing_slots);
    on_grid || scenario.frame.sensing_slots.contains(&sensing_slots)
}

/// Points that no other dominates: none is as good in both and better in one. Whole slots make some points lose both.
/// M log M in the number of points.
pub fn pareto(points: &[Point]) -> Vec<bool> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|&a, &b| points[b].accuracy.total_cmp(&points[a].accuracy));
    let mut front = vec![false; points.len()];
    // the largest throughput of all points of more accuracy
    let mut most = f64::NEG_INFINITY;
    for equals in order.chunk_by(|&a, &b| points[a].accuracy == points[b].accuracy) {
        let own = equals.iter().map(|&k| points[k].throughput_bit).fold(f64::NEG_INFINITY, f64::max);
        for &k in equals {
            front[k] = points[k].throughput_bit == own && own > most;
        }
        most = most.max(own);
    }
    front
}

#[cfg(test)]
mod tests {
    use super::super::theorem::Theorem;
    use super::*;
    use crate::numerics::random::Random;
    use crate::results::Parameters;

    fn curve() -> Curve {
        let parameters = Parameters { alpha: 61906.0, beta: 2.4297, gamma: Some(0.9499), epsilon: None };
        Curve { model: "pow3".into(), parameters, rmse: 0.0 }
    }

    #[test]
    fn integers_lose_less_than_k_minus_one_slots_against_the_closed_form() {
        let mut random = Random::new(4, 0, 0, 0);
        let scenario = Scenario::default();
        for users in [1, 3, 8] {
            for _ in 0..10 {
                let bits: Vec<f64> = (0..users).map(|_| 500.0 + 3000.0 * random.uniform()).collect();
                let theorem = Theorem::new(4000, &bits);
                for p in boundary(&scenario, &curve(), &bits).unwrap() {
                    let exact = theorem.throughput_bit(f64::from(p.sensing_slots));
                    let loss = f64::from(users - 1) / f64::from(4000 - p.sensing_slots);
                    assert!(p.throughput_bit <= exact * (1.0 + 1e-12));
                    assert!(p.throughput_bit >= exact * (1.0 - loss - 1e-12), "{} {exact}", p.throughput_bit);
                    assert_eq!(p.shares.iter().sum::<u32>() + p.sensing_slots, 4000);
                }
            }
        }
    }

    #[test]
    fn the_boundary_is_its_own_pareto_front_but_for_ties() {
        let points = boundary(&Scenario::default(), &curve(), &[1500.0, 2500.0, 3000.0]).unwrap();
        assert_eq!(points.len(), 849);
        let front = pareto(&points);
        for (p, front) in points.iter().zip(front) {
            let tie = points
                .iter()
                .any(|q| q.sensing_slots > p.sensing_slots && q.throughput_bit >= p.throughput_bit);
            assert_eq!(front, !tie, "{p:?}");
        }
    }

    #[test]
    fn the_front_is_what_no_other_point_dominates() {
        let mut random = Random::new(7, 0, 0, 0);
        for count in [0, 1, 2, 5, 40] {
            for _ in 0..50 {
                // of so few values many are equal
                let mut value = || (5.0 * random.uniform()).floor();
                let mut point = || {
                    let (accuracy, throughput_bit) = (value(), value());
                    Point { sensing_slots: 0, shares: Vec::new(), accuracy, throughput_bit }
                };
                let points: Vec<Point> = (0..count).map(|_| point()).collect();
                let dominated = |p: &Point| {
                    points.iter().any(|q| {
                        q.accuracy >= p.accuracy
                            && q.throughput_bit >= p.throughput_bit
                            && (q.accuracy > p.accuracy || q.throughput_bit > p.throughput_bit)
                    })
                };
                let expected: Vec<bool> = points.iter().map(|p| !dominated(p)).collect();
                assert_eq!(pareto(&points), expected, "{points:?}");
            }
        }
    }

    #[test]
    fn a_period_without_a_window_is_refused() {
        let mut scenario = Scenario::default();
        scenario.frame.period_slots = 400;
        assert!(matches!(boundary(&scenario, &curve(), &[1.0]), Err(OptimizerError::Invalid(_))));
    }
}
