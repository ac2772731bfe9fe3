//! A person in the room: who, where to, how fast; joint positions at any time.
//!
//! Walking is 0.5 H m/s, pacing the same gait at half that speed, standing the gait's pose at rest with sway and breathing.

use super::gait::{Gait, JOINTS, joint};
use super::primitives::{PRIMITIVES, Primitive, primitives};
use super::{Vec3, add, scale};
use crate::scenario::{Class, Target};
use crate::simulator::random::Random;
use serde::Serialize;
use std::f64::consts::{PI, TAU};

/// What is true of a recording.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Truth {
    /// The motion.
    pub class: Class,
    /// Whether a child moves.
    pub child: bool,
    /// Height in m.
    pub height_m: f64,
    /// Walking speed in m/s, 0 standing.
    pub speed_m_s: f64,
    /// Heading in degrees, counter-clockwise from the x axis.
    pub heading_deg: f64,
    /// Phase of the gait at the start, 0..1.
    pub phase: f64,
    /// Ground position at the start in m.
    pub start_m: [f64; 2],
}

/// A moving person.
#[derive(Debug, Clone)]
pub struct Person {
    /// What is true of it.
    pub truth: Truth,
    gait: Gait,
    pelvis: f64,
    sway: [(f64, f64, f64); 2],
    breath: (f64, f64),
}

/// Amplitude of the chest's breathing in m.
const BREATH_M: f64 = 0.0025;
/// Amplitude of each of the two sways in m; together below 1 cm.
const SWAY_M: f64 = 0.003;

impl Person {
    /// Draws a person of a class: height, speed, heading around the direction to the radar, phase.
    pub fn draw(class: Class, target: &Target, radar: Vec3, random: &mut Random) -> Self {
        let child = match class {
            Class::Standing => random.uniform() < 0.5,
            Class::ChildWalking | Class::ChildPacing => true,
            Class::AdultWalking | Class::AdultPacing => false,
        };
        let [low, high] = if child { target.child_height_m } else { target.adult_height_m };
        let height_m = low + (high - low) * random.uniform();
        let jitter = 1.0 + target.speed_jitter * random.gaussian().clamp(-3.0, 3.0);
        let speed_m_s = jitter
            * match class {
                Class::Standing => 0.0,
                Class::ChildWalking | Class::AdultWalking => 0.5 * height_m,
                Class::ChildPacing | Class::AdultPacing => 0.25 * height_m,
            };
        let [x, y] = target.start_m;
        let towards = libm::atan2(radar[1] - y, radar[0] - x) * 180.0 / PI;
        let heading_deg = towards + target.heading_spread_deg * (2.0 * random.uniform() - 1.0);
        let phase = random.uniform();
        let start_m = target.start_m;
        let truth = Truth { class, child, height_m, speed_m_s, heading_deg, phase, start_m };
        Self::new(truth, random)
    }

    /// A person of whom everything is known but the sway.
    pub fn new(truth: Truth, random: &mut Random) -> Self {
        let gait = Gait::new(truth.height_m, truth.speed_m_s / (0.491 * truth.height_m));
        let mut wave = |low: f64, high: f64| (low + (high - low) * random.uniform(), random.uniform());
        let (breath, first, second) = (wave(0.2, 0.35), wave(0.15, 0.4), wave(0.4, 0.9));
        Person {
            // hip joints stand a leg and the ankle's height above the ground
            pelvis: 0.53 * truth.height_m,
            gait,
            sway: [(SWAY_M, first.0, first.1), (SWAY_M, second.0, second.1)],
            breath,
            truth,
        }
    }

    /// Joints at `t` seconds, in the room's coordinates.
    pub fn joints(&self, t: f64) -> [Vec3; JOINTS] {
        let truth = &self.truth;
        let heading = truth.heading_deg * PI / 180.0;
        let (s, c) = (libm::sin(heading), libm::cos(heading));
        let place = [truth.start_m[0], truth.start_m[1], self.pelvis];
        let (mut pose, offset) = if truth.speed_m_s > 0.0 {
            let phase = truth.phase + t / self.gait.cycle_s();
            let shift = scale(self.gait.translation(phase), self.gait.segments().leg());
            (self.gait.pose(phase), add(shift, [truth.speed_m_s * t, 0.0, 0.0]))
        } else {
            let mut offset = [0.0; 3];
            for (axis, (amplitude, hz, phase)) in self.sway.iter().enumerate() {
                offset[axis] = amplitude * libm::sin(TAU * (hz * t + phase));
            }
            (self.gait.pose(0.25), offset)
        };
        if truth.speed_m_s <= 0.0 {
            let chest = BREATH_M * libm::sin(TAU * (self.breath.0 * t + self.breath.1));
            for j in [joint::NECK, joint::SHOULDER, joint::SHOULDER + 1] {
                pose[j][0] += chest;
            }
        }
        pose.map(|p| {
            let [x, y, z] = add(p, offset);
            add(place, [c * x - s * y, s * x + c * y, z])
        })
    }

    /// Primitives at `t` seconds.
    pub fn primitives(&self, t: f64) -> [Primitive; PRIMITIVES] {
        primitives(&self.joints(t), self.gait.segments(), self.truth.height_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn person(speed_m_s: f64) -> Person {
        let truth = Truth {
            class: Class::AdultWalking,
            child: false,
            height_m: 1.75,
            speed_m_s,
            heading_deg: 90.0,
            phase: 0.3,
            start_m: [1.0, 1.0],
        };
        Person::new(truth, &mut Random::new(1, 0, 0, 0))
    }

    #[test]
    fn a_walker_advances_at_its_speed_along_its_heading() {
        let walker = person(0.875);
        let cycle = walker.gait.cycle_s();
        let (a, b) = (walker.joints(0.0), walker.joints(cycle));
        for (a, b) in a.iter().zip(&b) {
            assert!((b[1] - a[1] - 0.875 * cycle).abs() < 1e-9 && (b[0] - a[0]).abs() < 1e-9);
        }
    }

    #[test]
    fn who_stands_moves_less_than_a_centimetre() {
        let standing = person(0.0);
        let first = standing.joints(0.0);
        for step in 1..500 {
            let now = standing.joints(0.02 * f64::from(step));
            for (a, b) in first.iter().zip(&now) {
                assert!(super::super::norm(super::super::sub(*a, *b)) < 0.02);
            }
        }
    }

    #[test]
    fn feet_are_on_the_ground() {
        let walker = person(0.9);
        for step in 0..100 {
            let joints = walker.joints(0.02 * f64::from(step));
            let lowest = joints.iter().map(|j| j[2]).fold(f64::INFINITY, f64::min);
            assert!((-0.03..0.12).contains(&lowest), "{lowest}");
        }
    }
}
