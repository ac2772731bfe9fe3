//! Requantising an accumulator that is held times four, as the tiles leave it: one high product and one shift.

use crate::dsn::per_channel::PerChannelQuant;
use crate::simd::mulh::mla_h;

/// Largest right shift.
const MAX_SHIFT: i8 = 20;

/// Accumulators are smaller than this, so that four of them fit a word.
pub const MAX_ACCUMULATOR: i64 = 1 << 29;

/// Start and scale of one output channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rescale {
    /// What four times the sum starts with: bias and zero point of the input.
    pub start: i32,
    multiplier: i32,
    offset: i32,
    shift: u32,
}

/// Words of a [`Rescale`].
pub const WORDS: usize = 4;

impl Rescale {
    /// `requantize(acc, multiplier, shift) + zero` of accumulators that start with `start`; `None` if the shift is not
    /// in -20..=-1.
    ///
    /// The rule of [`crate::fixed::requantize`] for |acc| < 2^29: with m the multiplier, h = floor(4 acc m / 2^32) and
    /// e = -shift, `round(acc m / 2^31)` is `(h + 1) >> 1` as m is not negative, and rounding halves away from zero is
    /// `(x + 2^(e-1) - [acc < 0]) >> e`, where for x = 0 the last term changes nothing. Floors of floors are one:
    /// `(h + 1 + 2^e - 2 [acc < 0]) >> (e + 1)`. The zero point goes in as `zero 2^(e+1)`.
    pub fn new(start: i64, multiplier: i32, shift: i8, zero: i8) -> Option<Self> {
        if !(-MAX_SHIFT..=-1).contains(&shift) || multiplier < 0 || start.abs() >= MAX_ACCUMULATOR {
            return None;
        }
        let shift = 1 + u32::from(shift.unsigned_abs());
        let offset = 1 + (1 << (shift - 1)) + (i32::from(zero) << shift);
        Some(Rescale { start: (start << 2) as i32, multiplier, offset, shift })
    }

    /// [`Rescale`] of output channel `o` of a layer whose `taps` weights of that channel have this `sum`, for inputs as
    /// u8 = i8 + 128; `None` also if an accumulator could leave +-[`MAX_ACCUMULATOR`].
    pub fn of(layer: &PerChannelQuant<'_>, o: usize, sum: i32, taps: usize) -> Option<Self> {
        let bias = i64::from(layer.bias(o));
        if bias.abs() + 255 * 128 * taps as i64 >= MAX_ACCUMULATOR {
            return None;
        }
        let (multiplier, shift) = layer.scale(o);
        let start = bias - i64::from(i32::from(layer.in_zp) + 128) * i64::from(sum);
        Self::new(start, multiplier, shift, layer.out_zp)
    }

    /// As words.
    pub fn to_words(self) -> [i32; WORDS] {
        [self.start, self.multiplier, self.offset, self.shift as i32]
    }

    /// From words.
    #[inline(always)]
    pub fn from_words([start, multiplier, offset, shift]: [i32; WORDS]) -> Self {
        Rescale { start, multiplier, offset, shift: shift as u32 }
    }

    /// The output for four times an accumulator, saturated.
    #[inline(always)]
    pub fn apply(&self, four: i32) -> i8 {
        let x = mla_h(self.offset, four, self.multiplier).wrapping_add((four >> 31) << 1);
        (x >> (self.shift & 31)).clamp(-128, 127) as i8
    }
}

/// Clamps outputs that are saturated to int8 to a layer's range.
pub fn clamp_all(values: &mut [i8], (low, high): (i8, i8)) {
    if (low, high) != (i8::MIN, i8::MAX) {
        values.iter_mut().for_each(|value| *value = (*value).max(low).min(high));
    }
}
