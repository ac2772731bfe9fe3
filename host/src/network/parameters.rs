//! A deep spectrogram network as plain numbers: its shape, its parameters and the images it is trained on.
//!
//! Paper, section V: an input convolution with pooling, residual blocks BN-ReLU-Conv-BN-ReLU-Conv, and a classifier.

use crate::numerics::random::box_muller;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use serde::{Deserialize, Serialize};

/// Added to a variance before its root, in training and when folding.
pub const BATCH_NORM_EPSILON: f64 = 1e-5;

/// Labelled spectrograms of one size.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Images {
    /// Doppler rows.
    pub rows: usize,
    /// STFT frames.
    pub frames: usize,
    /// Pixels `[image][row][frame]`; the real value is `(pixel + 128) / 255`.
    pub pixels: Vec<i8>,
    /// Class of each image.
    pub labels: Vec<u8>,
}

impl Images {
    /// Number of images.
    pub fn len(&self) -> usize {
        self.labels.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.labels.is_empty()
    }

    /// Pixels of one image, `[row][frame]`.
    pub fn image(&self, index: usize) -> &[i8] {
        let size = self.rows * self.frames;
        &self.pixels[index * size..(index + 1) * size]
    }
}

/// Shape of a network.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Architecture {
    /// Channels of every convolution, C.
    pub channels: usize,
    /// Residual blocks.
    pub blocks: usize,
    /// Stride of the input convolution, 1 or 2.
    pub stem_stride: usize,
    /// Classes.
    pub classes: usize,
}

/// Weights and biases of a convolution or of the classifier.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Weights {
    /// Weights: `[O][I][3][3]` of a convolution, `[O][I]` of the classifier.
    pub weights: Vec<f32>,
    /// Biases `[O]`.
    pub biases: Vec<f32>,
}

/// Batch normalisation `gamma (x - mean) / sqrt(variance + epsilon) + beta`, each `[C]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Norm {
    /// Learned factors.
    pub gamma: Vec<f32>,
    /// Learned offsets.
    pub beta: Vec<f32>,
    /// Running means.
    pub mean: Vec<f32>,
    /// Running variances.
    pub variance: Vec<f32>,
}

impl Norm {
    /// The factor and offset of every channel that inference multiplies and adds.
    pub fn affine(&self) -> Vec<(f64, f64)> {
        let channels = self.gamma.iter().zip(&self.beta).zip(self.mean.iter().zip(&self.variance));
        channels
            .map(|((&gamma, &beta), (&mean, &variance))| {
                let factor = f64::from(gamma) / (f64::from(variance) + BATCH_NORM_EPSILON).sqrt();
                (factor, f64::from(beta) - f64::from(mean) * factor)
            })
            .collect()
    }
}

/// Parameters of a residual block.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BlockParameters {
    /// Before the first convolution; cannot fold, the skip leaves before it.
    pub norm1: Norm,
    /// First convolution `[C][C][3][3]`; the normalisation after it makes a bias needless.
    pub conv1: Vec<f32>,
    /// Between the convolutions.
    pub norm2: Norm,
    /// Second convolution.
    pub conv2: Weights,
}

/// All parameters of a network.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Parameters {
    /// Shape.
    pub architecture: Architecture,
    /// Input convolution, 1 -> C.
    pub stem: Weights,
    /// Residual blocks.
    pub blocks: Vec<BlockParameters>,
    /// Classifier, C -> classes.
    pub head: Weights,
}

