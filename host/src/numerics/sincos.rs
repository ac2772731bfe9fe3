//! Sine and cosine of several angles at once, with the bits of [`libm::sincos`].
//!
//! The operations are those of `libm`'s port of FreeBSD's msun, in their order, without branches; no multiply-add is fused. Angles
//! beyond 9 pi / 4, tiny ones and those next to a multiple of pi / 2, where msun reduces otherwise, go to `libm` itself.
//!
//! After msun's `k_sin.c`, `k_cos.c` and `e_rem_pio2.c`, of which the coefficients are: Copyright (C) 1993 by Sun Microsystems, Inc. All rights
//! reserved. Developed at SunSoft, a Sun Microsystems, Inc. business. Permission to use, copy, modify, and distribute this software is freely
//! granted, provided that this notice is preserved.

#![allow(clippy::excessive_precision)] // all digits that msun prints

const S: [f64; 6] = [
    -1.666_666_666_666_663_243_48e-01,
    8.333_333_333_322_489_461_24e-03,
    -1.984_126_982_985_794_931_34e-04,
    2.755_731_370_707_006_767_89e-06,
    -2.505_076_025_340_686_341_95e-08,
    1.589_690_995_211_550_102_21e-10,
];
const C: [f64; 6] = [
    4.166_666_666_666_660_190_37e-02,
    -1.388_888_888_887_410_957_49e-03,
    2.480_158_728_947_672_941_78e-05,
    -2.755_731_435_139_066_330_35e-07,
    2.087_572_321_298_174_827_90e-09,
    -1.135_964_755_778_819_482_65e-11,
];
/// First 33 bits of pi / 2, and the rest.
const HALF_PI: [f64; 2] = [1.570_796_326_734_125_614_17, 6.077_100_506_506_192_249_32e-11];
/// High words of the largest angles that lie nearest to 0, 1, 2, 3 and 4 quarter turns.
const NEAREST: [u64; 5] = [0x3fe9_21fb, 0x4002_d97c, 0x400f_6a7a, 0x4015_fdbc, 0x401c_463b];
/// High words of the angles next to 1, 2, 3 and 4 quarter turns.
const MULTIPLES: [u64; 4] = [0x3ff9_21fb, 0x4009_21fb, 0x4012_d97c, 0x4019_21fb];
/// High word below which an angle is its own sine.
const TINY: u64 = 0x3e50_0000;

/// Sines and cosines of angles in rad. Cost: some 60 operations an angle, in vectors where the caller's instruction set has them.
#[inline(always)]
pub fn sincos<const N: usize>(angles: &[f64; N]) -> [[f64; N]; 2] {
    let (mut sines, mut cosines) = ([0.0; N], [0.0; N]);
    let mut other = 0_u64;
    for n in 0..N {
        let x = angles[n].abs();
        let high = x.to_bits() >> 32;
        let at = |multiple: u64| u64::from(high == multiple);
        other |= u64::from(high < TINY) | u64::from(high > NEAREST[4]);
        other |= at(MULTIPLES[0]) | at(MULTIPLES[1]) | at(MULTIPLES[2]) | at(MULTIPLES[3]);
        let beyond = |most: u64| u64::from(high > most);
        let quarters = beyond(NEAREST[0]) + beyond(NEAREST[1]) + beyond(NEAREST[2]) + beyond(NEAREST[3]);
        let turned = quarters as f64;
        let rest = x - turned * HALF_PI[0];
        let y0 = rest - turned * HALF_PI[1];
        let y1 = (rest - y0) - turned * HALF_PI[1];

        let z = y0 * y0;
        let w = z * z;
        let r = S[1] + z * (S[2] + z * S[3]) + z * w * (S[4] + z * S[5]);
        let v = z * y0;
        let reduced = y0 - ((z * (0.5 * y1 - v * r) - y1) - v * S[0]);
        let s = if quarters == 0 { y0 + v * (S[0] + z * r) } else { reduced };
        let r = z * (C[0] + z * (C[1] + z * C[2])) + w * w * (C[3] + z * (C[4] + z * C[5]));
        let half = 0.5 * z;
        let one = 1.0 - half;
        let c = one + (((1.0 - one) - half) + (z * r - y0 * y1));

        let (sine, cosine) = if quarters & 1 == 0 { (s, c) } else { (c, s) };
        // signs: of the sine in the third and fourth quarter and of negative angles, of the cosine in the second and third
        let sine_sign = ((quarters & 2) << 62) ^ (angles[n].to_bits() & (1 << 63));
        let cosine_sign = ((quarters + 1) & 2) << 62;
        sines[n] = f64::from_bits(sine.to_bits() ^ sine_sign);
        cosines[n] = f64::from_bits(cosine.to_bits() ^ cosine_sign);
    }
    if other != 0 {
        for (n, angle) in angles.iter().enumerate() {
            (sines[n], cosines[n]) = libm::sincos(*angle);
        }
    }
    [sines, cosines]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::random::Random;
    use crate::numerics::vectors::vectorised;
    use std::f64::consts::FRAC_PI_4;

    #[test]
    fn bits_are_those_of_libm() {
        let mut random = Random::new(1, 2, 3, 4);
        let check = |angles: [f64; 8]| {
            let [sines, cosines] = vectorised(
                #[inline(always)]
                || sincos(&angles),
            );
            for (n, angle) in angles.iter().enumerate() {
                let (sine, cosine) = libm::sincos(*angle);
                assert_eq!(sines[n].to_bits(), sine.to_bits(), "sin {angle}");
                assert_eq!(cosines[n].to_bits(), cosine.to_bits(), "cos {angle}");
            }
        };
        for largest in [0.1, 1.0, 2.0, 7.0, 7.07, 100.0] {
            for _ in 0..20_000 {
                check(std::array::from_fn(|_| largest * (2.0 * random.uniform() - 1.0)));
            }
        }
        // next to every border
        for eighths in 0..11_i32 {
            for step in 0..4000_i32 {
                let near = f64::from(eighths) * FRAC_PI_4;
                let apart = libm::exp2(-f64::from(step % 60)) * f64::from(step / 60);
                check([near, -near, near + apart, near - apart, apart, -apart, near + 1e-9, -near - apart]);
            }
        }
        check([0.0, -0.0, 1e-30, -1e-30, 1e300, f64::MIN_POSITIVE, 1e-9, -1e-8]);
    }
}
