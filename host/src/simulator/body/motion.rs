//! A person in the room: who, where to, how fast; joints and primitives at any time, with exact velocities.
//!
//! Walking is 0.5 H m/s, pacing the same gait at half that speed, running 1.3 H m/s (RV = 2.65, within the model's 3),
//! stepping the walk's angles on the spot, standing the gait's pose at rest with sway and breathing. Whoever comes near a
//! wall turns along an arc and walks on. Other motions are made on the spot ([`activity`](super::activity)), far enough from walls.

use super::activity::Activity;
use super::capture::Capture;
use super::gait::{Gait, JOINTS, Segments, joint};
use super::number::{Dual, Real};
use super::primitives::{PRIMITIVES, Primitive, primitives};
use super::trajectory::Trajectory;
use super::{Vec3, add, scale};
use crate::numerics::random::Random;
use crate::scenario::{Class, Target};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use std::sync::Arc;

/// What is true of a recording.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct GroundTruth {
    /// How it moves.
    pub class: Class,
    /// Whether a child moves.
    pub child: bool,
    /// Height in m.
    pub height_m: f64,
    /// Walking speed in m/s, 0 standing or stepping on the spot.
    pub speed_m_s: f64,
    /// Heading at the start in degrees, counter-clockwise from the x axis.
    pub heading_deg: f64,
    /// Phase of the gait at the start, 0..1.
    pub phase: f64,
    /// Ground position at the start in m.
    pub start_m: [f64; 2],
}

impl GroundTruth {
    /// An adult of this height who stands and looks along the x axis.
    pub fn standing(height_m: f64, start_m: [f64; 2]) -> Self {
        let class = Class::Standing;
        GroundTruth { class, child: false, height_m, speed_m_s: 0.0, heading_deg: 0.0, phase: 0.0, start_m }
    }
}

/// Sway and breathing of who stands: (frequency in Hz, phase in turns).
#[derive(Debug, Clone)]
struct Rest {
    sway: [(f64, f64); 2],
    breath: (f64, f64),
}

#[derive(Debug, Clone)]
enum Motion {
    Walking,
    /// The gait's rest pose.
    Standing(Rest),
    /// Another motion, with the sway of who stands.
    Acting(Box<Activity>, Rest),
    /// Joints from a file, its first base at the start position.
    Captured {
        capture: Arc<Capture>,
        offset: [f64; 2],
    },
}

#[derive(Debug, Clone)]
pub struct Person {
    /// What is true of it.
    pub truth: GroundTruth,
    motion: Motion,
    gait: Gait,
    segments: Segments,
    trajectory: Trajectory,
    pelvis: f64,
}

/// Amplitude of the chest's breathing in m: 5 mm from in to out.
const BREATH_M: f64 = 0.0025;
/// Amplitude of each of the two sways in m; with the breath, no point strays 1 cm from where it first was.
const SWAY_M: f64 = 0.001_5;
/// Distance to the walls at which a walker turns, in m; smaller for who starts nearer.
const TURN_M: f64 = 0.65;
/// Seconds for which a walk is drawn; afterwards it goes straight on.
const DRAWN_S: f64 = 120.0;

/// Distance to the walls which no joint comes nearer in a motion on the spot, in m.
const WALL_M: f64 = 0.05;
/// Seconds before and after the beginning of a recording in which such a motion has its whole extent, and the step between looks.
const EXTENT_S: [f64; 2] = [-1.5, 4.5];
const LOOK_S: f64 = 0.05;

/// Walking speed of a class in heights per second.
fn pace(class: Class) -> f64 {
    match class {
        Class::Standing
        | Class::SittingDown
        | Class::StandingUp
        | Class::Falling
        | Class::Bending
        | Class::Waving
        | Class::Jumping => 0.0,
        Class::ChildWalking | Class::AdultWalking | Class::ChildStepping | Class::AdultStepping => 0.5,
        Class::ChildPacing | Class::AdultPacing => 0.25,
        Class::ChildRunning | Class::AdultRunning => 1.3,
    }
}

