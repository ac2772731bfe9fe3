//! The person of a recording as point targets: position, velocity, cross section and phase of every primitive, for other simulators.
//!
//! A point target echoes by the radar equation: lambda sqrt(sigma) / ((4 pi)^1.5 D^2) at the delay 2 D / c. What the channel adds is
//! left out: the room, occlusion, and the antenna's pattern.

use super::body::Vec3;
use super::body::motion::GroundTruth;
use super::body::number::Dual;
use super::body::primitives::{PRIMITIVES, Primitive};
use super::channel::target::Target;
use crate::formats::table::Writer;
use crate::scenario::Scenario;
use schemars::JsonSchema;
use serde::Serialize;
use std::f64::consts::PI;
use std::io::{self, Write};

/// Names of the primitives in their order.
pub const PARTS: [&str; PRIMITIVES] = [
    "head",
    "torso",
    "left_shoulder",
    "right_shoulder",
    "left_upper_arm",
    "right_upper_arm",
    "left_lower_arm",
    "right_lower_arm",
    "left_hip",
    "right_hip",
    "left_thigh",
    "right_thigh",
    "left_shank",
    "right_shank",
    "left_foot",
    "right_foot",
];

/// Columns of the table; a row is one primitive at one instant.
pub const COLUMNS: [&str; 10] =
    ["time_s", "part", "x_m", "y_m", "z_m", "vx_m_s", "vy_m_s", "vz_m_s", "rcs_dbsm", "phase_deg"];

/// A primitive at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointTarget {
    /// Scatter centre in m, in the room's coordinates.
    pub position_m: Vec3,
    /// Its velocity in m/s.
    pub velocity_m_s: Vec3,
    /// Cross section towards the radar in dBsm, in the limit of high frequencies.
    pub rcs_dbsm: f64,
    /// Phase that scattering adds in degrees, fixed for the recording.
    pub phase_deg: f64,
}

/// Point targets that were written, and what another simulator needs besides.
#[derive(Debug, PartialEq, Serialize, JsonSchema)]
pub struct PointTargets {
    /// Position of the radar in m; one corner of the room is the origin, z points up.
    pub radar_m: [f64; 3],
    /// Carrier in Hz, at which a sweep begins.
    pub carrier_hz: f64,
    /// Frequency at the middle of a sweep in Hz.
    pub centre_hz: f64,
    /// Number of the recording within its class, from 0.
    pub index: u32,
    /// Time between two instants in s; the first is 0.
    pub every_s: f64,
    /// Instants.
    pub instants: u64,
    /// The primitives of an instant, in the order of their rows.
    pub parts: [&'static str; PRIMITIVES],
    /// One file for every class.
    pub files: Vec<PointTargetFile>,
}

/// The table of one class.
#[derive(Debug, PartialEq, Serialize, JsonSchema)]
pub struct PointTargetFile {
    /// Its name.
    pub file: String,
    /// The person in it.
    pub person: GroundTruth,
}

/// The primitives of `target` at `t` seconds, seen from `radar` in m.
pub(crate) fn point_targets(target: &Target, radar: Vec3, t: f64) -> [PointTarget; PRIMITIVES] {
    let moving = target.person.primitives(Dual::variable(t));
    let still: [Primitive; PRIMITIVES] = target.primitives(t);
    std::array::from_fn(|index| PointTarget {
        position_m: still[index].centre,
        velocity_m_s: moving[index].centre.map(|x| x.rate),
        rcs_dbsm: 10.0 * libm::log10(still[index].cross_section(radar)),
        phase_deg: target.phases[index] * 180.0 / PI,
    })
}

/// Writes the table of a person of `scenario`: `instants` of them, `every_s` seconds apart, the first at 0.
///
/// # Errors
///
/// What the file says.
pub(crate) fn write_table(
    file: impl Write,
    scenario: &Scenario,
    target: &Target,
    every_s: f64,
    instants: u64,
) -> io::Result<()> {
    let mut table = Writer::begin(file, b',', &COLUMNS)?;
    for instant in 0..instants {
        let t = instant as f64 * every_s;
        let points = point_targets(target, scenario.radar.position_m, t);
        for (part, point) in PARTS.iter().zip(points) {
            let PointTarget { position_m: [x, y, z], velocity_m_s: [vx, vy, vz], rcs_dbsm, phase_deg } =
                point;
            let mut row = vec![t.to_string(), (*part).to_owned()];
            row.extend([x, y, z, vx, vy, vz, rcs_dbsm, phase_deg].map(|number| number.to_string()));
            table.row(row)?;
        }
    }
    table.end()
}

#[cfg(test)]
mod tests {
    use super::super::body::{norm, sub};
    use super::super::channel::{Scene, carrier_phase, phasor, wavelength};
    use super::super::dataset::{Set, target_of};
    use super::*;
    use crate::scenario::{Class, SPEED_OF_LIGHT};

