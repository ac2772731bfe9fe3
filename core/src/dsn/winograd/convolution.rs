//! 3x3 convolutions with 30 products for twelve outputs instead of 108, exactly: Winograd's F(4x3, 3x3) in integers.
//!
//! Source: A. Lavin, S. Gray, Fast Algorithms for Convolutional Neural Networks, CVPR 2016, section 4.1.
//!
//! A tile of 6x5 inputs is transformed by B^T . B, the products at 30 points are summed over the channels, and A^T . A makes
//! 4x3 outputs. Inputs are u8 = i8 + 128; [`super::transform`] has the ranges. Sums are [`FACTOR`](super::transform::FACTOR)
//! times the convolution; the zero point and the 128 are in the bias. Two tiles, one below the other, are a block.

use super::clamp_all;
use super::packing::{WORDS, packed_outputs};
use super::transform::{transform_column, transform_row};
use crate::dsn::conv::Conv;
use crate::dsn::established;
use crate::simd::dual_mac::{
    BLOCK_COLUMNS, BLOCK_ROWS, Constants, DualMac, I16x8, POINT_ROWS, POINTS, Pixels, Sums, TILE_ROWS, Tile,
    lane, settle, widen,
};
use bytemuck::pod_align_to_mut;
use core::ops::Range;

/// Four channels of a column, transformed: two pairs at each of six points.
type Column = [[i32; POINT_ROWS]; 2];

/// The last two columns of a tile for each group of channels, which are the first of the tile beside it.
type Kept<const GROUPS: usize> = [[Column; 2]; GROUPS];

/// The columns of a tile that it does not share with the one before.
type New = [Column; BLOCK_COLUMNS];

/// Bytes of scratch, wherever they begin: the inputs of two tiles, their sums, and the columns that they keep. All of it stays
/// between two steps.
pub const fn scratch_bytes(inputs: usize) -> usize {
    let group = POINTS * size_of::<I16x8>() + size_of::<[[Column; 2]; 2]>();
    align_of::<i32>() - 1 + size_of::<Sums>() + size_of::<New>() + inputs.div_ceil(4) * group
}

/// What lies in the scratch: a block's inputs, its sums, the columns that each tile keeps, and new columns.
type Areas<'a, const IN: usize> = (&'a mut Tile<IN>, &'a mut Sums, &'a mut [Kept<IN>; 2], &'a mut New);

fn areas<const IN: usize>(scratch: &mut [i8]) -> Option<Areas<'_, IN>> {
    let (_, words, _) = pod_align_to_mut::<i8, i32>(scratch);
    let (sums, words) = words.split_at_mut_checked(size_of::<Sums>() / size_of::<i32>())?;
    let (new, words) = words.split_at_mut_checked(size_of::<New>() / size_of::<i32>())?;
    let (inputs, kept) = words.split_at_mut_checked(POINTS * IN * size_of::<I16x8>() / size_of::<i32>())?;
    Some((
        inputs.as_chunks_mut().0.as_chunks_mut().0.first_chunk_mut()?,
        sums.as_chunks_mut().0.as_chunks_mut().0.first_chunk_mut()?,
        kept.as_chunks_mut().0.as_chunks_mut().0.as_chunks_mut().0.as_chunks_mut().0.first_chunk_mut()?,
        new.as_chunks_mut().0.as_chunks_mut().0.first_chunk_mut()?,
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
    (height.div_ceil(BLOCK_ROWS) * width.div_ceil(BLOCK_COLUMNS)).div_ceil(blocks) * parts
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
        let (first, part, across) = (step / parts * most, step % parts, width.div_ceil(BLOCK_COLUMNS).max(1));
        let all = height.div_ceil(BLOCK_ROWS) * across;
        let Some((inputs, sums, kept, new)) = areas::<IN>(self.scratch) else {
            established::<()>(None);
            return true;
        };
        // the outputs of this part: pairs of them
        let pairs = packed_outputs(4 * OUT) / 2 / parts;
        let (weights, _) = self.weights.as_chunks::<IN>();
        let (weights, _) = weights.as_chunks::<POINTS>();
        let (constants, _) = self.constants.as_chunks::<WORDS>().0.as_chunks::<2>();
        let part_pairs = part * pairs..(part + 1) * pairs;
        let channel = self.first + 2 * part_pairs.start;
        let pairs: Pairs<'_, IN> = Pairs {
            weights: established(weights.get(part_pairs.clone())),
            constants: established(constants.get(part_pairs)),
            channel,
        };
        let channels = channel..channel + 2 * pairs.weights.len();
        let (pixels, _) = self.input.as_chunks::<C>().0.as_chunks::<IN>();
        let border = [[self.layer.quant.in_zp; C]; IN];
        let range = (self.layer.quant.act_min, self.layer.quant.act_max);
        let row = width * 4 * OUT;

        let mut patch: Patch<'_, C, IN> = [[&border; POINT_ROWS]; 5];
        for block in first..(first + most).min(all) {
            let (y, x) = (block / across * BLOCK_ROWS, block % across * BLOCK_COLUMNS);
            // all columns of the first tile of a row, of the others the last three
            let from = if x == 0 { 0 } else { 2 };
            for (tile, kept) in kept.iter_mut().enumerate().take(2 * usize::from(part == 0)) {
                for row in 0..POINT_ROWS {
                    let line = (y + TILE_ROWS * tile + row).checked_sub(1);
                    let line = line.and_then(|y| pixels.get(y * width..)?.get(..width)).unwrap_or(&[]);
                    // columns 2 to 4, where they are inside and the others kept
                    if let (false, Some([c, d, e])) =
                        (x == 0, line.get(x + 1..).and_then(|line| line.first_chunk()))
                    {
                        (patch[2][row], patch[3][row], patch[4][row]) = (c, d, e);
                        continue;
                    }
                    for (column, patch) in patch.iter_mut().enumerate().skip(from) {
                        patch[row] = line.get((x + column).wrapping_sub(1)).unwrap_or(&border);
                    }
                }
                transform::<P, C, IN>(&patch, x == 0, (kept, new), tile, inputs);
            }
            let columns = (width - x).min(BLOCK_COLUMNS);
            let output = established(self.output.get_mut(y * row + x * 4 * OUT..));
            if columns == BLOCK_COLUMNS {
                pairs.outputs::<P, OUT>(mac, inputs, sums, output, row);
            } else {
                // at the end of a row there may be fewer pixels than are computed
                ends::<OUT>(output, row, columns, channels.clone(), |found| {
                    pairs.outputs::<P, OUT>(mac, inputs, sums, found, size_of::<Pixels<OUT>>());
                });
            }
            for line in output.chunks_mut(row.max(1)).take(BLOCK_ROWS) {
                clamp_all(established(line.get_mut(..columns * 4 * OUT)), range);
            }
        }
        first + most >= all && part + 1 == parts
    }
}

