//! The input convolution and its 2x2 maximum in one: the square of outputs that is pooled is computed together.
//!
//! Source: as [`super::transform`]. Requantising never falls as the accumulator grows, so the largest of the four sums is
//! requantised and no row of the convolution is kept. With a stride of 1 the square is a tile of F(2x2, 3x3): 16 products and
//! 32 sums a pooled value. With a stride of 2 it takes 36 products of a patch of 5x5.

use super::packing::{self, channel};
use super::{clamp_all, packed, packed_mut};
use crate::dsn::conv::{Conv, pad_before, same};
use crate::dsn::established;
use crate::fixed::{Requantizer, TIMES_FOUR};
use crate::simd::native_largest_of_pairs;
use crate::simd::patch_pairs::{self, PatchPairs};

/// Points of a tile of F(2x2, 3x3).
const POINTS: usize = 16;

/// Words of a channel: its weights, `[column][row]` transformed or as they are, then those of [`channel`].
pub const WORDS: usize = patch_pairs::WORDS;

const _: () = assert!(WORDS == POINTS + packing::WORDS);

/// Pooled values of a step with a stride of 1 and of 2: at most 50 000 and 35 000 instructions on Cortex-M4F.
const VALUES: [usize; 2] = [512, 256];

/// Packs the weights; `None` if these kernels cannot compute it.
#[inline(never)]
pub fn pack(stem: &Conv<'_>, words: &mut [i32]) -> Option<()> {
    let (taps, _) = stem.quant.weights.as_chunks::<9>();
    for (o, (words, taps)) in
        packed_mut::<WORDS>(words, stem.quant.channels)?.iter_mut().zip(taps).enumerate()
    {
        let (weights, constants) = words.split_first_chunk_mut::<POINTS>()?;
        let taps = taps.map(|w| i32::from(w as i8));
        if stem.stride == 1 {
            let columns = filter_transform(|tap| taps[tap % 9]).map(|[a, b, c, d]| [b, c, a, -d]);
            *weights.as_chunks_mut().0.first_chunk_mut()? = columns;
        } else {
            let taps = taps.map(|w| 4 * w);
            *weights.first_chunk_mut()? = if PAIRS { pairs_of_taps(&taps) } else { taps };
        }
        *constants.first_chunk_mut()? = channel::<TIMES_FOUR>(&stem.quant, o, taps.iter().sum(), 9)?;
    }
    (stem.inputs == 1).then_some(())
}

/// `[height, width]` to the pooled `[height, width, channels]`.
pub(super) struct Stem<'a> {
    pub layer: &'a Conv<'a>,
    pub words: &'a [i32],
    pub image: &'a [i8],
    pub size: (usize, usize),
    pub output: &'a mut [i8],
}

impl Stem<'_> {
    /// Does a step: part of a pooled row; true after the last.
    pub fn run(self, step: usize) -> bool {
        let quant = self.layer.quant;
        let (channels, width) = (quant.channels.max(1), same(self.size.1, self.layer.stride) / 2);
        let steps = width.div_ceil((VALUES[self.layer.stride / 2 % 2] / channels).max(1)).max(1);
        let pixels = width.div_ceil(steps);
        let (y, first) = (step / steps, step % steps * pixels);
        let last = (first + pixels).min(width);
        let (from, to) = ((y * width + first) * channels, (y * width + last) * channels);
        let (end, packed) = (to == self.output.len(), packed(self.words, channels));
        let output = established(self.output.get_mut(from..to));
        if self.layer.stride == 1 {
            tiles(self.layer, packed, self.image, self.size, (y, first), output);
        } else {
            patches(self.layer, packed, self.image, self.size, (y, first), output);
        }
        clamp_all(output, (quant.act_min, quant.act_max));
        end
    }
}

/// What lies outside the image, as u8.
fn border(stem: &Conv<'_>) -> i32 {
    i32::from(stem.quant.in_zp) + 128
}

/// Line `y` of the image, empty outside.
fn line(image: &[i8], width: usize, y: usize) -> &[i8] {
    y.checked_mul(width).and_then(|start| image.get(start..)?.get(..width)).unwrap_or(&[])
}

/// A pixel as u8; the border outside the line.
#[inline(always)]
fn pixel(line: &[i8], x: usize, border: i32) -> i32 {
    line.get(x).map_or(border, |&v| i32::from(v as u8 ^ 0x80))
}

/// A stride of 1, from pooled pixel `(y, first)` on.
#[inline(never)]
fn tiles(
    stem: &Conv<'_>,
    channels: &[[i32; WORDS]],
    image: &[i8],
    (_, width): (usize, usize),
    (y, first): (usize, usize),
    output: &mut [i8],
) {
    let border = border(stem);
    let rows = [0, 1, 2, 3].map(|k| line(image, width, (2 * y + k).wrapping_sub(1)));
    let column = |x: usize| input_transform(rows.map(|row| pixel(row, x, border)));
    let mut columns = [[0; 4], [0; 4], column((2 * first).wrapping_sub(1)), column(2 * first)];
    for (x, pooled) in output.chunks_exact_mut(stem.quant.channels.max(1)).enumerate() {
        let [_, _, a, b] = columns;
        let x = 2 * (first + x);
        columns = [a, b, column(x + 1), column(x + 2)];
        let mut points = [[0; 4]; 4];
        for row in 0..4 {
            let transformed = input_transform(columns.map(|column| column[row]));
            for k in 0..4 {
                points[k][row] = transformed[k];
            }
        }
        for (out, words) in pooled.iter_mut().zip(channels) {
            *out = requantize(largest_of_tile(&points, words), words);
        }
    }
}

