//! A human body: how its joints move and what sixteen ellipsoids stand on them.

pub(crate) mod activity;
pub mod capture;
pub mod gait;
mod limbs;
pub(crate) mod motion;
pub(crate) mod number;
pub mod primitives;
pub(crate) mod trajectory;

use number::Real;

/// A point or vector in m: x, y, z.
pub type Vec3<R = f64> = [R; 3];

/// a + b.
#[inline(always)]
pub fn add<R: Real>(a: Vec3<R>, b: Vec3<R>) -> Vec3<R> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// a - b.
#[inline(always)]
pub fn sub<R: Real>(a: Vec3<R>, b: Vec3<R>) -> Vec3<R> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// s a.
#[inline(always)]
pub fn scale<R: Real>(a: Vec3<R>, s: R) -> Vec3<R> {
    [s * a[0], s * a[1], s * a[2]]
}

/// Inner product.
#[inline(always)]
pub fn dot<R: Real>(a: Vec3<R>, b: Vec3<R>) -> R {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Length.
#[inline(always)]
pub fn norm<R: Real>(a: Vec3<R>) -> R {
    dot(a, a).sqrt()
}
