//! The network's layers in tiles of 2x2 outputs, bit for bit the plain loops: for processors without wide vectors.
//!
//! Convolutions take 16 products instead of 36 by Winograd's F(2x2, 3x3) in exact integers, additions are tables, and the
//! stem keeps no row before its pooling. A convolution's weights are packed into the caller's memory: into one place when
//! the layer runs, or ahead where there are more places. A layer whose numbers this form does not cover (a shift outside
//! -20..=-1, an accumulator beyond 2^29; convolutions of other than 8, 16 or 32 channels) runs by the plain loops;
//! training and TFLite's converter make no such shifts or accumulators.

mod convolution;
mod packing;
mod pointwise;
mod rescale;
mod stem;

use super::add::Add;
use super::batch_norm::BatchNormRelu;
use super::conv::{Conv, same};
use super::kernels::{Kernels, Portable};
use super::model::{MAX_BLOCKS, Model};
use super::shape::Shape;
use crate::dims::ROWS;
use crate::simd::NativeDualMac;
use crate::simd::dual_mac::{DualMac, I16x8, POINTS};
use packing::{conv_eights, conv_words};

/// The caller's memory of a [`WinogradF2`].
#[derive(Debug, Default)]
pub struct WinogradMemory<'b> {
    /// Transformed weights, [`WinogradSizes::eights`] of them.
    pub eights: &'b mut [I16x8],
    /// Biases and scales, and a row of tiles: [`WinogradSizes::words`].
    pub words: &'b mut [i32],
}

/// How much of each a network takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct WinogradSizes {
    /// Sixteens of bytes: a place is 3.6 times the bytes of a convolution's weights.
    pub eights: usize,
    /// Words.
    pub words: usize,
}

impl WinogradSizes {
    /// The sizes for an image of `frames` columns, a network's shape, and `places` for packed convolutions: one does, and
    /// each further one keeps a convolution's weights from being packed at every recognition.
    pub const fn new(frames: usize, channels: usize, stem_stride: usize, places: usize) -> Self {
        WinogradSizes {
            eights: places * conv_eights(channels),
            words: places * conv_words(channels) + spare_words(frames, channels, stem_stride),
        }
    }

    /// The least for a model.
    pub fn of(model: &Model<'_>) -> Self {
        Self::new(model.frames(), model.channels(), model.stem_stride(), 1)
    }

    /// All of it in bytes.
    pub const fn total(&self) -> usize {
        size_of::<I16x8>() * self.eights + size_of::<i32>() * self.words
    }
}

impl Shape {
    /// Memory of its kernels, with one place for packed weights.
    pub const fn winograd_sizes(&self) -> WinogradSizes {
        WinogradSizes::new(self.frames, self.channels, self.stem_stride, 1)
    }
}

/// Words that one layer leaves to the next: a row of tiles, the tables of an addition, or the stem's weights.
const fn spare_words(frames: usize, channels: usize, stem_stride: usize) -> usize {
    let strip = convolution::strip_words(same(frames, stem_stride) / 2, channels);
    let stem = channels * stem::WORDS;
    let most = if strip > stem { strip } else { stem };
    if most > pointwise::MOST_WORDS { most } else { pointwise::MOST_WORDS }
}

/// A model's convolutions by tiles.
#[derive(Debug)]
pub struct WinogradF2<'b, P = NativeDualMac> {
    pairs: P,
    channels: usize,
    /// Convolutions that are packed: the others share the place behind them.
    ahead: usize,
    /// Of those, which run by the plain loops, by bit.
    plain: u64,
    eights: &'b mut [I16x8],
    constants: &'b mut [i32],
    spare: &'b mut [i32],
}

impl<'b> WinogradF2<'b> {
    /// The fastest arithmetic of the target, for a model; `None` if the memory is too small.
    pub fn new(model: &Model<'_>, memory: WinogradMemory<'b>) -> Option<Self> {
        Self::with_pairs(model, NativeDualMac::default(), memory)
    }
}

