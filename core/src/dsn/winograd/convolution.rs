//! 3x3 convolutions with 30 products for twelve outputs instead of 108, exactly: Winograd's F(4x3, 3x3) in integers.
//!
//! Source: A. Lavin, S. Gray, Fast Algorithms for Convolutional Neural Networks, CVPR 2016, section 4.1.
//!
//! A tile of 6x5 inputs is transformed by B^T . B, the products at 30 points are summed over the channels, and A^T . A makes
//! 4x3 outputs. Inputs are u8 = i8 + 128; [`super::transform`] has the ranges. Sums are [`FACTOR`](super::transform::FACTOR)
//! times the convolution; the zero point and the 128 are in the bias. Two tiles, one below the other, are a block.

use super::clamp_all;
use super::packing::{WORDS, packed_outputs};
use super::transform::{FACTOR_BITS, NINTH, outputs_of_row, transform_column, transform_row};
use crate::dsn::conv::Conv;
use crate::dsn::established;
use crate::fixed::Requantizer;
use crate::simd::dual_mac::{DualMac, I16x8, POINT_ROWS, POINTS, Sums, Tile, lane, settle, widen};
use bytemuck::pod_align_to_mut;
use core::ops::Range;

/// Rows of outputs of a tile.
const TILE_ROWS: usize = 4;

/// Rows of outputs of a block.
const ROWS: usize = 2 * TILE_ROWS;

/// Columns of outputs of a block.
const COLUMNS: usize = 3;

/// Words of a column of sums: two tiles and two outputs in four rows.
const COLUMN: usize = 4 * TILE_ROWS;

/// Four channels of a column, transformed: two pairs at each of six points.
type Column = [[i32; POINT_ROWS]; 2];

/// The last two columns of a tile for each group of channels, which are the first of the tile beside it.
type Kept<const GROUPS: usize> = [[Column; 2]; GROUPS];

/// Bytes of scratch, wherever they begin: the inputs of two tiles, their sums, and the columns that they keep. All of it stays
/// between two steps.
pub const fn scratch_bytes(inputs: usize) -> usize {
    let group = POINTS * size_of::<I16x8>() + size_of::<[[Column; 2]; 2]>();
    align_of::<i32>() - 1 + size_of::<Sums>() + inputs.div_ceil(4) * group
}

/// A block's inputs, sums, and the columns of each tile.
fn areas<const IN: usize>(scratch: &mut [i8]) -> Option<(&mut Tile<IN>, &mut Sums, &mut [Kept<IN>; 2])> {
    let (_, words, _) = pod_align_to_mut::<i8, i32>(scratch);
    let (sums, words) = words.split_at_mut_checked(size_of::<Sums>() / size_of::<i32>())?;
    let (inputs, kept) = words.split_at_mut_checked(POINTS * IN * size_of::<I16x8>() / size_of::<i32>())?;
    Some((
        inputs.as_chunks_mut().0.as_chunks_mut().0.first_chunk_mut()?,
        sums.as_chunks_mut().0.as_chunks_mut().0.first_chunk_mut()?,
        kept.as_chunks_mut().0.as_chunks_mut().0.as_chunks_mut().0.as_chunks_mut().0.first_chunk_mut()?,
    ))
}

/// Blocks that a step does, and steps that a block takes: of a convolution with so many inputs and outputs.
const fn work<P: DualMac>(inputs: usize, outputs: usize) -> (usize, usize) {
    let [of_8, of_16, parts_of_32] = P::BLOCKS;
    match outputs {
        _ if inputs > 32 => (1, 2),
        8 => (of_8, 1),
        16 => (of_16, 1),
        _ => (1, parts_of_32),
    }
}

/// Steps of a convolution with so many inputs and outputs, `(height, width)`.
pub const fn steps<P: DualMac>(inputs: usize, outputs: usize, (height, width): (usize, usize)) -> usize {
    let (blocks, parts) = work::<P>(inputs, outputs);
    (height.div_ceil(ROWS) * width.div_ceil(COLUMNS)).div_ceil(blocks) * parts
}

/// A convolution of stride 1: `[height, width, inputs]` to `[height, width, outputs]`.
pub(super) struct Convolution<'a> {
    pub layer: &'a Conv<'a>,
    /// First of the output channels that are packed.
    pub first: usize,
    pub weights: &'a [I16x8],
    pub constants: &'a [i32],
    pub input: &'a [i8],
    pub size: (usize, usize),
    /// [`scratch_bytes`].
    pub scratch: &'a mut [i8],
    pub output: &'a mut [i8],
}

