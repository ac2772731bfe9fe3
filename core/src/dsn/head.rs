//! The fully connected layer, the class and its confidence.
//!
//! The layer is a 1x1 convolution of a one-pixel image (TFLite CONV_2D, per-channel); softmax as in the paper.

use super::per_channel::PerChannelQuant;
use crate::math::fast_expf;

/// Most classes of a network.
pub const MAX_CLASSES: usize = 16;

/// The fully connected layer; weights `[classes, channels]`.
#[derive(Debug, Clone, Copy)]
pub struct Head<'m> {
    /// Weights and scales.
    pub quant: PerChannelQuant<'m>,
    /// Input channels.
    pub inputs: usize,
}

impl Head<'_> {
    /// `[channels]` to `[classes]`.
    pub fn forward(&self, features: &[i8], logits: &mut [i8]) {
        let rows = self.quant.weights.chunks_exact(self.inputs.max(1));
        for (o, (out, weights)) in logits.iter_mut().zip(rows).enumerate() {
            let mut sum = self.quant.bias(o);
            for (&x, &w) in features.iter().zip(weights) {
                sum = sum.wrapping_add((i32::from(x) - i32::from(self.quant.in_zp)) * i32::from(w as i8));
            }
            *out = self.quant.output(o, sum);
        }
    }
}

/// Probability of `class` by softmax of logits of `scale` nat a step; 0 if there is no such class.
pub fn confidence(logits: &[i8], class: usize, scale: f32) -> f32 {
    let Some(&top) = logits.get(class) else { return 0.0 };
    softmax_confidence(logits.iter().map(|&logit| (i32::from(logit) - i32::from(top)) as f32 * scale))
}

/// Probability of the class with the largest logit, from how far each class's, its own too, lies above it, in nat: 0 or
/// less. f32, relative error below 0.6 %; 0 of no classes.
pub fn softmax_confidence(above: impl Iterator<Item = f32>) -> f32 {
    // x < -16 by its bits: of numbers that are not positive the larger magnitude has the larger word
    let negligible = |x: f32| x.to_bits() > (-16.0_f32).to_bits();
    let sum = above.fold(0.0, |sum, x| if negligible(x) { sum } else { sum + fast_expf(x) });
    if sum.to_bits() == 0 { 0.0 } else { fast_expf(0.0) / sum }
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
