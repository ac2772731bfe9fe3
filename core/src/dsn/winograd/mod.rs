//! The network's operators for processors without wide vectors, bit for bit the plain loops.
//!
//! Source: A. Lavin, S. Gray, Fast Algorithms for Convolutional Neural Networks, CVPR 2016.
//!
//! Convolutions take 16 products instead of 36 by F(2x2, 3x3) in exact integers, additions are tables, and the stem keeps no row
//! before its pooling. The first steps of an operator pack its numbers into the caller's memory, unless they are packed ahead. An
//! operator with numbers that this form does not cover (a shift outside -20 to -1, an accumulator beyond 2^29; convolutions of other
//! than 8, 16 or 32 channels) runs by the plain loops; training and TFLite's converter make no such shifts or accumulators. Graphs also
//! have kernels of 64 channels (weights are packed sixteen outputs at a time) and of the three channels of a colour image.
//!
//! Cost: a step takes at most some 45 000 instructions on Cortex-M4F, except of plain loops.

mod convolution;
mod packing;
mod pointwise;
mod stem;
mod transform;

use super::conv::{Conv, same};
use super::established;
use super::kernels::{Kernels, Operator, Portable};
use super::model::{MAX_BLOCKS, Model};
use super::shape::Shape;
use crate::areas::{Area, range};
use crate::dims::ROWS;
use crate::simd::NativeDualMac;
use crate::simd::dual_mac::{DualMac, I16x8, POINTS};
use convolution::Convolution;
#[cfg(feature = "graph")]
pub(crate) use packing::covered;
use packing::{conv_vectors, conv_words, tile_vectors};
use stem::Stem;

/// The caller's memory of a [`WinogradF2`].
#[derive(Debug, Default)]
pub struct WinogradMemory<'b> {
    /// Transformed weights, [`WinogradSizes::vectors`] of them.
    pub vectors: &'b mut [I16x8],
    /// Biases and scales, and what stays between the steps of an operator: [`WinogradSizes::words`].
    pub words: &'b mut [i32],
}

/// How much of each a network takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct WinogradSizes {
    /// Vectors of 16 bytes: a packed convolution is 3.6 times the bytes of its weights.
    pub vectors: usize,
    /// Words of 4 bytes.
    pub words: usize,
}

impl WinogradSizes {
    /// The sizes for an image of `frames` columns, a network's shape, and memory for `packed` convolutions: one does, and
    /// each further one keeps a convolution's weights from being packed at every recognition.
    pub const fn new(frames: usize, channels: usize, stem_stride: usize, packed: usize) -> Self {
        WinogradSizes {
            vectors: packed * conv_vectors(channels, channels) + tile_vectors(channels, channels),
            words: packed * conv_words(channels, channels) + spare_words(frames, channels, stem_stride),
        }
    }

    /// The sizes for one convolution of an operator list: the columns of its input, its inputs and outputs.
    #[cfg(feature = "graph")]
    pub(crate) const fn of_convolution(width: usize, inputs: usize, outputs: usize) -> Self {
        WinogradSizes {
            vectors: conv_vectors(inputs, outputs) + tile_vectors(inputs, outputs),
            words: conv_words(inputs, outputs) + convolution::words(width, inputs),
        }
    }

    /// The least for a model.
    pub fn of(model: &Model<'_>) -> Self {
        model.shape().winograd_sizes()
    }

    /// What serves both.
    pub const fn max(self, other: Self) -> Self {
        WinogradSizes {
            vectors: if self.vectors > other.vectors { self.vectors } else { other.vectors },
            words: if self.words > other.words { self.words } else { other.words },
        }
    }

    /// All of it in bytes.
    pub const fn total(&self) -> usize {
        size_of::<I16x8>() * self.vectors + size_of::<i32>() * self.words
    }
}

impl Shape {
    /// Memory of its kernels, with nothing packed ahead.
    pub const fn winograd_sizes(&self) -> WinogradSizes {
        WinogradSizes::new(self.frames, self.channels, self.stem_stride, 1)
    }
}

/// Words that one operator leaves to the next: a strip of tiles, the tables of an addition, or the stem's weights.
const fn spare_words(frames: usize, channels: usize, stem_stride: usize) -> usize {
    let strip = convolution::words(same(frames, stem_stride) / 2, channels);
    let stem = channels * stem::WORDS;
    let most = if strip > stem { strip } else { stem };
    if most > pointwise::MOST_WORDS { most } else { pointwise::MOST_WORDS }
}

