//! Domain randomisation: people, rooms and sensors drawn so widely that a measured recording is one draw among others.
//!
//! Tobin et al. (2017), for a single-channel Doppler sensor (CW, AC-coupled, real) at any carrier. One draw is one second of
//! somebody walking, running or keeping still; nothing is fitted to a recording.
//!
//! Who walks does 0.45..1.1 heights a second. Who runs does 0.37..1.25 times sqrt(g L), L the leg: people change from one to the
//! other near 0.7 (Froude number 0.5; Alexander 1989), jog indoors as slowly as 4 km/h (slow jogging; Tanaka and Jackowska, 2016), and
//! sprint in no room; their limbs move at least as in a gait of 1.15 heights a second. Rooms up to 8 m by 11 m, any heading, mostly
//! back and forth on the beam's axis.

use super::body::Vec3;
use super::body::motion::{GroundTruth, Person};
use super::calibration::conditioning::ac_couple;
use super::channel::antenna::Antenna;
use super::channel::dahc::Dahc;
use super::channel::response::Response;
use super::channel::target::Target;
use super::channel::{BLOCKS, Blocks, ChannelModel, Complex64, Scene, Sensor, wavelength};
use crate::numerics::filter::high_pass;
use crate::numerics::random::Random;
use crate::scenario::{ArMode, Class, Clusters, Scenario, Tgn};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// The motions of a recording without labels of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Motion {
    /// Walking at any speed.
    Walking,
    /// Running.
    Running,
    /// Standing, sitting: sway and breathing.
    Still,
}

impl Motion {
    /// All; the index is the label.
    pub const ALL: [Motion; 3] = [Motion::Walking, Motion::Running, Motion::Still];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Motion::Walking => "walking",
            Motion::Running => "running",
            Motion::Still => "still",
        }
    }

    /// The adult who moves like this.
    pub fn class(self) -> Class {
        match self {
            Motion::Walking => Class::AdultWalking,
            Motion::Running => Class::AdultRunning,
            Motion::Still => Class::Standing,
        }
    }
}

/// Standard gravity in m/s^2, and the leg in heights.
const GRAVITY: f64 = 9.806_65;
const LEG: f64 = 0.53;
/// Seconds before the window, in which filters settle.
const SETTLE_S: f64 = 0.3;
/// Slots between two changes of the person's pace.
const GROUP: usize = 16;
/// Primitives of head and torso, which come first.
const TORSO: usize = 2;

fn between(random: &mut Random, low: f64, high: f64) -> f64 {
    low + (high - low) * random.uniform()
}

/// Uniform in the logarithm.
fn ratio(random: &mut Random, low: f64, high: f64) -> f64 {
    libm::exp(between(random, libm::log(low), libm::log(high)))
}

/// Symmetric triangular law.
fn triangular(random: &mut Random, low: f64, high: f64) -> f64 {
    low + (high - low) * 0.5 * (random.uniform() + random.uniform())
}

fn bernoulli(random: &mut Random, share: f64) -> bool {
    random.uniform() < share
}

/// A room, its radar at one end, where its walls are seen from, and its rho.
///
/// Walls are seen from 1 m and more off them, as from the paper's radar: the wall at a sensor's back is behind its antenna.
fn room(carrier_hz: f64, rate_hz: f64, random: &mut Random) -> (Scenario, Vec3, f64) {
    let mut scenario = Scenario::default();
    scenario.room.size_m = [between(random, 2.5, 8.0), between(random, 3.0, 11.0), between(random, 2.4, 4.0)];
    scenario.radar.position_m =
        [scenario.room.size_m[0] * between(random, 0.2, 0.8), 0.1, between(random, 0.5, 1.6)];
    scenario.radar.carrier_hz = carrier_hz;
    scenario.frame.slot_s = 1.0 / rate_hz;
    scenario.frame.spacing_slots = 0;
    (scenario.channel.mode, scenario.channel.clusters) = (ArMode::Paper, Clusters::Ieee80211ax);
    (scenario.channel.shadowing, scenario.channel.occlusion) = (false, false);
    scenario.channel.stationary_start = true;
    scenario.channel.tgn = [Tgn::B, Tgn::C, Tgn::D][(3.0 * random.uniform()) as usize];
    let [width, length, _] = scenario.room.size_m;
    let seen_from = [0.5 * width, between(random, 1.0, 0.5 * length), scenario.radar.position_m[2].max(1.0)];
    (scenario, seen_from, 1.0 - ratio(random, 0.001, 0.04))
}