/// Three pixels of a row: the outputs of a tile.
type Pixels<const GROUPS: usize> = [[[i8; 4]; GROUPS]; COLUMNS];

/// The pixels that a tile is made of, column by column.
type Patch<'a, const C: usize, const GROUPS: usize> = [[&'a [[i8; C]; GROUPS]; POINT_ROWS]; 5];

impl Convolution<'_> {
    /// Does a step: some blocks or a part of one, below 45 000 instructions on Cortex-M4F; true after the last.
    pub fn run<P: DualMac>(self, mac: P, step: usize) -> bool {
        match (self.layer.inputs, self.layer.quant.channels) {
            (8, _) => self.blocks::<P, 4, 2, 2>(mac, step),
            (16, _) => self.blocks::<P, 4, 4, 4>(mac, step),
            (32, _) => self.blocks::<P, 4, 8, 8>(mac, step),
            #[cfg(feature = "graph")]
            (64, _) => self.blocks::<P, 4, 16, 16>(mac, step),
            #[cfg(feature = "graph")]
            (3, 8) => self.blocks::<P, 3, 1, 2>(mac, step),
            #[cfg(feature = "graph")]
            (3, 16) => self.blocks::<P, 3, 1, 4>(mac, step),
            #[cfg(feature = "graph")]
            (3, 32) => self.blocks::<P, 3, 1, 8>(mac, step),
            _ => true,
        }
    }

    /// Does some blocks or a part of one, of inputs in `IN` groups of `C` channels and outputs in `OUT` groups of four.
    #[inline(never)] // a program has two of what calls it
    fn blocks<P: DualMac, const C: usize, const IN: usize, const OUT: usize>(
        self,
        mac: P,
        step: usize,
    ) -> bool {
        let (height, width) = self.size;
        let (most, parts) = work::<P>(self.layer.inputs, 4 * OUT);
        let (first, part, across) = (step / parts * most, step % parts, width.div_ceil(COLUMNS).max(1));
        let all = height.div_ceil(ROWS) * across;
        let Some((inputs, sums, kept)) = areas::<IN>(self.scratch) else {
            established::<()>(None);
            return true;
        };
        // the outputs of this part: pairs of them
        let pairs = packed_outputs(4 * OUT) / 2 / parts;
        let (weights, _) = self.weights.as_chunks::<IN>();
        let (weights, _) = weights.as_chunks::<POINTS>();
        let (constants, _) = self.constants.as_chunks::<WORDS>().0.as_chunks::<2>();
        let weights =
            established(weights.get(part * pairs..)).iter().zip(established(constants.get(part * pairs..)));
        let channel = self.first + 2 * part * pairs;
        let (pixels, _) = self.input.as_chunks::<C>().0.as_chunks::<IN>();
        let border = [[self.layer.quant.in_zp; C]; IN];
        let range = (self.layer.quant.act_min, self.layer.quant.act_max);

        let mut patch: Patch<'_, C, IN> = [[&border; POINT_ROWS]; 5];
        let mut found = [[[[0; 4]; OUT]; COLUMNS]; ROWS];
        for block in first..(first + most).min(all) {
            let (y, x) = (block / across * ROWS, block % across * COLUMNS);
            // all columns of the first tile of a row, of the others the last three
            let from = if x == 0 { 0 } else { 2 };
            for (tile, kept) in kept.iter_mut().enumerate().take(2 * usize::from(part == 0)) {
                for row in 0..POINT_ROWS {
                    let line = (y + TILE_ROWS * tile + row).checked_sub(1);
                    let line = line.and_then(|y| pixels.get(y * width..)?.get(..width)).unwrap_or(&[]);
                    for (column, patch) in patch.iter_mut().enumerate().skip(from) {
                        patch[row] = line.get((x + column).wrapping_sub(1)).unwrap_or(&border);
                    }
                }
                transform::<P, C, IN>(&patch, from, kept, tile, inputs);
            }
            let (output, _) = self.output.as_chunks_mut::<4>().0.as_chunks_mut::<OUT>();
            let lines = established(output.get_mut(y * width..)).chunks_exact_mut(width.max(1)).take(ROWS);
            let mut lines = lines.map(|line| established(line.get_mut(x..(x + COLUMNS).min(width))));
            let whole = y + ROWS <= height && x + COLUMNS <= width;
            let mut rows = found.each_mut();
            if whole {
                for (row, line) in rows.iter_mut().zip(&mut lines) {
                    if let Some(line) = line.first_chunk_mut() {
                        *row = line;
                    }
                }
            }
            for (pair, (weights, constants)) in weights.clone().take(pairs).enumerate() {
                mac.products(inputs, weights, sums);
                finish::<OUT, 0>(sums, &constants[0], &mut rows, channel + 2 * pair);
                finish::<OUT, 1>(sums, &constants[1], &mut rows, channel + 2 * pair + 1);
            }
            if whole {
                rows.iter_mut().for_each(|row| clamp_all(row.as_flattened_mut().as_flattened_mut(), range));
                continue;
            }
            // at the end of a row, or in the last rows, there may be fewer pixels than are computed
            let channels = channel / 4..(channel + 2 * pairs) / 4;
            for (line, found) in lines.zip(&found) {
                let (line, found) =
                    (line.as_flattened_mut().as_flattened_mut(), found.as_flattened().as_flattened());
                copy_channels(line, found, 4 * OUT, 4 * channels.start..4 * channels.end);
                clamp_all(line, range);
            }
        }
        first + most >= all && part + 1 == parts
    }
}

