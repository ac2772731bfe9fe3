//! The optimizer: what accuracy costs in throughput, and the operating point of the scheduler.
//!
//! [`water_filling`], [`limited_water_filling`] and [`throughput`] compute the bits of a slot; [`theorem`] is the boundary in closed form, [`region`] the exact one
//! in whole slots ([`shares`]); [`zones`] names its parts, [`operating_point`] chooses on it, [`early_exits`] draws the region beyond
//! it, [`spacings`] and [`sweep`] vary what else may vary.

pub(crate) mod early_exits;
pub mod limited_water_filling;
pub mod operating_point;
pub mod region;
pub(crate) mod shares;
pub mod spacings;
pub(crate) mod sweep;
pub mod theorem;
pub(crate) mod throughput;
pub mod water_filling;
pub(crate) mod zones;

pub use operating_point::Rule;

use crate::error::Invalid;
use crate::formats::table;
use crate::predictor::bootstrap::interval;
use crate::results::{Case, Curve, CurvePoint, Link, OperatingPoint, Optimum, RegionPoint, WeightedPoint};
use crate::scenario::{Scenario, ScenarioError};
use crate::simulator::channel::link;
use region::Point;
use sdp3_core::scheduler::PlanError;
use theorem::Theorem;
use zones::Zones;

/// Why there is no boundary or no point on it.
#[derive(Debug, thiserror::Error)]
pub enum OptimizerError {
    /// A user has no gain.
    #[error("communication: user {user} gets {bits} bits per slot; every user needs a gain above 0")]
    Gain {
        /// User, from 0.
        user: usize,
        /// Bits per slot.
        bits: f64,
    },
    /// Not even the shortest recording fits the period; a learning curve that is none of the seven.
    #[error(transparent)]
    Invalid(#[from] Invalid),
    /// No point satisfies the rule.
    #[error(
        "no point of the boundary satisfies: {rule}; it offers accuracies {low:.4} to {high:.4} and at most {most:.0} bit"
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
    /// A variation of the scenario is not legal.
    #[error(transparent)]
    Scenario(ScenarioError),
}

impl OptimizerError {
    /// No point of a boundary satisfies `rule`.
    fn unreachable(rule: Rule, points: &[Point]) -> Self {
        OptimizerError::Unreachable {
            rule: rule.words(),
            low: points.iter().map(|p| p.accuracy).fold(1.0, f64::min),
            high: points.iter().map(|p| p.accuracy).fold(0.0, f64::max),
            most: points.iter().map(|p| p.throughput_bit).fold(0.0, f64::max),
        }
    }
}

/// Boundary and operating point.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// Boundaries of all cases, as shown.
    pub region: Vec<RegionPoint>,
    /// Weighted-sum optima for weights 0, 0.05, ... 1, case by case.
    pub weighted: Vec<WeightedPoint>,
    /// Every case: bits per slot, borders of its zones, its operating point.
    pub cases: Vec<Case>,
    /// The point handed to the scheduler.
    pub operating_point: OperatingPoint,
}

impl Outcome {
    /// With the learning curve and the scenario that it is of.
    pub fn optimum(self, curve: Curve, scenario: &Scenario) -> Optimum {
        let Outcome { region, weighted, cases, operating_point } = self;
        let (zone_ratio, spacings) = (scenario.optimizer.zone_ratio, Vec::new());
        Optimum { curve, region, operating_point, weighted, cases, spacings, zone_ratio, retested: None }
    }
}

/// Bits of one slot for the users of a case.
struct Bits {
    /// At the expected gains.
    expected: Vec<f64>,
    /// Expected over fading: the mean over draws, each water-filled for itself.
    over_fading: Vec<f64>,
    /// What they are made of; nothing where they are stated.
    links: Vec<Link>,
}

impl Bits {
    /// Those the scenario states, else those of its channels.
    fn of(scenario: &Scenario, index: usize, seed: u64) -> Result<Self, OptimizerError> {
        if let Some(known) = scenario.communication.slot_bit.as_ref().and_then(|cases| cases.get(index)) {
            return Ok(Bits { expected: known.clone(), over_fading: known.clone(), links: Vec::new() });
        }
        let draws = scenario.communication.draws;
        let of_user = |&place: &[f64; 3]| {
            let mut bits = 0.0;
            let gains = link::expected(draws, link::subcarrier_draws(scenario, place, seed), |gains| {
                bits += throughput::slot_bit(scenario, gains);
            });
            (gains, bits / f64::from(draws))
        };
        let (gains, over_fading): (Vec<_>, _) =
            scenario.communication.cases[index].iter().map(of_user).unzip();
        let expected = throughput::slot_bits(scenario, &gains)?;
        let links = gains.iter().map(|gains| throughput::link(scenario, gains)).collect();
        Ok(Bits { expected, over_fading, links })
    }
}

