//! The numbers kinematics is written over: one formula gives positions, velocities and several slots at a time.
//!
//! [`f64`] for a position, [`Dual`] for a position with its exact rate of change (forward differentiation), [`Lanes`]
//! for several instants side by side.

use crate::numerics::pchip::Periodic;
use crate::numerics::vectors::vectorised;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// What a kinematic formula may do with a number.
pub trait Real:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    fn of(x: f64) -> Self;
    fn sqrt(self) -> Self;
    /// sin and cos of 2 pi times the number.
    fn sin_cos_turns(self) -> (Self, Self);
    /// K functions of the number at once: `f` gives their values and slopes.
    fn lift<const K: usize>(self, f: impl Fn(f64) -> ([f64; K], [f64; K])) -> [Self; K];
    /// A periodic curve at the number.
    fn on(self, curve: &Periodic) -> Self;
    /// The number times a constant.
    #[inline(always)]
    fn times(self, k: f64) -> Self {
        self * Self::of(k)
    }
    /// The number plus a constant.
    #[inline(always)]
    fn plus(self, k: f64) -> Self {
        self + Self::of(k)
    }
}

impl Real for f64 {
    #[inline(always)]
    fn of(x: f64) -> Self {
        x
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }
    fn sin_cos_turns(self) -> (Self, Self) {
        let angle = std::f64::consts::TAU * (self - self.floor());
        libm::sincos(angle)
    }
    fn lift<const K: usize>(self, f: impl Fn(f64) -> ([f64; K], [f64; K])) -> [Self; K] {
        f(self).0
    }
    fn on(self, curve: &Periodic) -> Self {
        curve.at(self).0
    }
}

/// A value and its rate of change.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dual {
    pub value: f64,
    pub rate: f64,
}

impl Dual {
    /// The independent variable itself at `x`.
    pub fn variable(x: f64) -> Self {
        Dual { value: x, rate: 1.0 }
    }
}

impl Add for Dual {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Dual { value: self.value + o.value, rate: self.rate + o.rate }
    }
}
impl Sub for Dual {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        Dual { value: self.value - o.value, rate: self.rate - o.rate }
    }
}
impl Mul for Dual {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        Dual { value: self.value * o.value, rate: self.rate * o.value + self.value * o.rate }
    }
}
impl Div for Dual {
    type Output = Self;
    fn div(self, o: Self) -> Self {
        let value = self.value / o.value;
        Dual { value, rate: (self.rate - value * o.rate) / o.value }
    }
}
impl Neg for Dual {
    type Output = Self;
    fn neg(self) -> Self {
        Dual { value: -self.value, rate: -self.rate }
    }
}

impl Real for Dual {
    fn of(x: f64) -> Self {
        Dual { value: x, rate: 0.0 }
    }
    fn sqrt(self) -> Self {
        let value = self.value.sqrt();
        Dual { value, rate: self.rate / (2.0 * value) }
    }
    fn sin_cos_turns(self) -> (Self, Self) {
        let (s, c) = self.value.sin_cos_turns();
        let turn = std::f64::consts::TAU * self.rate;
        (Dual { value: s, rate: c * turn }, Dual { value: c, rate: -s * turn })
    }
    fn lift<const K: usize>(self, f: impl Fn(f64) -> ([f64; K], [f64; K])) -> [Self; K] {
        let (values, slopes) = f(self.value);
        std::array::from_fn(|k| Dual { value: values[k], rate: slopes[k] * self.rate })
    }
    fn on(self, curve: &Periodic) -> Self {
        let (value, slope) = curve.at(self.value);
        Dual { value, rate: slope * self.rate }
    }
}

/// Instants side by side.
pub const LANES: usize = 16;

/// The same number at [`LANES`] instants, which the compiler puts in vector registers. IEEE operations only (no fused
/// multiply-add), so that the bits do not depend on the processor.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(64))]
pub struct Lanes([f64; LANES]);

impl Lanes {
    /// From the instants' values.
    #[inline(always)]
    pub fn new(values: [f64; LANES]) -> Self {
        Lanes(values)
    }

    /// The value at one instant.
    #[inline(always)]
    pub fn at(&self, lane: usize) -> f64 {
        self.0[lane]
    }

    #[inline(always)]
    pub fn to_array(self) -> [f64; LANES] {
        self.0
    }
}

macro_rules! lanewise {
    ($trait:ident, $method:ident, $op:tt) => {
        impl $trait for Lanes {
            type Output = Self;
            #[inline(always)]
            fn $method(self, o: Self) -> Self {
                Lanes(std::array::from_fn(|lane| self.0[lane] $op o.0[lane]))
            }
        }
    };
}
lanewise!(Add, add, +);
lanewise!(Sub, sub, -);
lanewise!(Mul, mul, *);
lanewise!(Div, div, /);

