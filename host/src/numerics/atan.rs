//! Arc tangents of several numbers at once, with the bits of [`libm::atan`] and [`libm::atan2`].
//!
//! The operations are those of `libm`'s port of FreeBSD's msun, in their order, without branches; no multiply-add is fused. Directions
//! that msun treats otherwise go to `libm` itself.
//!
//! After msun's `s_atan.c` and `e_atan2.c`, of which the coefficients are: Copyright (C) 1993 by Sun Microsystems, Inc. All rights
//! reserved. Developed at SunPro, a Sun Microsystems, Inc. business. Permission to use, copy, modify, and distribute this software is freely
//! granted, provided that this notice is preserved.

#![allow(clippy::excessive_precision)] // all digits that msun prints

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// Arc tangents of 1/2, 1, 3/2 and infinity.
const HIGH: [f64; 4] =
    [4.636_476_090_008_060_935_15e-01, FRAC_PI_4, 9.827_937_232_473_290_540_82e-01, FRAC_PI_2];
/// What their rounding left.
const LOW: [f64; 4] = [
    2.269_877_745_296_168_709_24e-17,
    3.061_616_997_868_383_017_93e-17,
    1.390_331_103_123_099_845_16e-17,
    6.123_233_995_736_766_035_87e-17,
];
const P: [f64; 11] = [
    3.333_333_333_333_293_180_27e-01,
    -1.999_999_999_987_648_324_76e-01,
    1.428_571_427_250_346_637_11e-01,
    -1.111_111_040_546_235_578_80e-01,
    9.090_887_133_436_506_561_96e-02,
    -7.691_876_205_044_829_994_95e-02,
    6.661_073_137_387_531_206_69e-02,
    -5.833_570_133_790_573_486_45e-02,
    4.976_877_994_615_932_360_17e-02,
    -3.653_157_274_421_691_552_70e-02,
    1.628_582_011_536_578_236_23e-02,
];
/// What the rounding of pi left.
const PI_LOW: f64 = 1.224_646_799_147_353_177_2e-16;
/// 2^63: steeper directions are `libm`'s.
const STEEP: f64 = 9_223_372_036_854_775_808.0;

/// Arc tangents in rad, of numbers that are no NaN.
#[inline(always)]
pub fn atan<const N: usize>(numbers: &[f64; N]) -> [f64; N] {
    let mut angles = [0.0; N];
    for n in 0..N {
        let x = numbers[n].abs();
        // tan(a - b) = (tan a - tan b) / (1 + tan a tan b), b the nearest of the table
        let (mut over, mut under, mut high, mut low) = (x, 1.0, 0.0, 0.0);
        if x >= 0.4375 {
            (over, under, high, low) = (2.0 * x - 1.0, 2.0 + x, HIGH[0], LOW[0]);
        }
        if x >= 0.6875 {
            (over, under, high, low) = (x - 1.0, x + 1.0, HIGH[1], LOW[1]);
        }
        if x >= 1.1875 {
            (over, under, high, low) = (x - 1.5, 1.0 + 1.5 * x, HIGH[2], LOW[2]);
        }
        if x >= 2.4375 {
            (over, under, high, low) = (-1.0, x, HIGH[3], LOW[3]);
        }
        let x = over / under;
        let z = x * x;
        let w = z * z;
        let odd = z * (P[0] + w * (P[2] + w * (P[4] + w * (P[6] + w * (P[8] + w * P[10])))));
        let even = w * (P[1] + w * (P[3] + w * (P[5] + w * (P[7] + w * P[9]))));
        angles[n] = (high - (x * (odd + even) - low - x)).copysign(numbers[n]);
    }
    angles
}

/// Angles in rad of the directions (x, y) from the x axis.
#[inline(always)]
pub fn atan2<const N: usize>(y: &[f64; N], x: &[f64; N]) -> [f64; N] {
    let mut slopes = [0.0; N];
    for n in 0..N {
        slopes[n] = (y[n] / x[n]).abs();
    }
    let mut angles = atan(&slopes);
    let mut other = 0_u64;
    for n in 0..N {
        other |= u64::from(slopes[n] >= STEEP) | u64::from(slopes[n].is_nan());
        let behind = PI - (angles[n] - PI_LOW);
        let angle = if x[n].is_sign_negative() { behind } else { angles[n] };
        angles[n] = angle.copysign(y[n]);
    }
    if other != 0 {
        for n in 0..N {
            angles[n] = libm::atan2(y[n], x[n]);
        }
    }
    angles
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::random::Random;
    use crate::numerics::vectors::vectorised;

    const CORNERS: [f64; 16] = [
        0.0,
        -0.0,
        1e-300,
        -1e-300,
        5e-324,
        1e-9,
        1.0,
        -1.0,
        0.4375,
        -0.6875,
        1.1875,
        2.4375,
        1e17,
        -1e300,
        f64::INFINITY,
        f64::NEG_INFINITY,
    ];

    #[test]
    fn bits_are_those_of_libm() {
        let mut random = Random::new(1, 2, 3, 4);
        let check = |numbers: [f64; 8]| {
            let found = vectorised(
                #[inline(always)]
                || atan(&numbers),
            );
            for (found, x) in found.iter().zip(numbers) {
                assert_eq!(found.to_bits(), libm::atan(x).to_bits(), "atan {x}");
            }
        };
        for largest in [1e-9, 1e-3, 0.5, 1.0, 3.0, 100.0, 1e12] {
            for _ in 0..20_000 {
                check(std::array::from_fn(|_| largest * (2.0 * random.uniform() - 1.0)));
            }
        }
        // next to every border
        for border in [0.4375, 0.6875, 1.1875, 2.4375] {
            for step in 0..100_u64 {
                let near = |k: usize| f64::from_bits(f64::to_bits(border) - 4 + k as u64 + 1000 * step);
                check(std::array::from_fn(near));
            }
        }
        for half in CORNERS.as_chunks::<8>().0 {
            check(*half);
        }
    }

    #[test]
    fn directions_are_those_of_libm() {
        let mut random = Random::new(5, 6, 7, 8);
        let check = |y: [f64; 8], x: [f64; 8]| {
            let found = vectorised(
                #[inline(always)]
                || atan2(&y, &x),
            );
            for (found, (y, x)) in found.iter().zip(y.into_iter().zip(x)) {
                assert_eq!(found.to_bits(), libm::atan2(y, x).to_bits(), "atan2 {y} {x}");
            }
        };
        for (high, wide) in [(1.0, 1.0), (1.0, 1e-9), (1e-9, 1.0), (1e-30, 1.0), (1e12, 3.0)] {
            for _ in 0..20_000 {
                let mut within = |most: f64| std::array::from_fn(|_| most * (2.0 * random.uniform() - 1.0));
                check(within(high), within(wide));
            }
        }
        for y in CORNERS {
            for half in CORNERS.as_chunks::<8>().0 {
                check([y; 8], *half);
            }
        }
    }
}
