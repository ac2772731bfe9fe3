//! A model's numbers in the order in which tiles read them.
//!
//! Convolution: for each pair of outputs the weights at 16 points, U = G g G^T times four, column by column, rows in the
//! order 1, 2, 0, 3, row 3 negated (see [`Points`](crate::simd::pairs::Points)); channels of a group in the order 0, 2,
//! 1, 3, as masks take them out of a word. Constants: a [`Rescale`](super::rescale::Rescale) of every output channel. Affine: a table of 256
//! outputs a channel, by the input's bits.

use super::convolution::covered;
use super::rescale::WORDS;
use super::stem;
use crate::dsn::affine::Affine;
use crate::dsn::conv::Conv;
use crate::dsn::model::Model;
use crate::simd::pairs::{Eight, POINTS, Pairs, place};

/// Entries of an affine channel's table.
pub const TABLE: usize = 256;

/// The channel that comes `k`-th in a group of four.
const ORDER: [usize; 4] = [0, 2, 1, 3];

/// Rows of points in the order of their use, and their signs.
const ROWS: [(usize, i32); 4] = [(1, 1), (2, 1), (0, 1), (3, -1)];

/// G, times two.
const G: [[i32; 3]; 4] = [[2, 0, 0], [1, 1, 1], [1, -1, 1], [0, 0, 2]];

/// Where a network's packed numbers lie.
#[derive(Debug, Clone, Copy)]
pub struct Layout {
    channels: usize,
    blocks: usize,
}

impl Layout {
    /// The layout of a network.
    pub const fn new(channels: usize, blocks: usize) -> Self {
        Layout { channels, blocks }
    }

    /// Eights of a convolution.
    pub const fn conv_eights(&self) -> usize {
        self.channels / 2 * POINTS * (self.channels / 4)
    }

    /// Words of all constants.
    pub const fn constants(&self) -> usize {
        self.channels * (stem::WORDS + 2 * self.blocks * WORDS)
    }

    /// The number of a convolution among all of them, by its layer.
    fn conv_number(&self, at: usize) -> Option<usize> {
        let at = at.checked_sub(1)?;
        Some(2 * (at / 4) + (at % 4).checked_sub(1)?)
    }

    /// Weights and constants of a convolution.
    pub fn conv<'a>(
        &self,
        at: usize,
        eights: &'a [Eight],
        constants: &'a [i32],
    ) -> Option<(&'a [Eight], &'a [i32])> {
        let number = self.conv_number(at)?;
        let words = self.channels * WORDS;
        let first = self.channels * stem::WORDS + number * words;
        let weights = eights.get(number * self.conv_eights()..)?.get(..self.conv_eights())?;
        Some((weights, constants.get(first..)?.get(..words)?))
    }

    /// Constants of the stem.
    pub fn stem<'a>(&self, constants: &'a [i32]) -> Option<&'a [i32]> {
        constants.get(..self.channels * stem::WORDS)
    }

    /// Tables of an affine layer.
    pub fn tables<'a>(&self, at: usize, tables: &'a [i8]) -> Option<&'a [i8]> {
        let length = self.channels * TABLE;
        tables.get(at.checked_sub(1)? / 4 * length..)?.get(..length)
    }

    /// Packs all layers in the order of `P`; the bits of those that tiles cannot compute, or `None` if the memory is too small.
    pub fn pack<P: Pairs>(
        &self,
        model: &Model<'_>,
        eights: &mut [Eight],
        constants: &mut [i32],
        tables: &mut [i8],
    ) -> Option<u64> {
        let (first, constants) = constants.split_at_mut_checked(self.channels * stem::WORDS)?;
        let mut plain = u64::from(stem::pack(&model.stem, first).is_none());
        let convs = model.blocks.iter().flat_map(|block| &block.conv);
        let memory = eights
            .chunks_exact_mut(self.conv_eights().max(1))
            .zip(constants.chunks_exact_mut((self.channels * WORDS).max(1)));
        for (number, (conv, (eights, constants))) in convs.zip(memory).enumerate() {
            if !covered(conv.inputs) || pack_constants(conv, constants).is_none() {
                plain |= 1 << (4 * (number / 2) + 2 + number % 2);
            }
            if covered(conv.inputs) {
                pack_weights::<P>(conv, eights);
            }
        }
        for (block, tables) in model.blocks.iter().zip(tables.chunks_exact_mut((self.channels * TABLE).max(1))) {
            tabulate(&block.affine, tables);
        }
        Some(plain)
    }
}

/// A weight at a point, four times U.
pub fn point(kernel: &[[i32; 3]; 3], row: usize, column: usize) -> i32 {
    let [Some(down), Some(along)] = [G.get(row), G.get(column)] else { return 0 };
    kernel.iter().zip(down).map(|(k, r)| r * k.iter().zip(along).map(|(w, c)| w * c).sum::<i32>()).sum()
}

/// The 3x3 weights of one output and one input.
pub fn kernel(conv: &Conv<'_>, output: usize, input: usize) -> [[i32; 3]; 3] {
    let at = |tap: usize| (output * 9 + tap) * conv.inputs + input;
    let tap = |tap| conv.layer.weights.get(at(tap)).map_or(0, |&w| i32::from(w as i8));
    [0, 1, 2].map(|row| [0, 1, 2].map(|column| tap(3 * row + column)))
}

fn pack_constants(conv: &Conv<'_>, constants: &mut [i32]) -> Option<()> {
    let (constants, _) = constants.as_chunks_mut::<WORDS>();
    for (o, words) in constants.iter_mut().enumerate() {
        *words = conv.layer.rescale(o, 9 * conv.inputs)?.to_words();
    }
    Some(())
}

fn pack_weights<P: Pairs>(conv: &Conv<'_>, eights: &mut [Eight]) {
    let quads = conv.inputs / 4;
    for (pair, eights) in eights.chunks_exact_mut((POINTS * quads).max(1)).enumerate() {
        for (point_at, eights) in eights.chunks_exact_mut(quads).enumerate() {
            let (column, (row, sign)) = (point_at / 4, ROWS[point_at % 4]);
            for (quad, part) in (0..quads).flat_map(|quad| [(quad, 0), (quad, 1)]) {
                let (eight, first) = place::<P>(quad, part);
                let Some(Eight(values)) = eights.get_mut(eight) else { continue };
                for (value, k) in values.iter_mut().skip(first).zip(ORDER) {
                    let weights = kernel(conv, 2 * pair + part, 4 * quad + k);
                    *value = (sign * point(&weights, row, column)) as i16;
                }
            }
        }
    }
}

/// Every output of every channel of an affine layer.
fn tabulate(affine: &Affine<'_>, tables: &mut [i8]) {
    let inputs: [i8; TABLE] = core::array::from_fn(|bits| bits as u8 as i8);
    for (c, table) in tables.chunks_exact_mut(TABLE).enumerate() {
        for (x, y) in inputs.iter().zip(table) {
            *y = affine.value(c, *x);
        }
    }
}