/// Pairs of output channels.
struct Pairs<'a, const IN: usize> {
    weights: &'a [Tile<IN>],
    constants: &'a [[Constants; 2]],
    /// The first channel.
    channel: usize,
}

impl<const IN: usize> Pairs<'_, IN> {
    /// The outputs of a block: its first pixel is that of `values`, its rows are `row` values apart.
    #[inline(never)]
    fn outputs<P: DualMac, const OUT: usize>(
        &self,
        mac: P,
        inputs: &Tile<IN>,
        sums: &mut Sums,
        values: &mut [i8],
        row: usize,
    ) {
        for (pair, (weights, constants)) in self.weights.iter().zip(self.constants).enumerate() {
            mac.products(inputs, weights, sums);
            mac.outputs::<OUT>(sums, constants, values, row, self.channel + 2 * pair);
        }
    }
}

/// Some channels of the first columns of a block, which `block` computes.
#[inline(never)]
fn ends<const OUT: usize>(
    output: &mut [i8],
    row: usize,
    columns: usize,
    channels: Range<usize>,
    block: impl FnOnce(&mut [i8]),
) {
    let mut found = [[[[0; 4]; OUT]; BLOCK_COLUMNS]; BLOCK_ROWS];
    block(found.as_flattened_mut().as_flattened_mut().as_flattened_mut());
    for (line, found) in output.chunks_mut(row.max(1)).zip(&found) {
        for (to, from) in line.chunks_exact_mut(4 * OUT).zip(found).take(columns) {
            let (to, from) = (to.get_mut(channels.clone()), from.as_flattened().get(channels.clone()));
            established(to).iter_mut().zip(established(from)).for_each(|(to, from)| *to = *from);
        }
    }
}

/// A tile's inputs, the first or the second of a block, transformed; unless it is the first of a row, two columns are those that were kept.
#[inline(never)]
fn transform<P: DualMac, const C: usize, const GROUPS: usize>(
    patch: &Patch<'_, C, GROUPS>,
    first_of_row: bool,
    (kept, new): (&mut Kept<GROUPS>, &mut New),
    tile: usize,
    inputs: &mut Tile<GROUPS>,
) {
    let [a, b, last @ ..] = patch;
    for (group, kept) in kept.iter_mut().enumerate() {
        let (vector, first) = lane::<P, GROUPS>(group, tile);
        if first_of_row {
            kept.iter_mut().zip([a, b]).for_each(|(to, column)| transform_group(column, group, to));
        }
        new.iter_mut().zip(last).for_each(|(to, column)| transform_group(column, group, to));
        for pair in 0..2 {
            let at = (first + pair) % 4;
            for row in 0..POINT_ROWS {
                let value = |column: &Column| column[pair][row];
                let ([a, b], [c, d, e]) = (kept.each_ref().map(value), new.each_ref().map(value));
                (kept[0][pair][row], kept[1][pair][row]) = (d, e);
                let points = transform_row([a, b, c, d, e]);
                for (column, point) in points.into_iter().enumerate() {
                    inputs[POINT_ROWS * column + row][vector % GROUPS][at] = settle(point);
                }
            }
        }
    }
}

/// A column of a group of channels, transformed.
#[inline(never)]
fn transform_group<const C: usize, const GROUPS: usize>(
    column: &[&[[i8; C]; GROUPS]; POINT_ROWS],
    group: usize,
    to: &mut Column,
) {
    // the weights of a fourth channel that is not there are zero
    let pairs = column.map(|pixel| widen(&pixel[group % GROUPS]));
    for pair in 0..2 {
        to[pair] = transform_column(pairs.map(|pairs| pairs[pair]));
    }
}
