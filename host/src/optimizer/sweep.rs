//! The operating point over carrier, power, number of users and their distance: every combination, one row each.

use super::operating_point::Rule;
use super::{OptimizerError, cases};
use crate::error::Invalid;
use crate::numerics::random::Random;
use crate::results::{Curve, CurvePoint, SweepRow};
use crate::scenario::Scenario;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Axis {
    /// Carrier frequency in Hz.
    Carrier,
    /// Transmit power of the communication in W.
    Power,
    /// Number of users K: the case's own first, then ones placed at random.
    Users,
    /// Factor on every user's distance from the base station.
    Distance,
}

impl Axis {
    /// All, by the names of the command line.
    pub const ALL: [(Axis, &str); 4] = [
        (Axis::Carrier, "carrier_hz"),
        (Axis::Power, "power_w"),
        (Axis::Users, "users"),
        (Axis::Distance, "distance"),
    ];
}

/// One axis with its values: `power_w=0.1,1,10`.
#[derive(Debug, Clone, PartialEq)]
pub struct Sweep {
    pub axis: Axis,
    /// Values in the order given.
    pub values: Vec<f64>,
}

impl std::str::FromStr for Sweep {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let names = Axis::ALL.map(|(_, name)| name).join(", ");
        let legal = format!("AXIS=VALUE,VALUE,... with AXIS one of {names}");
        let (name, values) = text.split_once('=').ok_or(&legal)?;
        let (axis, _) = Axis::ALL.into_iter().find(|(_, n)| *n == name).ok_or(&legal)?;
        let number = |value: &str| {
            let number = value.trim().parse::<f64>().ok().filter(|v| v.is_finite() && *v > 0.0);
            let number = number.filter(|v| axis != Axis::Users || (v.fract() == 0.0 && *v <= 8.0));
            let range = if axis == Axis::Users { "1 to 8" } else { "a number above 0" };
            number.ok_or_else(|| Invalid::new(name, value, range).to_string())
        };
        Ok(Sweep { axis, values: values.split(',').map(number).collect::<Result<_, _>>()? })
    }
}

/// Refuses an axis that is given twice.
///
/// # Errors
///
/// See [`Invalid`].
pub fn check(sweeps: &[Sweep]) -> Result<(), Invalid> {
    for (n, sweep) in sweeps.iter().enumerate() {
        if sweeps[..n].iter().any(|other| other.axis == sweep.axis) {
            let (_, name) = Axis::ALL[sweep.axis as usize];
            return Err(Invalid::option(
                "--sweep",
                format!("{name} twice"),
                "each axis once, with all its values",
            ));
        }
    }
    Ok(())
}

/// Stream number of the places of further users.
const STREAM: u64 = 202;

fn apply(scenario: &mut Scenario, axis: Axis, value: f64, seed: u64) {
    let (room, station) = (scenario.room.size_m, scenario.radar.position_m);
    match axis {
        Axis::Carrier => scenario.radar.carrier_hz = value,
        Axis::Power => scenario.communication.power_w = value,
        Axis::Users => {
            for (case, users) in scenario.communication.cases.iter_mut().enumerate() {
                users.truncate(value as usize);
                let mut random = Random::new(seed, STREAM, case as u64, 0);
                while users.len() < value as usize {
                    let place = [room[0] * random.uniform(), room[1] * random.uniform(), station[2]];
                    let apart = (place[0] - station[0]).hypot(place[1] - station[1]);
                    if apart >= 0.5 {
                        users.push(place);
                    }
                }
            }
        }
        Axis::Distance => {
            for place in scenario.communication.cases.iter_mut().flatten() {
                (0..3).for_each(|k| place[k] = station[k] + value * (place[k] - station[k]));
            }
        }
    }
}

/// How many combinations there are, or as many as can be counted.
pub fn combinations(sweeps: &[Sweep]) -> u64 {
    sweeps.iter().fold(1, |all, sweep| all.saturating_mul(sweep.values.len() as u64))
}

