//! The trained network in floating point, without burn: folded as the int8 network is, every activation visible.
//!
//! Images are `[row][frame][channel]`, as in the radar module. The caller sees and may change each activation, which
//! is how ranges are measured and int8 is fake-quantised.

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
    BatchNorm(usize),
    /// After the first convolution, second normalisation and ReLU of a block.
    Conv1(usize),
    /// After the second convolution of a block.
    Conv2(usize),
    /// After the addition of the skip of a block.
    Add(usize),
    /// Mean over the image, per channel; it keeps the scale of the last addition.
    Mean,
    Logits,
}

/// Weights `[O][tap][I]` and biases `[O]`, normalisation folded in.
#[derive(Debug, Clone, PartialEq)]
pub struct FoldedLayer {
    /// Weights; 9 taps of a convolution, row by row, or a single one.
    pub weights: Vec<f64>,
    pub biases: Vec<f64>,
}

#[derive(Debug, Clone, PartialEq)]
pub struct FoldedBlock {
    /// First normalisation: one weight and one bias per channel, then ReLU.
    pub affine: FoldedLayer,
    /// First convolution with the second normalisation, then ReLU.
    pub conv1: FoldedLayer,
    pub conv2: FoldedLayer,
}

/// The network as inference needs it.
#[derive(Debug, Clone, PartialEq)]
pub struct FloatNetwork {
    pub architecture: Architecture,
    pub stem: FoldedLayer,
    pub blocks: Vec<FoldedBlock>,
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
            visit(Activation::BatchNorm(b), &mut t);
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

    /// Classes of every image.
    pub fn classify(&self, images: &Images) -> Evaluation {
        self.evaluate(images, |(), _, _| ()).0
    }

    /// Classes of every image, with a visitor of every activation that keeps a record of each image, in the images' order. On all
    /// threads; the result does not depend on their number.
    pub fn evaluate<R: Default + Send>(
        &self,
        images: &Images,
        visit: impl Fn(&mut R, Activation, &mut [f32]) + Sync,
    ) -> (Evaluation, Vec<R>) {
        let answer = |i: usize| {
            let mut record = R::default();
            let visit = &mut |activation, values: &mut [f32]| visit(&mut record, activation, values);
            let logits = self.forward(images.image(i), images.rows, visit);
            ((first_maximum(&logits), cross_entropy(&logits, images.labels[i])), record)
        };
        let (answers, records): (Vec<(u8, f64)>, _) = (0..images.len()).into_par_iter().map(answer).unzip();
        let right = answers.iter().zip(&images.labels).filter(|((class, _), label)| class == *label).count();
        let loss = answers.iter().map(|(_, loss)| loss).sum::<f64>() / images.len().max(1) as f64;
        (Evaluation { classes: answers.into_iter().map(|(class, _)| class).collect(), right, loss }, records)
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

/// 3x3 convolution of `[h][w][i]`, zero padded; returns `[h'][w'][o]`, h', w'. Outputs are a multiple of 4.
fn convolve(x: &[f32], size: [usize; 3], layer: &FoldedLayer, stride: usize) -> (Vec<f32>, usize, usize) {
    match layer.biases.len() {
        outputs if outputs.is_multiple_of(16) => convolve_by::<16>(x, size, layer, stride),
        outputs if outputs.is_multiple_of(8) => convolve_by::<8>(x, size, layer, stride),
        _ => convolve_by::<4>(x, size, layer, stride),
    }
}

/// As [`convolve`], `N` neighbouring outputs at a time: their sums stay in registers. The bits do not depend on `N`.
fn convolve_by<const N: usize>(
    x: &[f32],
    [h, w, inputs]: [usize; 3],
    layer: &FoldedLayer,
    stride: usize,
) -> (Vec<f32>, usize, usize) {
    let outputs = layer.biases.len();
    let ((out_h, top), (out_w, left)) = (same_padding(h, stride), same_padding(w, stride));
    // [o / N][tap][i][o % N]
    let mut weights = vec![[0.0f32; N]; 9 * inputs * outputs / N];
    for (o, kernel) in layer.weights.chunks_exact(9 * inputs).enumerate() {
        kernel.iter().enumerate().for_each(|(k, &v)| weights[o / N * 9 * inputs + k][o % N] = v as f32);
    }
    let biases: Vec<f32> = layer.biases.iter().map(|&b| b as f32).collect();
    let mut y = vec![0.0; out_h * out_w * outputs];
    let places = (0..out_h).flat_map(|r| (0..out_w).map(move |c| (r, c)));
    for ((row, column), y) in places.zip(y.chunks_exact_mut(outputs)) {
        let blocks = weights.chunks_exact(9 * inputs).zip(biases.as_chunks::<N>().0);
        for ((taps, &biases), y) in blocks.zip(y.as_chunks_mut::<N>().0) {
            let mut sums = biases;
            for (ky, kx) in (0..3).flat_map(|ky| (0..3).map(move |kx| (ky, kx))) {
                let (r, c) =
                    ((row * stride + ky).wrapping_sub(top), (column * stride + kx).wrapping_sub(left));
                if r >= h || c >= w {
                    continue;
                }
                let pixel = &x[(r * w + c) * inputs..][..inputs];
                for (&v, kernel) in pixel.iter().zip(&taps[(ky * 3 + kx) * inputs..]) {
                    sums.iter_mut().zip(kernel).for_each(|(sum, &k)| *sum += v * k);
                }
            }
            *y = sums;
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
    fn outputs_taken_together_change_no_bit() {
        let value = |n: usize| libm::sin(1.7 * n as f64);
        let layer = FoldedLayer {
            weights: (0..9 * 3 * 16).map(value).collect(),
            biases: (0..16).map(value).collect(),
        };
        let x: Vec<f32> = (0..7 * 6 * 3).map(|n| value(n * n) as f32).collect();
        for stride in [1, 2] {
            let four = convolve_by::<4>(&x, [7, 6, 3], &layer, stride);
            assert_eq!(four, convolve_by::<8>(&x, [7, 6, 3], &layer, stride));
            assert_eq!(four, convolve_by::<16>(&x, [7, 6, 3], &layer, stride));
            assert_eq!(four, convolve(&x, [7, 6, 3], &layer, stride));
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
