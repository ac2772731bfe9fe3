//! What every layer with weights holds: one bias, multiplier and shift per output channel, read in place.
//!
//! TFLite 8-bit specification, per-axis quantisation.

use crate::fixed::requantize;

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
    pub multipliers: &'m [u8],
    /// Biases in accumulator steps: little-endian i32, `[channels]`; see [`PerChannelQuant::bias`].
    pub biases: &'m [u8],
    /// Shifts, -31..=7: i8, `[channels]`, then zeros up to a multiple of four.
    pub shifts: &'m [u8],
    /// Weights: i8, output channel first.
    pub weights: &'m [u8],
}

impl PerChannelQuant<'_> {
    /// Bias of output channel `o`.
    pub fn bias(&self, o: usize) -> i32 {
        read_i32(self.biases, o)
    }

    /// Multiplier and shift of output channel `o`.
    pub fn scale(&self, o: usize) -> (i32, i8) {
        (read_i32(self.multipliers, o), self.shifts.get(o).map_or(0, |&s| s as i8))
    }

    /// Requantises an accumulator of output channel `o`.
    pub fn requantize(&self, o: usize, accumulator: i32) -> i32 {
        let (multiplier, shift) = self.scale(o);
        requantize(accumulator, multiplier, shift)
    }
}

/// The `index`-th little-endian i32; 0 beyond the end (the parser has checked that there is none).
pub(super) fn read_i32(bytes: &[u8], index: usize) -> i32 {
    match bytes.get(index * 4..).and_then(|rest| rest.first_chunk::<4>()) {
        Some(word) => i32::from_le_bytes(*word),
        None => 0,
    }
}