/// Kernels by F(2x2, 3x3), over the dual multiply-accumulates `P`.
#[derive(Debug)]
pub struct WinogradF2<'b, P = NativeDualMac> {
    mac: P,
    /// Convolutions that the memory holds packed.
    packed_slots: usize,
    /// Those that are prepacked: the others share the last slot.
    prepacked: usize,
    /// Of those, which run by the plain loops, by bit.
    uncovered: u64,
    /// Step of the operator that ran last, or runs, from which on the plain loops compute it, if they do.
    plain: Option<usize>,
    vectors: &'b mut [I16x8],
    /// What stays between the steps of an operator; at the end the constants of every slot.
    words: &'b mut [i32],
}

impl<'b> WinogradF2<'b> {
    /// The fastest arithmetic of the target, for one model: as many convolutions are packed ahead as the memory holds;
    /// `None` if it is smaller than [`WinogradSizes::of`] the model.
    pub fn new(model: &Model<'_>, memory: WinogradMemory<'b>) -> Option<Self> {
        Self::with_mac(model, NativeDualMac::default(), memory)
    }

    /// The fastest arithmetic of the target, for every model if the memory holds its [`WinogradSizes`]; nothing is packed
    /// ahead. An operator that the memory does not hold runs by the plain loops.
    pub fn shared(memory: WinogradMemory<'b>) -> Self {
        Self::shared_with_mac(NativeDualMac::default(), memory)
    }
}

impl<'b, P: DualMac> WinogradF2<'b, P> {
    /// [`WinogradF2::shared`] by the arithmetic `mac`.
    pub fn shared_with_mac(mac: P, WinogradMemory { vectors, words }: WinogradMemory<'b>) -> Self {
        WinogradF2 { mac, packed_slots: 1, prepacked: 0, uncovered: 0, plain: None, vectors, words }
    }

    /// [`WinogradF2::new`] by the arithmetic `mac`.
    pub fn with_mac(model: &Model<'_>, mac: P, memory: WinogradMemory<'b>) -> Option<Self> {
        let channels = model.channels();
        let spare = spare_words(model.frames(), channels, model.stem_stride());
        let constants = memory.words.len().checked_sub(spare)?;
        let weights = memory.vectors.len().checked_sub(tile_vectors(channels, channels))?;
        let all = 2 * model.blocks();
        let fit = |have: usize, need: usize| have.checked_div(need).unwrap_or(all).min(all);
        let packed_slots = fit(weights, conv_vectors(channels, channels))
            .min(fit(constants, conv_words(channels, channels)));
        let prepacked = if packed_slots < all { packed_slots.checked_sub(1)? } else { all };
        let width = same(model.frames(), model.stem_stride()) / 2;
        let mut kernels = WinogradF2 { packed_slots, prepacked, ..Self::shared_with_mac(mac, memory) };
        for number in 0..prepacked {
            let conv = model.block(number / 2)?.convs[number % 2];
            if (0..packing::steps(channels, channels))
                .any(|step| kernels.pack(number, &conv, width, 0, step).is_none())
            {
                kernels.uncovered |= 1 << number;
            }
        }
        Some(kernels)
    }

    /// Where its data lie.
    pub(crate) fn area(&self, area: Area) -> core::ops::Range<*const u8> {
        if area == Area::PackedWeights { range(self.vectors) } else { range(self.words) }
    }

    /// Convolutions that are packed ahead, not at every recognition.
    pub fn prepacked(&self) -> usize {
        self.prepacked
    }

    /// Whether the operator that ran last, or runs, is left to the plain loops.
    pub fn is_portable(&self) -> bool {
        self.plain.is_some()
    }

    /// Packed weights and constants of convolution `number`, and the words of its strip.
    fn packed_memory(&mut self, number: usize, conv: &Conv<'_>, width: usize) -> Option<PackedMemory<'_>> {
        let slot = number.min(self.prepacked);
        let (inputs, outputs) = (conv.inputs, conv.quant.channels);
        let (vectors, constant_words) = (conv_vectors(inputs, outputs), conv_words(inputs, outputs));
        let spare = self.words.len().checked_sub(self.packed_slots * constant_words)?;
        let (spare, constants) = self.words.split_at_mut_checked(spare)?;
        let (tile, weights) = self.vectors.split_at_mut_checked(tile_vectors(inputs, outputs))?;
        Some(PackedMemory {
            tile,
            weights: weights.get_mut(slot * vectors..)?.get_mut(..vectors)?,
            constants: constants.get_mut(slot * constant_words..)?.get_mut(..constant_words)?,
            words: spare.get_mut(..convolution::words(width, inputs))?,
        })
    }

    /// Does a step of packing output channels of a convolution from `first` on; `None` if these kernels cannot compute it.
    fn pack(
        &mut self,
        number: usize,
        conv: &Conv<'_>,
        width: usize,
        first: usize,
        step: usize,
    ) -> Option<()> {
        let PackedMemory { weights, constants, .. } = self.packed_memory(number, conv, width)?;
        packing::pack::<P>(conv, first, step, weights, constants)
    }
}

/// Memory of a convolution.
#[derive(Default)]
struct PackedMemory<'a> {
    tile: &'a mut [I16x8],
    weights: &'a mut [I16x8],
    constants: &'a mut [i32],
    words: &'a mut [i32],
}

