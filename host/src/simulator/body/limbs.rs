//! Joints and segments of a body, and where an arm's and a leg's joints are by their angles: every motion's forward kinematics.

use super::number::Real;
use super::{Vec3, add};

/// Joints in their order: base, neck, head, then left and right of shoulder, elbow, hand, hip, knee, ankle, toe.
pub const JOINTS: usize = 17;

/// Index of a joint; the right one is the left one plus one.
pub mod joint {
    /// Pelvis centre.
    pub const BASE: usize = 0;
    /// Upper end of the torso.
    pub const NECK: usize = 1;
    /// Top of the head.
    pub const HEAD: usize = 2;
    /// Left shoulder.
    pub const SHOULDER: usize = 3;
    /// Left elbow.
    pub const ELBOW: usize = 5;
    /// Left hand.
    pub const HAND: usize = 7;
    /// Left hip.
    pub const HIP: usize = 9;
    /// Left knee.
    pub const KNEE: usize = 11;
    /// Left ankle.
    pub const ANKLE: usize = 13;
    /// Left toe.
    pub const TOE: usize = 15;
}

/// Segment lengths in m; fractions of the height.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segments {
    /// Neck to top of the head.
    pub head: f64,
    /// Half the shoulder width.
    pub half_shoulder: f64,
    /// Pelvis to neck.
    pub torso: f64,
    /// Half the hip width.
    pub half_hip: f64,
    /// Hip to knee.
    pub thigh: f64,
    /// Knee to ankle.
    pub shank: f64,
    /// Ankle to toe.
    pub foot: f64,
    /// Shoulder to elbow.
    pub upper_arm: f64,
    /// Elbow to hand.
    pub lower_arm: f64,
}

impl Segments {
    /// Of a person of height `h` in m.
    pub fn of_height(h: f64) -> Self {
        Segments {
            head: 0.130 * h,
            half_shoulder: 0.1295 * h,
            torso: 0.288 * h,
            half_hip: 0.0955 * h,
            thigh: 0.245 * h,
            shank: 0.246 * h,
            foot: 0.143 * h,
            upper_arm: 0.188 * h,
            lower_arm: 0.152 * h,
        }
    }

    /// Thigh and shank, H_t: the model's unit of length.
    pub fn leg(&self) -> f64 {
        self.thigh + self.shank
    }
}

/// A rotation by its sine and cosine.
#[derive(Debug, Clone, Copy)]
pub struct Turn<R>(pub R, pub R);

impl<R: Real> Turn<R> {
    #[inline(always)]
    pub fn degrees(angle: R) -> Self {
        let (s, c) = angle.times(1.0 / 360.0).sin_cos_turns();
        Turn(s, c)
    }

    /// About y: a positive angle swings a hanging limb forward.
    #[inline(always)]
    pub fn pitch(self, [x, y, z]: Vec3<R>) -> Vec3<R> {
        let Turn(s, c) = self;
        [c * x - s * z, y, s * x + c * z]
    }

    /// About z, clockwise seen from above.
    #[inline(always)]
    pub fn yaw(self, [x, y, z]: Vec3<R>) -> Vec3<R> {
        let Turn(s, c) = self;
        [c * x + s * y, c * y - s * x, z]
    }

    /// About x.
    #[inline(always)]
    pub fn tilt(self, [x, y, z]: Vec3<R>) -> Vec3<R> {
        let Turn(s, c) = self;
        [x, c * y + s * z, c * z - s * y]
    }
}

/// A vertical segment of `length` m; negative: hanging.
#[inline(always)]
pub fn along<R: Real>(length: f64) -> Vec3<R> {
    [R::of(0.0), R::of(0.0), R::of(length)]
}

/// Elbow and hand seen from the shoulder; at angles of 0 the arm hangs straight.
#[inline(always)]
pub fn arm<R: Real>(s: &Segments, shoulder: Turn<R>, elbow: Turn<R>) -> [Vec3<R>; 2] {
    let upper_arm = along(-s.upper_arm);
    let hand = shoulder.pitch(add(elbow.pitch(along(-s.lower_arm)), upper_arm));
    [shoulder.pitch(upper_arm), hand]
}

/// Knee, ankle and toe seen from the hip; at angles of 0 the leg hangs straight and the foot points forward.
#[inline(always)]
pub fn leg<R: Real>(s: &Segments, hip: Turn<R>, knee: Turn<R>, ankle: Turn<R>) -> [Vec3<R>; 3] {
    let (thigh, shank) = (along(-s.thigh), along(-s.shank));
    let toe = add(ankle.pitch([R::of(s.foot), R::of(0.0), R::of(0.0)]), shank);
    let below = |v: Vec3<R>| hip.pitch(add(knee.pitch(v), thigh));
    [hip.pitch(thigh), below(shank), below(toe)]
}
