//! Softmax in integers: TFLite's reference kernel, which takes the exponential and the reciprocal of gemmlowp's fixed point.
//!
//! The exponential of Q5.26 numbers that are not positive is a polynomial of degree four below a quarter, times a constant for each
//! bit above; the reciprocal takes three steps of Newton and Raphson. Output: scale 1/256, zero point -128.

use crate::dsn::ModelError;
use crate::dsn::model::error::check;
use crate::fixed::{doubling_high_mul, rounding_divide};

/// Integer bits of a difference of inputs.
const DIFFERENCE_BITS: i32 = 5;
/// Integer bits of the sum of exponentials.
const SUM_BITS: i32 = 12;

/// Scale of a softmax: what makes differences of inputs Q5.26.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Softmax {
    /// Q0.31 in 2^30..2^31.
    pub multiplier: i32,
    /// Shift to the left before the multiplication.
    pub shift: i32,
    /// A difference below it counts as an exponential of zero.
    pub least_difference: i32,
}

impl Softmax {
    /// Fields in their legal range: no difference that counts leaves 32 bits, and no sum of exponentials reaches 512.
    pub(super) fn check(&self, channels: usize) -> Result<(), ModelError> {
        check("softmax.channels", channels as i64, channels < 512)?;
        check("softmax.multiplier", i64::from(self.multiplier), self.multiplier >= 1 << 30)?;
        check("softmax.shift", i64::from(self.shift), (0..=31).contains(&self.shift))?;
        let least = i64::from(self.least_difference);
        check(
            "softmax.least_difference",
            least,
            (-(1_i64 << (31 - self.shift).clamp(0, 31))..=0).contains(&least),
        )
    }

    /// A row of inputs to their probabilities. Cost: two exponentials a value, some 150 instructions.
    pub(super) fn forward(&self, input: &[i8], output: &mut [i8]) {
        let top = i32::from(input.iter().copied().max().unwrap_or(0));
        let exponential = |x: i8| {
            let difference = i32::from(x) - top;
            (difference >= self.least_difference)
                .then(|| exp(doubling_high_mul(difference.wrapping_shl(self.shift as u32), self.multiplier)))
        };
        let sum = input.iter().filter_map(|&x| exponential(x));
        let sum = sum.fold(0_i32, |sum, e| sum.wrapping_add(rounding_divide(e, SUM_BITS as u32)));
        let headroom = sum.leading_zeros();
        let above_one = ((sum as u32).wrapping_shl(headroom)).wrapping_sub(1 << 31) as i32;
        let reciprocal = reciprocal_of_one_plus(above_one);
        // 31 fractional bits to the eight of the output
        let shift = (SUM_BITS - headroom as i32 + 31 - 8).clamp(0, 31) as u32;
        for (&x, out) in input.iter().zip(output) {
            let scaled = |e| rounding_divide(doubling_high_mul(reciprocal, e), shift);
            let value = exponential(x).map_or(0, scaled) - 128;
            *out = value.clamp(-128, 127) as i8;
        }
    }
}

/// `x 2^bits`, saturated.
const fn shift_left(x: i32, bits: u32) -> i32 {
    let wide = (x as i64) << bits;
    if wide > i32::MAX as i64 {
        i32::MAX
    } else if wide < i32::MIN as i64 {
        i32::MIN
    } else {
        wide as i32
    }
}

/// e^a of a Q5.26 number that is not positive, Q0.31.
fn exp(a: i32) -> i32 {
    const FRACTION: u32 = 31 - DIFFERENCE_BITS as u32;
    const QUARTER: i32 = 1 << (FRACTION - 2);
    /// e^-(2^k) for k = -2 to 4, Q0.31.
    const POWERS: [i32; 7] = [1672461947, 1302514674, 790015084, 290630308, 39332535, 720401, 242];
    if a == 0 {
        return i32::MAX;
    }
    let below_quarter = (a & (QUARTER - 1)) - QUARTER;
    let mut result = exp_below_quarter(shift_left(below_quarter, DIFFERENCE_BITS as u32));
    let remainder = below_quarter.wrapping_sub(a);
    for (bit, power) in POWERS.into_iter().enumerate() {
        if remainder & (QUARTER << bit) != 0 {
            result = doubling_high_mul(result, power);
        }
    }
    result
}

/// e^a of a Q0.31 number in -1/4 to 0: Taylor's polynomial around -1/8.
fn exp_below_quarter(a: i32) -> i32 {
    const AT_MINUS_EIGHTH: i32 = 1895147668;
    const THIRD: i32 = 715827883;
    let x = a.wrapping_add(1 << 28);
    let x2 = doubling_high_mul(x, x);
    let x3 = doubling_high_mul(x2, x);
    let x4 = doubling_high_mul(x2, x2);
    let cubic = doubling_high_mul(rounding_divide(x4, 2).wrapping_add(x3), THIRD);
    let above_linear = rounding_divide(cubic.wrapping_add(x2), 1);
    AT_MINUS_EIGHTH.wrapping_add(doubling_high_mul(AT_MINUS_EIGHTH, x.wrapping_add(above_linear)))
}

/// 1 / (1 + a) of a Q0.31 number in 0 to 1, Q0.31.
fn reciprocal_of_one_plus(a: i32) -> i32 {
    /// 48/17 and -32/17, Q2.29.
    const START: [i32; 2] = [1515870810, -1010580540];
    // (a + 1) / 2, rounded; both are not negative
    let half = ((i64::from(a) + i64::from(i32::MAX) + 1) / 2) as i32;
    let mut x = START[0].wrapping_add(doubling_high_mul(half, START[1]));
    for _ in 0..3 {
        let error = (1_i32 << 29).wrapping_sub(doubling_high_mul(half, x));
        x = x.wrapping_add(shift_left(doubling_high_mul(x, error), 2));
    }
    shift_left(x, 1)
}
