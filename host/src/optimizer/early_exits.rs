//! The region with early exits: threshold and last exit as variables beside N_s.
//!
//! What a recording does not sense goes to the users in the same period, so the expected throughput of a policy is Theorem 1's
//! at its expected number of sensing slots: R is linear in N_s.

use super::operating_point::{Rule, choose};
use super::region::Point;
use super::theorem::Theorem;
use super::{OptimizerError, bits_per_slot};
use crate::network::early_exits::policy::{ExitClasses, Policy};
use crate::network::evaluation::ExitLogits;
use crate::results::{EarlyExitGain, EarlyExitRegionPoint, EarlyExitResult, StaticPoint};
use crate::scenario::Scenario;

/// Recordings evaluated by a policy, with the classification of each exit's network alone.
#[derive(Debug, Clone, Copy)]
pub struct Evaluated<'a> {
    /// Logits of every exit.
    pub exit_logits: &'a ExitLogits,
    pub exit_classes: &'a [ExitClasses],
}

/// For every static N_s: threshold and last exit that reach its accuracy on the calibration recordings with the fewest slots, and
/// what they reach on the test recordings beside it.
pub fn gains(policy: &Policy, calibration: Evaluated, test: Evaluated) -> Vec<EarlyExitGain> {
    let rows = (0..policy.exits.len()).filter_map(|exit| {
        let wanted = calibration.exit_logits.accuracy(exit);
        let (threshold, last) =
            policy.cheapest(calibration.exit_classes, &calibration.exit_logits.truth, wanted)?;
        let early_exit = policy.evaluate(test.exit_classes, &test.exit_logits.truth, threshold, last);
        let static_slots = policy.exits[exit].sensing_slots;
        Some(EarlyExitGain {
            static_slots,
            static_accuracy: test.exit_logits.accuracy(exit),
            saved: 1.0 - early_exit.sensing_slots / f64::from(static_slots),
            early_exit,
        })
    });
    rows.collect()
}

/// The upper envelope of all thresholds and last exits: accuracy against expected throughput of one user placement. Each point on
/// the calibration recordings, which it is chosen by, and what it reaches on the test recordings.
pub fn region(
    policy: &Policy,
    calibration: Evaluated,
    test: Evaluated,
    theorem: &Theorem,
    case: u32,
) -> Vec<(Point, EarlyExitRegionPoint)> {
    let mut all = Vec::new();
    for last in 0..policy.exits.len() {
        for threshold in Policy::thresholds() {
            let found =
                policy.evaluate(calibration.exit_classes, &calibration.exit_logits.truth, threshold, last);
            all.push((found.sensing_slots, found.accuracy, threshold, last));
        }
    }
    all.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.total_cmp(&a.1)));
    let mut most = 0.0;
    let front = all.into_iter().filter(|&(_, accuracy, ..)| {
        let better = accuracy > most;
        most = f64::max(most, accuracy);
        better
    });
    front
        .map(|(sensing_slots, accuracy, threshold, last)| {
            let throughput_bit = |slots| theorem.throughput_bit(slots);
            let calibrated = Point {
                sensing_slots: sensing_slots.round() as u32,
                shares: Vec::new(),
                accuracy,
                throughput_bit: throughput_bit(sensing_slots),
            };
            let point = policy.evaluate(test.exit_classes, &test.exit_logits.truth, threshold, last);
            let throughput_bit = throughput_bit(point.sensing_slots);
            (calibrated, EarlyExitRegionPoint { case, throughput_bit, point })
        })
        .collect()
}

/// Everything `sdp3 early-exits` states. `rule` chooses among the points of case `optimizer.case`, by what they reach on the calibration
/// recordings.
///
/// # Errors
///
/// [`OptimizerError::Gain`], and [`OptimizerError::Unreachable`] if no point satisfies the rule.
pub fn outcome(
    scenario: &Scenario,
    seed: u64,
    policy: &Policy,
    calibration: &ExitLogits,
    test: &ExitLogits,
    rule: Rule,
) -> Result<EarlyExitResult, OptimizerError> {
    let (fitted, exit_classes) = (policy.exit_classes(calibration), policy.exit_classes(test));
    let fitted = Evaluated { exit_logits: calibration, exit_classes: &fitted };
    let evaluated = Evaluated { exit_logits: test, exit_classes: &exit_classes };
    let (mut all, mut still) = (Vec::new(), Vec::new());
    for (case, slot_bit) in bits_per_slot(scenario, seed)? {
        let theorem = Theorem::new(scenario.frame.period_slots, &slot_bit);
        all.extend(region(policy, fitted, evaluated, &theorem, case));
        still.extend(policy.exits.iter().enumerate().map(|(exit, e)| StaticPoint {
            case,
            sensing_slots: e.sensing_slots,
            accuracy: test.accuracy(exit),
            throughput_bit: theorem.throughput_bit(f64::from(e.sensing_slots)),
        }));
    }
    let own = all.iter().filter(|(_, p)| p.case == scenario.optimizer.case);
    let (points, own): (Vec<Point>, Vec<&EarlyExitRegionPoint>) = own.map(|(c, p)| (c.clone(), p)).unzip();
    let chosen = choose(&points, rule).ok_or_else(|| OptimizerError::unreachable(rule, &points))?;
    let operating_point = own[chosen].clone();
    let fused = |exit: usize| policy.evaluate(evaluated.exit_classes, &test.truth, 2.0, exit).accuracy;
    Ok(EarlyExitResult {
        calibrated_on: calibration.truth.len() as u32,
        tested: test.truth.len() as u32,
        gains: gains(policy, fitted, evaluated),
        fused_accuracy: (0..policy.exits.len()).map(fused).collect(),
        region: all.into_iter().map(|(_, point)| point).collect(),
        static_region: still,
        operating_point,
        exits: policy.exits.clone(),
        channels: scenario.communication.channels().to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_operating_point_is_chosen_on_the_calibration_recordings() {
        let labelled = |truth: Vec<u8>| ExitLogits {
            slots: vec![200, 400],
            scales: vec![0.1; 2],
            logits: (0..10).map(|_| vec![vec![100, 0]; 2]).collect(),
            truth,
        };
        let policy = Policy::new(&[200, 400], vec![vec![1 << 12], vec![1 << 11; 2]]);
        // every class is 0: right of the recordings to calibrate on, and of three of ten tested
        let (calibration, test) =
            (labelled(vec![0; 10]), labelled((0..10).map(|n| u8::from(n >= 3)).collect()));
        let rule = Rule::AccuracyAtLeast(0.9);
        let found = outcome(&Scenario::default(), 1, &policy, &calibration, &test, rule).unwrap();
        assert_eq!(found.operating_point.point.accuracy, 0.3);
        let refused = outcome(&Scenario::default(), 1, &policy, &test, &calibration, rule);
        assert!(matches!(refused, Err(OptimizerError::Unreachable { .. })));
    }
}
