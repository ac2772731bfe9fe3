//! N_m as a variable: the operating point of every spacing that accuracies were measured at, and the best of these.
//!
//! N_s (N_m + 1) <= N bounds N_s, the pulse repetition interval (N_m + 1) T_s bounds the unambiguous speed,
//! lambda / (4 (N_m + 1) T_s), and the radar observes the motion for N_s of these intervals. Accuracy depends on that time as much as
//! on N_s, so that every N_m has a learning curve A(N_s) of its own.

use super::operating_point::{Rule, choose, choose_within};
use super::region::{Point, boundary};
use super::{Bits, OptimizerError};
use crate::predictor::points;
use crate::results::{Curve, CurvePoint, Spacing};
use crate::scenario::{SPEED_OF_LIGHT, Scenario};

/// Accuracies measured at one N_m, and the curve through them.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// N_m.
    pub spacing_slots: u32,
    /// The learning curve.
    pub curve: Curve,
    /// The points that it was fitted to.
    pub points: Vec<CurvePoint>,
}

impl Measured {
    /// The scenario at this N_m, with those of its N_s that fit the period.
    pub fn scenario(&self, scenario: &Scenario) -> Scenario {
        let mut own = scenario.clone();
        own.frame.spacing_slots = self.spacing_slots;
        let most = own.frame.period_slots / (self.spacing_slots + 1);
        own.frame.sensing_slots.retain(|&slots| slots <= most);
        if own.frame.sensing_slots.is_empty() {
            own.frame.sensing_slots.push(most);
        }
        own
    }
}