impl Person {
    /// Draws a person of a class: height, speed, heading around the direction to the radar, phase.
    pub fn draw(class: Class, target: &Target, room: Vec3, radar: Vec3, random: &mut Random) -> Self {
        let child = class.child().unwrap_or_else(|| random.uniform() < 0.5);
        let [low, high] = if child { target.child_height_m } else { target.adult_height_m };
        let height_m = low + (high - low) * random.uniform();
        let jitter = 1.0 + target.speed_jitter * random.gaussian().clamp(-3.0, 3.0);
        let stride_m_s = jitter * pace(class) * height_m;
        let [x, y] = target.begin_m();
        let towards = libm::atan2(radar[1] - y, radar[0] - x) * 180.0 / PI;
        let heading_deg = towards + target.heading_spread_deg * (2.0 * random.uniform() - 1.0);
        let phase = random.uniform();
        let speed_m_s = if class.on_the_spot() { 0.0 } else { stride_m_s };
        let truth = GroundTruth { class, child, height_m, speed_m_s, heading_deg, phase, start_m: [x, y] };
        let mut person = Self::striding(truth, stride_m_s, room, target.turns, random);
        if target.waypoints_m.len() > 1 && speed_m_s > 0.0 {
            person.trajectory = Trajectory::through(&target.waypoints_m, speed_m_s);
            let [.., c, s] = person.trajectory.at(0.0);
            person.truth.heading_deg = libm::atan2(s, c) * 180.0 / PI;
        }
        person
    }

    /// A person of whom everything is known but the sway, in a room of this size.
    pub fn new(truth: GroundTruth, room: Vec3, random: &mut Random) -> Self {
        let stride =
            if truth.class.on_the_spot() { pace(truth.class) * truth.height_m } else { truth.speed_m_s };
        Self::striding(truth, stride, room, true, random)
    }

    /// As [`Person::new`], with the limbs of a gait of another speed: who brakes or runs in a small room moves them faster than
    /// the body.
    pub fn paced(truth: GroundTruth, stride_m_s: f64, room: Vec3, random: &mut Random) -> Self {
        Self::striding(truth, stride_m_s, room, true, random)
    }

    fn striding(truth: GroundTruth, stride_m_s: f64, room: Vec3, turns: bool, random: &mut Random) -> Self {
        let gait = Gait::new(truth.height_m, stride_m_s / (0.491 * truth.height_m));
        let mut wave = |low: f64, high: f64| (low + (high - low) * random.uniform(), random.uniform());
        let (breath, first, second) = (wave(0.2, 0.35), wave(0.15, 0.4), wave(0.4, 0.9));
        let heading = truth.heading_deg * PI / 180.0;
        let borders = std::array::from_fn(|axis| {
            let (start, size) = (truth.start_m[axis], room[axis]);
            [TURN_M.min(start), (size - TURN_M).max(start)]
        });
        let trajectory =
            Trajectory::bouncing(truth.start_m, heading, truth.speed_m_s, DRAWN_S, borders, turns);
        let segments = *gait.segments();
        let rest = Rest { sway: [first, second], breath };
        let motion = match Activity::draw(truth.class, truth.height_m, &segments, random) {
            Some(activity) => Motion::Acting(Box::new(activity), rest),
            None if stride_m_s > 0.0 => Motion::Walking,
            None => Motion::Standing(rest),
        };
        // hip joints stand a leg and the ankle's height above the ground
        let pelvis = 0.53 * truth.height_m;
        let person = Person { pelvis, segments, motion, gait, trajectory, truth };
        match person.motion {
            Motion::Acting(..) => person.away_from_walls(room),
            _ => person,
        }
    }

    /// Starts further from a wall which a joint would touch; in the middle where there is no room.
    fn away_from_walls(mut self, room: Vec3) -> Self {
        let looks = ((EXTENT_S[1] - EXTENT_S[0]) / LOOK_S) as u32;
        let joints = (0..=looks).flat_map(|k| self.joints(EXTENT_S[0] + LOOK_S * f64::from(k)));
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for at in joints {
            for axis in 0..2 {
                (low[axis], high[axis]) = (low[axis].min(at[axis]), high[axis].max(at[axis]));
            }
        }
        for axis in 0..2 {
            let [back, on] = [WALL_M - low[axis], room[axis] - WALL_M - high[axis]];
            self.truth.start_m[axis] += if back > on { 0.5 * (back + on) } else { 0.0_f64.clamp(back, on) };
        }
        self.trajectory = Trajectory::standing(self.truth.start_m, self.truth.heading_deg * PI / 180.0);
        self
    }

