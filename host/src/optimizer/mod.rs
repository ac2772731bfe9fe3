//! Trade: what accuracy costs in throughput, and the point handed to the scheduler.
//!
//! [`water_filling`] and [`throughput`] price a slot in bits, [`region`] draws the boundary (Theorem 1 and its exact integer
//! form), [`zones`] names its parts, [`operating_point`] chooses on it, [`playback`] lets the core's scheduler play it.

pub mod operating_point;
pub mod playback;
pub mod region;
pub mod throughput;
pub mod water_filling;
pub mod zones;

pub use operating_point::Rule;

use crate::results::{Curve, OperatingPoint, RegionPoint, WeightedPoint};
use crate::scenario::Scenario;
use sdp3_core::schedule::PlanError;

/// Why there is no boundary or no point on it.
#[derive(Debug, thiserror::Error)]
pub enum OptimizerError {
    /// A receiver hears nothing.
    #[error(
        "communication: receiver {receiver} gets {bits} bits per slot; every receiver needs a gain above 0"
    )]
    Gain {
        /// Receiver, from 0.
        receiver: usize,
        /// Bits per slot.
        bits: f64,
    },
    /// Not one STFT window fits the period.
    #[error(
        "frame.period_slots = {period} is outside its legal range: at least {least}, one STFT window of sensing slots"
    )]
    Period {
        /// N.
        period: u32,
        /// Least N.
        least: u32,
    },
    /// The learning curve is not one of the seven.
    #[error("curve.model = {model:?} is none of the seven learning curves")]
    Curve {
        /// Its name.
        model: String,
    },
    /// No point satisfies the rule.
    #[error(
        "no point of the boundary satisfies: {rule}; it offers accuracies {low:.4}..={high:.4} and at most {most:.0} bit"
    )]
    Unreachable {
        /// The rule in words.
        rule: String,
        /// Least accuracy of the boundary.
        low: f64,
        /// Largest accuracy.
        high: f64,
        /// Largest throughput.
        most: f64,
    },
    /// The numbers are not a plan.
    #[error("plan: {0}")]
    Plan(PlanError),
}

/// Boundary and operating point.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// Boundaries of all cases.
    pub region: Vec<RegionPoint>,
    /// Weighted-sum optima for weights 0, 0.05, ... 1, case by case.
    pub weighted: Vec<WeightedPoint>,
    /// The point handed to the scheduler.
    pub operating_point: OperatingPoint,
}

/// The boundary of every case and the point `rule` chooses in case `trade.case`.
///
/// `gains` are `E |H_m|^2`, `[case][receiver][subcarrier]`.
///
/// # Errors
///
/// [`OptimizerError`].
pub fn optimise(
    curve: &Curve,
    gains: &[Vec<Vec<f64>>],
    scenario: &Scenario,
    rule: Rule,
) -> Result<Outcome, OptimizerError> {
    let mut region = Vec::new();
    let mut weighted = Vec::new();
    let mut operating_point = None;
    for (index, gains) in gains.iter().enumerate() {
        let case = index as u32 + 1;
        let slot_bit = throughput::slot_bits(scenario, gains)?;
        let points = region::boundary(scenario, curve, &slot_bit)?;
        let zones = zones::zones(&points, scenario.trade.zone_ratio);
        for (p, &zone) in points.iter().zip(&zones) {
            region.push(RegionPoint {
                case,
                sensing_slots: p.sensing_slots,
                accuracy: p.accuracy,
                throughput_bit: p.throughput_bit,
                zone,
            });
        }
        for step in 0..=20 {
            let weight = f64::from(step) / 20.0;
            if let Some(best) = operating_point::choose(&points, Rule::Weighted(weight)) {
                let p = &points[best];
                weighted.push(WeightedPoint {
                    case,
                    weight,
                    sensing_slots: p.sensing_slots,
                    accuracy: p.accuracy,
                    throughput_bit: p.throughput_bit,
                });
            }
        }
        if case == scenario.trade.case {
            let chosen =
                operating_point::choose(&points, rule).ok_or_else(|| OptimizerError::Unreachable {
                    rule: rule.words(),
                    low: points.iter().map(|p| p.accuracy).fold(1.0, f64::min),
                    high: points.iter().map(|p| p.accuracy).fold(0.0, f64::max),
                    most: points.iter().map(|p| p.throughput_bit).fold(0.0, f64::max),
                })?;
            let p = &points[chosen];
            operating_point = Some(OperatingPoint {
                case,
                sensing_slots: p.sensing_slots,
                spacing_slots: scenario.frame.spacing_slots,
                period_slots: scenario.frame.period_slots,
                communication_slots: p.shares.clone(),
                slot_bit,
                accuracy: p.accuracy,
                throughput_bit: p.throughput_bit,
                zone: zones[chosen],
                rule: rule.words(),
            });
        }
    }
    let operating_point =
        operating_point.ok_or(OptimizerError::Plan(PlanError::Receivers { receivers: 0 }))?;
    Ok(Outcome { region, weighted, operating_point })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::{Parameters, Zone};

    fn outcome(rule: Rule) -> Result<Outcome, OptimizerError> {
        let parameters = Parameters { alpha: 61906.0, beta: 2.4297, gamma: Some(0.9499), epsilon: None };
        let curve = Curve { model: "pow3".into(), parameters, rmse: 0.0 };
        let scenario = Scenario::default();
        let gains: Vec<Vec<Vec<f64>>> = scenario
            .communication
            .cases
            .iter()
            .map(|case| {
                case.iter()
                    .map(|&p| crate::simulator::channel::link::subcarrier_gains(&scenario, p, 1))
                    .collect()
            })
            .collect();
        optimise(&curve, &gains, &scenario, rule)
    }

    #[test]
    fn case_two_contains_case_one_and_all_zones_exist() {
        let found = outcome(Rule::Weighted(0.5)).unwrap();
        let of = |case: u32| found.region.iter().filter(move |p| p.case == case);
        for (one, two) in of(1).zip(of(2)) {
            assert_eq!(one.sensing_slots, two.sensing_slots);
            assert!(two.throughput_bit > one.throughput_bit);
        }
        for zone in [Zone::CommunicationSaturation, Zone::Adversarial, Zone::SensingSaturation] {
            assert!(of(1).any(|p| p.zone == zone), "{zone:?}");
        }
        assert_eq!(found.operating_point.zone, Zone::Adversarial);
    }

    #[test]
    fn the_scheduler_plays_the_point_exactly() {
        let point = outcome(Rule::AccuracyAtLeast(0.93)).unwrap().operating_point;
        assert!(point.accuracy >= 0.93);
        let played = playback::play(&point).unwrap();
        assert_eq!(played.communication_slots, point.communication_slots);
        assert_eq!(played.sensing_slots, point.sensing_slots);
        let worst = played.delivered_bit.iter().copied().fold(f64::INFINITY, f64::min);
        assert!((worst / point.throughput_bit - 1.0).abs() < 1e-9);
        assert!(outcome(Rule::AccuracyAtLeast(0.99)).is_err());
    }
}
