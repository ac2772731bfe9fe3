//! Fixed-point arithmetic: the one rounding rule of the int8 network.
//!
//! TFLite's reference rule (gemmlowp): saturating rounding doubling high multiply, then a rounding shift that takes
//! halves away from zero. Both steps round, hence "double rounding".

/// `round(a b / 2^31)`, saturating the single overflow (`i32::MIN` squared).
pub const fn saturating_rounding_doubling_high_mul(a: i32, b: i32) -> i32 {
    if a == i32::MIN && b == i32::MIN {
        return i32::MAX;
    }
    let product = a as i64 * b as i64;
    let nudge = if product >= 0 { 1 << 30 } else { 1 - (1 << 30) };
    ((product + nudge) / (1 << 31)) as i32
}

/// `round(x / 2^exponent)`, halves away from zero; exponent 0..=31.
pub const fn rounding_divide_by_power_of_two(x: i32, exponent: u32) -> i32 {
    let exponent = if exponent > 31 { 31 } else { exponent };
    let mask = ((1_i64 << exponent) - 1) as i32;
    let remainder = x & mask;
    let threshold = (mask >> 1) + (x < 0) as i32;
    (x >> exponent) + (remainder > threshold) as i32
}

/// Scales an accumulator by `multiplier / 2^31 * 2^shift`, rounding twice as TFLite's reference kernels do.
///
/// `multiplier` is 0 or Q0.31 in 2^30..2^31; `shift` is -31..=7. A left shift wraps, as in the reference.
pub const fn requantize(accumulator: i32, multiplier: i32, shift: i8) -> i32 {
    let left = if shift > 0 { shift as u32 } else { 0 };
    let right = if shift < 0 { shift.unsigned_abs() as u32 } else { 0 };
    let scaled = saturating_rounding_doubling_high_mul(accumulator.wrapping_shl(left), multiplier);
    rounding_divide_by_power_of_two(scaled, right)
}

/// Clamps to an int8 activation range; `low <= high`, both within -128..=127.
pub const fn clamp_i8(value: i32, low: i8, high: i8) -> i8 {
    if value < low as i32 {
        low
    } else if value > high as i32 {
        high
    } else {
        value as i8
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn high_multiply_rounds_to_nearest() {
        assert_eq!(saturating_rounding_doubling_high_mul(i32::MIN, i32::MIN), i32::MAX);
        assert_eq!(saturating_rounding_doubling_high_mul(1 << 30, 1 << 30), 1 << 29);
        // 3 * 2^29 / 2^31 = 0.75 -> 1; -0.75 -> -1
        assert_eq!(saturating_rounding_doubling_high_mul(3, 1 << 29), 1);
        assert_eq!(saturating_rounding_doubling_high_mul(-3, 1 << 29), -1);
        // exactly one half: up for positive, towards zero for negative (gemmlowp's nudge)
        assert_eq!(saturating_rounding_doubling_high_mul(2, 1 << 29), 1);
        assert_eq!(saturating_rounding_doubling_high_mul(-2, 1 << 29), 0);
    }

    #[test]
    fn rounding_shift_takes_halves_away_from_zero() {
        for exponent in 0..=31_u32 {
            for x in [0, 1, -1, 2, -2, 3, -3, 5, -5, 127, -128, 1 << 20, -(1 << 20), i32::MAX, i32::MIN] {
                let scale = (1_i64 << exponent) as f64;
                let exact = f64::from(x) / scale;
                let away = if exact < 0.0 { -libm::floor(-exact + 0.5) } else { libm::floor(exact + 0.5) };
                assert_eq!(
                    f64::from(rounding_divide_by_power_of_two(x, exponent)),
                    away,
                    "{x} >> {exponent}"
                );
            }
        }
    }

    #[test]
    fn a_shift_beyond_the_word_is_the_longest() {
        for x in [i32::MIN, -1, 0, 1, i32::MAX] {
            assert_eq!(rounding_divide_by_power_of_two(x, 40), rounding_divide_by_power_of_two(x, 31));
        }
        assert_eq!(rounding_divide_by_power_of_two(i32::MIN, 31), -1);
        assert_eq!(rounding_divide_by_power_of_two(i32::MAX, 31), 1);
    }

    #[test]
    fn requantising_stays_within_one_of_the_exact_product() {
        let mut state = 1_u32;
        for _ in 0..100_000 {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let accumulator = (state as i32) >> 8;
            let multiplier = (1 << 30) + (state >> 2) as i32 % (1 << 30);
            let shift = -((state >> 27) as i8 % 16);
            let exact = f64::from(accumulator) * f64::from(multiplier) / 2_147_483_648.0
                * libm::exp2(f64::from(shift));
            assert!((f64::from(requantize(accumulator, multiplier, shift)) - exact).abs() <= 1.0);
        }
    }
}