impl Parameters {
    /// A network before training: He's normal weights, from the seed alone.
    ///
    /// The second convolution of a block is scaled down by the root of the number of blocks, so that the sum of all
    /// branches starts as large as the skip.
    pub fn initial(architecture: Architecture, seed: u64) -> Parameters {
        let Architecture { channels: c, blocks, classes, .. } = architecture;
        let mut random = stream(seed, Stream::Weights, 0);
        let mut normal = |count: usize, inputs: usize, gain: f64| -> Vec<f32> {
            let deviation = gain / (inputs as f64).sqrt();
            (0..count).map(|_| (deviation * box_muller(&mut random)) as f32).collect()
        };
        let norm =
            || Norm { gamma: vec![1.0; c], beta: vec![0.0; c], mean: vec![0.0; c], variance: vec![1.0; c] };
        let he = std::f64::consts::SQRT_2;
        let stem = Weights { weights: normal(9 * c, 9, he), biases: vec![0.0; c] };
        let blocks = (0..blocks)
            .map(|_| BlockParameters {
                norm1: norm(),
                conv1: normal(9 * c * c, 9 * c, he),
                norm2: norm(),
                conv2: Weights {
                    weights: normal(9 * c * c, 9 * c, he / (blocks as f64).sqrt()),
                    biases: vec![0.0; c],
                },
            })
            .collect();
        let head = Weights { weights: normal(c * classes, c, 1.0), biases: vec![0.0; classes] };
        Parameters { architecture, stem, blocks, head }
    }

    /// Number of trained parameters (running statistics are not trained).
    pub fn count(&self) -> usize {
        let weights = |w: &Weights| w.weights.len() + w.biases.len();
        let block = |b: &BlockParameters| {
            b.conv1.len() + weights(&b.conv2) + 2 * (b.norm1.gamma.len() + b.norm2.gamma.len())
        };
        weights(&self.stem) + self.blocks.iter().map(block).sum::<usize>() + weights(&self.head)
    }
}

/// What random numbers are drawn for.
#[derive(Debug, Clone, Copy)]
pub(super) enum Stream {
    Weights = 1,
    Shuffle = 2,
}

/// The generator of one purpose and index under a seed.
pub(super) fn stream(seed: u64, purpose: Stream, index: u64) -> Xoshiro256PlusPlus {
    let mut key = [0u8; 32];
    for (bytes, word) in key.chunks_exact_mut(8).zip([seed, purpose as u64, index, 0x7072_6564_6963_746f]) {
        bytes.copy_from_slice(&word.to_le_bytes());
    }
    let mut random = Xoshiro256PlusPlus::from_seed(key);
    for _ in 0..16 {
        random.next_u64();
    }
    random
}

/// A permutation of `0..count`, Fisher and Yates; a function of seed and round.
pub(crate) fn shuffled(count: usize, seed: u64, round: u64) -> Vec<usize> {
    let mut random = stream(seed, Stream::Shuffle, round);
    let mut order: Vec<usize> = (0..count).collect();
    for i in (1..count).rev() {
        let j = ((u128::from(random.next_u64()) * (i as u128 + 1)) >> 64) as usize;
        order.swap(i, j);
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAPER: Architecture = Architecture { channels: 8, blocks: 5, stem_stride: 1, classes: 5 };

    #[test]
    fn eight_channels_and_five_blocks_have_six_thousand_parameters() {
        // stem 72 + 8; block 576 + 576 + 8 + 4 * 8; head 40 + 5.
        assert_eq!(Parameters::initial(PAPER, 1).count(), 80 + 5 * 1192 + 45);
    }

    #[test]
    fn initial_weights_depend_on_the_seed_alone_and_have_hes_spread() {
        let a = Parameters::initial(PAPER, 7);
        assert_eq!(a, Parameters::initial(PAPER, 7));
        assert_ne!(a.stem, Parameters::initial(PAPER, 8).stem);
        let all: Vec<f32> = a.blocks.iter().flat_map(|b| b.conv1.iter().copied()).collect();
        let power = all.iter().map(|w| w * w).sum::<f32>() / all.len() as f32;
        assert!((power / (2.0 / 72.0) - 1.0).abs() < 0.1, "{power}");
    }

    #[test]
    fn normalisation_becomes_factor_and_offset() {
        let norm = Norm { gamma: vec![2.0], beta: vec![1.0], mean: vec![3.0], variance: vec![4.0] };
        let (factor, offset) = norm.affine()[0];
        assert!((factor - 1.0).abs() < 1e-5 && (offset + 2.0).abs() < 1e-5);
    }
}
