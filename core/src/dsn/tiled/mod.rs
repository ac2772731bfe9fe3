//! The network's layers in tiles of 2x2 outputs, bit for bit the plain loops: for processors without wide vectors.
//!
//! Convolutions take 16 products instead of 36 by Winograd's F(2x2, 3x3) in exact integers, affine layers are tables,
//! and the stem keeps no row before its pooling. Weights are packed once into the caller's memory. A layer whose numbers
//! this form does not cover (a shift outside -20..=-1, an accumulator beyond 2^29; convolutions of other than 8, 16 or 32
//! channels) runs by the plain loops; training and TFLite's converter make no such shifts or accumulators.

mod convolution;
mod packing;
mod pointwise;
mod rescale;
mod stem;

use super::add::Add;
use super::affine::Affine;
use super::conv::{Conv, same};
use super::kernels::{Kernels, Portable};
use super::model::Model;
use crate::frame::ROWS;
use crate::simd::NativePairs;
use crate::simd::pairs::{Eight, POINTS, Pairs};
use packing::{Layout, TABLE};

/// The caller's memory of a [`Tiled`].
#[derive(Debug)]
pub struct TiledMemory<'b> {
    /// Transformed weights, [`TiledSizes::eights`] of them.
    pub eights: &'b mut [Eight],
    /// Biases and scales, and one row of tiles: [`TiledSizes::words`].
    pub words: &'b mut [i32],
    /// Tables of the affine layers, and a border: [`TiledSizes::bytes`].
    pub bytes: &'b mut [i8],
}

/// How much of each a network takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TiledSizes {
    /// Sixteens of bytes: 3.6 times the bytes of the convolutions' weights.
    pub eights: usize,
    /// Words.
    pub words: usize,
    /// Bytes.
    pub bytes: usize,
}

impl TiledSizes {
    /// The sizes for an image of `frames` columns and a network's shape.
    pub const fn new(frames: usize, channels: usize, blocks: usize, stem_stride: usize) -> Self {
        let width = same(frames, stem_stride) / 2;
        let layout = Layout::new(channels, blocks);
        let strip = convolution::strip_words(width, channels);
        let scratch = if strip > pointwise::ADD_WORDS { strip } else { pointwise::ADD_WORDS };
        TiledSizes {
            eights: 2 * blocks * layout.conv_eights(),
            words: layout.constants() + scratch,
            bytes: blocks * channels * TABLE + width * channels,
        }
    }

    /// The sizes for a model.
    pub fn of(model: &Model<'_>) -> Self {
        Self::new(model.frames(), model.channels(), model.blocks(), model.stem_stride())
    }

    /// All of it in bytes.
    pub const fn total(&self) -> usize {
        16 * self.eights + 4 * self.words + self.bytes
    }
}

/// Memory for a `static`, by [`TiledSizes`].
#[derive(Debug)]
pub struct TiledBuffers<const EIGHTS: usize, const WORDS: usize, const BYTES: usize> {
    eights: [Eight; EIGHTS],
    words: [i32; WORDS],
    bytes: [i8; BYTES],
}

impl<const EIGHTS: usize, const WORDS: usize, const BYTES: usize> TiledBuffers<EIGHTS, WORDS, BYTES> {
    /// Zeros.
    pub const fn new() -> Self {
        TiledBuffers { eights: [Eight::ZERO; EIGHTS], words: [0; WORDS], bytes: [0; BYTES] }
    }

    /// The memory, borrowed.
    pub fn view(&mut self) -> TiledMemory<'_> {
        TiledMemory { eights: &mut self.eights, words: &mut self.words, bytes: &mut self.bytes }
    }
}

impl<const EIGHTS: usize, const WORDS: usize, const BYTES: usize> Default
    for TiledBuffers<EIGHTS, WORDS, BYTES>
{
    fn default() -> Self {
        Self::new()
    }
}

/// A model's packed weights.
#[derive(Debug)]
pub struct Tiled<'b, P = NativePairs> {
    pairs: P,
    layout: Layout,
    /// Layers that run by the plain loops, by bit.
    plain: u64,
    eights: &'b [Eight],
    constants: &'b [i32],
    scratch: &'b mut [i32],
    tables: &'b [i8],
    border: &'b mut [i8],
}

impl<'b> Tiled<'b> {
    /// Packs a model's weights for the fastest arithmetic of the target; `None` if the memory is too small.
    pub fn new(model: &Model<'_>, memory: TiledMemory<'b>) -> Option<Self> {
        Self::with_pairs(model, NativePairs::default(), memory)
    }
}

impl<'b, P: Pairs> Tiled<'b, P> {
    /// [`Tiled::new`] by the arithmetic `pairs`.
    pub fn with_pairs(model: &Model<'_>, pairs: P, memory: TiledMemory<'b>) -> Option<Self> {
        let sizes = TiledSizes::of(model);
        let layout = Layout::new(model.channels(), model.blocks());
        let eights = memory.eights.get_mut(..sizes.eights)?;
        let (constants, scratch) = memory.words.split_at_mut_checked(layout.constants())?;
        let scratch = scratch.get_mut(..sizes.words - layout.constants())?;
        let (tables, border) = memory.bytes.split_at_mut_checked(model.blocks() * model.channels() * TABLE)?;
        let border = border.get_mut(..sizes.bytes - tables.len())?;
        let plain = layout.pack::<P>(model, eights, constants, tables)?;
        Some(Tiled { pairs, layout, plain, eights, constants, scratch, tables, border })
    }

    /// How many layers run by the plain loops.
    pub fn plain_layers(&self) -> u32 {
        self.plain.count_ones()
    }

    fn covers(&self, at: usize) -> bool {
        self.plain >> (at & 63) & 1 == 0
    }
}

impl<P: Pairs> Kernels for Tiled<'_, P> {
    fn stem(
        &mut self,
        stem: &Conv<'_>,
        image: &[i8],
        size: (usize, usize),
        rows: &mut [i8],
        pooled: &mut [i8],
    ) {
        match self.layout.stem(self.constants).filter(|_| self.covers(0) && stem.stride == 1) {
            Some(constants) => stem::pooled(stem, constants, image, size, pooled),
            None => Portable.stem(stem, image, size, rows, pooled),
        }
    }

    fn affine(&mut self, at: usize, layer: &Affine<'_>, input: &[i8], output: &mut [i8]) {
        match self.layout.tables(at, self.tables) {
            Some(tables) => pointwise::look_up(tables, input, output),
            None => layer.forward(input, output),
        }
    }

    fn conv(&mut self, at: usize, layer: &Conv<'_>, input: &[i8], size: (usize, usize), output: &mut [i8]) {
        let packed = self.layout.conv(at, self.eights, self.constants).filter(|_| self.covers(at));
        let Some((weights, constants)) = packed else {
            return layer.forward(input, size.0, size.1, output);
        };
        let (border, strip) = (&mut *self.border, &mut *self.scratch);
        border.fill(layer.layer.in_zp);
        let (_, width) = size;
        let job = convolution::Convolution { layer, weights, constants, input, width, border, strip, output };
        job.run(self.pairs); // packing has refused other widths
    }

    fn add(&mut self, _at: usize, layer: &Add, x: &mut [i8], branch: &[i8]) {
        if !pointwise::add(layer, self.scratch, x, branch) {
            layer.forward(x, branch);
        }
    }
}

const _: () = assert!(POINTS == 16 && ROWS % 4 == 0, "tiles are 4x4 points and rows come in pairs behind the pooling");

#[cfg(test)]
mod tests;
