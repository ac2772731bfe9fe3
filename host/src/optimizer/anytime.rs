//! The anytime region: threshold and last exit as variables beside N_s.
//!
//! What a recording does not sense goes to the receivers in the same period, so the expected throughput of a policy is Theorem 1's
//! at its expected number of sensing slots: R is linear in N_s.

use super::operating_point::{Rule, choose};
use super::region::Point;
use super::theorem::Theorem;
use super::{OptimizerError, prices};
use crate::predictor::anytime::Answers;
use crate::predictor::anytime::policy::{Course, Policy};
use crate::results::{AnytimeGain, AnytimeRegionPoint, AnytimeResult, StaticPoint};
use crate::scenario::Scenario;

/// Recordings judged by a policy, with what each exit's network alone would have said.
#[derive(Debug, Clone, Copy)]
pub struct Judged<'a> {
    /// Answers.
    pub answers: &'a Answers,
    /// Verdicts.
    pub courses: &'a [Course],
}

/// For every static N_s: threshold and last exit that reach its accuracy on the calibration recordings with the fewest slots, and
/// what they reach on the test recordings beside it.
pub fn gains(policy: &Policy, calibration: Judged, test: Judged) -> Vec<AnytimeGain> {
    let rows = (0..policy.exits.len()).filter_map(|exit| {
        let wanted = calibration.answers.alone(exit);
        let (threshold, last) = policy.cheapest(calibration.courses, &calibration.answers.truth, wanted)?;
        let anytime = policy.play(test.courses, &test.answers.truth, threshold, last);
        let static_slots = policy.exits[exit].sensing_slots;
        Some(AnytimeGain {
            static_slots,
            static_accuracy: test.answers.alone(exit),
            saved: 1.0 - anytime.sensing_slots / f64::from(static_slots),
            anytime,
        })
    });
    rows.collect()
}

/// The upper envelope of all thresholds and last exits: accuracy against expected throughput of one receiver placement. Chosen
/// on the calibration recordings, stated on the test recordings.
pub fn region(
    policy: &Policy,
    calibration: Judged,
    test: Judged,
    theorem: &Theorem,
    case: u32,
) -> Vec<AnytimeRegionPoint> {
    let mut all = Vec::new();
    for last in 0..policy.exits.len() {
        for threshold in Policy::thresholds() {
            let found = policy.play(calibration.courses, &calibration.answers.truth, threshold, last);
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
        .map(|(_, _, threshold, last)| {
            let point = policy.play(test.courses, &test.answers.truth, threshold, last);
            let throughput_bit = theorem.throughput_bit(point.sensing_slots);
            AnytimeRegionPoint { case, throughput_bit, point }
        })
        .collect()
}

/// Everything `sdp3 anytime` states. `rule` chooses among the anytime points of case `trade.case`.
///
/// # Errors
///
/// [`OptimizerError::Gain`], and [`OptimizerError::Unreachable`] if no point satisfies the rule.
pub fn outcome(
    scenario: &Scenario,
    seed: u64,
    policy: &Policy,
    calibration: &Answers,
    test: &Answers,
    rule: Rule,
) -> Result<AnytimeResult, OptimizerError> {
    let (fitted, courses) = (policy.courses(calibration), policy.courses(test));
    let fitted = Judged { answers: calibration, courses: &fitted };
    let judged = Judged { answers: test, courses: &courses };
    let (mut all, mut still) = (Vec::new(), Vec::new());
    for (case, slot_bit) in prices(scenario, seed)? {
        let theorem = Theorem::new(scenario.frame.period_slots, &slot_bit);
        all.extend(region(policy, fitted, judged, &theorem, case));
        still.extend(policy.exits.iter().enumerate().map(|(exit, e)| StaticPoint {
            case,
            sensing_slots: e.sensing_slots,
            accuracy: test.alone(exit),
            throughput_bit: theorem.throughput_bit(f64::from(e.sensing_slots)),
        }));
    }
    let own: Vec<&AnytimeRegionPoint> = all.iter().filter(|p| p.case == scenario.trade.case).collect();
    let point = |p: &&AnytimeRegionPoint| Point {
        sensing_slots: p.point.sensing_slots.round() as u32,
        shares: Vec::new(),
        accuracy: p.point.accuracy,
        throughput_bit: p.throughput_bit,
    };
    let points: Vec<Point> = own.iter().map(point).collect();
    let chosen = choose(&points, rule).ok_or_else(|| OptimizerError::unreachable(rule, &points))?;
    let operating_point = own[chosen].clone();
    let fused = |exit: usize| policy.play(judged.courses, &test.truth, 2.0, exit).accuracy;
    Ok(AnytimeResult {
        calibrated_on: calibration.truth.len() as u32,
        tested: test.truth.len() as u32,
        gains: gains(policy, fitted, judged),
        fused_accuracy: (0..policy.exits.len()).map(fused).collect(),
        region: all,
        static_region: still,
        operating_point,
        exits: policy.exits.clone(),
    })
}
