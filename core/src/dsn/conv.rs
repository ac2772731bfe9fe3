//! 3x3 convolution in int8 with per-channel weights, padded as TFLite's SAME.
//!
//! TFLite 8-bit specification, CONV_2D: acc = bias + sum (x - z_x) w, y = requantize(acc) + z_y, clamped.

use super::established;
use super::per_channel::PerChannelQuant;

/// Most channels of a model.
pub const MAX_CHANNELS: usize = 32;

/// Most input channels of a convolution that the kernels compute: of a graph it may have more than of a [`Model`](super::Model).
pub(crate) const WIDEST: usize = if cfg!(feature = "graph") { 64 } else { MAX_CHANNELS };

/// The values under a kernel.
pub(crate) type Patch = [i16; 9 * WIDEST];

/// A [`Patch`] for scratch.
pub(crate) const EMPTY_PATCH: Patch = [0; 9 * WIDEST];

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
    /// All output channels of output pixel `(y, x)`, from `[height, width, inputs]`; `patch` is scratch.
    ///
    /// Cost: outputs x 9 x inputs multiply-accumulates. Padding contributes nothing.
    pub(crate) fn pixel(
        &self,
        input: &[i8],
        (height, width): (usize, usize),
        (y, x): (usize, usize),
        patch: &mut Patch,
        output: &mut [i8],
    ) {
        let first_row = (y * self.stride).wrapping_sub(pad_before(height, self.stride));
        let first_column = (x * self.stride).wrapping_sub(pad_before(width, self.stride));
        // the neighbourhood with the zero point taken off; outside the image it is zero
        let (zero, inputs) = (i16::from(self.quant.in_zp), self.inputs.max(1));
        for (k, cell) in patch.chunks_exact_mut(inputs).take(9).enumerate() {
            let (y, x) = (first_row.wrapping_add(k / 3), first_column.wrapping_add(k % 3));
            if y >= height || x >= width {
                cell.fill(0);
                continue;
            }
            for (out, &value) in cell.iter_mut().zip(established(input.get((y * width + x) * inputs..))) {
                *out = i16::from(value) - zero;
            }
        }
        let patch = established(patch.get(..9 * inputs));
        for (o, (out, weights)) in
            output.iter_mut().zip(self.quant.weights.chunks_exact(9 * inputs)).enumerate()
        {
            let mut sum = self.quant.bias(o);
            for (&x, &w) in patch.iter().zip(weights) {
                sum = sum.wrapping_add(i32::from(x) * i32::from(w as i8));
            }
            *out = self.quant.output(o, sum);
        }
    }
}
