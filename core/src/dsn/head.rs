//! The fully connected layer, the answer and its confidence.
//!
//! The layer is a 1x1 convolution of a one-pixel image (TFLite CONV_2D, per-channel); softmax as in the paper.

use super::channelwise::Channelwise;
use crate::fixed::clamp_i8;
use crate::math::fast_expf;

/// Most classes of a network.
pub const MAX_CLASSES: usize = 16;

/// The fully connected layer; weights `[classes, channels]`.
#[derive(Debug, Clone, Copy)]
pub struct Head<'m> {
    pub(super) layer: Channelwise<'m>,
    pub(super) inputs: usize,
    pub(super) scale: f32,
}

impl Head<'_> {
    /// `[channels]` to `[classes]`.
    pub fn forward(&self, features: &[i8], logits: &mut [i8]) {
        let rows = self.layer.weights.chunks_exact(self.inputs.max(1));
        for (o, (out, weights)) in logits.iter_mut().zip(rows).enumerate() {
            let mut sum = self.layer.bias(o);
            for (&x, &w) in features.iter().zip(weights) {
                sum = sum.wrapping_add((i32::from(x) - i32::from(self.layer.in_zp)) * i32::from(w as i8));
            }
            let y = self.layer.requantize(o, sum).wrapping_add(i32::from(self.layer.out_zp));
            *out = clamp_i8(y, self.layer.act_min, self.layer.act_max);
        }
    }

    /// Probability of `class` by softmax, f32, relative error below 0.6 %.
    pub fn confidence(&self, logits: &[i8], class: usize) -> f32 {
        let Some(&top) = logits.get(class) else { return 0.0 };
        let mut sum = 0.0_f32;
        for &logit in logits {
            let x = (i32::from(logit) - i32::from(top)) as f32 * self.scale;
            sum += if x < -16.0 { 0.0 } else { fast_expf(x) };
        }
        if sum > 0.0 { fast_expf(0.0) / sum } else { 0.0 }
    }
}

/// Index of the first maximum.
pub fn arg_max(logits: &[i8]) -> usize {
    let mut best = (0, i8::MIN);
    for (index, &logit) in logits.iter().enumerate() {
        if logit > best.1 {
            best = (index, logit);
        }
    }
    best.0
}