/// Number of every case and the bits of one slot for its users.
///
/// # Errors
///
/// [`OptimizerError::Gain`] for a user without gain.
pub fn bits_per_slot(scenario: &Scenario, seed: u64) -> Result<Vec<(u32, Vec<f64>)>, OptimizerError> {
    let of_case = |index: usize| Ok((index as u32 + 1, Bits::of(scenario, index, seed)?.expected));
    (0..scenario.communication.cases.len()).map(of_case).collect()
}

/// A case with its whole boundary.
struct Optimized {
    case: Case,
    points: Vec<Point>,
}

fn of_case(
    curve: &Curve,
    zones: &Zones,
    scenario: &Scenario,
    rule: Rule,
    index: usize,
    seed: u64,
) -> Result<Optimized, OptimizerError> {
    let Bits { expected: slot_bit, over_fading, links } = Bits::of(scenario, index, seed)?;
    let points = region::boundary(scenario, curve, &slot_bit)?;
    let case = index as u32 + 1;
    let operating_point = operating_point::choose(&points, rule).map(|chosen| {
        let p = &points[chosen];
        OperatingPoint {
            case,
            sensing_slots: p.sensing_slots,
            spacing_slots: scenario.frame.spacing_slots,
            period_slots: scenario.frame.period_slots,
            period_s: scenario.period_s(),
            communication_slots: p.shares.clone(),
            slot_bit: slot_bit.clone(),
            accuracy: p.accuracy,
            throughput_bit: p.throughput_bit,
            zone: zones.at(p.sensing_slots),
            extrapolated: zones.extrapolated(p.sensing_slots),
            rule: rule.words(),
            channels: scenario.communication.channels().to_owned(),
        }
    });
    let case = Case {
        case,
        slot_bit,
        slot_bit_over_fading: over_fading,
        links,
        borders: zones.borders(),
        operating_point,
    };
    Ok(Optimized { case, points })
}

/// Steps of the weight of accuracy from 0 to 1.
const WEIGHTS: u32 = 20;

/// The optimum of every weight.
fn weighted(Optimized { case, points }: &Optimized) -> Vec<WeightedPoint> {
    let best = |step: u32| {
        let weight = f64::from(step) / f64::from(WEIGHTS);
        let p = &points[operating_point::choose(points, Rule::Weighted(weight))?];
        Some(WeightedPoint {
            case: case.case,
            weight,
            sensing_slots: p.sensing_slots,
            accuracy: p.accuracy,
            throughput_bit: p.throughput_bit,
        })
    };
    (0..=WEIGHTS).filter_map(best).collect()
}

/// Every case's bits per slot, zones and operating point; `points` are those that the curve was fitted to.
///
/// # Errors
///
/// [`OptimizerError`]; a rule no point satisfies is no error here.
pub fn cases(
    curve: &Curve,
    points: &[CurvePoint],
    scenario: &Scenario,
    rule: Rule,
    seed: u64,
) -> Result<Vec<Case>, OptimizerError> {
    let zones = &zones_of(curve, points, scenario)?;
    let all = 0..scenario.communication.cases.len();
    all.map(|index| Ok(of_case(curve, zones, scenario, rule, index, seed)?.case)).collect()
}

/// The zones of a curve through `points` over every legal N_s.
fn zones_of<'a>(
    curve: &'a Curve,
    points: &[CurvePoint],
    scenario: &Scenario,
) -> Result<Zones<'a>, OptimizerError> {
    let range = region::range(scenario, scenario.frame.spacing_slots)?;
    Ok(Zones::new(curve, range, crate::predictor::points::range(points), scenario.optimizer.zone_ratio))
}

/// Columns of the boundary as CSV.
const BOUNDARY: [&str; 10] = [
    "case",
    "sensing_slots",
    "accuracy",
    "throughput_bit",
    "throughput_mbit_s",
    "closed_form_bit",
    "pareto",
    "zone",
    "extrapolated",
    "communication_slots",
];

