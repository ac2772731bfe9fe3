//! Exponentials of several numbers at once, with the bits of [`libm::exp`].
//!
//! The operations are those of `libm`'s port of FreeBSD's msun, in their order, without branches; no multiply-add is fused. Numbers that
//! msun treats otherwise, tiny and large ones, go to `libm` itself.
//!
//! After msun's `e_exp.c`, of which the coefficients are: Copyright (C) 2004 by Sun Microsystems, Inc. All rights reserved. Permission to
//! use, copy, modify, and distribute this software is freely granted, provided that this notice is preserved.

#![allow(clippy::excessive_precision)] // all digits that msun prints

/// High words of ln 2 / 2 and 3 ln 2 / 2.
const HALVES: [u64; 2] = [0x3fd6_2e42, 0x3ff0_a2b2];
/// High words up to which a number, and from which on, is treated otherwise.
const OTHER: [u64; 2] = [0x3e30_0000, 0x4086_0000];
/// First bits of ln 2, and the rest.
const LN2: [f64; 2] = [6.931_471_803_691_238_164_90e-01, 1.908_214_929_270_587_700_02e-10];
const INVERSE_LN2: f64 = std::f64::consts::LOG2_E;
const P: [f64; 5] = [
    1.666_666_666_666_660_190_37e-01,
    -2.777_777_777_701_559_338_42e-03,
    6.613_756_321_437_934_361_17e-05,
    -1.653_390_220_546_525_153_90e-06,
    4.138_136_797_057_238_460_39e-08,
];
/// Adding 1.5 * 2^52 leaves an integer in the lowest bits.
const ROUNDING: f64 = 6_755_399_441_055_744.0;

/// e to the power of each number.
#[inline(always)]
pub fn exp<const N: usize>(numbers: &[f64; N]) -> [f64; N] {
    let mut powers = [0.0; N];
    let mut other = 0_u64;
    for n in 0..N {
        let x = numbers[n];
        let high = (x.to_bits() >> 32) & 0x7fff_ffff;
        other |= u64::from(high <= OTHER[0]) | u64::from(high >= OTHER[1]);
        let sign = if x < 0.0 { -1.0 } else { 1.0 };
        let far = (INVERSE_LN2 * x + 0.5 * sign).trunc();
        let near = if high > HALVES[0] { sign } else { 0.0 };
        let k = if high >= HALVES[1] { far } else { near };
        let (upper, lower) = (x - k * LN2[0], k * LN2[1]);
        let x = upper - lower;
        let z = x * x;
        let c = x - z * (P[0] + z * (P[1] + z * (P[2] + z * (P[3] + z * P[4]))));
        let y = 1.0 + (x * c / (2.0 - c) - lower + upper);
        let exponent = (k + ROUNDING).to_bits().wrapping_add(1023);
        powers[n] = y * f64::from_bits(exponent << 52);
    }
    if other == 0 { powers } else { numbers.map(libm::exp) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::random::Random;
    use crate::numerics::vectors::vectorised;

    #[test]
    fn bits_are_those_of_libm() {
        let mut random = Random::new(1, 2, 3, 4);
        let check = |numbers: [f64; 8]| {
            let found = vectorised(
                #[inline(always)]
                || exp(&numbers),
            );
            for (found, x) in found.iter().zip(numbers) {
                assert_eq!(found.to_bits(), libm::exp(x).to_bits(), "exp {x}");
            }
        };
        for largest in [1e-9, 1e-3, 0.3, 1.0, 8.0, 100.0, 800.0] {
            for _ in 0..20_000 {
                check(std::array::from_fn(|_| largest * (2.0 * random.uniform() - 1.0)));
            }
        }
        // next to every border
        for halves in -40..40_i32 {
            let border = f64::from(halves) * 0.5 * std::f64::consts::LN_2;
            check(std::array::from_fn(|k| border + (k as f64 - 3.5) * 1e-15));
            check(std::array::from_fn(|k| border + (k as f64 - 3.5) * 1e-7));
        }
        check([0.0, -0.0, 1e-300, -1e-300, 1e300, -1e300, f64::INFINITY, f64::NEG_INFINITY]);
        check([700.0, -700.0, 709.7, -708.3, 1e-9, -1e-9, 5e-9, -5e-9]);
    }
}
