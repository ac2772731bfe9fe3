//! The network's backbone, from the image to the mean of every channel, with its gradient: what training spends its time on.
//!
//! Forward and backward passes are written out for this one topology (paper, section V; He et al., 2016, for the
//! pre-activation block) on the CPU, because burn 0.22's CPU backend derives a convolution's gradients from transposed
//! and swapped convolutions. Convolutions are Winograd's; a vector holds channels of one pixel. Nothing between the
//! convolutions is stored that can be computed again from two tensors per block. Images are shared among threads in
//! chunks; their number depends on the batch only, and sums of chunks are added in their order: the bits do not depend on
//! the number of threads.

mod backward;
mod elementwise;
mod forward;
mod kernels;
mod layout;
pub(crate) mod operation;
mod products;
mod stem;
mod winograd;

pub use backward::backward;
pub use forward::{Forward, forward};

use super::float_network::same_padding;
use super::parameters::BATCH_NORM_EPSILON;
use elementwise::Sums;
use layout::{Aligned, CHANNELS, Geometry};
use pulp::Arch;
use std::borrow::Cow;
use std::ops::{Deref, DerefMut};
use std::sync::{Arc, Mutex};

/// Most chunks that a batch is cut into.
const CHUNKS: usize = 24;

/// How the blocks are wired.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BlockKind {
    /// Normalised by the batch, the input added to the output: the deep spectrogram network's.
    Residual,
    /// Neither: gamma and beta act on the values as they are. Means are 0 and variances 1 wherever statistics are given.
    Plain,
}

/// Sizes of a backbone and of its batch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shape {
    pub batch: usize,
    /// Rows of an image.
    pub rows: usize,
    /// Columns of an image.
    pub frames: usize,
    /// Channels C, a multiple of 4.
    pub channels: usize,
    pub blocks: usize,
    /// Stride of the input convolution.
    pub stem_stride: usize,
    /// How the blocks are wired.
    pub block_kind: BlockKind,
}

impl Shape {
    /// Number of parameters: weights `[C][9]` and biases `[C]` of the input convolution, then for every block gamma,
    /// beta `[C]` and weights `[C][C][9]` of the first half, gamma, beta, weights and biases `[C]` of the second.
    pub fn parameters(&self) -> usize {
        10 * self.channels + self.blocks * self.block_parameters()
    }

    /// Number of statistics: for every block mean, variance, mean, variance, each `[C]`.
    pub fn statistics(&self) -> usize {
        4 * self.channels * self.blocks
    }

    fn block_parameters(&self) -> usize {
        18 * self.channels * self.channels + 5 * self.channels
    }

    fn geometry(&self) -> Geometry {
        let pooled = |size| same_padding(size, self.stem_stride).0 / 2;
        Geometry { channels: self.channels, height: pooled(self.rows), width: pooled(self.frames) }
    }

    /// The widest vectors of this processor that the channels fill.
    fn arch(&self) -> Arch {
        #[cfg(target_arch = "x86_64")]
        if !self.channels.is_multiple_of(2 * CHANNELS)
            && let Some(narrow) = pulp::x86::V3::try_new()
        {
            return Arch::V3(narrow);
        }
        Arch::new()
    }

    /// As many channels as [`CHANNELS`] needs.
    fn widened(self) -> Shape {
        Shape { channels: self.channels.next_multiple_of(CHANNELS), ..self }
    }

    /// The parameters, or their gradient, of this shape with another number of channels: new ones are zero.
    fn parameters_of<'a>(&self, from: usize, parameters: &'a [f32]) -> Cow<'a, [f32]> {
        // kernels with `[C]` inputs, and taps
        let stem = [(false, 9), (false, 1)];
        let half = [(false, 1), (false, 1), (true, 9)];
        let block = || half.into_iter().chain(half).chain([(false, 1)]);
        let fields = stem.into_iter().chain((0..self.blocks).flat_map(|_| block()));
        with_channels(parameters, fields, from, self.channels)
    }

    /// Weights `[9][C]` of the input convolution from `[C][9]`.
    fn stem_weights(&self, weights: &[f32]) -> Vec<f32> {
        (0..9 * self.channels).map(|at| weights[at % self.channels * 9 + at / self.channels]).collect()
    }

    /// What the normalisations take off: the statistics of the `count` values behind the sums, or nothing.
    fn statistics_of(&self, sums: &[Sums], count: f64) -> Vec<Statistics> {
        match self.block_kind {
            BlockKind::Residual => Statistics::new(sums, count),
            BlockKind::Plain => vec![Statistics::NONE; sums.len()],
        }
    }

    /// Images of a chunk.
    fn chunk(&self) -> usize {
        self.batch.div_ceil(CHUNKS).max(1)
    }

    /// Cuts parameters, or their gradient, into the input convolution's and the blocks'.
    fn split<'a>(&self, parameters: &'a [f32]) -> ([&'a [f32]; 2], Vec<Block<'a>>) {
        let c = self.channels;
        let (stem, blocks) = parameters.split_at(10 * c);
        let (weights, bias) = stem.split_at(9 * c);
        let lengths = [c, c, 9 * c * c, c, c, 9 * c * c, c];
        let block = |mut rest: &'a [f32]| {
            let [gamma1, beta1, conv1, gamma2, beta2, conv2, bias2] = lengths.map(|length| {
                let (part, behind) = rest.split_at(length);
                rest = behind;
                part
            });
            Block {
                halves: [
                    PreActConv { gamma: gamma1, beta: beta1, conv: conv1 },
                    PreActConv { gamma: gamma2, beta: beta2, conv: conv2 },
                ],
                bias: bias2,
            }
        };
        ([weights, bias], blocks.chunks_exact(self.block_parameters()).map(block).collect())
    }
}

