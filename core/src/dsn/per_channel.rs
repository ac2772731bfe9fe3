//! What every layer with weights holds: one bias, multiplier and shift per output channel, read in place.
//!
//! TFLite 8-bit specification, per-axis quantisation.

use super::established;
use crate::fixed::{clamp_i8, requantize};

/// Weights, biases and multipliers of a layer with one set per output channel, read in place.
#[derive(Debug, Clone, Copy)]
pub struct PerChannelQuant<'m> {
    /// Zero point of the input.
    pub in_zp: i8,
    /// Zero point of the output.
    pub out_zp: i8,
    /// Least output: the activation's lower end.
    pub act_min: i8,
    /// Largest output; not below `act_min`.
    pub act_max: i8,
    /// Output channels.
    pub channels: usize,
    /// Multipliers, 0 or Q0.31 in 2^30..2^31: little-endian i32, `[channels]`; see [`PerChannelQuant::scale`].
    pub multipliers: &'m [[u8; 4]],
    /// Biases in accumulator steps: little-endian i32, `[channels]`; see [`PerChannelQuant::bias`].
    pub biases: &'m [[u8; 4]],
    /// Shifts, -31 to 7: i8, `[channels]`.
    pub shifts: &'m [u8],
    /// Weights: i8, output channel first.
    pub weights: &'m [u8],
}

impl PerChannelQuant<'_> {
    /// Bias of output channel `o`, which is below [`PerChannelQuant::channels`].
    #[inline(always)]
    pub fn bias(&self, o: usize) -> i32 {
        i32::from_le_bytes(established(self.biases.get(o).copied()))
    }

    /// Multiplier and shift of output channel `o`, which is below [`PerChannelQuant::channels`].
    #[inline(always)]
    pub fn scale(&self, o: usize) -> (i32, i8) {
        let multiplier = i32::from_le_bytes(established(self.multipliers.get(o).copied()));
        (multiplier, established(self.shifts.get(o).copied()) as i8)
    }

    /// The output of channel `o` for an accumulator: requantised, with the zero point, in the activation's range.
    #[inline(always)]
    pub fn output(&self, o: usize, accumulator: i32) -> i8 {
        let (multiplier, shift) = self.scale(o);
        let value = requantize(accumulator, multiplier, shift).wrapping_add(i32::from(self.out_zp));
        clamp_i8(value, self.act_min, self.act_max)
    }
}
