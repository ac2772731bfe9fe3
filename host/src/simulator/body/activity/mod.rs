//! Motions of an adult besides walking: sitting down, standing up, falling, bending, waving and jumping.
//!
//! Joint angles are functions of time, joints follow by forward kinematics with rigid segments, velocities are exact. What
//! differs from person to person is drawn. A movement that is made once has its middle, or its impact, in the first second;
//! one that is repeated goes on for the whole recording. Sources:
//!
//! - Sitting down and standing up: joint angles of least jerk through a posture in between (Flash and Hogan 1985; Yamasaki,
//!   Nakamura, Nagasaki 2014, J. Biomedical Science and Engineering 7(7)). The trunk flexes, then hips and knees extend
//!   (Schenkman et al. 1990); the hips leave the seat after 32 % of the time, as measured with much flexion of the trunk
//!   (Scarborough et al. 2007, J. Rehabilitation Research and Development 44(1)). It takes 1.7 to 2.3 s at a natural speed
//!   (Arch. Physical Medicine and Rehabilitation 74(10), 1993, 1095), here 1.5 to 3 s; a chair is 0.44 m high (Wheeler et al.
//!   1985). How far the trunk leans is an assumption. Sitting down is standing up with time reversed.
//! - Falling: an inverted pendulum with knees that give way and a trunk that is held back. The pelvis meets the floor at 2.14
//!   +- 0.63 m/s in 25 falls of older adults, 16 % slower than young adults' in laboratories, 0.58 +- 0.26 s after the descent
//!   began (Choi, Wakeling, Robinovitch 2015, J. Biomechanics 48).
//! - Jumping: a countermovement, then a flight of 2 v / g with v = sqrt(2 g h), and a landing (phases: McMahon et al. 2018,
//!   Strength and Conditioning J. 40(4)). Ranges are assumptions.
//! - Bending: the trunk flexes and extends with least jerk, hips move back. Range and duration are assumptions.
//! - Waving: the forearm swings about the elbow. Rate, range and position of the arm are assumptions.

mod posture;
mod timing;

#[cfg(test)]
mod tests;

use super::Vec3;
use super::limbs::{JOINTS, Segments, joint};
use super::number::{Dual, Real};
use crate::numerics::random::Random;
use crate::scenario::Class;
use posture::{Frame, Posture, STANDING_DEG};
use std::f64::consts::PI;
use timing::{Curve, dropped, ease, repeated};

/// Standard gravity in m/s^2.
const GRAVITY: f64 = 9.806_65;
/// When the movement's middle comes, in s.
const MIDDLE_S: [f64; 2] = [0.3, 0.7];
/// When a fall's impact comes, in s.
const IMPACT_S: [f64; 2] = [0.5, 0.9];
/// Share of the time of standing up after which the hips leave the seat.
const LIFT_OFF: f64 = 0.32;
/// Share of it after which the trunk leans most.
const MOST_LEAN: f64 = 0.4;
/// Hips above the seat, in heights.
const HIPS_ABOVE_SEAT: f64 = 0.05;
/// Length of the leg at take-off and landing, and most in flight, relative to a straight one: ankles and toes stretch too.
const TAKE_OFF: f64 = 0.94;
const STRETCHED: f64 = 0.99;

/// One adult's motion.
#[derive(Debug, Clone)]
pub struct Activity {
    kind: Kind,
    frame: Frame,
    segments: Segments,
}

#[derive(Debug, Clone)]
enum Kind {
    Rise(Rise),
    Fall(Fall),
    Bend(Bend),
    Wave(Wave),
    Jump(Jump),
}

