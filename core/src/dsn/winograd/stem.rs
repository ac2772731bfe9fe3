//! The input convolution and its 2x2 maximum in one: the square of outputs that is pooled is computed together.
//!
//! Source: as [`super::transform`]. Requantising never falls as the accumulator grows, so the largest of the four sums is
//! requantised and no row of the convolution is kept. It takes 36 products of a patch of 5x5, or 4x4 with a stride of 1; where no
//! instruction makes two of them, the square is a tile of F(2x2, 3x3) with a stride of 1: 16 products and 32 sums a pooled value.

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
        if stem.stride == 1 && !PAIRS {
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
        let compute = match self.layer.stride {
            1 if PAIRS => patches::<1>,
            1 => tiles,
            _ => patches::<2>,
        };
        compute(self.layer, packed, self.image, self.size, (y, first), output);
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

/// A stride of 1 by tiles, from pooled pixel `(y, first)` on.
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

/// Five columns of five pixels; with a stride of 1 four of four.
type Patch = [[i32; 5]; 5];

/// A stride of `STRIDE`, from pooled pixel `(y, first)` on.
#[inline(never)]
fn patches<const STRIDE: usize>(
    stem: &Conv<'_>,
    channels: &[[i32; WORDS]],
    image: &[i8],
    (height, width): (usize, usize),
    (y, first): (usize, usize),
    output: &mut [i8],
) {
    let border = border(stem);
    // columns that a patch does not share with the one before
    let new = 2 * STRIDE;
    let (above, before) = (pad_before(height, STRIDE), pad_before(width, STRIDE));
    let rows = [0, 1, 2, 3, 4].map(|k| line(image, width, (new * y + k).wrapping_sub(above)));
    let mut patch: Patch = [[0; 5]; 5];
    let mut x = (new * first).wrapping_sub(before);
    for column in patch.iter_mut().take(3 - STRIDE + new).skip(new) {
        *column = rows.map(|row| pixel(row, x, border));
        x = x.wrapping_add(1);
    }
    for pooled in output.chunks_exact_mut(stem.quant.channels.max(1)) {
        for shared in 0..3 - STRIDE {
            patch[shared] = patch[shared + new];
        }
        for (row, line) in rows.iter().enumerate() {
            let columns = patch.iter_mut().skip(3 - STRIDE).take(new);
            match x.checked_add(new).and_then(|end| line.get(x..end)) {
                Some(inside) => columns.zip(inside).for_each(|(to, &v)| to[row] = i32::from(v as u8 ^ 0x80)),
                None => columns.zip(0..).for_each(|(to, k)| to[row] = pixel(line, x.wrapping_add(k), border)),
            }
        }
        x = x.wrapping_add(new);
        if PAIRS {
            native_largest_of_pairs(&pairs_of_patch::<STRIDE>(&patch), channels, pooled);
            continue;
        }
        for (out, words) in pooled.iter_mut().zip(channels) {
            let [.., multiplier, offset, shift] = *words;
            let most = largest_of_patch::<STRIDE>(&patch, words);
            *out = Requantizer::from_words([multiplier, offset, shift]).apply::<TIMES_FOUR>(most);
        }
    }
}

/// The largest of a patch's four sums, with their start.
#[inline(always)]
fn largest_of_patch<const STRIDE: usize>(patch: &Patch, words: &[i32; WORDS]) -> i32 {
    let [.., start, _, _, _] = *words;
    let mut sums = [start; 4];
    for row in 0..3 {
        for column in 0..3 {
            let w = words[3 * row + column];
            for (k, sum) in sums.iter_mut().enumerate() {
                *sum = sum.wrapping_add(w.wrapping_mul(patch[column + k % 2 * STRIDE][row + k / 2 * STRIDE]));
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
fn pairs_of_patch<const STRIDE: usize>(patch: &Patch) -> PatchPairs {
    let pair = |low: i32, high: i32| low | high << 16;
    let rows = [0, STRIDE].map(|x| [0, 1, 2, 3, 4].map(|row| pair(patch[x][row], patch[x + 1][row])));
    [0, 1, 2, 3].map(|k| {
        let (rows, column, y) = (&rows[k % 2], &patch[k % 2 * STRIDE + 2], k / 2 * STRIDE);
        [rows[y], rows[y + 1], rows[y + 2], pair(column[y], column[y + 1]), column[y + 2]]
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
