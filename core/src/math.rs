//! The crate's floating-point functions: free functions with the same bits on every target and in every build.
//!
//! Method calls such as `x.sqrt()` are never used in this crate: in a graph that links `std` they silently become
//! another implementation. `libm` is compiled from source everywhere; `+ - * /` are IEEE 754.

use micromath::F32Ext;

/// Square root, correctly rounded. Cost: about 15 instructions with an FPU.
pub fn sqrtf(x: f32) -> f32 {
    libm::sqrtf(x)
}

/// Nearest integer, halves away from zero. Exact.
pub fn roundf(x: f32) -> f32 {
    libm::roundf(x)
}

/// Nearest integer, halves away from zero, saturated to i32. Exact.
#[cfg(feature = "graph")]
pub fn round_to_i32(x: f64) -> i32 {
    libm::round(x) as i32
}

/// e^x by micromath's approximation, relative error below 0.3 % on -16 to 0: enough for a confidence, at a tenth
/// of the cost of `libm::expf`.
pub fn fast_expf(x: f32) -> f32 {
    F32Ext::exp(x)
}

/// Modified Bessel function of the first kind, order zero, by its power series.
///
/// The terms (x/2)^2k / k!^2 are all positive, so nothing cancels: relative error below 2e-6 for 0 <= x <= 40.
/// Bounded: at most 64 terms.
pub fn bessel_i0f(x: f32) -> f32 {
    let quarter = x * x / 4.0;
    let mut term = 1.0_f32;
    let mut sum = 1.0_f32;
    for k in 1_u8..64 {
        let k = f32::from(k);
        term = term * quarter / (k * k);
        sum += term;
        if term < sum * 1e-9 {
            break;
        }
    }
    sum
}

/// Sine and cosine of `2 pi k / n`, for tables made at compile time; error below 1e-15.
///
/// Reduced to the first octant in integers, then Taylor's series.
pub const fn sin_cos_turn(k: u64, n: u64) -> (f64, f64) {
    let n = if n == 0 { 1 } else { n };
    let k = k % n;
    // eight octants of n/8: work in units of 1/(8 n) turn to stay exact
    let eighths = 8 * k;
    let octant = eighths / n;
    let rest = eighths % n; // position inside the octant, out of n
    let within = if octant & 1 == 0 { rest } else { n - rest };
    let x = core::f64::consts::FRAC_PI_4 * (within as f64) / (n as f64);
    let x2 = x * x;
    let mut sine = 0.0;
    let mut cosine = 0.0;
    let mut degree = 22_u32;
    // Horner on both series together, highest degree first
    while degree > 0 {
        let d = degree as f64;
        cosine = 1.0 - x2 / (d * (d - 1.0)) * if degree == 22 { 1.0 } else { cosine };
        sine = 1.0 - x2 / ((d + 1.0) * d) * if degree == 22 { 1.0 } else { sine };
        degree -= 2;
    }
    let sine = x * sine;
    match octant {
        0 => (sine, cosine),
        1 => (cosine, sine),
        2 => (cosine, -sine),
        3 => (sine, -cosine),
        4 => (-sine, -cosine),
        5 => (-cosine, -sine),
        6 => (-cosine, sine),
        _ => (-sine, cosine),
    }
}

/// 2^(k/n) for 0 <= k < n, for tables made at compile time; error below 1e-15.
pub const fn exp2_fraction(k: u64, n: u64) -> f64 {
    let x = core::f64::consts::LN_2 * (k as f64) / (n as f64);
    let mut sum = 1.0;
    let mut degree = 24_u32;
    while degree > 0 {
        sum = 1.0 + x / (degree as f64) * sum;
        degree -= 1;
    }
    sum
}
