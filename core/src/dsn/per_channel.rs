//! What every layer with weights holds: one bias, multiplier and shift per output channel, read in place.
//!
//! TFLite 8-bit specification, per-axis quantisation.

use crate::fixed::requantize;

/// Weights, biases and multipliers of a layer with one set per output channel, read in place.
#[derive(Debug, Clone, Copy)]
pub struct PerChannelQuant<'m> {
    pub(super) in_zp: i8,
    pub(super) out_zp: i8,
    pub(super) act_min: i8,
    pub(super) act_max: i8,
    pub(super) channels: usize,
    pub(super) multipliers: &'m [u8],
    pub(super) biases: &'m [u8],
    pub(super) shifts: &'m [u8],
    pub(super) weights: &'m [u8],
}

impl PerChannelQuant<'_> {
    /// Bias of output channel `o`.
    pub(super) fn bias(&self, o: usize) -> i32 {
        read_i32(self.biases, o)
    }

    /// Multiplier and shift of output channel `o`.
    pub(super) fn scale(&self, o: usize) -> (i32, i8) {
        (read_i32(self.multipliers, o), self.shifts.get(o).map_or(0, |&s| s as i8))
    }

    /// Requantises an accumulator of output channel `o`.
    pub(super) fn requantize(&self, o: usize, accumulator: i32) -> i32 {
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
