//! The trained network in floating point, without burn: folded as the int8 network is, every activation visible.
//!
//! Images are `[row][frame][channel]`, as in the radar module. The caller sees and may change each activation, which
//! is how ranges are measured and int8 is rehearsed.

use super::parameters::{Architecture, Images, Parameters};
use rayon::prelude::*;

/// An activation of the network.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Activation {
    /// The image, `(pixel + 128) / 255`.
    Input,
    /// Output of the input convolution and of the pooling, which keeps its scale.
    Stem,
    /// After the first normalisation and ReLU of a block.
    Affine(usize),
    /// After the first convolution, second normalisation and ReLU of a block.
    Conv1(usize),
    /// After the second convolution of a block.
    Conv2(usize),
    /// After the addition of the skip of a block.
    Add(usize),
    /// Mean over the image, per channel; it keeps the scale of the last addition.
    Mean,
    /// The answer.
    Logits,
}

/// Weights `[O][tap][I]` and biases `[O]`, normalisation folded in.
#[derive(Debug, Clone, PartialEq)]
pub struct FoldedLayer {
    /// Weights; 9 taps of a convolution, row by row, or a single one.
    pub weights: Vec<f64>,
    /// Biases.
    pub biases: Vec<f64>,
}

/// A residual block.
#[derive(Debug, Clone, PartialEq)]
pub struct FoldedBlock {
    /// First normalisation: one weight and one bias per channel, then ReLU.
    pub affine: FoldedLayer,
    /// First convolution with the second normalisation, then ReLU.
    pub conv1: FoldedLayer,
    /// Second convolution.
    pub conv2: FoldedLayer,
}

/// The network as inference needs it.
#[derive(Debug, Clone, PartialEq)]
pub struct FloatNetwork {
    /// Shape.
    pub architecture: Architecture,
    /// Input convolution.
    pub stem: FoldedLayer,
    /// Residual blocks.
    pub blocks: Vec<FoldedBlock>,
    /// Classifier.
    pub head: FoldedLayer,
}

/// `[O][I][3][3]` to `[O][9][I]`, each output scaled and offset.
fn fold(weights: &[f32], inputs: usize, affine: &[(f64, f64)]) -> FoldedLayer {
    let mut folded = Vec::with_capacity(weights.len());
    for (kernel, (factor, _)) in weights.chunks_exact(9 * inputs).zip(affine) {
        for tap in 0..9 {
            folded.extend((0..inputs).map(|i| f64::from(kernel[9 * i + tap]) * factor));
        }
    }
    FoldedLayer { weights: folded, biases: affine.iter().map(|a| a.1).collect() }
}

fn biased(biases: &[f32]) -> Vec<(f64, f64)> {
    biases.iter().map(|&b| (1.0, f64::from(b))).collect()
}

impl FloatNetwork {
    /// Folds the normalisations of trained parameters.
    pub fn new(parameters: &Parameters) -> FloatNetwork {
        let c = parameters.architecture.channels;
        let blocks = parameters.blocks.iter().map(|b| {
            let (weights, biases) = b.norm1.affine().into_iter().unzip();
            FoldedBlock {
                affine: FoldedLayer { weights, biases },
                conv1: fold(&b.conv1, c, &b.norm2.affine()),
                conv2: fold(&b.conv2.weights, c, &biased(&b.conv2.biases)),
            }
        });
        let head = &parameters.head;
        FloatNetwork {
            architecture: parameters.architecture,
            stem: fold(&parameters.stem.weights, 1, &biased(&parameters.stem.biases)),
            blocks: blocks.collect(),
            head: FoldedLayer {
                weights: head.weights.iter().map(|&w| f64::from(w)).collect(),
                biases: head.biases.iter().map(|&b| f64::from(b)).collect(),
            },
        }
    }