/// The boundary of every case and the point `rule` chooses in case `optimizer.case`; `points` are those that the curve was fitted to,
/// `replicates` the curve as other tests would have it, for the bands.
///
/// # Errors
///
/// [`OptimizerError`].
pub fn optimise(
    curve: &Curve,
    points: &[CurvePoint],
    replicates: &[Curve],
    scenario: &Scenario,
    rule: Rule,
    seed: u64,
) -> Result<Outcome, OptimizerError> {
    let range = region::range(scenario, scenario.frame.spacing_slots)?;
    let zones = zones_of(curve, points, scenario)?;
    let (mut cases, mut weighted) = (Vec::new(), Vec::new());
    for index in 0..scenario.communication.cases.len() {
        // its boundary is made again below: a case's fits the memory, all of them may not
        let found = of_case(curve, &zones, scenario, rule, index, seed)?;
        weighted.extend(self::weighted(&found));
        cases.push(found.case);
    }
    let mut region = Vec::new();
    let operating = cases.iter().filter_map(|case| case.operating_point.as_ref());
    let operating = operating.map(|point| point.sensing_slots);
    let chosen: Vec<u32> = operating.chain(weighted.iter().map(|point| point.sensing_slots)).collect();
    let measured = |n: u32| points.iter().any(|p| p.sensing_slots == f64::from(n));
    for case in &cases {
        let theorem = Theorem::new(scenario.frame.period_slots, &case.slot_bit);
        let shown = |n: &u32| chosen.contains(n) || measured(*n) || region::shown(scenario, range, *n);
        for n in (range.0..=range.1).filter(shown) {
            let p = region::point(scenario.frame.period_slots, curve, &case.slot_bit, n);
            let band = (!replicates.is_empty()).then(|| interval(replicates, f64::from(n)));
            region.push(RegionPoint {
                case: case.case,
                sensing_slots: n,
                communication_slots: p.shares,
                accuracy: p.accuracy,
                accuracy_low: band.map(|b| b.0),
                accuracy_high: band.map(|b| b.1),
                throughput_bit: p.throughput_bit,
                closed_form_bit: theorem.throughput_bit(f64::from(n)),
                extrapolated: zones.extrapolated(n),
                zone: zones.at(n),
            });
        }
    }
    let Some(case) = cases.iter().find(|case| case.case == scenario.optimizer.case) else {
        return Err(OptimizerError::Plan(PlanError::Users { users: 0 }));
    };
    let Some(operating_point) = case.operating_point.clone() else {
        return Err(OptimizerError::unreachable(rule, &region::boundary(scenario, curve, &case.slot_bit)?));
    };
    Ok(Outcome { region, weighted, cases, operating_point })
}

/// Writes the boundaries of all cases at every N_s as CSV, one boundary after the other; curve, points and scenario are those that the
/// cases are of.
///
/// # Errors
///
/// What the file says; see [`OptimizerError`].
pub fn write_boundary(
    file: impl std::io::Write,
    curve: &Curve,
    points: &[CurvePoint],
    scenario: &Scenario,
    cases: &[Case],
) -> std::io::Result<()> {
    let other = std::io::Error::other::<OptimizerError>;
    let zones = zones_of(curve, points, scenario).map_err(other)?;
    let mut table = table::Writer::begin(file, b',', &BOUNDARY)?;
    for case in cases {
        let theorem = Theorem::new(scenario.frame.period_slots, &case.slot_bit);
        let points = region::boundary(scenario, curve, &case.slot_bit).map_err(other)?;
        for (p, front) in points.iter().zip(region::pareto(&points)) {
            let n = p.sensing_slots;
            let shares: Vec<String> = p.shares.iter().map(u32::to_string).collect();
            table.row(vec![
                case.case.to_string(),
                n.to_string(),
                p.accuracy.to_string(),
                p.throughput_bit.to_string(),
                (p.throughput_bit / scenario.period_s() / 1e6).to_string(),
                theorem.throughput_bit(f64::from(n)).to_string(),
                front.to_string(),
                zones.at(n).name().to_owned(),
                zones.extrapolated(n).to_string(),
                shares.join(" "),
            ])?;
        }
    }
    table.end()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::{Parameters, Zone};

    fn outcome(rule: Rule) -> Result<Outcome, OptimizerError> {
        let parameters = Parameters { alpha: 61906.0, beta: 2.4297, gamma: Some(0.9499), epsilon: None };
        let curve = Curve { model: "pow3".into(), parameters, rmse: 0.0 };
        // without a largest modulation, which both placements reach
        let scenario = crate::scenario::builtin::named("as-printed".as_ref()).unwrap().scenario();
        optimise(&curve, &[], &[], &scenario, rule, 1)
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
    fn a_user_without_gain_is_named() {
        let error =
            throughput::slot_bits(&Scenario::default(), &[vec![1e-9; 64], vec![0.0; 64]]).unwrap_err();
        assert!(error.to_string().contains("user 1 gets 0 bits"), "{error}");
    }
}
