//! Sixteen ellipsoids on seventeen joints, and the radar cross section of each from where the radar stands.
//!
//! High-frequency ellipsoid: sigma = pi a^4 c^2 / (a^2 sin^2 th + c^2 cos^2 th)^2 for a = b, th between the line of sight
//! and the axis of length 2c (Chen, "The Micro-Doppler Effect in Radar", ch. 4).

use super::gait::{JOINTS, Segments, joint};
use super::{Vec3, dot, norm, scale, sub};
use std::f64::consts::PI;

/// Primitives of a body.
pub const PRIMITIVES: usize = 16;

/// An ellipsoid of revolution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Primitive {
    /// Scatter centre in m.
    pub centre: Vec3,
    /// Direction of its axis, not normalised.
    pub axis: Vec3,
    /// Semi-axes across (a = b) and along (c) in m.
    pub semi: [f64; 2],
}

impl Primitive {
    /// Radar cross section in m^2 seen from `radar`.
    pub fn cross_section(&self, radar: Vec3) -> f64 {
        let [a, c] = self.semi;
        let sight = sub(radar, self.centre);
        let cosine = dot(sight, self.axis) / (norm(sight) * norm(self.axis)).max(1e-12);
        let cos2 = (cosine * cosine).min(1.0);
        let (a2, c2) = (a * a, c * c);
        let below = a2 * (1.0 - cos2) + c2 * cos2;
        PI * a2 * a2 * c2 / (below * below)
    }
}

/// The primitives of a body of height `height` at these joints: head, torso, then left and right of shoulder, upper
/// arm, lower arm, hip, thigh, shank, foot. Girths scale with the height (they are those of 1.75 m).
pub fn primitives(joints: &[Vec3; JOINTS], segments: &Segments, height: f64) -> [Primitive; PRIMITIVES] {
    let girth = height / 1.75;
    let between = |a: usize, b: usize| scale(super::add(joints[a], joints[b]), 0.5);
    let make = |centre: Vec3, from: usize, to: usize, a: f64, c: f64| Primitive {
        centre,
        axis: sub(joints[to], joints[from]),
        semi: [a * girth, c],
    };
    let s = segments;
    let side = |side: usize| {
        let at = |base: usize| base + side;
        let (shoulder, elbow, hand) = (at(joint::SHOULDER), at(joint::ELBOW), at(joint::HAND));
        let (hip, knee, ankle, toe) = (at(joint::HIP), at(joint::KNEE), at(joint::ANKLE), at(joint::TOE));
        [
            make(joints[shoulder], joint::NECK, shoulder, 0.06, s.half_shoulder / 2.0),
            make(between(shoulder, elbow), elbow, shoulder, 0.06, s.upper_arm / 2.0),
            make(joints[hand], hand, elbow, 0.05, s.lower_arm / 2.0),
            make(joints[hip], joint::BASE, hip, 0.07, s.half_hip / 2.0),
            make(between(hip, knee), hip, knee, 0.07, s.thigh / 2.0),
            make(between(knee, ankle), knee, ankle, 0.06, s.shank / 2.0),
            make(joints[toe], toe, ankle, 0.05, s.foot / 2.0),
        ]
    };
    let head = make(joints[joint::HEAD], joint::NECK, joint::HEAD, 0.10, s.head / 2.0);
    let torso = make(between(joint::NECK, joint::BASE), joint::BASE, joint::NECK, 0.15, s.torso / 2.0);
    let (left, right) = (side(0), side(1));
    std::array::from_fn(|b| match b {
        0 => head,
        1 => torso,
        b if b % 2 == 0 => left[b / 2 - 1],
        b => right[b / 2 - 1],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cross_sections_of_known_shapes() {
        let mut p = Primitive { centre: [0.0; 3], axis: [0.0, 0.0, 1.0], semi: [0.3, 0.3] };
        assert!((p.cross_section([5.0, 1.0, 2.0]) - PI * 0.09).abs() < 1e-12); // sphere
        p.semi = [0.1, 0.4];
        assert!((p.cross_section([5.0, 0.0, 0.0]) - PI * 0.16).abs() < 1e-12); // broadside: pi c^2
        assert!((p.cross_section([0.0, 0.0, 5.0]) - PI * 1e-4 / 0.16).abs() < 1e-12); // end-on: pi a^4 / c^2
    }
}
