//! The interface by which the network is computed: one operator at a time, in bounded steps.
//!
//! Every implementation gives the same bits. [`Portable`] is the reference.

use super::add::Add;
use super::batch_norm::BatchNormRelu;
use super::conv::{Conv, EMPTY_PATCH, MAX_CHANNELS, same};
use super::established;
use super::pool::average;
use core::ops::Range;

/// One operator of the network with its tensors: int8, NHWC.
#[derive(Debug)]
pub enum Operator<'a> {
    /// Input convolution, then the 2x2 maximum of its output.
    Stem {
        /// The convolution.
        layer: &'a Conv<'a>,
        /// `[height, width]`.
        image: &'a [i8],
        /// Height and width of the image.
        size: (usize, usize),
        /// `[ceil(height / stride) / 2, ceil(width / stride) / 2, channels]`, halves cut off.
        output: &'a mut [i8],
    },
    /// Batch normalisation with ReLU.
    BatchNormRelu {
        /// The layer.
        layer: &'a BatchNormRelu<'a>,
        /// `[pixels, channels]`.
        input: &'a [i8],
        /// Of the input's shape.
        output: &'a mut [i8],
    },
    /// Convolution of stride 1.
    Conv {
        /// The convolution.
        layer: &'a Conv<'a>,
        /// `[height, width, channels]`.
        input: &'a [i8],
        /// Height and width.
        size: (usize, usize),
        /// Scratch of [`winograd::scratch_bytes`](super::winograd::scratch_bytes).
        scratch: &'a mut [i8],
        /// `[height, width, outputs]`; a graph's may have another number of outputs than of inputs.
        output: &'a mut [i8],
    },
    /// `x += branch`.
    Add {
        /// The layer.
        layer: &'a Add,
        /// Any shape.
        x: &'a mut [i8],
        /// Of the same shape.
        branch: &'a [i8],
    },
    /// Average over all pixels.
    Average {
        /// `[pixels, channels]`.
        input: &'a [i8],
        /// Channels.
        channels: usize,
        /// `[channels]`.
        output: &'a mut [i8],
    },
}

/// What the network is computed by.
pub trait Kernels {
    /// Does step `step`, from 0, of operator `index`, counted from the stem, 0; true after the last step.
    ///
    /// The steps of an operator come in order. Between two of them nobody touches its tensors or the kernels' memory;
    /// another operator may begin at any time, and then the unfinished one is given up.
    fn run(&mut self, index: usize, operator: Operator<'_>, step: usize) -> bool;
}

/// The plain loops, on every processor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Portable;

/// Values of a step that treats every value alone.
const RUN: usize = 256;

/// Multiply-accumulates of a step that convolves; one output counts another sixteen.
const PRODUCTS: usize = 7680;

/// Values that a step of the average adds.
const SUMMANDS: usize = 1 << 14;

/// Piece `step` of `all` values in pieces of `length`, and whether it is the last.
#[inline(always)]
pub(crate) fn piece(all: usize, length: usize, step: usize) -> (Range<usize>, bool) {
    let first = (step * length).min(all);
    let end = (first + length).min(all);
    (first..end, end == all)
}

/// Computes piece `step` of an output, `count` pixels long, pixel by pixel; true if it is the last.
fn pixels(
    output: &mut [i8],
    channels: usize,
    count: usize,
    step: usize,
    mut pixel: impl FnMut(usize, &mut [i8]),
) -> bool {
    let (count, channels) = (count.max(1), channels.max(1));
    let (range, last) = piece(output.len(), count * channels, step);
    for (k, out) in established(output.get_mut(range)).chunks_exact_mut(channels).enumerate() {
        pixel(step * count + k, out);
    }
    last
}

impl Kernels for Portable {
    fn run(&mut self, _index: usize, operator: Operator<'_>, step: usize) -> bool {
        match operator {
            Operator::Stem { layer, image, size, output, .. } => {
                let (channels, width) = (layer.quant.channels, (same(size.1, layer.stride) / 2).max(1));
                let mut patch = EMPTY_PATCH;
                pixels(output, channels, PRODUCTS / (100 * channels).max(1), step, |p, out| {
                    let (y, x) = (2 * (p / width), 2 * (p % width));
                    out.fill(i8::MIN);
                    for (y, x) in [(y, x), (y, x + 1), (y + 1, x), (y + 1, x + 1)] {
                        let mut values = [0; MAX_CHANNELS];
                        layer.pixel(image, size, (y, x), &mut patch, &mut values);
                        out.iter_mut().zip(values).for_each(|(out, value)| *out = value.max(*out));
                    }
                })
            }
            Operator::BatchNormRelu { layer, input, output } => {
                let channels = layer.quant.channels.max(1);
                let (range, last) = piece(output.len(), (RUN / channels).max(1) * channels, step);
                layer.forward(established(input.get(range.clone())), established(output.get_mut(range)));
                last
            }
            Operator::Conv { layer, input, size, output, .. } => {
                let (channels, width) = (layer.quant.channels, size.1.max(1));
                let mut patch = EMPTY_PATCH;
                pixels(
                    output,
                    channels,
                    PRODUCTS / ((9 * layer.inputs + 16) * channels).max(1),
                    step,
                    |p, out| {
                        layer.pixel(input, size, (p / width, p % width), &mut patch, out);
                    },
                )
            }
            Operator::Add { layer, x, branch } => {
                let (range, last) = piece(x.len(), RUN, step);
                layer.forward(established(x.get_mut(range.clone())), established(branch.get(range)));
                last
            }
            Operator::Average { input, channels, output } => {
                let count = (SUMMANDS * channels / input.len().max(1)).max(4) / 4 * 4;
                let (range, last) = piece(channels, count, step);
                average(input, channels, range.start, established(output.get_mut(range)));
                last
            }
        }
    }
}
