//! Sixteen ellipsoids on seventeen joints, and the radar cross section of each from where the radar stands.
//!
//! High-frequency ellipsoid: sigma = pi a^4 c^2 / (a^2 sin^2 th + c^2 cos^2 th)^2 for a = b, th between the line of sight
//! and the axis of length 2c (Chen, "The Micro-Doppler Effect in Radar", ch. 4).

use super::gait::{JOINTS, Segments, joint};
use super::number::Real;
use super::{Vec3, dot, scale, sub};
use std::f64::consts::PI;

/// Primitives of a body.
pub const PRIMITIVES: usize = 16;

/// An ellipsoid of revolution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Primitive<R = f64> {
    /// Scatter centre in m.
    pub centre: Vec3<R>,
    /// Direction of its axis, not normalised.
    pub axis: Vec3<R>,
    /// Length of `axis` in m.
    pub axis_m: f64,
    /// Semi-axes across (a = b) and along (c) in m.
    pub semi: [f64; 2],
}

impl<R: Real> Primitive<R> {
    /// Distance D to `radar` in m, and sqrt(sigma) / D^2 in 1/m: what the radar equation needs of a primitive.
    ///
    /// With p the projection of the line of sight on the axis, a^2 sin^2 th + c^2 cos^2 th = (a^2 D^2 + (c^2 - a^2) p^2) / D^2,
    /// so that sqrt(sigma) / D^2 = sqrt(pi) a^2 c / (a^2 D^2 + (c^2 - a^2) p^2).
    #[inline(always)]
    pub fn echo(&self, radar: Vec3) -> (R, R) {
        let [a, c] = self.semi;
        let sight = sub(radar.map(R::of), self.centre);
        let distance2 = dot(sight, sight);
        let along = dot(sight, self.axis).times(1.0 / self.axis_m);
        let below = distance2.times(a * a) + (along * along).times(c * c - a * a);
        (distance2.sqrt(), R::of(PI.sqrt() * a * a * c) / below)
    }
}

impl Primitive {
    /// Radar cross section in m^2 seen from `radar`.
    pub fn cross_section(&self, radar: Vec3) -> f64 {
        let root = self.root_cross_section(radar);
        root * root
    }

    /// Its square root in m.
    fn root_cross_section(&self, radar: Vec3) -> f64 {
        let (distance, amplitude) = self.echo(radar);
        amplitude * distance * distance
    }

    /// Root in m of the geometric mean of the cross sections seen from two points: of the bistatic cross section of a body that is
    /// small against both distances.
    pub fn root_bistatic_cross_section(&self, from: Vec3, to: Vec3) -> f64 {
        if from == to {
            return self.root_cross_section(from);
        }
        (self.cross_section(from) * self.cross_section(to)).sqrt().sqrt()
    }
}

/// A primitive without its position: which joints it connects, and its size.
#[derive(Debug, Clone, Copy)]
pub struct Limb {
    /// Joints at which its axis begins and ends.
    pub ends: [usize; 2],
    /// Length of the axis in m.
    length: f64,
    /// Semi-axis across in m.
    radius: f64,
    /// Whether the scatter centre is the middle of the axis, or its end.
    middle: bool,
}

impl Limb {
    /// The primitive on these joints.
    #[inline(always)]
    pub fn between<R: Real>(&self, a: Vec3<R>, b: Vec3<R>) -> Primitive<R> {
        Primitive {
            centre: if self.middle { scale(super::add(a, b), R::of(0.5)) } else { b },
            axis: sub(b, a),
            axis_m: self.length,
            semi: [self.radius, self.length / 2.0],
        }
    }
}

/// The limbs of a body of height `height`, in their order: head, torso, then left and right of shoulder, upper arm, lower arm, hip,
/// thigh, shank, foot. Girths scale with the height (they are those of 1.75 m).
#[inline(always)]
pub fn limb(segments: &Segments, height: f64, index: usize) -> Limb {
    use joint::{ANKLE, BASE, ELBOW, HAND, HEAD, HIP, KNEE, NECK, SHOULDER, TOE};
    let s = segments;
    let side = index % 2;
    // (from, to, length of the axis, radius, whether the centre is the middle of the limb or its end)
    let (from, to, length, radius, middle) = match (index, index / 2) {
        (0, _) => (NECK, HEAD, s.head, 0.10, false),
        (1, _) => (BASE, NECK, s.torso, 0.15, true),
        (_, 1) => (NECK, SHOULDER + side, s.half_shoulder, 0.06, false),
        (_, 2) => (SHOULDER + side, ELBOW + side, s.upper_arm, 0.06, true),
        (_, 3) => (ELBOW + side, HAND + side, s.lower_arm, 0.05, false),
        (_, 4) => (BASE, HIP + side, s.half_hip, 0.07, false),
        (_, 5) => (HIP + side, KNEE + side, s.thigh, 0.07, true),
        (_, 6) => (KNEE + side, ANKLE + side, s.shank, 0.06, true),
        _ => (ANKLE + side, TOE + side, s.foot, 0.05, false),
    };
    Limb { ends: [from, to], length, radius: radius * height / 1.75, middle }
}

/// The primitives of a body of height `height` at these joints, one for each [`limb`].
pub fn primitives<R: Real>(
    joints: &[Vec3<R>; JOINTS],
    segments: &Segments,
    height: f64,
) -> [Primitive<R>; PRIMITIVES] {
    std::array::from_fn(|index| {
        let limb = limb(segments, height, index);
        let [a, b] = limb.ends.map(|joint| joints[joint]);
        limb.between(a, b)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cross_sections_of_known_shapes() {
        let mut p = Primitive { centre: [0.0; 3], axis: [0.0, 0.0, 1.0], axis_m: 1.0, semi: [0.3, 0.3] };
        assert!((p.cross_section([5.0, 1.0, 2.0]) - PI * 0.09).abs() < 1e-12); // sphere
        p.semi = [0.1, 0.4];
        assert!((p.cross_section([5.0, 0.0, 0.0]) - PI * 0.16).abs() < 1e-12); // broadside: pi c^2
        assert!((p.cross_section([0.0, 0.0, 5.0]) - PI * 1e-4 / 0.16).abs() < 1e-12); // end-on: pi a^4 / c^2
    }
}
