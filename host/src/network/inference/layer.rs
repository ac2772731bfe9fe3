//! What the vector convolutions share: the padded input as words, and the way from sums back to int8.

use super::simd::{I32x16, Kernel, LANES, Requantizer, SimdI32};
use sdp3_core::dsn::conv::Conv;
use sdp3_core::dsn::per_channel::PerChannelQuant;

/// Sixteen output channels of a convolution.
#[derive(Debug)]
pub struct OutputGroup {
    /// The first of them.
    pub first: usize,
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
        // the words of a pixel; sixteen inputs in pairs, and 32, were above
        match (S::INPUTS, inputs / 4) {
            (4, 1) => self.direct::<S, 1>(simd),
            (4, 2) | (_, 1) => self.direct::<S, 2>(simd),
            (4, 3) => self.direct::<S, 3>(simd),
            (4, 4) | (_, 2) => self.direct::<S, 4>(simd),
            (4, 5) => self.direct::<S, 5>(simd),
            (4, 6) | (_, 3) => self.direct::<S, 6>(simd),
            (4, 7) => self.direct::<S, 7>(simd),
            (4, _) => self.direct::<S, 8>(simd),
            (_, 5) => self.direct::<S, 10>(simd),
            (_, 6) => self.direct::<S, 12>(simd),
            _ => self.direct::<S, 14>(simd),
        }
    }
}

/// Makes a buffer hold `length` words, or their bytes.
pub fn reserve<T: Copy + Default>(words: &mut Vec<T>, length: usize) {
    if words.len() < length {
        words.resize(length, T::default());
    }
}

/// The word that borders are made of: all its inputs are the zero point.
#[inline(always)]
pub fn border_word<S: SimdI32>(simd: S, zero: i8) -> i32 {
    let mut words = [0; 2];
    simd.input_words(&[zero; 4], &mut words[..4 / S::INPUTS]);
    words[0]
}

impl Convolution<'_> {
    /// Rewrites the input as words `[rows, columns, step]`: in a border of one pixel of its zero point, and so to the end.
    #[inline(always)]
    pub fn pad_input<S: SimdI32>(&mut self, simd: S, step: usize, (rows, columns): (usize, usize)) {
        let (height, width) = self.size;
        let border = border_word(simd, self.layer.quant.in_zp);
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

/// Requantises the sums of four pixels from `pixel` on, and writes those of them that the row has.
#[inline(always)]
pub fn finish<S: SimdI32>(
    simd: S,
    quant: &PerChannelQuant<'_>,
    group: &OutputGroup,
    sums: [S::I32; 4],
    row: &mut [i8],
    pixel: usize,
) {
    let Some(rest) = row.get_mut(pixel * quant.channels..).filter(|rest| !rest.is_empty()) else { return };
    let mut values = sums;
    for value in &mut values {
        *value = simd.requantize::<true>(simd.add(*value, *value), &group.requantizer);
    }
    let values = simd.narrow(values, quant.act_min, quant.act_max);
    if quant.channels == LANES
        && let Some(out) = rest.first_chunk_mut()
    {
        *out = values;
    } else {
        write_partial(values, group.first, quant.channels, rest);
    }
}

/// Writes sixteen channels of up to four pixels where pixels are not whole vectors, or fewer than four are left.
#[inline(never)]
fn write_partial(values: [i8; 4 * LANES], first: usize, channels: usize, rest: &mut [i8]) {
    let (values, _) = values.as_chunks::<LANES>();
    for (values, pixel) in values.iter().zip(rest.chunks_exact_mut(channels)) {
        for (out, &value) in pixel.iter_mut().skip(first).zip(values) {
            *out = value;
        }
    }
}