/// The operating points of all combinations, the last axis varying fastest; a rule that cannot be satisfied leaves its row empty.
///
/// # Errors
///
/// [`OptimizerError::Scenario`] for a combination that is no legal scenario; what [`cases`] refuses.
pub fn rows(
    scenario: &Scenario,
    (curve, points): (&Curve, &[CurvePoint]),
    rule: Rule,
    sweeps: &[Sweep],
    seed: u64,
) -> Result<Vec<SweepRow>, OptimizerError> {
    let mut rows = Vec::new();
    for number in 0..combinations(sweeps) {
        let (mut scenario, mut values, mut behind) = (scenario.clone(), Vec::new(), combinations(sweeps));
        for sweep in sweeps {
            behind /= sweep.values.len() as u64;
            values.push((sweep.axis, sweep.values[(number / behind) as usize % sweep.values.len()]));
        }
        let distance =
            values.iter().find(|(axis, _)| *axis == Axis::Distance).map_or(1.0, |(_, value)| *value);
        // every user's distance: after the further users are there
        values.sort_by_key(|(axis, _)| *axis == Axis::Distance);
        values.iter().for_each(|&(axis, value)| apply(&mut scenario, axis, value, seed));
        scenario.check("command line, --sweep").map_err(OptimizerError::Scenario)?;
        for case in cases(curve, points, &scenario, rule, seed)? {
            let point = case.operating_point;
            rows.push(SweepRow {
                carrier_hz: scenario.radar.carrier_hz,
                power_w: scenario.communication.power_w,
                users: case.slot_bit.len() as u32,
                distance,
                case: case.case,
                sensing_slots: point.as_ref().map(|p| p.sensing_slots),
                accuracy: point.as_ref().map(|p| p.accuracy),
                throughput_bit: point.as_ref().map(|p| p.throughput_bit),
                zone: point.as_ref().map(|p| p.zone),
                channels: scenario.communication.channels().to_owned(),
            });
        }
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::Parameters;

    #[test]
    fn axes_may_be_given_in_any_order_and_once() {
        let parameters = Parameters { alpha: 61906.0, beta: 2.4297, gamma: Some(0.9499), epsilon: None };
        let curve = Curve { model: "pow3".into(), parameters, rmse: 0.0 };
        let mut printed = crate::scenario::builtin::named("as-printed".as_ref()).unwrap().scenario();
        printed.communication.power_w = 1e-7;
        let found = |sweeps: [&str; 2]| {
            let sweeps = sweeps.map(|text| text.parse::<Sweep>().unwrap());
            check(&sweeps).unwrap();
            rows(&printed, (&curve, &[]), Rule::AccuracyAtLeast(0.9), &sweeps, 1).unwrap()
        };
        assert_eq!(found(["users=6", "distance=0.5"]), found(["distance=0.5", "users=6"]));
        let twice = ["users=6", "power_w=1", "users=5"].map(|text| text.parse::<Sweep>().unwrap());
        assert!(check(&twice).unwrap_err().to_string().contains("users twice"));
    }

    #[test]
    fn every_combination_gets_a_row_and_physics_its_way() {
        let parameters = Parameters { alpha: 61906.0, beta: 2.4297, gamma: Some(0.9499), epsilon: None };
        let curve = Curve { model: "pow3".into(), parameters, rmse: 0.0 };
        let sweeps: Vec<Sweep> =
            ["power_w=0.1,1,10", "users=1,3,5"].iter().map(|text| text.parse().unwrap()).collect();
        // without a largest modulation, which every power reaches
        let printed = crate::scenario::builtin::named("as-printed".as_ref()).unwrap().scenario();
        let found = rows(&printed, (&curve, &[]), Rule::AccuracyAtLeast(0.9), &sweeps, 1).unwrap();
        assert_eq!(found.len(), 3 * 3 * 2);
        let bit = |power: f64, users: u32| {
            let row = found.iter().find(|r| r.power_w == power && r.users == users && r.case == 1);
            row.and_then(|r| r.throughput_bit).unwrap()
        };
        assert!(bit(10.0, 3) > bit(1.0, 3) && bit(1.0, 3) > bit(0.1, 3));
        assert!(bit(1.0, 1) > bit(1.0, 3) && bit(1.0, 3) > bit(1.0, 5));
        assert!("power=1".parse::<Sweep>().unwrap_err().contains("power_w"));
        assert!("users=9".parse::<Sweep>().unwrap_err().contains("1 to 8"));
        let far: Sweep = "distance=3".parse().unwrap();
        let error = rows(&Scenario::default(), (&curve, &[]), Rule::Weighted(0.5), &[far], 1)
            .unwrap_err()
            .to_string();
        assert!(error.contains("communication.cases[0][0]") && error.contains("inside the room"), "{error}");
    }
}