/// Copies some channels of as many pixels as there are.
#[inline(never)]
fn copy_channels(to: &mut [i8], from: &[i8], all: usize, channels: Range<usize>) {
    for (to, from) in to.chunks_exact_mut(all.max(1)).zip(from.chunks_exact(all.max(1))) {
        let (to, from) = (to.get_mut(channels.clone()), from.get(channels.clone()));
        established(to).iter_mut().zip(established(from)).for_each(|(to, from)| *to = *from);
    }
}

/// A tile's inputs, the first or the second of a block, transformed; columns before `from` are those that were kept.
#[inline(never)]
fn transform<P: DualMac, const C: usize, const GROUPS: usize>(
    patch: &Patch<'_, C, GROUPS>,
    from: usize,
    kept: &mut Kept<GROUPS>,
    tile: usize,
    inputs: &mut Tile<GROUPS>,
) {
    let mut new = [[[0; POINT_ROWS]; 2]; COLUMNS];
    for (group, kept) in kept.iter_mut().enumerate() {
        let (vector, first) = lane::<P, GROUPS>(group, tile);
        for (to, column) in kept.iter_mut().chain(&mut new).zip(patch).skip(from) {
            let pairs = column.map(|pixel| {
                // the weights of a fourth channel that is not there are zero
                let mut four = [0; 4];
                four.iter_mut().zip(&pixel[group]).for_each(|(to, from)| *to = *from);
                widen(four)
            });
            for pair in 0..2 {
                to[pair] = transform_column(pairs.map(|pairs| pairs[pair]));
            }
        }
        for pair in 0..2 {
            let at = (first + pair) % 4;
            for row in 0..POINT_ROWS {
                let value = |column: &Column| column[pair][row];
                let ([a, b], [c, d, e]) = (kept.each_ref().map(value), new.each_ref().map(value));
                let points = transform_row([a, b, c, d, e]);
                for (column, point) in points.into_iter().enumerate() {
                    inputs[POINT_ROWS * column + row][vector % GROUPS][at] = settle(point);
                }
            }
        }
        *kept = [new[1], new[2]];
    }
}

/// A^T along the rows of two tiles, and requantisation: the `OUTPUT`-th channel of the sums.
#[inline(never)]
fn finish<const OUT: usize, const OUTPUT: usize>(
    sums: &Sums,
    constants: &[i32; WORDS],
    rows: &mut [&mut Pixels<OUT>; ROWS],
    channel: usize,
) {
    let [start, scale @ ..] = *constants;
    let requantizer = Requantizer::from_words(scale);
    let channel = channel % (4 * OUT);
    let sums = sums.as_flattened().as_flattened();
    for (tile, rows) in rows.as_chunks_mut::<TILE_ROWS>().0.iter_mut().enumerate() {
        // the sums of a row lie a column apart
        let windows = sums.windows(4 * COLUMN + 1).skip(2 * OUTPUT + tile).step_by(4);
        for (pixels, window) in rows.iter_mut().zip(windows) {
            let Some(window) = window.first_chunk::<{ 4 * COLUMN + 1 }>() else { continue };
            let row = outputs_of_row([0, 1, 2, 3, 4].map(|column| window[COLUMN * column]));
            for (pixel, sum) in pixels.iter_mut().zip(row) {
                let sixteen = sum.wrapping_mul(NINTH).wrapping_add(start);
                pixel.as_flattened_mut()[channel] = requantizer.apply::<FACTOR_BITS>(sixteen);
            }
        }
    }
}
