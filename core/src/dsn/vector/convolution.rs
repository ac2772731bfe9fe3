//! 3x3 convolutions on vectors: sixteen outputs in the lanes, a row of pixels in registers.
//!
//! The input is first rewritten as words of two or four inputs, with a border of its zero point: then no pixel is
//! special, and a row of the kernel is one run of successive words. Cost: 9 inputs / 2 or 9 inputs / 4 vector products
//! a pixel and sixteen outputs.

use super::packing::transforms;
use crate::dsn::channelwise::Channelwise;
use crate::dsn::conv::{Conv, pad_before, same};
use crate::simd::{Job, LANES, Lanes, Line, Rescale};

/// A convolution of stride 1: `[height, width, inputs]` to `[height, width, outputs]`.
pub struct Convolution<'a> {
    pub layer: &'a Conv<'a>,
    pub lines: &'a [Line],
    pub words: &'a mut [i32],
    pub input: &'a [i8],
    pub size: (usize, usize),
    pub output: &'a mut [i8],
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

/// Sums of `P` successive pixels: three runs of `run` words, rows apart; a pixel is `step` words.
#[inline(always)]
fn tile<L: Lanes, const P: usize>(
    lanes: L,
    start: L::V,
    group: &Group<'_>,
    (run, step): (usize, usize),
    words: &[i32],
    row: usize,
) -> Option<[L::V; P]> {
    let mut sums = [start; P];
    for ky in 0..3 {
        let words = words.get(ky * row..)?.get(..(P - 1) * step + run)?;
        let weights = group.words.get(ky * run..)?.get(..run)?;
        for k in 0..run {
            let w = lanes.load(&weights[k]);
            for p in 0..P {
                sums[p] = lanes.dot(sums[p], words[p * step + k], w);
            }
        }
    }
    Some(sums)
}

/// Four pixels to int8.
#[inline(always)]
pub fn finish<L: Lanes>(
    lanes: L,
    layer: &Channelwise<'_>,
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

    #[inline(always)]
    fn rows<L: Lanes, const QUADS: usize, const P: usize>(mut self, lanes: L) {
        let step = QUADS * (4 / L::INPUTS);
        let (height, width) = self.size;
        let columns = width.next_multiple_of(P) + 2;
        let row = columns * step;
        self.spread(lanes, step, (height + 2, columns));
        let (layer, words) = (&self.layer.layer, &*self.words);
        let channels = layer.channels;
        let mut lines = self.lines;
        for first in (0..channels).step_by(LANES) {
            let Some(group) = Group::take(&mut lines, 9 * step) else { return };
            let start = lanes.load(group.biases);
            let rows = self.output.chunks_exact_mut((width * channels).max(1));
            for (y, out) in rows.take(height).enumerate() {
                for x in (0..width).step_by(P) {
                    let words = words.get(y * row + x * step..).unwrap_or(&[]);
                    let Some(sums) = tile::<L, P>(lanes, start, &group, (3 * step, step), words, row) else {
                        return;
                    };
                    let (fours, _) = sums.as_chunks::<4>();
                    for (k, &four) in fours.iter().enumerate() {
                        let values = finish(lanes, layer, group.rescale, four);
                        put(&values, first, channels, out, x + 4 * k);
                    }
                }
            }
        }
    }

    #[inline(always)]
    fn tiles<L: Lanes, const QUADS: usize>(self, lanes: L) {
        match L::TILE {
            4 => self.rows::<L, QUADS, 4>(lanes),
            8 => self.rows::<L, QUADS, 8>(lanes),
            _ => self.rows::<L, QUADS, 16>(lanes),
        }
    }
}