/// Number of the convolution that is operator `index`: the second and third of every four behind the stem.
const fn convolution_number(index: usize) -> usize {
    2 * (index.wrapping_sub(1) / 4) + index.wrapping_sub(2) % 4
}

/// The first `count` items of so many words; `None` if there are fewer.
fn packed_mut<const WORDS: usize>(words: &mut [i32], count: usize) -> Option<&mut [[i32; WORDS]]> {
    words.as_chunks_mut().0.get_mut(..count)
}

/// The same, of words that were packed.
fn packed<const WORDS: usize>(words: &[i32], count: usize) -> &[[i32; WORDS]] {
    established(words.as_chunks().0.get(..count))
}

/// Clamps outputs that are saturated to int8 to a layer's range.
pub(crate) fn clamp_all(values: &mut [i8], (low, high): (i8, i8)) {
    if (low, high) != (i8::MIN, i8::MAX) {
        values.iter_mut().for_each(|value| *value = (*value).max(low).min(high));
    }
}

impl<P: DualMac> Kernels for WinogradF2<'_, P> {
    fn run(&mut self, index: usize, operator: Operator<'_>, step: usize) -> bool {
        let number = convolution_number(index);
        let (packing, plain) = match operator {
            Operator::Average { .. } => (0, true),
            Operator::Conv { .. } if number < self.prepacked => (0, self.uncovered >> number & 1 == 1),
            Operator::Conv { layer, .. } => (packing::steps(layer.inputs, layer.quant.channels), false),
            _ => (1, false),
        };
        if step == 0 {
            self.plain = plain.then_some(0);
        }
        if let Some(from) = self.plain {
            return Portable.run(index, operator, step - from);
        }
        // a convolution with more outputs than are packed at a time begins again for the next
        let next = step + 1;
        let (first, step, all) = match operator {
            Operator::Conv { layer, size, .. } => {
                let count = packing::packed_outputs(layer.quant.channels);
                let steps = (packing + convolution::steps::<P>(layer.quant.channels, size)).max(1);
                let first = step / steps * count;
                (first, step % steps, first + count >= layer.quant.channels)
            }
            _ => (0, step, true),
        };
        if step < packing {
            let done = match operator {
                Operator::Stem { layer, .. } => stem::pack(layer, self.words),
                Operator::BatchNormRelu { layer, .. } => pointwise::pack_batch_norm(layer, self.words),
                Operator::Conv { layer, size, .. } => self.pack(number, layer, size.1, first, step),
                Operator::Add { layer, .. } => pointwise::pack_add(layer, self.words),
                Operator::Average { .. } => None,
            };
            self.plain = done.is_none().then_some(next);
            return false;
        }
        let step = step - packing;
        match operator {
            Operator::Stem { layer, image, size, output, .. } => {
                Stem { layer, words: self.words, image, size, output }.run(step)
            }
            Operator::BatchNormRelu { layer, input, output } => {
                pointwise::batch_norm(layer, self.words, input, output, step)
            }
            Operator::Conv { layer, input, size, row, output } => {
                let (mac, width) = (self.mac, size.1);
                let border = established(row.get_mut(..width * layer.inputs));
                let PackedMemory { tile, weights, constants, words } =
                    established(self.packed_memory(number, layer, width));
                Convolution { layer, first, weights, constants, input, width, border, words, tile, output }
                    .run(mac, step)
                    && all
            }
            Operator::Add { layer, x, branch } => pointwise::add(layer, self.words, x, branch, step),
            average => Portable.run(index, average, step),
        }
    }
}

const _: () = assert!(2 * MAX_BLOCKS <= 64, "a bit for every convolution");
const _: () = assert!(
    POINTS == 16 && ROWS.is_multiple_of(4),
    "tiles are 4x4 points and rows come in pairs behind the pooling"
);
