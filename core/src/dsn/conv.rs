//! 3x3 convolution in int8 with per-channel weights, padded as TFLite's SAME.
//!
//! TFLite 8-bit specification, CONV_2D: acc = bias + sum (x - z_x) w, y = requantize(acc) + z_y, clamped.

use super::per_channel::PerChannelQuant;
use crate::fixed::clamp_i8;

/// Most input channels of a convolution.
pub const MAX_CHANNELS: usize = 32;

/// Values under a kernel.
const PATCH: usize = 9 * MAX_CHANNELS;

/// A 3x3 convolution; weights `[output, 3, 3, input]`.
#[derive(Debug, Clone, Copy)]
pub struct Conv<'m> {
    /// Weights and scales.
    pub quant: PerChannelQuant<'m>,
    /// Input channels.
    pub inputs: usize,
    /// Stride of both axes, 1 or 2.
    pub stride: usize,
}

/// Length of a convolved or padded axis: ceil(n / stride).
pub const fn same(n: usize, stride: usize) -> usize {
    if stride == 0 { 0 } else { n.div_ceil(stride) }
}

/// TFLite's SAME padding before the axis: half of what is missing, rounded down.
pub const fn pad_before(n: usize, stride: usize) -> usize {
    (same(n, stride).saturating_sub(1) * stride + 3).saturating_sub(n) / 2
}

impl Conv<'_> {
    /// Output channels.
    pub fn channels(&self) -> usize {
        self.quant.channels
    }

    /// Convolves row `y` of the output: `[width_out, outputs]` from `[height, width, inputs]`.
    ///
    /// Cost: width_out x outputs x 9 x inputs multiply-accumulates. Padding contributes nothing.
    pub fn row(&self, input: &[i8], height: usize, width: usize, y: usize, output: &mut [i8]) {
        let outputs = self.quant.channels;
        let first_row = (y * self.stride).wrapping_sub(pad_before(height, self.stride));
        let before = pad_before(width, self.stride);
        let mut patch = [0_i16; PATCH];
        for (x, pixel) in output.chunks_exact_mut(outputs.max(1)).enumerate() {
            let first_column = (x * self.stride).wrapping_sub(before);
            self.gather(input, (height, width), (first_row, first_column), &mut patch);
            self.pixel(&patch, pixel);
        }
    }

    /// Widens the 3x3 neighbourhood to i16 with the zero point taken off; outside the image it is zero.
    fn gather(&self, input: &[i8], size: (usize, usize), first: (usize, usize), patch: &mut [i16; PATCH]) {
        let (height, width) = size;
        let zero = i16::from(self.quant.in_zp);
        let row_length = 3 * self.inputs;
        for (ky, row) in patch.chunks_exact_mut(row_length.max(1)).take(3).enumerate() {
            row.fill(0);
            let y = first.0.wrapping_add(ky);
            if y >= height {
                continue;
            }
            for (kx, cell) in row.chunks_exact_mut(self.inputs.max(1)).enumerate() {
                let x = first.1.wrapping_add(kx);
                if x >= width {
                    continue;
                }
                let at = (y * width + x) * self.inputs;
                for (out, &value) in cell.iter_mut().zip(input.get(at..).unwrap_or(&[])) {
                    *out = i16::from(value) - zero;
                }
            }
        }
    }

    /// All output channels of one pixel.
    fn pixel(&self, patch: &[i16; PATCH], pixel: &mut [i8]) {
        let taps = 9 * self.inputs;
        let patch = patch.get(..taps).unwrap_or(&[]);
        let weights = self.quant.weights.chunks_exact(taps.max(1));
        for (o, (out, weights)) in pixel.iter_mut().zip(weights).enumerate() {
            let mut sum = self.quant.bias(o);
            for (&x, &w) in patch.iter().zip(weights) {
                sum = sum.wrapping_add(i32::from(x) * i32::from(w as i8));
            }
            let y = self.quant.requantize(o, sum).wrapping_add(i32::from(self.quant.out_zp));
            *out = clamp_i8(y, self.quant.act_min, self.quant.act_max);
        }
    }

    /// The whole output, `[same(height), same(width), outputs]`.
    pub fn forward(&self, input: &[i8], height: usize, width: usize, output: &mut [i8]) {
        let row_length = same(width, self.stride) * self.quant.channels;
        for (y, row) in output.chunks_exact_mut(row_length.max(1)).take(same(height, self.stride)).enumerate()
        {
            self.row(input, height, width, y, row);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn padding_is_tflites() {
        // (n, stride) -> (out, before): 64/2 pads 0 before and 1 after; 35/2 pads 1 and 1
        assert_eq!((same(64, 2), pad_before(64, 2)), (32, 0));
        assert_eq!((same(35, 2), pad_before(35, 2)), (18, 1));
        assert_eq!((same(10, 1), pad_before(10, 1)), (10, 1));
    }
}
