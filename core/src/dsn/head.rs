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
    let sum = above.fold(0.0, |sum, x| if x < -16.0 { sum } else { sum + fast_expf(x) });
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Two classes of one weight each.
    fn head() -> Head<'static> {
        let layer = PerChannelQuant {
            in_zp: -3,
            out_zp: 5,
            act_min: -100,
            act_max: 100,
            channels: 2,
            multipliers: &[[0, 0, 0, 64]; 2], // 2^30: one half
            biases: &[[10, 0, 0, 0], [246, 255, 255, 255]],
            shifts: &[1, 0], // doubled again, and not
            weights: &[2, 253],
        };
        Head { quant: layer, inputs: 1 }
    }

    #[test]
    fn a_class_is_its_scaled_sum() {
        let mut logits = [0; 2];
        head().forward(&[4], &mut logits);
        // 10 + (4 + 3) 2 = 24; -10 - (4 + 3) 3 = -31, halved -15.5, which the first rounding takes to -15
        assert_eq!(logits, [24 + 5, -15 + 5]);
        head().forward(&[127], &mut logits);
        assert_eq!(logits, [100, -100]);
    }

    #[test]
    fn the_class_is_the_first_maximum() {
        for (logits, class) in [([1, 5, 5], 1), ([-128, -128, -128], 0), ([3, 2, 4], 2)] {
            assert_eq!(arg_max(&logits), class);
        }
    }

    #[test]
    fn far_below_the_best_counts_nothing() {
        assert_eq!(confidence(&[7, 7], 0, 1.0), 0.5);
        assert_eq!(confidence(&[1], 1, 1.0), 0.0, "no such class");
        assert_eq!(confidence(&[-17, -17, -17, -17, -17, 0], 5, 1.0), 1.0);
        assert!(confidence(&[-16, -16, -16, -16, -16, 0], 5, 1.0) < 1.0);
        let exact = 1.0 / (1.0 + libm::exp(-1.0) + libm::exp(-3.0));
        let found = f64::from(confidence(&[2, 1, -1], 0, 1.0));
        assert!((found / exact - 1.0).abs() < 6e-3, "{found} {exact}");
    }
}