/// Somebody 1 to 8 m away.
fn person(motion: Motion, scenario: &Scenario, random: &mut Random) -> Person {
    let [width, length, _] = scenario.room.size_m;
    let radar = scenario.radar.position_m;
    let child = bernoulli(random, 0.2);
    let height_m = if child { between(random, 0.9, 1.45) } else { between(random, 1.45, 2.0) };
    let (speed, limbs) = match motion {
        Motion::Walking => {
            let speed = triangular(random, 0.45, 1.1);
            (speed, speed)
        }
        Motion::Running => {
            let speed = between(random, 0.37, 1.25) * (GRAVITY * LEG / height_m).sqrt();
            (speed, speed.max(between(random, 1.15, 1.47)))
        }
        Motion::Still => (0.0, 0.0),
    };
    let away = between(random, 1.0, 8.0).min(length - 0.7);
    let aside = radar[0] + away * between(random, -0.4, 0.4);
    let start_m = [aside.clamp(0.6, width - 0.6), radar[1] + away];
    let heading_deg = match (bernoulli(random, 0.25), bernoulli(random, 0.5)) {
        (true, _) => between(random, -180.0, 180.0),
        (_, towards) => between(random, -25.0, 25.0) + if towards { -90.0 } else { 90.0 },
    };
    let truth = GroundTruth {
        class: motion.class(),
        child,
        height_m,
        speed_m_s: speed * height_m,
        heading_deg,
        phase: random.uniform(),
        start_m,
    };
    Person::paced(truth, limbs * height_m, scenario.room.size_m, random)
}

/// What the sensor adds: its own AC coupling, noise, hum, a low-pass and the rails of its amplifier.
fn sense(y: &mut [f64], echo: f64, carried: bool, rate_hz: f64, random: &mut Random) {
    let pole = |hz: f64| libm::exp(-TAU * hz / rate_hz);
    for _ in 0..1 + usize::from(bernoulli(random, 0.5)) {
        high_pass(y, pole(ratio(random, 0.5, 30.0)));
    }
    // white and 1/f-like noise below the echo
    let white = echo * libm::pow(10.0, -between(random, 3.0, 50.0) / 20.0);
    let pink = if bernoulli(random, 0.5) { white * ratio(random, 0.3, 10.0) } else { 0.0 };
    let keep = pole(ratio(random, 1.0, 30.0));
    let mut slow = 0.0;
    for y in y.iter_mut() {
        slow = keep * slow + (1.0 - keep * keep).sqrt() * random.gaussian();
        *y += white * random.gaussian() + pink * slow;
    }
    if bernoulli(random, 0.3) {
        let mains = if bernoulli(random, 0.5) { 50.0 } else { 60.0 };
        for harmonic in 1..=8 {
            let amplitude = white * ratio(random, 0.03, 3.0) / f64::from(harmonic);
            let phase = TAU * random.uniform();
            let step = TAU * mains * f64::from(harmonic) / rate_hz;
            y.iter_mut().enumerate().for_each(|(n, y)| *y += amplitude * libm::cos(step * n as f64 + phase));
        }
    }
    if bernoulli(random, 0.5) {
        let keep = pole(ratio(random, 0.15 * rate_hz, 2.0 * rate_hz));
        let mut state = 0.0;
        for y in y.iter_mut() {
            state = keep * state + (1.0 - keep) * *y;
            *y = state;
        }
    }
    if carried && bernoulli(random, 0.3) {
        let most = y.iter().fold(0.0_f64, |m, y| m.max(y.abs())) * between(random, 0.3, 1.0);
        y.iter_mut().for_each(|y| *y = y.clamp(-most, most));
    }
}

/// One number a time of `people` seen from `from`, in rooms of coefficient `rho`, in the person's own time, AC-coupled.
fn seen(room: &Scenario, rho: f64, view: View, people: &[Target], random: Random) -> Vec<f64> {
    let rate_hz = 1.0 / room.frame.slot_s;
    let mut beats = vec![Blocks::default(); (SETTLE_S * rate_hz) as usize + rate_hz.round() as usize];
    let mut channel = Dahc::new(room, (view.walls, view.walls), rho, random);
    let mut time_s = view.start_s;
    let sensor = Sensor { antenna: Antenna::constant(), response: Response::Paper };
    let groups = beats.len().div_ceil(GROUP) as f64;
    for (k, group) in beats.chunks_mut(GROUP).enumerate() {
        let interval_s = (view.pace[0] + (view.pace[1] - view.pace[0]) * k as f64 / groups) / rate_hz;
        let scene = Scene { slot: 0, time_s, from: view.radar, to: view.radar, people };
        channel.beats(&scene, interval_s, &sensor, group);
        time_s += interval_s * group.len() as f64;
    }
    let mut y: Vec<_> = beats.iter().map(|b| Complex64::new(b[BLOCKS / 2].re, 0.0)).collect();
    ac_couple(&mut y, rate_hz);
    y.iter().map(|z| z.re).collect()
}

