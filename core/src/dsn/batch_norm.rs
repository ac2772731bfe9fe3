//! Batch normalisation with ReLU as one int8 layer: a depthwise 1x1 convolution.
//!
//! TFLite 8-bit specification, DEPTHWISE_CONV_2D with a 1x1 kernel: acc = bias_c + (x - z_x) w_c.

use super::per_channel::PerChannelQuant;
use crate::fixed::clamp_i8;

/// A per-channel scale and offset; weights `[channels]`.
#[derive(Debug, Clone, Copy)]
pub struct BatchNormRelu<'m> {
    /// Weights and scales.
    pub quant: PerChannelQuant<'m>,
}

impl BatchNormRelu<'_> {
    /// `[pixels, channels]` to the same shape. Cost: one multiply and one requantisation a value.
    pub fn forward(&self, input: &[i8], output: &mut [i8]) {
        let channels = self.quant.channels.max(1);
        for (from, to) in input.chunks_exact(channels).zip(output.chunks_exact_mut(channels)) {
            for (c, (&x, y)) in from.iter().zip(to).enumerate() {
                *y = self.value(c, x);
            }
        }
    }

    /// One value of channel `c`.
    pub(super) fn value(&self, c: usize, x: i8) -> i8 {
        let weight = self.quant.weights.get(c).map_or(0, |&w| i32::from(w as i8));
        let product = (i32::from(x) - i32::from(self.quant.in_zp)) * weight;
        let value = self.quant.requantize(c, self.quant.bias(c).wrapping_add(product));
        clamp_i8(value.wrapping_add(i32::from(self.quant.out_zp)), self.quant.act_min, self.quant.act_max)
    }
}
