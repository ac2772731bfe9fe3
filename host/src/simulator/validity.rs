//! What a scenario can simulate: whether its people and its antenna can be used at all, whether limbs alias, and where the far field begins.

use super::body::capture::{Capture, CaptureError, JOINT_NAMES};
use super::body::gait::joint;
use super::body::trajectory::Trajectory;
use super::body::{norm, sub};
use super::channel::antenna::far_field_m;
use super::channel::{antenna, wavelength};
use crate::error::Invalid;
use crate::scenario::{AntennaPattern, Class, Scenario};
use std::fmt;

/// Deepest below the floor that a joint is captured, and fastest: a sprinter's foot passes 20 m/s.
const FLOOR_M: f64 = 0.3;
const FASTEST_M_S: f64 = 30.0;

/// Why a scenario's people cannot be simulated.
#[derive(Debug, thiserror::Error)]
pub enum CastError {
    /// The antenna's pattern cannot be used.
    #[error(transparent)]
    Antenna(#[from] Invalid),
    /// The motion capture cannot be used.
    #[error("target.capture: {0}")]
    Capture(#[from] CaptureError),
    /// Somebody leaves the room.
    #[error(
        "target.capture = {file}: the body is at x = {x:.2} m, y = {y:.2} m after {time_s:.2} s, outside the room \
         0 to {width} m by 0 to {depth} m; move target.start_m"
    )]
    Outside {
        /// The capture.
        file: String,
        /// Place in m.
        x: f64,
        /// Place in m.
        y: f64,
        /// When, in s.
        time_s: f64,
        /// The room in m.
        width: f64,
        /// The room in m.
        depth: f64,
    },
}

/// Reads what a scenario refers to and walks through it once, before anything is simulated.
///
/// # Errors
///
/// See [`CastError`].
pub fn check(scenario: &Scenario) -> Result<(), CastError> {
    if let Some(file) = &scenario.radar.antenna_table {
        antenna::Table::read(file)?;
    }
    let Some(file) = &scenario.target.capture else { return Ok(()) };
    let capture = Capture::shared(file)?;
    let refuse = |field: &str, value: String, legal: String| {
        Err(CastError::Capture(Invalid::new(field, value, legal).at(file.display()).into()))
    };
    let base = capture.at(0.0).0[joint::BASE];
    let start = scenario.target.begin_m();
    let [width, depth, height] = scenario.room.size_m;
    let slots = scenario.largest_sensing_slots();
    let needed_s = f64::from(slots - 1) * scenario.interval_s();
    if capture.duration_s() < needed_s {
        let value = format!("{:.3} s", capture.duration_s());
        return refuse("duration", value, format!("{needed_s:.3} s and more: {slots} sensing slots"));
    }
    for slot in 0..slots {
        let time_s = f64::from(slot) * scenario.interval_s();
        let (places, velocities) = capture.at(time_s);
        let now = places[joint::BASE];
        let (x, y) = (start[0] + now[0] - base[0], start[1] + now[1] - base[1]);
        if !(0.0..=width).contains(&x) || !(0.0..=depth).contains(&y) {
            let file = file.display().to_string();
            return Err(CastError::Outside { file, x, y, time_s, width, depth });
        }
        for ((name, place), velocity) in JOINT_NAMES.iter().zip(places).zip(velocities) {
            if !(-FLOOR_M..=height).contains(&place[2]) {
                let value = format!("{:.2} m at {time_s:.3} s", place[2]);
                return refuse(&format!("{name} z"), value, format!("from the floor, z = 0, to {height} m"));
            }
            if norm(velocity) > FASTEST_M_S {
                let value = format!("{:.1} m/s at {time_s:.3} s", norm(velocity));
                return refuse(&format!("{name} speed"), value, format!("at most {FASTEST_M_S} m/s"));
            }
        }
    }
    Ok(())
}

/// A scenario with limbs that move faster than the sensing slots can follow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aliasing {
    /// Fastest limb in m/s.
    pub limb_m_s: f64,
    /// Fastest unambiguous speed in m/s.
    pub unambiguous_m_s: f64,
    /// Largest N_m that would not alias, if any.
    pub spacing_slots: Option<u32>,
}

impl fmt::Display for Aliasing {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let [limb, limit] = [self.limb_m_s, self.unambiguous_m_s];
        write!(f, "limbs at {limb:.1} m/s alias above {limit:.1} m/s at this carrier and spacing; ")?;
        match self.spacing_slots {
            Some(n) => write!(f, "frame.spacing_slots = {n} would not"),
            None => f.write_str("no spacing of these slots would not"),
        }
    }
}