impl Neg for Lanes {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Lanes(self.0.map(|x| -x))
    }
}

/// 1.5 * 2^52: adding it rounds to an integer.
const ROUNDING: f64 = 6_755_399_441_055_744.0;

/// Coefficients of sin(pi x) / x and cos(pi x) in x^2: Taylor, below 1e-11 for |x| <= 1/2.
const SINE: [f64; 8] = series(1);
const COSINE: [f64; 9] = series(0);

const fn series<const N: usize>(first: u32) -> [f64; N] {
    let mut out = [0.0; N];
    let (mut term, mut n, mut k) = (1.0, 0, 0);
    while n < first {
        n += 1;
        term *= std::f64::consts::PI / n as f64;
    }
    while k < N {
        out[k] = term;
        term *= -std::f64::consts::PI * std::f64::consts::PI / ((n + 1) as f64 * (n + 2) as f64);
        n += 2;
        k += 1;
    }
    out
}

/// sin and cos of 2 pi times `turns`. Error below 3e-11.
#[inline(always)]
pub fn sin_cos_turns(turns: f64) -> (f64, f64) {
    // half the angle lies within a quarter turn; doubling it needs no quadrants
    let x = turns - ((turns + ROUNDING) - ROUNDING);
    let (s, c) = (x * polynomial(&SINE, x * x), polynomial(&COSINE, x * x));
    (s * 2.0 * c, 1.0 - s * 2.0 * s)
}

#[inline(always)]
fn polynomial<const N: usize>(coefficients: &[f64; N], x: f64) -> f64 {
    let mut sum = coefficients[N - 1];
    for &c in coefficients[..N - 1].iter().rev() {
        sum = sum * x + c;
    }
    sum
}

impl Real for Lanes {
    #[inline(always)]
    fn of(x: f64) -> Self {
        Lanes([x; LANES])
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Lanes(self.0.map(f64::sqrt))
    }
    /// A function of its own, not inlined: in the middle of a long formula the compiler would put sine and cosine of one
    /// instant side by side, and not the instants.
    #[inline(always)]
    fn sin_cos_turns(self) -> (Self, Self) {
        vectorised(
            #[inline(always)]
            || {
                let [mut sines, mut cosines] = [[0.0; LANES]; 2];
                // one instant at a time: the compiler makes vectors of such a loop, and none of a chain of whole `Lanes`
                for lane in 0..LANES {
                    (sines[lane], cosines[lane]) = sin_cos_turns(self.0[lane]);
                }
                (Lanes(sines), Lanes(cosines))
            },
        )
    }
    #[inline(always)]
    fn lift<const K: usize>(self, f: impl Fn(f64) -> ([f64; K], [f64; K])) -> [Self; K] {
        let mut values = [[0.0; LANES]; K];
        for (lane, &x) in self.0.iter().enumerate() {
            for (to, value) in values.iter_mut().zip(f(x).0) {
                to[lane] = value;
            }
        }
        values.map(Lanes)
    }
    /// The instants mostly lie on one piece.
    #[inline(always)]
    fn on(self, curve: &Periodic) -> Self {
        let t = Lanes(self.0.map(|t| t - t.floor()));
        let (piece, until) = curve.piece(t.0[0]);
        if t.0.iter().all(|&t| piece.start <= t && t < until) {
            let [a0, a1, a2, a3] = piece.a;
            let s = t.plus(-piece.start);
            let inner = s * s.times(a3).plus(a2);
            return (s * inner.plus(a1)).plus(a0);
        }
        Lanes(self.0.map(|t| curve.at(t).0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lanes_know_sine_and_cosine() {
        for step in -4000..4000 {
            let turns = f64::from(step) / 1237.0;
            let (s, c) = Lanes::of(turns).sin_cos_turns();
            let angle = std::f64::consts::TAU * turns;
            assert!((s.to_array()[3] - libm::sin(angle)).abs() < 3e-11, "{turns} {}", s.to_array()[3]);
            assert!((c.to_array()[3] - libm::cos(angle)).abs() < 3e-11, "{turns} {}", c.to_array()[3]);
        }
    }

    #[test]
    fn duals_follow_the_chain_rule() {
        // d/dx of sin(2 pi x^2) sqrt(x) / (1 + x)
        let f = |x: f64| libm::sin(std::f64::consts::TAU * x * x) * x.sqrt() / (1.0 + x);
        let x = Dual::variable(0.7);
        let (s, _) = (x * x).sin_cos_turns();
        let y = s * x.sqrt() / x.plus(1.0);
        let h = 1e-5;
        assert!((y.value - f(0.7)).abs() < 1e-15);
        assert!((y.rate - (f(0.7 + h) - f(0.7 - h)) / (2.0 * h)).abs() < 1e-8);
    }
}