    /// A person that moves as a file says; the joints' first base stands at `truth.start_m`.
    pub fn captured(mut truth: GroundTruth, capture: Arc<Capture>) -> Self {
        truth.height_m = capture.height_m();
        let gait = Gait::new(truth.height_m, 1.0);
        let [base, last] = [0.0, capture.duration_s()].map(|t| capture.at(t).0[joint::BASE]);
        let (east, north) = (last[0] - base[0], last[1] - base[1]);
        // on average, from the first place to the last
        truth.speed_m_s = libm::hypot(east, north) / capture.duration_s();
        truth.heading_deg = libm::atan2(north, east) * 180.0 / PI;
        let offset = [truth.start_m[0] - base[0], truth.start_m[1] - base[1]];
        Person {
            pelvis: 0.0,
            segments: capture.segments(),
            trajectory: Trajectory::standing(truth.start_m, 0.0),
            motion: Motion::Captured { capture, offset },
            gait,
            truth,
        }
    }

    /// Joints at `t` seconds, in the room's coordinates.
    #[inline(always)]
    pub fn joints<R: Real>(&self, t: R) -> [Vec3<R>; JOINTS] {
        let (pose, offset) = match &self.motion {
            Motion::Captured { capture, offset } => return captured(capture, *offset, t),
            Motion::Acting(activity, rest) => {
                let [ahead, aside, _] = rest.sway(t);
                (activity.joints(t), [ahead, aside, R::of(-self.pelvis)])
            }
            Motion::Walking => {
                let phase = t.times(1.0 / self.gait.cycle_s()).plus(self.truth.phase);
                let shift = scale(self.gait.translation(phase), R::of(self.segments.leg()));
                (self.gait.pose(phase), shift)
            }
            Motion::Standing(rest) => self.resting(rest, t),
        };
        let [x, y, c, s] = self.trajectory.at(t);
        let place = [x, y, R::of(self.pelvis)];
        let mut joints = pose;
        for joint in &mut joints {
            let [x, y, z] = add(*joint, offset);
            *joint = add(place, [c * x - s * y, s * x + c * y, z]);
        }
        joints
    }

    #[inline(always)]
    fn resting<R: Real>(&self, rest: &Rest, t: R) -> ([Vec3<R>; JOINTS], Vec3<R>) {
        let mut pose = self.gait.pose(0.25).map(|p| p.map(R::of));
        let chest = wave(BREATH_M, rest.breath, t);
        for j in [joint::NECK, joint::SHOULDER, joint::SHOULDER + 1] {
            pose[j][0] = pose[j][0] + chest;
        }
        (pose, rest.sway(t))
    }

    /// Positions in m and velocities in m/s of the joints: the derivative of the formulas, not of samples.
    pub fn kinematics(&self, t: f64) -> [(Vec3, Vec3); JOINTS] {
        self.joints(Dual::variable(t)).map(|p| (p.map(|x| x.value), p.map(|x| x.rate)))
    }

    pub fn segments(&self) -> &Segments {
        &self.segments
    }

    /// Primitives at `t` seconds.
    pub fn primitives<R: Real>(&self, t: R) -> [Primitive<R>; PRIMITIVES] {
        primitives(&self.joints(t), &self.segments, self.truth.height_m)
    }
}

/// A sine of this amplitude, and (frequency in Hz, phase in turns).
#[inline(always)]
fn wave<R: Real>(amplitude: f64, (hz, phase): (f64, f64), t: R) -> R {
    t.times(hz).plus(phase).sin_cos_turns().0.times(amplitude)
}

impl Rest {
    /// Offset of the whole body in m.
    #[inline(always)]
    fn sway<R: Real>(&self, t: R) -> Vec3<R> {
        let [ahead, aside] = self.sway;
        [wave(SWAY_M, ahead, t), wave(SWAY_M, aside, t), R::of(0.0)]
    }
}

fn captured<R: Real>(capture: &Capture, offset: [f64; 2], t: R) -> [Vec3<R>; JOINTS] {
    const K: usize = 3 * JOINTS;
    let flat: [R; K] = t.lift(|t| {
        let (position, velocity) = capture.at(t);
        let flat = |p: [Vec3; JOINTS]| std::array::from_fn(|k| p[k / 3][k % 3]);
        (flat(position), flat(velocity))
    });
    std::array::from_fn(|j| [flat[3 * j].plus(offset[0]), flat[3 * j + 1].plus(offset[1]), flat[3 * j + 2]])
}

#[cfg(test)]
mod tests {
    use super::super::{norm, sub};
    use super::*;