/// Parameters of a residual block.
struct Block<'a> {
    halves: [PreActConv<'a>; 2],
    bias: &'a [f32],
}

/// Batch normalisation and the convolution after it.
struct PreActConv<'a> {
    gamma: &'a [f32],
    beta: &'a [f32],
    conv: &'a [f32],
}

/// Statistics of a batch in one channel.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Statistics {
    mean: f64,
    /// Mean square about the mean.
    variance: f64,
}

impl Statistics {
    /// Those that change nothing.
    const NONE: Statistics = Statistics { mean: 0.0, variance: 1.0 - BATCH_NORM_EPSILON };

    /// From the sums of the values and of their squares over `count` values.
    fn new(sums: &[Sums], count: f64) -> Vec<Statistics> {
        let one = |s: &Sums| {
            let mean = s.0 / count;
            Statistics { mean, variance: (s.1 / count - mean * mean).max(0.0) }
        };
        sums.iter().map(one).collect()
    }

    /// One over the standard deviation.
    fn scale(&self) -> f64 {
        1.0 / (self.variance + BATCH_NORM_EPSILON).sqrt()
    }

    /// Factor and offset that normalise.
    fn affine(&self, gamma: f32, beta: f32) -> (f32, f32) {
        let factor = f64::from(gamma) * self.scale();
        (factor as f32, (f64::from(beta) - self.mean * factor) as f32)
    }
}

/// Fields `[C][inputs][taps]` one behind the other, with another number of channels; new ones are zero, those that are too many go.
/// Of a field it is known whether it has `[C]` inputs or one, and how many taps.
fn with_channels(
    values: &[f32],
    fields: impl Iterator<Item = (bool, usize)>,
    from: usize,
    to: usize,
) -> Cow<'_, [f32]> {
    if from == to {
        return Cow::Borrowed(values);
    }
    let (mut rest, mut found) = (values, Vec::new());
    for (square, taps) in fields {
        let [old, new] = [from, to].map(|channels| if square { channels } else { 1 });
        let (field, behind) = rest.split_at(from * old * taps);
        rest = behind;
        for (o, i) in (0..to).flat_map(|o| (0..new).map(move |i| (o, i))) {
            match o < from && i < old {
                true => found.extend_from_slice(&field[(o * old + i) * taps..][..taps]),
                false => found.extend(std::iter::repeat_n(0.0, taps)),
            }
        }
    }
    Cow::Owned(found)
}

/// Rows of `[C]` with another number of channels.
fn rows_with_channels(values: &[f32], from: usize, to: usize) -> Vec<f32> {
    let rows = values.len() / from;
    with_channels(values, std::iter::repeat_n((false, 1), rows), from, to).into_owned()
}

/// Memory that one training step leaves to the next.
#[derive(Debug, Clone, Default)]
pub struct Workspace(Arc<Mutex<Vec<Aligned>>>);

impl Workspace {
    /// `length` values, whatever they are.
    fn take(&self, length: usize) -> Buffer {
        let mut free = self.0.lock().unwrap_or_else(|e| e.into_inner());
        let values = match free.iter().position(|b| b.len() == length) {
            Some(index) => free.swap_remove(index),
            None => Aligned::new(length),
        };
        Buffer { values, home: self.clone() }
    }
}

/// A piece of a [`Workspace`], given back when dropped.
#[derive(Debug)]
struct Buffer {
    values: Aligned,
    home: Workspace,
}

impl Deref for Buffer {
    type Target = [f32];

    fn deref(&self) -> &[f32] {
        &self.values
    }
}

impl DerefMut for Buffer {
    fn deref_mut(&mut self) -> &mut [f32] {
        &mut self.values
    }
}

impl Drop for Buffer {
    fn drop(&mut self) {
        let mut free = self.home.0.lock().unwrap_or_else(|e| e.into_inner());
        free.push(std::mem::take(&mut self.values));
    }
}

/// Adds the chunks' sums in their order.
fn total(chunks: impl IntoIterator<Item = Vec<Sums>>) -> Vec<Sums> {
    let mut chunks = chunks.into_iter();
    let mut total = chunks.next().unwrap_or_default();
    for chunk in chunks {
        total.iter_mut().zip(chunk).for_each(|(t, c)| *t += c);
    }
    total
}

#[cfg(test)]
mod tests {
    use super::*;

    pub(super) fn numbers(count: usize, seed: u32) -> Vec<f32> {
        let mut state = seed;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 23) as f32 - 1.0
        };
        (0..count).map(|_| next()).collect()
    }

    /// Every instruction set that this processor has and the channels fill.
    pub(super) fn every_arch(channels: usize) -> Vec<Arch> {
        let shape = Shape {
            batch: 1,
            rows: 8,
            frames: 8,
            channels,
            blocks: 1,
            stem_stride: 1,
            block_kind: BlockKind::Residual,
        };
        let mut archs = vec![Arch::Scalar, shape.arch()];
        #[cfg(target_arch = "x86_64")]
        archs.extend(pulp::x86::V3::try_new().map(Arch::V3));
        archs
    }
}