/// From where, and when.
#[derive(Clone, Copy)]
struct View {
    /// The radar, or its image in a wall, in m.
    radar: Vec3,
    /// Where the walls are seen from in m.
    walls: Vec3,
    /// Begin in s.
    start_s: f64,
    /// Pace of the person's own time at the begin and at the end: steady, or braking and speeding up.
    pace: [f64; 2],
}

fn rms(y: &[f64]) -> f64 {
    (y.iter().map(|y| y * y).sum::<f64>() / y.len().max(1) as f64).sqrt()
}

/// The `index`-th draw of a motion: one second at `rate_hz`, AC-coupled as measured signals are.
///
/// `set` separates training from testing draws.
pub fn draw(carrier_hz: f64, rate_hz: f64, motion: Motion, seed: u64, set: u64, index: u32) -> Vec<f64> {
    let stream = |part: u64| Random::new(seed, 0x7264 + 16 * set + part, motion as u64, u64::from(index));
    let random = &mut stream(0);
    let (scenario, walls, rho) = room(carrier_hz, rate_hz, random);
    let mut target = Target::new(person(motion, &scenario, random), random);
    // bodies are not sixteen ellipsoids: limbs (after head and torso) echo less or more than those, each a little else
    let limbs = between(random, -12.0, 3.0);
    for (k, weight) in target.weights.iter_mut().enumerate() {
        let db = if k < TORSO { 0.0 } else { limbs } + 3.0 * random.gaussian();
        *weight = libm::pow(10.0, db / 20.0);
    }
    let pace = match bernoulli(random, 0.7) {
        true => [1.0, 1.0],
        false => [between(random, 0.5, 1.1), between(random, 0.5, 1.1)],
    };
    let radar = scenario.radar.position_m;
    let view = View { radar, walls, start_s: between(random, 0.0, 20.0), pace };
    let people = [target];
    // a room of rho = 1 vanishes behind the AC coupling
    let mut y = seen(&scenario, 1.0, view, &people, stream(1));
    // the person up to five times more, by way of walls and furniture, out and back: seen from the radar's image in each, which
    // may lie anywhere around; their Doppler fills what the direct echo leaves empty
    let [width, length, height] = scenario.room.size_m;
    for part in 0..(6.0 * random.uniform()) as u64 {
        let around = [between(random, -1.0, 2.0), between(random, -1.0, 2.0), between(random, -1.0, 2.0)];
        let image = [width * around[0], length * around[1], height * around[2]];
        let share = libm::pow(10.0, -between(random, 0.0, 12.0) / 20.0);
        let ghost = seen(&scenario, 1.0, View { radar: image, ..view }, &people, stream(5 + part));
        y.iter_mut().zip(ghost).for_each(|(y, g)| *y += share * g);
    }
    // what a walker echoes there; who keeps still is measured on 0.73 m^2 (-1.37 dBsm) 2 to 8 m away
    let mut echo = rms(&y);
    if motion == Motion::Still {
        let away = between(random, 2.0, 8.0);
        echo = wavelength(carrier_hz) * (0.73_f64 / 2.0).sqrt() / (libm::pow(4.0 * PI, 1.5) * away * away);
    }
    let wall = seen(&scenario, rho, view, &[], stream(4));
    let level =
        echo * libm::pow(10.0, -between(random, 0.0, 35.0) / 20.0) / rms(&wall).max(f64::MIN_POSITIVE);
    y.iter_mut().zip(wall).for_each(|(y, w)| *y += level * w);
    sense(&mut y, echo, motion != Motion::Still, rate_hz, random);
    let mut z: Vec<_> = y.into_iter().map(|y| Complex64::new(y, 0.0)).collect();
    ac_couple(&mut z, rate_hz);
    z[(SETTLE_S * rate_hz) as usize..].iter().map(|z| z.re).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn draws_are_functions_of_their_coordinates_and_finite() {
        for motion in Motion::ALL {
            let one = draw(24e9, 2000.0, motion, 1, 0, 7);
            assert_eq!(one.len(), 2000);
            assert!(one.iter().all(|y| y.is_finite()) && one.iter().any(|y| *y != 0.0));
            assert_eq!(one, draw(24e9, 2000.0, motion, 1, 0, 7));
            assert_ne!(one, draw(24e9, 2000.0, motion, 1, 1, 7));
        }
    }
}