    fn everybody() -> (Scenario, Vec<Target>) {
        let scenario = Scenario::default();
        let target = |class| target_of(&scenario, 3, Set::Train, class, 2);
        let targets = Class::EVERY.map(target).to_vec();
        (scenario, targets)
    }

    #[test]
    fn the_radar_equation_of_the_points_is_the_echo_of_the_simulator() {
        let (scenario, targets) = everybody();
        let radar = scenario.radar.position_m;
        let lambda = wavelength(scenario.radar.carrier_hz);
        for target in &targets {
            for slot in [0, 137, 999] {
                let time_s = f64::from(slot) * scenario.interval_s();
                let scene = Scene { slot, time_s, from: radar, to: radar, people: &[] };
                let mut paths = Vec::new();
                target.echoes(&scene, lambda, &mut paths);
                for (path, point) in paths.iter().zip(point_targets(target, radar, time_s)) {
                    let distance = norm(sub(point.position_m, radar));
                    let root = libm::pow(10.0, point.rcs_dbsm / 20.0);
                    let amplitude = lambda * root / (libm::pow(4.0 * PI, 1.5) * distance * distance);
                    let gain = carrier_phase(2.0 * distance, lambda)
                        * phasor(point.phase_deg * PI / 180.0)
                        * amplitude;
                    assert!((path.gain - gain).norm() < 1e-9 * amplitude, "{} {gain}", path.gain);
                    assert!((path.delay_s - 2.0 * distance / SPEED_OF_LIGHT).abs() < 1e-18);
                }
            }
        }
    }

    #[test]
    fn velocities_are_those_of_the_positions() {
        let (scenario, targets) = everybody();
        let (radar, h) = (scenario.radar.position_m, 1e-5);
        let mut fastest: f64 = 0.0;
        for target in &targets {
            for step in 0..100 {
                let t = 0.011 + 0.01 * f64::from(step);
                let [before, now, after] = [t - h, t, t + h].map(|t| point_targets(target, radar, t));
                for ((before, now), after) in before.iter().zip(&now).zip(&after) {
                    let secant = sub(after.position_m, before.position_m).map(|d| d / (2.0 * h));
                    // corners in the second derivative of the gait's curves
                    assert!(norm(sub(secant, now.velocity_m_s)) < 0.02, "{t}: {secant:?} {now:?}");
                    fastest = fastest.max(norm(now.velocity_m_s));
                }
            }
        }
        assert!(fastest > 3.0, "nobody moved: {fastest}");
    }

    #[test]
    fn a_table_has_the_points_bit_for_bit() {
        let (scenario, targets) = everybody();
        let mut text = Vec::new();
        write_table(&mut text, &scenario, &targets[3], 0.25, 3).unwrap();
        let text = String::from_utf8(text).unwrap();
        let mut lines = text.lines();
        assert_eq!(lines.next().unwrap(), COLUMNS.join(","));
        for instant in 0..3 {
            let t = 0.25 * f64::from(instant);
            for (part, point) in PARTS.iter().zip(point_targets(&targets[3], scenario.radar.position_m, t)) {
                let cells: Vec<&str> = lines.next().unwrap().split(',').collect();
                let number = |column: usize| cells[column].parse::<f64>().unwrap();
                assert_eq!((number(0), cells[1]), (t, *part));
                assert_eq!([number(2), number(3), number(4)], point.position_m);
                assert_eq!([number(5), number(6), number(7)], point.velocity_m_s);
                assert_eq!([number(8), number(9)], [point.rcs_dbsm, point.phase_deg]);
            }
        }
        assert_eq!(lines.next(), None);
    }

    #[test]
    fn left_parts_are_on_the_left() {
        let (scenario, targets) = everybody();
        let points = point_targets(&targets[0], scenario.radar.position_m, 0.0);
        let heading = targets[0].person.truth.heading_deg * PI / 180.0;
        let left = [-libm::sin(heading), libm::cos(heading), 0.0];
        for (k, part) in PARTS.iter().enumerate().filter(|(_, part)| part.starts_with("left_")) {
            assert_eq!(PARTS[k + 1], part.replace("left_", "right_"));
            let apart = super::super::body::dot(sub(points[k].position_m, points[k + 1].position_m), left);
            assert!(apart > 0.05, "{part}: {apart}");
        }
    }
}