/// Between sitting and standing.
#[derive(Debug, Clone)]
struct Rise {
    /// Standing up; else sitting down.
    up: bool,
    middle_s: f64,
    duration_s: f64,
    /// Thigh and shank in sitting, and most of the lean, in degrees.
    thigh: f64,
    shank: f64,
    lean: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Side {
    Forward,
    Backward,
    Left,
    Right,
}

#[derive(Debug, Clone)]
struct Fall {
    side: Side,
    impact_s: f64,
    /// From the begin to the impact.
    duration_s: f64,
    /// Knees at the impact, or halfway to it in falling forward, in degrees.
    knees: f64,
    /// Trunk at the impact of the pelvis, held back from the floor, in degrees, and the time in which it follows, in s.
    held: f64,
    follows_s: f64,
}

#[derive(Debug, Clone)]
struct Bend {
    start_s: f64,
    /// Of the way down, and of the way up.
    way_s: f64,
    /// At the lowest.
    hold_s: f64,
    period_s: f64,
    lean: f64,
    knees: f64,
}

#[derive(Debug, Clone)]
struct Wave {
    /// Index of the arm.
    arm: usize,
    rate_hz: f64,
    /// At the begin, in turns.
    phase: f64,
    shoulder: f64,
    /// Middle of the elbow's angle, and how far it goes to either side.
    elbow: [f64; 2],
}

#[derive(Debug, Clone)]
struct Jump {
    start_s: f64,
    period_s: f64,
    /// End of the way down; begin and end of the way up after landing.
    crouched_s: f64,
    rising_s: [f64; 2],
    /// Of the leg, relative to a straight one, from the crouch to the lowest after landing.
    length: Curve,
    /// Of the ankles above the floor, in m.
    flight: Curve,
    lean: Curve,
    shoulder: Curve,
    toes: Curve,
}

impl Activity {
    /// Draws the motion of an adult of height `height_m`; `None` for the classes of [`Gait`](super::gait::Gait).
    pub fn draw(class: Class, height_m: f64, segments: &Segments, random: &mut Random) -> Option<Self> {
        let mut draw = |[low, high]: [f64; 2]| low + (high - low) * random.uniform();
        let mut frame = Frame {
            arm_planes: [0.0; 2],
            falls: [0.0, 1.0],
            // hip joints stand a leg and the ankle's height above the ground
            ankle_m: 0.53 * height_m - segments.leg(),
        };
        let kind = match class {
            Class::SittingDown | Class::StandingUp => {
                let seat_m = draw([0.42, 0.50]);
                let shank = draw([0.0, 15.0]);
                let drop = seat_m + HIPS_ABOVE_SEAT * height_m
                    - frame.ankle_m
                    - segments.shank * libm::cos(shank * PI / 180.0);
                Kind::Rise(Rise {
                    up: class == Class::StandingUp,
                    middle_s: draw(MIDDLE_S),
                    duration_s: draw([1.5, 3.0]),
                    thigh: libm::acos((drop / segments.thigh).clamp(-0.5, 0.9)) * 180.0 / PI,
                    shank,
                    lean: draw([30.0, 45.0]),
                })
            }
            Class::Falling => {
                let (side, knees) = match draw([0.0, 4.0]) as u8 {
                    0 => (Side::Forward, draw([20.0, 50.0])),
                    1 => (Side::Backward, draw([40.0, 80.0])),
                    2 => (Side::Left, draw([30.0, 60.0])),
                    _ => (Side::Right, draw([30.0, 60.0])),
                };
                let turned = match side {
                    Side::Forward => 0.0,
                    Side::Backward => 180.0,
                    Side::Left => 90.0,
                    Side::Right => -90.0,
                };
                frame.falls = [libm::sin(turned * PI / 180.0), libm::cos(turned * PI / 180.0)];
                frame.arm_planes = if side == Side::Backward { [80.0; 2] } else { [0.0; 2] };
                let held = if side == Side::Forward { draw([10.0, 25.0]) } else { draw([35.0, 55.0]) };
                let (follows_s, impact_s) = (draw([0.3, 0.5]), draw(IMPACT_S));
                let speed_m_s = draw([2.3, 3.3]);
                let mut fall = Fall { side, impact_s, duration_s: 1.0, knees, held, follows_s };
                // the pelvis of a fall of 1 s is as fast as this; all speeds scale with the duration
                let trial = Activity { kind: Kind::Fall(fall.clone()), frame, segments: *segments };
                let [.., vertical] = trial.joints(Dual::variable(impact_s))[joint::BASE];
                fall.duration_s = -vertical.rate / speed_m_s;
                Kind::Fall(fall)
            }
            Class::Bending => {
                let (way_s, hold_s) = (draw([1.0, 1.5]), draw([0.1, 0.5]));
                let period_s = 2.0 * way_s + hold_s + draw([0.2, 0.8]);
                // the middle of the way down or of the way up
                let middle = if draw([0.0, 1.0]) < 0.5 { 0.5 * way_s } else { 1.5 * way_s + hold_s };
                let start_s = draw(MIDDLE_S) - middle;
                let (lean, knees) = (draw([60.0, 90.0]), draw([0.0, 40.0]));
                Kind::Bend(Bend { start_s, way_s, hold_s, period_s, lean, knees })
            }
            Class::Waving => {
                let arm = usize::from(draw([0.0, 1.0]) < 0.7);
                frame.arm_planes[arm] = draw([20.0, 90.0]);
                let shoulder = draw([60.0, 110.0]);
                let middle = (180.0 - shoulder + draw([-10.0, 10.0])).clamp(50.0, 100.0);
                let (rate_hz, phase) = (draw([0.8, 2.5]), draw([0.0, 1.0]));
                Kind::Wave(Wave { arm, rate_hz, phase, shoulder, elbow: [middle, draw([20.0, 45.0])] })
            }
            Class::Jumping => Kind::Jump(Jump::draw(segments.leg(), &mut draw)),
            _ => return None,
        };
        Some(Activity { kind, frame, segments: *segments })
    }

