//! Batch normalisation with ReLU as one int8 layer: a depthwise 1x1 convolution.
//!
//! TFLite 8-bit specification, DEPTHWISE_CONV_2D with a 1x1 kernel: acc = bias_c + (x - z_x) w_c.

use super::per_channel::PerChannelQuant;

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
        let zero = i32::from(self.quant.in_zp);
        for (from, to) in input.chunks_exact(channels).zip(output.chunks_exact_mut(channels)) {
            for (c, ((&x, y), &w)) in from.iter().zip(to).zip(self.quant.weights).enumerate() {
                let product = (i32::from(x) - zero) * i32::from(w as i8);
                *y = self.quant.output(c, self.quant.bias(c).wrapping_add(product));
            }
        }
    }
}