    fn person(class: Class, speed_m_s: f64) -> Person {
        let truth = GroundTruth {
            class,
            child: false,
            height_m: 1.75,
            speed_m_s,
            heading_deg: 90.0,
            phase: 0.3,
            start_m: [1.0, 1.0],
        };
        Person::new(truth, [3.0, 4.5, 3.0], &mut Random::new(1, 0, 0, 0))
    }

    #[test]
    fn a_walker_advances_at_its_speed_along_its_heading() {
        let walker = person(Class::AdultWalking, 0.875);
        let cycle = walker.gait.cycle_s();
        let (a, b) = (walker.joints(0.0), walker.joints(cycle));
        for (a, b) in a.iter().zip(&b) {
            assert!((b[1] - a[1] - 0.875 * cycle).abs() < 1e-9 && (b[0] - a[0]).abs() < 1e-9);
        }
    }

    #[test]
    fn who_stands_moves_less_than_a_centimetre_and_who_steps_stays() {
        let standing = person(Class::Standing, 0.0);
        let first = standing.joints(0.0);
        for step in 1..500 {
            let now = standing.joints(0.02 * f64::from(step));
            for (a, b) in first.iter().zip(&now) {
                assert!(norm(sub(*a, *b)) < 0.01);
            }
        }
        let stepping = person(Class::AdultStepping, 0.0);
        let cycle = stepping.gait.cycle_s();
        let reach = |t: f64| norm(sub(stepping.joints(t)[joint::TOE], stepping.joints(0.0)[joint::TOE]));
        assert!(reach(0.5 * cycle) > 0.1 && reach(cycle) < 1e-9);
    }

    #[test]
    fn velocities_are_the_derivatives_of_positions() {
        let h = 1e-5;
        for (class, speed) in [
            (Class::Standing, 0.0),
            (Class::AdultWalking, 0.875),
            (Class::AdultPacing, 0.4),
            (Class::AdultStepping, 0.0),
            (Class::AdultRunning, 2.3),
            (Class::StandingUp, 0.0),
            (Class::Falling, 0.0),
            (Class::Jumping, 0.0),
        ] {
            let person = person(class, speed);
            for step in 0..400 {
                let t = 0.011 + 0.02 * f64::from(step);
                let (before, after) = (person.joints(t - h), person.joints(t + h));
                for (j, (_, velocity)) in person.kinematics(t).iter().enumerate() {
                    let secant = sub(after[j], before[j]).map(|d| d / (2.0 * h));
                    // the gait's curves have corners in their second derivative
                    let error = norm(sub(secant, *velocity));
                    assert!(error < 0.02, "{class:?} joint {j} t {t}: {secant:?} {velocity:?}");
                }
            }
        }
    }

    #[test]
    fn toes_are_almost_five_times_as_fast_as_the_body() {
        let walker = person(Class::AdultWalking, 1.0);
        let speed = |n: u32| walker.kinematics(f64::from(n) * 1e-3)[joint::TOE].1[1];
        let fastest = (0..1250).map(speed).fold(0.0, f64::max);
        assert!((fastest - 4.9).abs() < 0.1, "{fastest}");
    }

    #[test]
    fn a_body_reflects_like_a_human() {
        // 3GPP TR 38.901 clause 7.9.2: an adult's mean cross section is -1.37 dBsm
        let standing = person(Class::Standing, 0.0);
        let primitives = standing.primitives(0.0);
        let total = |degrees: i32| -> f64 {
            let angle = f64::from(degrees) * PI / 180.0;
            let radar = [1.0 + 3.0 * libm::cos(angle), 1.0 + 3.0 * libm::sin(angle), 1.0];
            primitives.iter().map(|p| p.cross_section(radar)).sum()
        };
        let mean = (0..360).step_by(5).map(total).sum::<f64>() / 72.0;
        let dbsm = 10.0 * libm::log10(mean);
        assert!((dbsm + 1.37).abs() < 3.0, "{dbsm}");
    }

    #[test]
    fn feet_are_on_the_ground_and_nobody_leaves_the_room() {
        let walker = person(Class::AdultWalking, 0.9);
        for step in 0..3000 {
            let joints = walker.joints(0.02 * f64::from(step));
            let lowest = joints.iter().map(|j| j[2]).fold(f64::INFINITY, f64::min);
            assert!((-0.03..0.12).contains(&lowest), "{lowest}");
            let inside = |j: &Vec3| (0.0..=3.0).contains(&j[0]) && (0.0..=4.5).contains(&j[1]);
            assert!(joints.iter().all(inside), "{step}: {joints:?}");
        }
    }
}