    /// Joints at `t` s in m: x ahead of where the ankles stand, y left of their middle, z above the floor.
    pub fn joints<R: Real>(&self, t: R) -> [Vec3<R>; JOINTS] {
        let posture = match &self.kind {
            Kind::Rise(rise) => rise.posture(t),
            Kind::Fall(fall) => fall.posture(t, self.segments.foot),
            Kind::Bend(bend) => bend.posture(t),
            Kind::Wave(wave) => wave.posture(t),
            Kind::Jump(jump) => jump.posture(t),
        };
        posture::joints(&posture, &self.frame, &self.segments)
    }
}

/// From `a` to `b` by the share `s`.
fn mix<R: Real>(a: f64, b: f64, s: R) -> R {
    s.times(b - a).plus(a)
}

impl Rise {
    fn posture<R: Real>(&self, t: R) -> Posture<R> {
        // in shares of the duration
        let since = t.plus(-self.middle_s).times(1.0 / self.duration_s);
        let u = if self.up { since } else { -since }.plus(0.5);
        let up = ease(u, LIFT_OFF, 1.0);
        let lean = (ease(u, 0.0, MOST_LEAN) - ease(u, MOST_LEAN, 1.0)).times(self.lean);
        let arm = [mix(25.0, 3.0, up), mix(60.0, 10.0, up)];
        Posture {
            lean,
            thigh: mix(self.thigh, STANDING_DEG, up),
            shank: mix(self.shank, STANDING_DEG, up),
            arms: [arm; 2],
            ..Posture::standing()
        }
    }
}

impl Fall {
    fn posture<R: Real>(&self, t: R, foot_m: f64) -> Posture<R> {
        let s = dropped(t, self.impact_s, self.duration_s);
        let halfway = s.times(4.0) * (R::of(1.0) - s);
        let soon = s * (R::of(2.0) - s);
        let held = (s - dropped(t, self.impact_s + self.follows_s, self.follows_s)).times(self.held);
        let upright = Posture { held, ..Posture::standing() };
        match self.side {
            Side::Forward => {
                let tilt = s.times(94.0);
                let toes = soon.times(60.0);
                // the body goes over its toes, which stay; the arms reach out
                let (sine, cosine) = (toes + tilt).times(1.0 / 360.0).sin_cos_turns();
                let ankles_m = [(R::of(1.0) - cosine).times(foot_m), sine.times(foot_m)];
                let bent = halfway.times(0.5 * self.knees).plus(STANDING_DEG);
                let arm = [mix(3.0, 188.0, s), mix(10.0, 20.0, s)];
                Posture { thigh: bent, shank: bent, toes, arms: [arm; 2], tilt, ankles_m, ..upright }
            }
            Side::Backward | Side::Left | Side::Right => {
                let bent = mix(STANDING_DEG, 0.5 * self.knees, s);
                let shoulder = mix(3.0, 40.0, soon);
                let arm = [shoulder, mix(10.0, 25.0, s)];
                Posture { thigh: bent, shank: bent, arms: [arm; 2], tilt: s.times(88.0), ..upright }
            }
        }
    }
}

impl Bend {
    fn posture<R: Real>(&self, t: R) -> Posture<R> {
        let t = repeated(t, self.start_s, self.period_s);
        let up = self.way_s + self.hold_s;
        let down = ease(t, 0.0, self.way_s) - ease(t, up, up + self.way_s);
        // legs lean back by 8 degrees, so that the feet stay under the centre of mass; arms hang down
        let bent = |lean: f64| down.times(0.5 * self.knees + lean).plus(STANDING_DEG);
        let arm = [mix(3.0, self.lean, down), R::of(10.0)];
        Posture {
            lean: down.times(self.lean),
            thigh: bent(8.0),
            shank: bent(-8.0),
            arms: [arm; 2],
            ..Posture::standing()
        }
    }
}

impl Wave {
    fn posture<R: Real>(&self, t: R) -> Posture<R> {
        let (swing, _) = t.times(self.rate_hz).plus(self.phase).sin_cos_turns();
        let mut posture = Posture::standing();
        let [middle, range] = self.elbow;
        // the upper arm goes along a little
        posture.arms[self.arm] = [swing.times(4.0).plus(self.shoulder), swing.times(range).plus(middle)];
        posture
    }
}

impl Jump {
    fn draw(leg_m: f64, draw: &mut impl FnMut([f64; 2]) -> f64) -> Self {
        let speed = (2.0 * GRAVITY * draw([0.15, 0.40])).sqrt();
        let (crouch, landed) = (draw([0.62, 0.72]), draw([0.70, 0.80]));
        let swing = draw([20.0, 100.0]);
        // from rest to the speed, and to rest, at a constant acceleration
        let within = |length: f64| 2.0 * (TAKE_OFF - length) * leg_m / speed;
        let crouched_s = draw([0.4, 0.6]);
        let off = crouched_s + within(crouch);
        let on = off + 2.0 * speed / GRAVITY;
        let apex = 0.5 * (off + on);
        let low = on + within(landed);
        let stood = low + draw([0.4, 0.6]);
        // the leg stretches while the feet gather speed, and bends as much before they land
        let stretch_s = 2.0 * (STRETCHED - TAKE_OFF) * leg_m / speed;
        let (gained, slower) = (0.5 * stretch_s * (speed - GRAVITY * stretch_s), speed - GRAVITY * stretch_s);
        let rate = speed / leg_m;
        Jump {
            start_s: draw(MIDDLE_S) - apex,
            period_s: stood + draw([0.1, 0.4]),
            crouched_s,
            rising_s: [low, stood],
            length: Curve(vec![
                [crouched_s, crouch, 0.0],
                [off, TAKE_OFF, rate],
                [off + stretch_s, STRETCHED, 0.0],
                [on - stretch_s, STRETCHED, 0.0],
                [on, TAKE_OFF, -rate],
                [low, landed, 0.0],
            ]),
            flight: Curve(vec![
                [off, 0.0, 0.0],
                [off + stretch_s, gained, slower],
                [on - stretch_s, gained, -slower],
                [on, 0.0, 0.0],
            ]),
            lean: Curve(vec![
                [0.0, 0.0, 0.0],
                [crouched_s, 35.0, 0.0],
                [apex, 3.0, 0.0],
                [low, 25.0, 0.0],
                [stood, 0.0, 0.0],
            ]),
            shoulder: Curve(vec![
                [0.0, 3.0, 0.0],
                [crouched_s, -0.4 * swing, 0.0],
                [apex, swing, 0.0],
                [low, 0.3 * swing, 0.0],
                [stood, 3.0, 0.0],
            ]),
            toes: Curve(vec![[off, 0.0, 0.0], [apex, 20.0, 0.0], [on, 0.0, 0.0]]),
        }
    }

    fn posture<R: Real>(&self, t: R) -> Posture<R> {
        let t = repeated(t, self.start_s, self.period_s);
        // thigh and shank are equally long but for 1 mm: both angles follow from the leg's length
        let [bent] = self.length.at(t).lift(|l| {
            let degrees = 180.0 / PI;
            ([libm::acos(l) * degrees], [-degrees / (1.0 - l * l).sqrt()])
        });
        let [low, stood] = self.rising_s;
        let crouching = ease(t, 0.0, self.crouched_s) - ease(t, low, stood);
        let bent = bent.plus(-STANDING_DEG) * crouching;
        let bent = bent.plus(STANDING_DEG);
        let arm = [self.shoulder.at(t), R::of(20.0)];
        Posture {
            lean: self.lean.at(t),
            thigh: bent,
            shank: bent,
            toes: self.toes.at(t),
            arms: [arm; 2],
            ankles_m: [R::of(0.0), self.flight.at(t)],
            ..Posture::standing()
        }
    }
}