/// The index of the N_m with the best operating point by `rule` in case `optimizer.case`, and the operating point of every N_m. With
/// [`Rule::Weighted`] the spans that compare them are those of all boundaries.
///
/// # Errors
///
/// [`OptimizerError`]: an N_m at which not even the shortest recording fits; a rule that no point satisfies.
pub fn spacings(
    scenario: &Scenario,
    measured: &[Measured],
    rule: Rule,
    seed: u64,
) -> Result<(usize, Vec<Spacing>), OptimizerError> {
    let slot_bit = Bits::of(scenario, scenario.optimizer.case as usize - 1, seed)?.expected;
    let wavelength = SPEED_OF_LIGHT / scenario.radar.carrier_hz;
    let (mut all, mut chosen, mut rows) = (Vec::new(), Vec::new(), Vec::new());
    for (index, one) in measured.iter().enumerate() {
        let own = one.scenario(scenario);
        let boundary = boundary(&own, &one.curve, &slot_bit)?;
        let point: Option<&Point> = choose(&boundary, rule).map(|at| &boundary[at]);
        let (low, high) = points::range(&one.points);
        rows.push(Spacing {
            spacing_slots: one.spacing_slots,
            curve: one.curve.clone(),
            most_sensing_slots: own.frame.period_slots / (one.spacing_slots + 1),
            unambiguous_m_s: wavelength / (4.0 * own.interval_s()),
            sensing_slots: point.map(|p| p.sensing_slots),
            extrapolated: point.is_some_and(|p| !(low..=high).contains(&f64::from(p.sensing_slots))),
            accuracy: point.map(|p| p.accuracy),
            throughput_bit: point.map(|p| p.throughput_bit),
            observation_s: point.map(|p| own.interval_s() * f64::from(p.sensing_slots)),
        });
        chosen.extend(point.map(|p| (index, p.clone())));
        all.extend(boundary);
    }
    let (indices, points): (Vec<usize>, Vec<Point>) = chosen.into_iter().unzip();
    match choose_within(&points, &all, rule) {
        Some(best) => Ok((indices[best], rows)),
        None => Err(OptimizerError::unreachable(rule, &all)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::predictor::{best_curve, fit_all};

    /// Accuracies of a power law through `points`.
    fn measured(spacing_slots: u32, points: &[(f64, f64)]) -> Measured {
        let point =
            |&(sensing_slots, accuracy)| CurvePoint { sensing_slots, accuracy, tested: None, std: None };
        let points: Vec<CurvePoint> = points.iter().map(point).collect();
        Measured { spacing_slots, curve: best_curve(&fit_all(&points).unwrap()), points }
    }

    fn three() -> [Measured; 3] {
        [
            measured(3, &[(200.0, 0.80), (300.0, 0.86), (400.0, 0.92), (600.0, 0.96), (1000.0, 0.976)]),
            measured(7, &[(200.0, 0.911), (300.0, 0.968), (400.0, 0.989), (500.0, 0.993)]),
            measured(12, &[(160.0, 0.935), (200.0, 0.965), (250.0, 0.984), (300.0, 0.990)]),
        ]
    }

    fn scenario() -> Scenario {
        let mut scenario = Scenario::default();
        scenario.communication.slot_bit = Some(vec![vec![9000.0, 10000.0, 11000.0]; 2]);
        scenario
    }

    #[test]
    fn the_best_spacing_has_the_best_operating_point() {
        let (scenario, measured) = (scenario(), three());
        for accuracy in [0.90, 0.95, 0.97] {
            let (best, rows) = spacings(&scenario, &measured, Rule::AccuracyAtLeast(accuracy), 1).unwrap();
            assert_eq!(rows.iter().map(|row| row.spacing_slots).collect::<Vec<_>>(), [3, 7, 12]);
            let most = rows.iter().filter_map(|row| row.throughput_bit).fold(0.0, f64::max);
            assert_eq!(rows[best].throughput_bit, Some(most));
            for row in &rows {
                // the fewest slots of this N_m that reach it, by its own curve
                let at = |n: u32| crate::predictor::evaluate(&row.curve, f64::from(n)).unwrap();
                let n = row.sensing_slots.unwrap();
                assert!(at(n) >= accuracy && (at(n - 1) < accuracy || n == 152), "{row:?}");
                let seconds = f64::from(n * (row.spacing_slots + 1)) * 250e-6;
                assert!((row.observation_s.unwrap() - seconds).abs() < 1e-12);
                assert_eq!(row.most_sensing_slots, 4000 / (row.spacing_slots + 1));
            }
        }
        // the most accuracy at a throughput
        let (best, rows) = spacings(&scenario, &measured, Rule::ThroughputAtLeast(1.25e7), 1).unwrap();
        let most = rows.iter().filter_map(|row| row.accuracy).fold(0.0, f64::max);
        assert_eq!(rows[best].accuracy, Some(most));
    }

    #[test]
    fn a_spacing_that_cannot_reach_the_accuracy_has_no_point_and_none_is_an_error() {
        let (scenario, measured) = (scenario(), three());
        let (best, rows) = spacings(&scenario, &measured, Rule::AccuracyAtLeast(0.985), 1).unwrap();
        assert_eq!(rows[0].sensing_slots, None);
        assert!(rows[best].sensing_slots.is_some());
        let refused = spacings(&scenario, &measured, Rule::AccuracyAtLeast(0.9999), 1).unwrap_err();
        assert!(refused.to_string().contains("no point of the boundary satisfies"), "{refused}");
    }

    #[test]
    fn weights_compare_the_spacings_over_the_span_of_all() {
        let (scenario, measured) = (scenario(), three());
        for weight in [0.2, 0.5, 0.8] {
            let (best, rows) = spacings(&scenario, &measured, Rule::Weighted(weight), 1).unwrap();
            // N_m = 12 reaches any accuracy of the others with fewer slots
            assert_eq!(rows[best].spacing_slots, 12, "{weight}");
        }
    }

    #[test]
    fn the_scenario_of_a_spacing_is_legal() {
        for one in three() {
            let own = one.scenario(&scenario());
            own.check("").unwrap();
            assert_eq!(own.frame.spacing_slots, one.spacing_slots);
        }
    }
}