impl Job for Convolution<'_> {
    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        if L::INPUTS == 2 && transforms(self.layer.inputs) {
            let _ = match self.layer.inputs {
                16 => self.winograd::<L, 8>(lanes),
                _ => self.winograd::<L, 16>(lanes),
            };
            return;
        }
        match self.layer.inputs / 4 {
            1 => self.tiles::<L, 1>(lanes),
            2 => self.tiles::<L, 2>(lanes),
            3 => self.tiles::<L, 3>(lanes),
            4 => self.tiles::<L, 4>(lanes),
            5 => self.tiles::<L, 5>(lanes),
            6 => self.tiles::<L, 6>(lanes),
            7 => self.tiles::<L, 7>(lanes),
            _ => self.tiles::<L, 8>(lanes),
        }
    }
}

/// The input convolution with its 2x2 maximum: `[height, width]` to `[pooled height, pooled width, outputs]`.
///
/// Requantisation never falls where its argument rises, so the maximum is taken before it, of the sums.
pub struct Stem<'a> {
    pub layer: &'a Conv<'a>,
    pub lines: &'a [Line],
    pub words: &'a mut [i32],
    pub image: &'a [i8],
    pub size: (usize, usize),
    pub pooled: &'a mut [i8],
}

/// Pixels of the stem in one tile: four after pooling.
const STEM_TILE: usize = 8;

impl Stem<'_> {
    /// Rewrites each image row as words of the four values from each output's first tap; returns the words of a row.
    #[inline(always)]
    fn spread<L: Lanes>(&mut self, lanes: L) -> usize {
        let (height, width) = self.size;
        let stride = self.layer.stride;
        let (rows, columns) = (same(height, stride), same(width, stride));
        let (above, before) = (pad_before(height, stride), pad_before(width, stride));
        let zero = self.layer.layer.in_zp;
        let per_pixel = 4 / L::INPUTS;
        let row = columns.next_multiple_of(STEM_TILE) * per_pixel;
        let count = (rows.max(1) - 1) * stride + 3;
        for (y, words) in self.words.chunks_exact_mut(row.max(1)).take(count).enumerate() {
            let line = y.checked_sub(above).filter(|&y| y < height);
            let line = line.and_then(|y| self.image.get(y * width..)?.get(..width)).unwrap_or(&[]);
            for (x, words) in words.chunks_exact_mut(per_pixel).enumerate() {
                let at = (x * stride).wrapping_sub(before);
                let four = match line.get(at..).and_then(|rest| rest.first_chunk()) {
                    Some(four) => *four,
                    None => [0, 1, 2, 3].map(|k| line.get(at.wrapping_add(k)).copied().unwrap_or(zero)),
                };
                lanes.words(&four, words);
            }
        }
        row
    }
}

impl Job for Stem<'_> {
    #[inline(always)]
    fn run<L: Lanes>(mut self, lanes: L) {
        let row = self.spread(lanes);
        let (layer, stride, words) = (&self.layer.layer, self.layer.stride, &*self.words);
        let channels = layer.channels;
        let width = same(self.size.1, stride) / 2;
        let step = 4 / L::INPUTS;
        let mut lines = self.lines;
        for first in (0..channels).step_by(LANES) {
            let Some(group) = Group::take(&mut lines, 3 * step) else { return };
            let start = lanes.load(group.biases);
            for (y, out) in self.pooled.chunks_exact_mut((width * channels).max(1)).enumerate() {
                for x in (0..width).step_by(STEM_TILE / 2) {
                    let mut largest = [start; STEM_TILE / 2];
                    for below in 0..2 {
                        let at = (2 * y + below) * stride * row + 2 * x * step;
                        let words = words.get(at..).unwrap_or(&[]);
                        let shape = (step, step);
                        let sums = tile::<L, STEM_TILE>(lanes, start, &group, shape, words, row);
                        let Some(sums) = sums else { return };
                        for k in 0..STEM_TILE / 2 {
                            let pair = lanes.max(sums[2 * k], sums[2 * k + 1]);
                            largest[k] = if below == 0 { pair } else { lanes.max(largest[k], pair) };
                        }
                    }
                    let values = finish(lanes, layer, group.rescale, largest);
                    put(&values, first, channels, out, x);
                }
            }
        }
    }
}