    /// Logits of one image `[rows][frames]`; `visit` sees, and may change, every activation.
    pub fn forward(
        &self,
        image: &[i8],
        rows: usize,
        visit: &mut impl FnMut(Activation, &mut [f32]),
    ) -> Vec<f32> {
        let Architecture { channels: c, stem_stride, classes, .. } = self.architecture;
        let frames = image.len() / rows;
        let mut x: Vec<f32> = image.iter().map(|&p| (f32::from(p) + 128.0) / 255.0).collect();
        visit(Activation::Input, &mut x);
        let (mut x, h, w) = convolve(&x, [rows, frames, 1], &self.stem, stem_stride);
        visit(Activation::Stem, &mut x);
        let mut x = max_pool(&x, [h, w, c]);
        let (h, w) = (h / 2, w / 2);
        for (b, block) in self.blocks.iter().enumerate() {
            let mut t = x.clone();
            for pixel in t.chunks_exact_mut(c) {
                for ((v, &weight), &bias) in
                    pixel.iter_mut().zip(&block.affine.weights).zip(&block.affine.biases)
                {
                    *v = (*v * weight as f32 + bias as f32).max(0.0);
                }
            }
            visit(Activation::Affine(b), &mut t);
            let (mut t, ..) = convolve(&t, [h, w, c], &block.conv1, 1);
            t.iter_mut().for_each(|v| *v = v.max(0.0));
            visit(Activation::Conv1(b), &mut t);
            let (mut t, ..) = convolve(&t, [h, w, c], &block.conv2, 1);
            visit(Activation::Conv2(b), &mut t);
            x.iter_mut().zip(&t).for_each(|(x, t)| *x += t);
            visit(Activation::Add(b), &mut x);
        }
        let sum = |i| x.iter().skip(i).step_by(c).map(|&v| f64::from(v)).sum::<f64>();
        let mut mean: Vec<f32> = (0..c).map(|i| (sum(i) / (h * w) as f64) as f32).collect();
        visit(Activation::Mean, &mut mean);
        let mut logits: Vec<f32> = (0..classes)
            .map(|o| {
                let row = &self.head.weights[o * c..(o + 1) * c];
                let dot = row.iter().zip(&mean).map(|(w, &m)| w * f64::from(m)).sum::<f64>();
                (self.head.biases[o] + dot) as f32
            })
            .collect();
        visit(Activation::Logits, &mut logits);
        logits
    }

    /// Classes of every image, on all threads; the result does not depend on their number.
    pub fn classify(&self, images: &Images) -> Evaluation {
        let answer = |i: usize| {
            let logits = self.forward(images.image(i), images.rows, &mut |_, _| {});
            (first_maximum(&logits), cross_entropy(&logits, images.labels[i]))
        };
        let answers: Vec<(u8, f64)> = (0..images.len()).into_par_iter().map(answer).collect();
        let right = answers.iter().zip(&images.labels).filter(|((class, _), label)| class == *label).count();
        let loss = answers.iter().map(|(_, loss)| loss).sum::<f64>() / images.len().max(1) as f64;
        Evaluation { classes: answers.into_iter().map(|(class, _)| class).collect(), right, loss }
    }

    /// As [`FloatNetwork::classify`], one image after the other, with a visitor of every activation.
    pub fn evaluate(&self, images: &Images, visit: &mut impl FnMut(Activation, &mut [f32])) -> Evaluation {
        let mut evaluation = Evaluation { classes: Vec::new(), right: 0, loss: 0.0 };
        for (i, &label) in images.labels.iter().enumerate() {
            let logits = self.forward(images.image(i), images.rows, visit);
            let class = first_maximum(&logits);
            evaluation.right += usize::from(class == label);
            evaluation.loss += cross_entropy(&logits, label);
            evaluation.classes.push(class);
        }
        evaluation.loss /= images.len().max(1) as f64;
        evaluation
    }
}

/// Answers of a network to a set of images.
#[derive(Debug, Clone, PartialEq)]
pub struct Evaluation {
    /// Class answered to each image.
    pub classes: Vec<u8>,
    /// How many were right.
    pub right: usize,
    /// Mean cross entropy in nats.
    pub loss: f64,
}

impl Evaluation {
    /// Share that was right, 0 to 1.
    pub fn accuracy(&self) -> f64 {
        self.right as f64 / self.classes.len().max(1) as f64
    }
}

/// Index of the first maximum.
pub fn first_maximum(logits: &[f32]) -> u8 {
    (0..logits.len()).fold(0, |best, i| if logits[i] > logits[best] { i } else { best }) as u8
}

/// `log(sum exp(logits)) - logits[label]` in nats.
pub fn cross_entropy(logits: &[f32], label: u8) -> f64 {
    let top = logits.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let sum: f64 = logits.iter().map(|&l| libm::exp(f64::from(l - top))).sum();
    libm::log(sum) - f64::from(logits[usize::from(label)] - top)
}

/// Output size and leading padding of a 3x3 convolution along one axis, TFLite's `SAME`.
pub fn same_padding(size: usize, stride: usize) -> (usize, usize) {
    let out = size.div_ceil(stride);
    let total = ((out - 1) * stride + 3).saturating_sub(size);
    (out, total / 2)
}

