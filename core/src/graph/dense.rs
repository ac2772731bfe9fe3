//! Fully connected layers as LiteRT's reference kernel computes them: integers up to the accumulator, then f64.
//!
//! y = clamp(round(acc ratio) + z_y) with ratio = s_x s_w / s_y in f64, halves away from zero. tflite-micro and CMSIS-NN requantise this
//! layer in fixed point, as all other layers are here too; near a tie an output differs by one step.

use crate::dsn::ModelError;
use crate::dsn::established;
use crate::dsn::model::error::check;
use crate::fixed::clamp_i8;
use crate::math::round_to_i32;
use core::ops::Range;

/// Weights and scales of a fully connected layer, read in place.
#[derive(Debug, Clone, Copy)]
pub struct Dense<'m> {
    /// Zero points of input and output.
    pub zero_points: [i8; 2],
    /// Least and largest output.
    pub activation: [i8; 2],
    /// What a step of the accumulator is worth in steps of the output: little-endian f64, `[outputs]`.
    pub ratios: &'m [[u8; 8]],
    /// Biases in accumulator steps: little-endian i32, `[outputs]`.
    pub biases: &'m [[u8; 4]],
    /// Weights: i8, `[outputs, inputs]`.
    pub weights: &'m [u8],
}

impl Dense<'_> {
    /// Ratios in their legal range: finite, above zero and at most 2^7.
    pub(super) fn check(&self) -> Result<(), ModelError> {
        self.ratios.iter().try_for_each(|ratio| {
            let ratio = f64::from_le_bytes(*ratio);
            check("operator.ratio", ratio.to_bits() as i64, ratio > 0.0 && ratio <= 128.0)
        })
    }

    /// Output values `range` of `[inputs]`. Cost: a multiply-accumulate a weight, and a product of f64 an output.
    pub(super) fn forward(&self, input: &[i8], range: Range<usize>, output: &mut [i8]) {
        let (taps, [zero, out_zero]) = (input.len(), self.zero_points.map(i32::from));
        for (o, out) in range.zip(output) {
            let mut sum = i32::from_le_bytes(established(self.biases.get(o).copied()));
            let weights = established(self.weights.get(o * taps..(o + 1) * taps));
            for (&x, &w) in input.iter().zip(weights) {
                sum = sum.wrapping_add((i32::from(x) - zero) * i32::from(w as i8));
            }
            let ratio = f64::from_le_bytes(established(self.ratios.get(o).copied()));
            let value = round_to_i32(f64::from(sum) * ratio).saturating_add(out_zero);
            *out = clamp_i8(value, self.activation[0], self.activation[1]);
        }
    }
}
