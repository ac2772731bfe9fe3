//! The requantiser against its definition in whole numbers: every shift, every kind of edge, and all small values.
//!
//! Oracle: gemmlowp's two roundings as floor divisions of i128, sharing no expression with the crate.

use sdp3_core::fixed::requantize;

/// `round(a m / 2^31)`: nearest, halves up of positive and of negative products alike.
fn doubling_high(a: i128, m: i128) -> i128 {
    // gemmlowp truncates after adding 2^30, or 1 - 2^30 to a negative product: both are the floor of x + 1/2
    (a * m + (1 << 30)).div_euclid(1 << 31)
}

/// `round(x / 2^n)`, halves away from zero.
fn rounding_shift(x: i128, n: u32) -> i128 {
    let magnitude = (2 * x.abs() + (1 << n)).div_euclid(2 << n);
    if x < 0 { -magnitude } else { magnitude }
}

fn definition(accumulator: i32, multiplier: i32, shift: i8) -> i32 {
    let left = u32::from(shift.max(0).unsigned_abs());
    let right = u32::from(shift.min(0).unsigned_abs());
    let wrapped = ((i128::from(accumulator) << left) as u32) as i32; // a left shift wraps at 32 bits
    rounding_shift(doubling_high(i128::from(wrapped), i128::from(multiplier)), right) as i32
}

/// 0, 1, 2^k - 1, 2^k, 2^k + 1 and their negatives, and the ends of the range.
fn edges() -> Vec<i32> {
    let mut all = vec![0, i32::MAX, i32::MIN, i32::MIN + 1, i32::MAX - 1];
    for k in 0..31 {
        for near in [-1, 0, 1] {
            all.extend([(1 << k) + near, -(1 << k) + near]);
        }
    }
    all.sort_unstable();
    all.dedup();
    all
}

/// 0 and the legal range's ends, neighbours and middle.
const MULTIPLIERS: [i32; 9] = [
    0,
    1 << 30,
    (1 << 30) + 1,
    1_518_500_250, // 2^31 / sqrt(2)
    3 << 29,
    (3 << 29) + 1,
    1_999_999_999,
    i32::MAX - 1,
    i32::MAX,
];

const SHIFTS: core::ops::RangeInclusive<i8> = -31..=7;

#[test]
fn every_shift_at_every_edge() {
    for shift in SHIFTS {
        for multiplier in MULTIPLIERS {
            for &accumulator in &edges() {
                let expected = definition(accumulator, multiplier, shift);
                let found = requantize(accumulator, multiplier, shift);
                assert_eq!(found, expected, "{accumulator} * {multiplier} * 2^{shift}");
            }
        }
    }
}

#[test]
fn every_sixteen_bit_accumulator_at_every_shift() {
    let step = if cfg!(miri) { 4099 } else { 1 };
    for shift in SHIFTS {
        for multiplier in MULTIPLIERS {
            for accumulator in (-(1 << 15)..=1 << 15).step_by(step) {
                let expected = definition(accumulator, multiplier, shift);
                assert_eq!(
                    requantize(accumulator, multiplier, shift),
                    expected,
                    "{accumulator} {multiplier} {shift}"
                );
            }
        }
    }
}

#[test]
fn every_tie_of_the_second_rounding() {
    // 2^30 and a shift of one to the left make the first step exact: x goes in as x, halves are hit exactly
    for shift in 1..=20_u32 {
        for whole in -300_i32..=300 {
            for beside in [-1, 0, 1] {
                let x = (whole << shift) + (1 << (shift - 1)) + beside;
                let found = requantize(2 * x, 1 << 30, -(shift as i8));
                assert_eq!(i128::from(found), rounding_shift(i128::from(x), shift), "{x} / 2^{shift}");
            }
        }
    }
}

#[test]
fn a_shift_beyond_the_word_is_the_longest() {
    for accumulator in [i32::MIN, -1, 0, 1, i32::MAX] {
        let [far, longest] = [-40, -31].map(|shift| requantize(accumulator, i32::MAX, shift));
        assert_eq!(far, longest);
    }
    assert_eq!(requantize(i32::MIN, i32::MIN, 0), i32::MAX, "the single overflow saturates");
}
