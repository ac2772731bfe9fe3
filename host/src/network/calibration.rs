//! Ranges of the activations: from what a float network does on training images to one int8 grid per activation.
//!
//! Two rules compete, the widest range seen and the one of least squared error; the caller keeps the one with the
//! smaller loss under fake quantisation (Jacob et al., 2018, section 3; Nagel et al., 2021, section 3.1).

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::float_network::{Activation, FloatNetwork};
use super::parameters::Images;

/// How the range of an activation is chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Rule {
    /// From the smallest to the largest value seen.
    #[serde(rename = "widest")]
    MinMax,
    /// The part of that range, from the same zero, with the least squared error.
    LeastError,
}

/// Shares of the widest range that [`Rule::LeastError`] tries.
const SHARES: [f32; 8] = [1.0, 0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3];

/// Affine int8 quantisation: value `q` means `(q - zero) scale`; 0 is representable.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct QuantParams {
    /// Real size of one step.
    pub scale: f32,
    /// Value that stands for zero.
    pub zero: i8,
}

impl QuantParams {
    /// The image's grid: pixel -128 is 0, pixel 127 is 1.
    pub const IMAGE: QuantParams = QuantParams { scale: 1.0 / 255.0, zero: -128 };

    /// The 256 steps that cover `low..=high` and zero.
    pub fn covering(low: f32, high: f32) -> QuantParams {
        let (low, high) = (low.min(0.0), high.max(0.0));
        let scale = (high - low) / 255.0;
        if !(scale.is_normal() && scale.is_finite()) {
            return QuantParams { scale: 1.0, zero: 0 };
        }
        QuantParams { scale, zero: (-128.0 - low / scale).round().clamp(-128.0, 127.0) as i8 }
    }

    /// The value nearest to `x`, half a step upwards.
    pub fn quantize(self, x: f32) -> i8 {
        // Counted from -128, so that the truncating conversion is a floor.
        let steps = x / self.scale + (f32::from(self.zero) + 128.5);
        (i16::from(steps.clamp(0.0, 255.0) as u8) - 128) as i8
    }

    /// The grid point nearest to `x`.
    pub fn round(self, x: f32) -> f32 {
        f32::from(i16::from(self.quantize(x)) - i16::from(self.zero)) * self.scale
    }

    /// Smallest and largest number on the grid.
    pub fn range(self) -> (f32, f32) {
        let at = |q: i16| f32::from(q - i16::from(self.zero)) * self.scale;
        (at(-128), at(127))
    }
}

/// The quantisation of every activation of a network.
#[derive(Debug, Clone, PartialEq)]
pub struct ActivationQuant {
    /// After the input convolution and the pooling.
    pub stem: QuantParams,
    /// Per block: affine, conv1, conv2, add.
    pub blocks: Vec<[QuantParams; 4]>,
    /// The answer.
    pub logits: QuantParams,
}

impl ActivationQuant {
    /// Parameters of an activation.
    pub fn of(&self, activation: Activation) -> QuantParams {
        match activation {
            Activation::Input => QuantParams::IMAGE,
            Activation::Stem => self.stem,
            Activation::BatchNorm(b) => self.blocks[b][0],
            Activation::Conv1(b) => self.blocks[b][1],
            Activation::Conv2(b) => self.blocks[b][2],
            Activation::Add(b) => self.blocks[b][3],
            Activation::Mean => self.blocks.last().map_or(self.stem, |b| b[3]),
            Activation::Logits => self.logits,
        }
    }
}

/// Position of an activation in the order they are computed.
pub(super) fn position(activation: Activation, blocks: usize) -> usize {
    match activation {
        Activation::Input => 0,
        Activation::Stem => 1,
        Activation::BatchNorm(b) => 2 + 4 * b,
        Activation::Conv1(b) => 3 + 4 * b,
        Activation::Conv2(b) => 4 + 4 * b,
        Activation::Add(b) => 5 + 4 * b,
        Activation::Mean => 2 + 4 * blocks,
        Activation::Logits => 3 + 4 * blocks,
    }
}

