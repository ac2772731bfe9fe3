//! A posture by its angles, with both legs alike, and the joints that follow from it.

use super::super::limbs::{JOINTS, Segments, Turn, along, arm, joint, leg};
use super::super::number::Real;
use super::super::{Vec3, add, sub};

/// Angles in degrees; lengths in m.
#[derive(Debug, Clone, Copy)]
pub struct Posture<R> {
    /// Trunk and head, forward of the vertical.
    pub lean: R,
    /// Thigh, knee before the hip.
    pub thigh: R,
    /// Shank, knee before the ankle.
    pub shank: R,
    /// Foot, toes below the horizontal.
    pub toes: R,
    /// Left and right arm: shoulder forward of the trunk, elbow bent.
    pub arms: [[R; 2]; 2],
    /// The whole body about the ankles, to where it falls.
    pub tilt: R,
    /// Trunk and head, held back from where the body falls.
    pub held: R,
    /// Where the ankles are, ahead of and above their place in standing.
    pub ankles_m: [R; 2],
}

impl<R: Real> Posture<R> {
    /// Upright, knees not quite straight, arms hanging.
    pub fn standing() -> Self {
        let [zero, bent] = [0.0, STANDING_DEG].map(R::of);
        let arm = [3.0, 10.0].map(R::of);
        Posture {
            lean: zero,
            thigh: bent,
            shank: bent,
            toes: zero,
            arms: [arm; 2],
            tilt: zero,
            held: zero,
            ankles_m: [zero; 2],
        }
    }
}

/// Thighs and shanks off the vertical in standing, in degrees.
pub const STANDING_DEG: f64 = 3.0;

/// What does not change in a motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// Angles in degrees from straight ahead to the plane in which each arm moves, outwards.
    pub arm_planes: [f64; 2],
    /// Sine and cosine of the direction in which the body tilts, from straight ahead to the left.
    pub falls: [f64; 2],
    /// Height of the ankles above the floor in m.
    pub ankle_m: f64,
}

/// Joints in m: x ahead of the ankles' place in standing, y left of their middle, z above the floor.
pub fn joints<R: Real>(posture: &Posture<R>, frame: &Frame, s: &Segments) -> [Vec3<R>; JOINTS] {
    let Posture { lean, thigh, shank, toes, arms, tilt, held, ankles_m: [ahead, above] } = *posture;
    let aside = |width: f64, up: f64| [R::of(0.0), R::of(width), R::of(up)];
    let [sine, cosine] = frame.falls;
    let (there, back) = (Turn(R::of(sine), R::of(cosine)), Turn(R::of(-sine), R::of(cosine)));
    let (lean, held, tilt) = (Turn::degrees(-lean), Turn::degrees(held), Turn::degrees(-tilt));
    let trunk = |v: Vec3<R>| back.yaw(held.pitch(there.yaw(lean.pitch(v))));
    let mut joints = [[R::of(0.0); 3]; JOINTS];
    joints[joint::NECK] = trunk(along(s.torso));
    joints[joint::HEAD] = trunk(along(s.torso + s.head));
    let below = leg(s, Turn::degrees(thigh), Turn::degrees(-(thigh + shank)), Turn::degrees(shank - toes));
    for (side, sign) in [(0, 1.0), (1, -1.0)] {
        let [shoulder, elbow] = arms[side];
        let root = aside(sign * s.half_shoulder, s.torso);
        let plane = Turn::degrees(R::of(-sign * frame.arm_planes[side]));
        let [elbow, hand] =
            arm(s, Turn::degrees(shoulder), Turn::degrees(elbow)).map(|v| add(plane.yaw(v), root));
        joints[joint::SHOULDER + side] = trunk(root);
        joints[joint::ELBOW + side] = trunk(elbow);
        joints[joint::HAND + side] = trunk(hand);
        let root = aside(sign * s.half_hip, 0.0);
        let [knee, ankle, toe] = below.map(|v| add(v, root));
        joints[joint::HIP + side] = root;
        joints[joint::KNEE + side] = knee;
        joints[joint::ANKLE + side] = ankle;
        joints[joint::TOE + side] = toe;
    }
    // the body tilts about the ankles, sideways about the ankle on that side
    let [_, ankle, _] = below;
    let pivot = add(ankle, aside(sine * s.half_hip, 0.0));
    let place = [ahead, R::of(sine * s.half_hip), above.plus(frame.ankle_m)];
    joints.map(|p| add(back.yaw(tilt.pitch(there.yaw(sub(p, pivot)))), place))
}