/// 3x3 convolution of `[h][w][i]`, zero padded; returns `[h'][w'][o]`, h', w'.
fn convolve(
    x: &[f32],
    [h, w, inputs]: [usize; 3],
    layer: &FoldedLayer,
    stride: usize,
) -> (Vec<f32>, usize, usize) {
    let outputs = layer.biases.len();
    let ((out_h, top), (out_w, left)) = (same_padding(h, stride), same_padding(w, stride));
    // [tap][i][o]: the innermost loop runs over neighbouring outputs.
    let mut weights = vec![0.0f32; layer.weights.len()];
    for (o, kernel) in layer.weights.chunks_exact(9 * inputs).enumerate() {
        kernel.iter().enumerate().for_each(|(k, &v)| weights[k * outputs + o] = v as f32);
    }
    let biases: Vec<f32> = layer.biases.iter().map(|&b| b as f32).collect();
    let mut y = Vec::with_capacity(out_h * out_w * outputs);
    for (row, column) in (0..out_h).flat_map(|r| (0..out_w).map(move |c| (r, c))) {
        let start = y.len();
        y.extend_from_slice(&biases);
        let sums = &mut y[start..];
        for (ky, kx) in (0..3).flat_map(|ky| (0..3).map(move |kx| (ky, kx))) {
            let (r, c) = ((row * stride + ky).wrapping_sub(top), (column * stride + kx).wrapping_sub(left));
            if r >= h || c >= w {
                continue;
            }
            let pixel = &x[(r * w + c) * inputs..][..inputs];
            let kernel = &weights[(ky * 3 + kx) * inputs * outputs..][..inputs * outputs];
            for (&v, kernel) in pixel.iter().zip(kernel.chunks_exact(outputs)) {
                for (sums, kernel) in sums.chunks_exact_mut(4).zip(kernel.chunks_exact(4)) {
                    for (sum, &k) in sums.iter_mut().zip(kernel) {
                        *sum += v * k;
                    }
                }
            }
        }
    }
    (y, out_h, out_w)
}

/// Maximum of 2x2 pixels, stride 2, of `[h][w][c]`; an odd last row or column is dropped.
fn max_pool(x: &[f32], [h, w, c]: [usize; 3]) -> Vec<f32> {
    let mut y = Vec::with_capacity(h / 2 * (w / 2) * c);
    for (row, column) in (0..h / 2).flat_map(|r| (0..w / 2).map(move |k| (r, k))) {
        let at = |dr: usize, dc: usize, i: usize| x[((2 * row + dr) * w + 2 * column + dc) * c + i];
        y.extend((0..c).map(|i| at(0, 0, i).max(at(0, 1, i)).max(at(1, 0, i)).max(at(1, 1, i))));
    }
    y
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn padding_is_tflites() {
        // TFLite: out = ceil(in / stride); stride 2 pads an even size behind only, an odd one on both sides.
        assert_eq!(same_padding(64, 1), (64, 1));
        assert_eq!(same_padding(64, 2), (32, 0));
        assert_eq!(same_padding(35, 2), (18, 1));
        assert_eq!(same_padding(1, 2), (1, 1));
    }

    #[test]
    fn convolution_of_an_impulse_is_the_mirrored_kernel() {
        let kernel: Vec<f64> = (1..=9).map(f64::from).collect();
        let weights = [kernel.clone(), vec![0.0; 27]].concat();
        let layer = FoldedLayer { weights, biases: vec![0.5, 1.0, 2.0, 3.0] };
        let mut x = vec![0.0; 25];
        x[12] = 1.0;
        let (y, h, w) = convolve(&x, [5, 5, 1], &layer, 1);
        assert_eq!((h, w), (5, 5));
        for (r, c) in (0..5).flat_map(|r| (0..5).map(move |c| (r, c))) {
            let inside = (1..4).contains(&r) && (1..4).contains(&c);
            let expected = if inside { kernel[(3 - r) * 3 + (3 - c)] as f32 } else { 0.0 };
            assert_eq!(y[(r * 5 + c) * 4..][..4], [0.5 + expected, 1.0, 2.0, 3.0]);
        }
    }

    #[test]
    fn pooling_drops_an_odd_edge() {
        let x: Vec<f32> = (0..15).map(|v| v as f32).collect();
        assert_eq!(max_pool(&x, [3, 5, 1]), [6.0, 8.0]);
    }

    #[test]
    fn cross_entropy_of_equal_logits_is_the_logarithm_of_their_number() {
        assert!((cross_entropy(&[2.0; 5], 3) - 5f64.ln()).abs() < 1e-12);
        assert_eq!(first_maximum(&[1.0, 3.0, 3.0]), 1);
    }
}
