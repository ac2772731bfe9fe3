//! Fresnel's integrals C(x) and S(x) of cos and sin(pi t^2 / 2) from 0 to x.
//!
//! Power series up to |x| = 3, from there on the asymptotic series of the auxiliary functions f and g (Abramowitz and Stegun, 7.3.9, 7.3.27
//! and 7.3.28).

use std::f64::consts::{FRAC_PI_2, PI};

/// (C, S) to 1e-6.
pub fn fresnel(x: f64) -> (f64, f64) {
    let (size, t) = (x.abs(), FRAC_PI_2 * x * x);
    let (mut c, mut s) = (0.0, 0.0);
    if size < 3.0 {
        // term k is t^k / k!, with the signs + + - -, in C and in S by turns
        let (mut term, mut k) = (size, 0_u32);
        while term > 1e-17 || k < 20 {
            let part = term / f64::from(2 * k + 1) * if k & 2 == 0 { 1.0 } else { -1.0 };
            if k & 1 == 0 {
                c += part
            } else {
                s += part
            }
            k += 1;
            term *= t / f64::from(k);
        }
    } else {
        let z = PI * size * size;
        let w = 1.0 / (z * z);
        let f = (1.0 - w * (3.0 - w * (105.0 - w * 10_395.0))) / (PI * size);
        let g = (1.0 - w * (15.0 - w * 945.0)) / (PI * size * z);
        // whole turns are taken off: large arguments keep their phase
        let turn = 2.0 * PI * (0.25 * x * x - (0.25 * x * x).floor());
        let (sine, cosine) = (libm::sin(turn), libm::cos(turn));
        (c, s) = (0.5 + f * sine - g * cosine, 0.5 - f * cosine - g * sine);
    }
    if x < 0.0 { (-c, -s) } else { (c, s) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Abramowitz and Stegun, table 7.7.
    #[test]
    fn printed_values() {
        for (x, c, s) in [
            (0.5, 0.492_344_2, 0.064_732_4),
            (1.0, 0.779_893_4, 0.438_259_1),
            (2.0, 0.488_253_4, 0.343_415_7),
            (3.0, 0.605_720_8, 0.496_313_0),
            (4.0, 0.498_426_0, 0.420_515_8),
            (5.0, 0.563_631_2, 0.499_191_4),
        ] {
            let found = fresnel(x);
            assert!((found.0 - c).abs() < 2e-6 && (found.1 - s).abs() < 2e-6, "{x}: {found:?}");
            assert_eq!(fresnel(-x), (-found.0, -found.1));
        }
        let (below, above) = (fresnel(3.0 - 1e-9), fresnel(3.0));
        assert!((below.0 - above.0).abs() < 1e-6 && (below.1 - above.1).abs() < 1e-6);
    }
}