/// The largest of a tile's four sums.
#[inline(always)]
fn largest_of_tile(points: &[[i32; 4]; 4], words: &[i32; WORDS]) -> i32 {
    let (mut upper, mut lower) = ([0_i32; 4], [0_i32; 4]);
    for (k, ([d0, d1, d2, d3], w)) in points.iter().zip(words.as_chunks::<4>().0).enumerate() {
        let (a, b) = (w[0].wrapping_mul(*d1), w[1].wrapping_mul(*d2));
        upper[k] = a.wrapping_add(b).wrapping_add(w[2].wrapping_mul(*d0));
        lower[k] = a.wrapping_sub(b).wrapping_add(w[3].wrapping_mul(*d3));
    }
    let most = |m: [i32; 4]| {
        let left = m[0].wrapping_add(m[1]).wrapping_add(m[2]);
        left.max(m[1].wrapping_sub(m[2]).wrapping_sub(m[3]))
    };
    most(upper).max(most(lower))
}

/// Five columns of five pixels.
type Patch = [[i32; 5]; 5];

/// A stride of 2, from pooled pixel `(y, first)` on.
#[inline(never)]
fn patches(
    stem: &Conv<'_>,
    channels: &[[i32; WORDS]],
    image: &[i8],
    (height, width): (usize, usize),
    (y, first): (usize, usize),
    output: &mut [i8],
) {
    let border = border(stem);
    let (above, before) = (pad_before(height, 2), pad_before(width, 2));
    let rows = [0, 1, 2, 3, 4].map(|k| line(image, width, (4 * y + k).wrapping_sub(above)));
    let column = |x: usize| rows.map(|row| pixel(row, x, border));
    let mut patch: Patch = [column((4 * first).wrapping_sub(before)); 5];
    for (x, pooled) in output.chunks_exact_mut(stem.quant.channels.max(1)).enumerate() {
        patch[0] = patch[4];
        let x = (4 * (first + x)).wrapping_sub(before).wrapping_add(1);
        for (row, line) in rows.iter().enumerate() {
            let new: [i32; 4] = match line.get(x..).and_then(|line| line.first_chunk()) {
                Some(inside) => inside.map(|v: i8| i32::from(v as u8 ^ 0x80)),
                None => [0, 1, 2, 3].map(|k| pixel(line, x.wrapping_add(k), border)),
            };
            patch.iter_mut().skip(1).zip(new).for_each(|(column, value)| column[row] = value);
        }
        if PAIRS {
            native_largest_of_pairs(&pairs_of_patch(&patch), channels, pooled);
            continue;
        }
        for (out, words) in pooled.iter_mut().zip(channels) {
            let [.., multiplier, offset, shift] = *words;
            let most = largest_of_patch(&patch, words);
            *out = Requantizer::from_words([multiplier, offset, shift]).apply::<TIMES_FOUR>(most);
        }
    }
}

/// The largest of a patch's four sums, with their start.
#[inline(always)]
fn largest_of_patch(patch: &Patch, words: &[i32; WORDS]) -> i32 {
    let [.., start, _, _, _] = *words;
    let mut sums = [start; 4];
    for row in 0..3 {
        for column in 0..3 {
            let w = words[3 * row + column];
            for (k, sum) in sums.iter_mut().enumerate() {
                *sum = sum.wrapping_add(w.wrapping_mul(patch[column + k % 2 * 2][row + k / 2 * 2]));
            }
        }
    }
    let [a, b, c, d] = sums;
    a.max(b).max(c.max(d))
}

/// Whether a patch is multiplied by pairs of i16, where an instruction does.
const PAIRS: bool = cfg!(all(target_arch = "arm", arm_dsp));

/// The patches of four outputs as pairs of i16: of each row the columns 0 and 1, then of column 2 the rows 0 and 1, and 2.
#[inline(always)]
fn pairs_of_patch(patch: &Patch) -> PatchPairs {
    let rows = [0, 2].map(|x| [0, 1, 2, 3, 4].map(|row| patch[x][row] | patch[x + 1][row] << 16));
    [0, 1, 2, 3].map(|k| {
        let ([a, b, c], column) = ([0, 1, 2].map(|row| rows[k % 2][row + k / 2 * 2]), patch[k % 2 * 2 + 2]);
        let [first, second, third] = [0, 1, 2].map(|row| column[row + k / 2 * 2]);
        [a, b, c, first | second << 16, third]
    })
}

/// A kernel in the same order.
fn pairs_of_taps(taps: &[i32; 9]) -> [i32; 9] {
    let pair = |low: i32, high: i32| low & 0xffff | high << 16;
    let [a, b, c, d, e, f, g, h, i] = *taps;
    [pair(a, b), pair(d, e), pair(g, h), pair(c, f), i, 0, 0, 0, 0]
}

/// The output for four times a sum without its start.
#[inline(always)]
fn requantize(most: i32, words: &[i32; WORDS]) -> i8 {
    let [.., start, multiplier, offset, shift] = *words;
    Requantizer::from_words([multiplier, offset, shift]).apply::<TIMES_FOUR>(most.wrapping_add(start))
}

/// The input transform of F(2, 3), B^T.
#[inline(always)]
fn input_transform([a, b, c, d]: [i32; 4]) -> [i32; 4] {
    [a - c, b + c, c - b, b - d]
}

/// The filter transform of F(2x2, 3x3), G g G^T, times four: `[column][row]`.
#[inline(always)]
fn filter_transform(tap: impl Fn(usize) -> i32) -> [[i32; 4]; 4] {
    // G on three weights, times two
    let g = |[a, b, c]: [i32; 3]| [2 * a, a + b + c, a - b + c, 2 * c];
    let [a, b, c] = [0, 3, 6].map(|row| g([tap(row), tap(row + 1), tap(row + 2)]));
    [0, 1, 2, 3].map(|column| g([a[column], b[column], c[column]]))
}