/// Chooses the activation_quant by both rules, from what the network does on `images`.
pub fn calibrate(network: &FloatNetwork, images: &Images) -> [(Rule, ActivationQuant); 2] {
    let blocks = network.architecture.blocks;
    let count = position(Activation::Logits, blocks) + 1;
    // records of an image lie in the order of `position`
    let (_, each) = network.evaluate(images, |seen: &mut Vec<(f32, f32)>, _, values| {
        seen.push(values.iter().fold((0.0, 0.0), |(low, high): (f32, f32), &v| (low.min(v), high.max(v))));
    });
    let range = |at: usize| {
        let seen = each.iter().map(|image| image[at]);
        seen.fold((0.0_f32, 0.0_f32), |(low, high), (l, h)| (low.min(l), high.max(h)))
    };
    let covering = |(low, high)| SHARES.map(|share| QuantParams::covering(share * low, share * high));
    let candidates: Vec<[QuantParams; SHARES.len()]> = (0..count).map(range).map(covering).collect();
    let (_, each) = network.evaluate(images, |errors: &mut Vec<[f64; SHARES.len()]>, _, values| {
        let error = |grid: QuantParams| values.iter().map(|&v| f64::from((v - grid.round(v)).powi(2))).sum();
        errors.push(candidates[errors.len()].map(error));
    });
    let sum = |at: usize, share: usize| each.iter().fold(0.0, |sum, image| sum + image[at][share]);
    let errors: Vec<[f64; SHARES.len()]> =
        (0..count).map(|at| std::array::from_fn(|share| sum(at, share))).collect();
    let mut best: Vec<QuantParams> = errors
        .iter()
        .zip(&candidates)
        .map(|(errors, activation_quant)| {
            let least = (0..SHARES.len()).fold(0, |best, i| if errors[i] < errors[best] { i } else { best });
            activation_quant[least]
        })
        .collect();
    let widest: Vec<QuantParams> = candidates.iter().map(|activation_quant| activation_quant[0]).collect();
    // The answer is never clipped: what would be lost there is the order of the classes.
    best[count - 1] = widest[count - 1];
    [(Rule::MinMax, widest), (Rule::LeastError, best)]
        .map(|(rule, activation_quant)| (rule, assemble(&activation_quant, blocks)))
}

/// One grid per [`position`], sorted into a network's places.
pub(super) fn assemble(activation_quant: &[QuantParams], blocks: usize) -> ActivationQuant {
    let at = |activation| activation_quant[position(activation, blocks)];
    let block = |b| {
        [Activation::BatchNorm(b), Activation::Conv1(b), Activation::Conv2(b), Activation::Add(b)].map(at)
    };
    ActivationQuant {
        stem: at(Activation::Stem),
        blocks: (0..blocks).map(block).collect(),
        logits: at(Activation::Logits),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zero_is_on_every_grid_and_a_rectified_one_starts_there() {
        for (low, high) in [(-1.0, 3.0), (0.0, 7.0), (-5.0, 0.0), (2.0, 3.0), (-0.3, 1000.0)] {
            let grid = QuantParams::covering(low, high);
            assert_eq!(grid.round(0.0), 0.0);
            let (bottom, top) = grid.range();
            assert!(bottom <= low.max(0.0) + grid.scale && top >= high - grid.scale, "{low} {high}");
        }
        assert_eq!(QuantParams::covering(0.0, 7.0).zero, -128);
        assert_eq!(QuantParams::covering(0.0, 0.0), QuantParams { scale: 1.0, zero: 0 });
    }

    #[test]
    fn rounding_errs_by_half_a_step_at_most() {
        let grid = QuantParams::covering(-2.0, 5.0);
        for i in 0..=700 {
            let x = -2.0 + i as f32 * 0.01;
            assert!((grid.round(x) - x).abs() <= 0.5001 * grid.scale + 1e-6, "{x}");
        }
        assert_eq!(QuantParams::IMAGE.quantize(1.0), 127);
        assert_eq!(grid.quantize(1e9), 127);
    }
}