/// Fastest limb of a class over its height, in 1/s: the toes, 4.9 times as fast as the body of who walks, 3.2 times as fast as of who runs.
fn limb_pace(class: Class) -> f64 {
    match class {
        Class::ChildRunning | Class::AdultRunning => 3.2 * 1.3,
        _ => 4.9 * 0.5,
    }
}

/// Compares the fastest limb of these classes, and of further people, with lambda PRF / 4.
pub fn aliasing(scenario: &Scenario, classes: &[Class]) -> Option<Aliasing> {
    let others = scenario.target.others.iter().map(|other| other.class);
    let pace = classes.iter().copied().chain(others).map(limb_pace).fold(0.0, f64::max);
    let limb_m_s = pace * scenario.target.adult_height_m[1];
    let limit = |interval: f64| wavelength(scenario.radar.centre_hz()) / (4.0 * interval);
    let unambiguous_m_s = limit(scenario.interval_s());
    if limb_m_s <= unambiguous_m_s {
        return None;
    }
    let fits = |spacing: &u32| limb_m_s <= limit(scenario.frame.slot_s * f64::from(spacing + 1));
    let spacing_slots = (0..scenario.frame.spacing_slots).rev().find(fits);
    Some(Aliasing { limb_m_s, unambiguous_m_s, spacing_slots })
}

/// How near a person comes to the radar, and where its antenna's far field begins, in m: the antenna's pattern and the radar equation
/// hold beyond. `None` where the whole walk is in the far field, or where the antenna has no pattern.
pub fn near_field(scenario: &Scenario) -> Option<[f64; 2]> {
    let radar = &scenario.radar;
    let far = far_field_m(radar.antenna_gain_db, radar.carrier_hz);
    let target = &scenario.target;
    let [x, y] = target.begin_m();
    let start = norm(sub([x, y, 1.0], radar.position_m));
    let speed_m_s = 0.5 * target.adult_height_m[1];
    let time_s = |slot: u32| f64::from(slot) * scenario.interval_s();
    let slots = scenario.largest_sensing_slots();
    let nearest = match target.waypoints_m.len() {
        0 | 1 => (start - speed_m_s * time_s(slots)).max(0.0),
        _ => {
            let path = Trajectory::through(&target.waypoints_m, speed_m_s);
            let at = |slot: u32| {
                let [x, y, ..] = path.at(time_s(slot));
                norm(sub([x, y, 1.0], radar.position_m))
            };
            (0..slots).map(at).fold(start, f64::min)
        }
    };
    (radar.antenna_pattern != AntennaPattern::Constant && nearest < far).then_some([nearest, far])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulator::channel::Sensor;

    #[test]
    fn a_walk_along_way_points_is_seen_from_its_beginning() {
        let mut scenario = Scenario::default();
        let nearest =
            |scenario: &Scenario| near_field(scenario).map_or(f64::INFINITY, |[nearest, _]| nearest);
        assert!(nearest(&scenario) > 2.0);
        // past the radar at (1.5, 1) and away from it
        scenario.target.waypoints_m = vec![[0.9, 1.3], [2.5, 1.3]];
        assert!((0.25..0.4).contains(&nearest(&scenario)), "{}", nearest(&scenario));
        let towards = Sensor::of(&scenario).antenna.boresight();
        assert!(towards[0] < -0.8 && towards[1] > 0.4, "{towards:?}");
    }

    #[test]
    fn high_carriers_alias_and_three_and_a_half_gigahertz_do_not() {
        let mut scenario = Scenario::default();
        assert_eq!(aliasing(&scenario, &Class::ALL), None);
        scenario.radar.carrier_hz = 60e9;
        // toes at 4.66 m/s: 5 m/s are unambiguous with every slot sensing
        let spacing = |scenario: &Scenario, classes: &[Class]| {
            aliasing(scenario, classes).and_then(|aliasing| aliasing.spacing_slots)
        };
        assert_eq!(spacing(&scenario, &Class::ALL), Some(0));
        scenario.radar.carrier_hz = 24e9;
        assert_eq!(spacing(&scenario, &Class::ALL), Some(1));
        // who runs has faster toes
        assert_eq!(spacing(&scenario, &[Class::AdultRunning]), Some(0));
        scenario.frame.spacing_slots = 1;
        assert_eq!(aliasing(&scenario, &Class::ALL), None);
        assert!(aliasing(&scenario, &[Class::AdultRunning]).is_some());
    }
}