impl<'b, P: DualMac> WinogradF2<'b, P> {
    /// [`WinogradF2::new`] by the arithmetic `pairs`.
    pub fn with_pairs(model: &Model<'_>, pairs: P, memory: WinogradMemory<'b>) -> Option<Self> {
        let channels = model.channels();
        let (spare, constants) =
            memory.words.split_at_mut_checked(spare_words(model.frames(), channels, model.stem_stride()))?;
        let eights = memory.eights;
        let all = 2 * model.blocks();
        let fit = |have: usize, need: usize| have.checked_div(need).unwrap_or(all);
        let places = fit(eights.len(), conv_eights(channels)).min(fit(constants.len(), conv_words(channels)));
        if places == 0 {
            return None;
        }
        let ahead = if places < all { places - 1 } else { all };
        let mut tiled = WinogradF2 { pairs, channels, ahead, plain: 0, eights, constants, spare };
        let convolutions = model.blocks.iter().flat_map(|block| &block.convs);
        for (number, conv) in convolutions.enumerate().take(ahead) {
            if tiled.pack(number, conv).is_none() {
                tiled.plain |= 1 << number;
            }
        }
        Some(tiled)
    }

    /// Packs convolution `number` into its place; `None` if tiles cannot compute it.
    fn pack(&mut self, number: usize, conv: &Conv<'_>) -> Option<()> {
        let (eights, constants) = (conv_eights(self.channels), conv_words(self.channels));
        let place = number.min(self.ahead);
        let weights = self.eights.get_mut(place * eights..)?.get_mut(..eights)?;
        packing::pack::<P>(conv, weights, self.constants.get_mut(place * constants..)?.get_mut(..constants)?)
    }

    /// Convolves; `None`, and nothing is done, if tiles cannot.
    fn convolve(
        &mut self,
        number: usize,
        layer: &Conv<'_>,
        input: &[i8],
        width: usize,
        border: &mut [i8],
        output: &mut [i8],
    ) -> Option<()> {
        if number >= self.ahead {
            self.pack(number, layer)?;
        } else if self.plain >> number & 1 == 1 {
            return None;
        }
        let (eights, words) = (conv_eights(self.channels), conv_words(self.channels));
        let place = number.min(self.ahead);
        let weights = self.eights.get(place * eights..)?.get(..eights)?;
        let constants = self.constants.get(place * words..)?.get(..words)?;
        let border = border.get_mut(..width * self.channels)?;
        border.fill(layer.quant.in_zp);
        let strip = self.spare.get_mut(..convolution::strip_words(width, self.channels))?;
        let job = convolution::Convolution { layer, weights, constants, input, width, border, strip, output };
        job.run(self.pairs).then_some(())
    }
}

/// Number of the convolution that is layer `at`: the second and third of every four behind the stem.
const fn convolution_number(at: usize) -> usize {
    2 * (at.wrapping_sub(1) / 4) + at.wrapping_sub(2) % 4
}

impl<P: DualMac> Kernels for WinogradF2<'_, P> {
    fn stem(
        &mut self,
        stem: &Conv<'_>,
        image: &[i8],
        size: (usize, usize),
        rows: &mut [i8],
        pooled: &mut [i8],
    ) {
        if !stem::pooled(stem, self.spare, image, size, pooled) {
            Portable.stem(stem, image, size, rows, pooled);
        }
    }

    fn affine(&mut self, _at: usize, layer: &BatchNormRelu<'_>, input: &[i8], output: &mut [i8]) {
        if !pointwise::affine(layer, self.spare, input, output) {
            layer.forward(input, output);
        }
    }

    fn conv(
        &mut self,
        at: usize,
        layer: &Conv<'_>,
        input: &[i8],
        size: (usize, usize),
        rows: &mut [i8],
        output: &mut [i8],
    ) {
        if self.convolve(convolution_number(at), layer, input, size.1, rows, output).is_none() {
            layer.forward(input, size.0, size.1, output);
        }
    }

    fn add(&mut self, _at: usize, layer: &Add, x: &mut [i8], branch: &[i8]) {
        if !pointwise::add(layer, self.spare, x, branch) {
            layer.forward(x, branch);
        }
    }
}

const _: () = assert!(2 * MAX_BLOCKS <= 64, "a bit for every convolution");
const _: () = assert!(
    POINTS == 16 && ROWS.is_multiple_of(4),
    "tiles are 4x4 points and rows come in pairs behind the pooling"
);

#[cfg(test)]
mod tests;
