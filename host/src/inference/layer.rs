//! What every convolution on vectors is made of: views of its memory, groups of sixteen outputs, and the way back to int8.

use crate::dsn::conv::Conv;
use crate::dsn::per_channel::PerChannelQuant;
use crate::simd::{LANES, Lanes, Line, Rescale};

/// A convolution of stride 1: `[height, width, inputs]` to `[height, width, outputs]`.
pub struct Convolution<'a> {
    pub layer: &'a Conv<'a>,
    pub lines: &'a [Line],
    pub words: &'a mut [i32],
    pub input: &'a [i8],
    pub size: (usize, usize),
    pub output: &'a mut [i8],
}

impl Convolution<'_> {
    /// Rewrites the input as words, `[rows, columns, step]`, with a border of one pixel and what else the map holds.
    #[inline(always)]
    pub fn spread<L: Lanes>(&mut self, lanes: L, step: usize, (rows, columns): (usize, usize)) {
        let (height, width) = self.size;
        let row = columns * step;
        let mut border = [0; 2];
        if let Some(border) = border.get_mut(..4 / L::INPUTS) {
            lanes.words(&[self.layer.layer.in_zp; 4], border);
        }
        let [border, _] = border; // all inputs of it are the same
        let row_length = width * self.layer.inputs;
        for (y, words) in self.words.chunks_exact_mut(row.max(1)).take(rows).enumerate() {
            let line = y.checked_sub(1).filter(|&y| y < height).map(|y| y * row_length);
            let Some(values) = line.and_then(|at| self.input.get(at..)?.get(..row_length)) else {
                words.fill(border);
                continue;
            };
            let (left, rest) = words.split_at_mut_checked(step).unwrap_or_default();
            let (inside, right) = rest.split_at_mut_checked(width * step).unwrap_or_default();
            left.fill(border);
            right.fill(border);
            lanes.words(values, inside);
        }
    }
}

/// Biases, scales and words of sixteen outputs.
pub struct Group<'a> {
    pub biases: &'a Line,
    pub rescale: &'a Rescale,
    pub words: &'a [Line],
}

impl<'a> Group<'a> {
    /// Splits a group of `words` words off the front.
    #[inline(always)]
    pub fn take(lines: &mut &'a [Line], words: usize) -> Option<Self> {
        let (biases, rest) = lines.split_first()?;
        let (rescale, rest) = rest.split_first_chunk()?;
        let (words, rest) = rest.split_at_checked(words)?;
        *lines = rest;
        Some(Group { biases, rescale, words })
    }
}

/// Four pixels to int8.
#[inline(always)]
pub fn finish<L: Lanes>(
    lanes: L,
    layer: &PerChannelQuant<'_>,
    rescale: &Rescale,
    sums: [L::V; 4],
) -> [i8; 4 * LANES] {
    let mut values = sums;
    // results of negative sums are below the zero point: where that is the least output, their rounding is no matter
    if layer.act_min >= layer.out_zp {
        for value in &mut values {
            *value = lanes.rescale::<false>(*value, rescale);
        }
    } else {
        for value in &mut values {
            *value = lanes.rescale::<true>(*value, rescale);
        }
    }
    lanes.narrow(values, layer.act_min, layer.act_max)
}

/// Writes sixteen channels of up to four pixels of a row; `first` is the first channel's number.
#[inline(always)]
pub fn put(values: &[i8; 4 * LANES], first: usize, channels: usize, row: &mut [i8], pixel: usize) {
    let Some(rest) = row.get_mut(pixel * channels..) else { return };
    if channels == LANES
        && let Some(out) = rest.first_chunk_mut()
    {
        *out = *values;
    } else {
        put_some(values, first, channels, rest);
    }
}

/// [`put`] where pixels are not whole vectors, or fewer than four are left.
#[inline(never)]
fn put_some(values: &[i8; 4 * LANES], first: usize, channels: usize, rest: &mut [i8]) {
    let (values, _) = values.as_chunks::<LANES>();
    for (values, pixel) in values.iter().zip(rest.chunks_exact_mut(channels.max(1))) {
        for (out, &value) in pixel.iter_mut().skip(first).zip(values) {
            *out = value;
        }
    }
}
