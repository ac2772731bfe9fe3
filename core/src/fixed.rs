//! Fixed-point arithmetic: the one rounding rule of the int8 network.
//!
//! TFLite's reference rule (gemmlowp): saturating rounding doubling high multiply, then a rounding shift that takes
//! halves away from zero. Both steps round, hence "double rounding". [`requantize`] is the definition; `Requantizer` does the
//! same by one high product and one shift.

use crate::simd::mulh::mla_h;

/// `round(a b / 2^31)`, saturating the single overflow (`i32::MIN` squared).
pub(crate) const fn doubling_high_mul(a: i32, b: i32) -> i32 {
    if a == i32::MIN && b == i32::MIN {
        return i32::MAX;
    }
    // halves up; of a negative product gemmlowp's other nudge and its division towards zero are the same
    ((a as i64 * b as i64 + (1 << 30)) >> 31) as i32
}

/// `round(x / 2^exponent)`, halves away from zero; exponent 0 to 31, a larger one counts as 31.
pub(crate) const fn rounding_divide(x: i32, exponent: u32) -> i32 {
    let exponent = if exponent > 31 { 31 } else { exponent };
    let mask = ((1_i64 << exponent) - 1) as i32;
    let remainder = x & mask;
    let threshold = (mask >> 1) + (x < 0) as i32;
    (x >> exponent) + (remainder > threshold) as i32
}

/// Scales an accumulator by `multiplier / 2^31 * 2^shift`, rounding twice as TFLite's reference kernels do.
///
/// `multiplier` is 0 or Q0.31 in 2^30..2^31; `shift` is -31 to 7. A left shift wraps, as in the reference.
pub const fn requantize(accumulator: i32, multiplier: i32, shift: i8) -> i32 {
    let left = if shift > 0 { shift as u32 } else { 0 };
    let right = if shift < 0 { shift.unsigned_abs() as u32 } else { 0 };
    rounding_divide(doubling_high_mul(accumulator.wrapping_shl(left), multiplier), right)
}

/// Clamps to an int8 activation range; `low <= high`, both within -128 to 127.
pub const fn clamp_i8(value: i32, low: i8, high: i8) -> i8 {
    if value < low as i32 {
        low
    } else if value > high as i32 {
        high
    } else {
        value as i8
    }
}

/// Binary logarithm of four: the least multiple of an accumulator that a [`Requantizer`] takes.
pub(crate) const TIMES_FOUR: u32 = 2;

/// [`requantize`] with a zero point, of accumulators that are held times 2^`BITS`, at least four: one high product and one shift.
///
/// With m the multiplier, h = floor(4 acc m / 2^32) and e = -shift, `round(acc m / 2^31)` is `(h + 1) >> 1` as m is not
/// negative, and rounding halves away from zero is `(x + 2^(e-1) - [acc < 0]) >> e`, where for x = 0 the last term changes
/// nothing. Floors of floors are one: `(h + 1 + 2^e - 2 [acc < 0]) >> (e + 1)`. The zero point goes in as `zero 2^(e+1)`.
/// With more bits everything but the high product is as many times as large: floors of floors again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Requantizer {
    multiplier: i32,
    offset: i32,
    shift: u32,
}

impl Requantizer {
    /// Accumulators are smaller than this, so that four of them fit a word; those times 2^`BITS` are below 2^(31 - `BITS`).
    pub const MAX_ACCUMULATOR: i64 = 1 << (31 - TIMES_FOUR);

    /// Words of a packed one.
    pub const WORDS: usize = 3;

    /// For `requantize(acc, multiplier, shift) + zero`; `None` unless the shift is in -20 to -1.
    pub const fn new<const BITS: u32>(multiplier: i32, shift: i8, zero: i8) -> Option<Self> {
        if shift < -20 || shift > -1 || multiplier < 0 {
            return None;
        }
        let shift = 1 + shift.unsigned_abs() as u32;
        let (offset, more) = (1 + (1 << (shift - 1)) + ((zero as i32) << shift), BITS - TIMES_FOUR);
        Some(Requantizer { multiplier, offset: offset << more, shift: shift + more })
    }

    /// Whether all accumulators are in its range.
    #[cfg(feature = "graph")]
    #[inline(always)]
    pub fn takes(&self, accumulators: &[i32]) -> bool {
        let bits =
            accumulators.iter().fold(0, |bits, accumulator| bits | (accumulator ^ (accumulator >> 31)));
        i64::from(bits) < Self::MAX_ACCUMULATOR
    }

    /// As words.
    pub const fn to_words(self) -> [i32; Self::WORDS] {
        [self.multiplier, self.offset, self.shift as i32]
    }

    /// From words.
    #[inline(always)]
    pub const fn from_words([multiplier, offset, shift]: [i32; Self::WORDS]) -> Self {
        Requantizer { multiplier, offset, shift: shift as u32 }
    }

    /// The output for an accumulator times 2^`BITS`, saturated to int8.
    #[inline(always)]
    pub fn apply<const BITS: u32>(&self, multiple: i32) -> i8 {
        let x = mla_h(self.offset, multiple, self.multiplier).wrapping_add((multiple >> 31) << (BITS - 1));
        (x >> (self.shift & 31)).clamp(-128, 127) as i8
    }
}
