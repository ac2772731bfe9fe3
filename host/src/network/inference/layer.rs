//! What the vector convolutions share: the padded input as words, and the way from sums back to int8.

use super::simd::{I32x16, Kernel, LANES, Requantizer, SimdI32};
use sdp3_core::dsn::conv::Conv;
use sdp3_core::dsn::per_channel::PerChannelQuant;

/// Sixteen output channels of a convolution.
#[derive(Debug)]
pub struct OutputGroup {
    /// What the sums start with.
    pub start: I32x16,
    pub requantizer: Requantizer,
    /// Words of weights in the order of the input's words: `[kernel row, kernel column and input]`, or
    /// `[point, input]` of [`super::winograd_f4`].
    pub weights: Vec<I32x16>,
}

/// Whether a convolution runs by [`super::winograd_f4`]: inputs in sixteens, of 16 bits.
pub fn by_winograd(inputs: usize, word_inputs: usize) -> bool {
    word_inputs == 2 && inputs.is_multiple_of(LANES)
}

/// A convolution of stride 1: `[height, width, inputs]` to `[height, width, outputs]`.
pub struct Convolution<'a> {
    pub layer: &'a Conv<'a>,
    pub groups: &'a [OutputGroup],
    pub words: &'a mut Vec<i32>,
    pub input: &'a [i8],
    pub size: (usize, usize),
    pub output: &'a mut [i8],
}

impl Kernel for Convolution<'_> {
    /// Runs by Winograd's transforms where products cost most, else directly.
    #[inline(always)]
    fn run<S: SimdI32>(self, simd: S) {
        let inputs = self.layer.inputs;
        if by_winograd(inputs, S::INPUTS) {
            return if inputs == 16 { self.winograd::<S, 8>(simd) } else { self.winograd::<S, 16>(simd) };
        }
        match inputs / 4 {
            1 => self.direct::<S, 1>(simd),
            2 => self.direct::<S, 2>(simd),
            3 => self.direct::<S, 3>(simd),
            4 => self.direct::<S, 4>(simd),
            5 => self.direct::<S, 5>(simd),
            6 => self.direct::<S, 6>(simd),
            7 => self.direct::<S, 7>(simd),
            _ => self.direct::<S, 8>(simd),
        }
    }
}

/// Makes a buffer hold `length` words.
pub fn reserve(words: &mut Vec<i32>, length: usize) {
    if words.len() < length {
        words.resize(length, 0);
    }
}

impl Convolution<'_> {
    /// Rewrites the input as words `[rows, columns, step]`: in a border of one pixel of its zero point, and so to the end.
    #[inline(always)]
    pub fn pad_input<S: SimdI32>(&mut self, simd: S, step: usize, (rows, columns): (usize, usize)) {
        let (height, width) = self.size;
        let mut border = [0; 2];
        simd.input_words(&[self.layer.quant.in_zp; 4], &mut border[..4 / S::INPUTS]);
        let [border, _] = border; // all inputs of it are the same
        let row_length = width * self.layer.inputs;
        for (y, words) in self.words.chunks_exact_mut(columns * step).take(rows).enumerate() {
            if y == 0 || y > height {
                words.fill(border);
                continue;
            }
            let (left, rest) = words.split_at_mut(step);
            let (inside, right) = rest.split_at_mut(width * step);
            left.fill(border);
            right.fill(border);
            simd.input_words(&self.input[(y - 1) * row_length..][..row_length], inside);
        }
    }
}

/// Requantises the sums of four pixels.
#[inline(always)]
pub fn requantize<S: SimdI32>(
    simd: S,
    quant: &PerChannelQuant<'_>,
    by: &Requantizer,
    sums: [S::I32; 4],
) -> [i8; 4 * LANES] {
    let mut values = sums;
    // results of negative sums are below the zero point: where that is the least output, their rounding is no matter
    if quant.act_min >= quant.out_zp {
        for value in &mut values {
            *value = simd.requantize::<false>(simd.add(*value, *value), by);
        }
    } else {
        for value in &mut values {
            *value = simd.requantize::<true>(simd.add(*value, *value), by);
        }
    }
    simd.narrow(values, quant.act_min, quant.act_max)
}

/// Writes sixteen channels, `first` and those behind it, of up to four pixels of a row.
#[inline(always)]
pub fn store(values: &[i8; 4 * LANES], first: usize, channels: usize, row: &mut [i8], pixel: usize) {
    let rest = &mut row[pixel * channels..];
    if channels == LANES
        && let Some(out) = rest.first_chunk_mut()
    {
        *out = *values;
    } else {
        store_partial(values, first, channels, rest);
    }
}

/// [`store`] where pixels are not whole vectors, or fewer than four are left.
#[inline(never)]
fn store_partial(values: &[i8; 4 * LANES], first: usize, channels: usize, rest: &mut [i8]) {
    let (values, _) = values.as_chunks::<LANES>();
    for (values, pixel) in values.iter().zip(rest.chunks_exact_mut(channels)) {
        for (out, &value) in pixel.iter_mut().skip(first).zip(values) {
            *out = value;
        }
    }
}
