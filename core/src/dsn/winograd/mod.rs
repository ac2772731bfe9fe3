//! The network's operators for processors without wide vectors, bit for bit the plain loops.
//!
//! Source: A. Lavin, S. Gray, Fast Algorithms for Convolutional Neural Networks, CVPR 2016.
//!
//! Convolutions take 30 products instead of 108 by F(4x3, 3x3) in exact integers, additions are tables, and the stem keeps no row
//! before its pooling. The first steps of an operator pack its numbers into the caller's memory, unless they are packed ahead. An
//! operator with numbers that this form does not cover (a shift outside -20 to -1, an accumulator beyond 2^29, of a
//! convolution 2^27; convolutions of other than 8, 16 or 32 channels) runs by the plain loops; training and TFLite's converter make
//! no such shifts or accumulators. Graphs also have kernels of 64 channels (weights are packed sixteen outputs at a time) and of
//! the three channels of a colour image.
//!
//! Cost: a step takes at most some 45 000 instructions on Cortex-M4F, 82 000 of a convolution of 64 channels, except of plain loops.

mod convolution;
mod packing;
mod pointwise;
mod stem;
mod transform;

use super::conv::Conv;
use super::established;
use super::kernels::{Kernels, Operator, Portable};
use super::model::{MAX_BLOCKS, Model};
use super::shape::Shape;
use crate::areas::{Area, range};
use crate::simd::NativeDualMac;
use crate::simd::dual_mac::{DualMac, I16x8};
use convolution::Convolution;
#[cfg(feature = "graph")]
pub(crate) use packing::covered as has_kernels;
use packing::{conv_vectors, conv_words, covered};
use stem::Stem;
pub(crate) use transform::{FACTOR_BITS, NINTH, outputs_of_column, outputs_of_row};

/// The caller's memory of a [`WinogradKernels`].
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
    /// Vectors of 16 bytes: a packed convolution is 6.7 times the bytes of its weights.
    pub vectors: usize,
    /// Words of 4 bytes.
    pub words: usize,
}

impl WinogradSizes {
    /// The sizes for a network of so many channels, and memory for `packed` convolutions: one does, the last, which other operators use
    /// too, and each further one keeps a convolution's weights from being packed at every recognition.
    pub const fn new(channels: usize, packed: usize) -> Self {
        WinogradSizes {
            vectors: packed.saturating_sub(1) * conv_vectors(channels, channels)
                + last_vectors(channels, channels),
            words: packed * conv_words(channels, channels),
        }
    }

    /// The sizes for one convolution of an operator list: its inputs and outputs.
    #[cfg(feature = "graph")]
    pub(crate) const fn of_convolution(inputs: usize, outputs: usize) -> Self {
        WinogradSizes { vectors: last_vectors(inputs, outputs), words: conv_words(inputs, outputs) }
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
        WinogradSizes::new(self.channels, 1)
    }
}

/// Vectors of the last place: a convolution's weights, the tables of an addition, or the stem's weights.
const fn last_vectors(inputs: usize, outputs: usize) -> usize {
    let words = size_of::<I16x8>() / size_of::<i32>();
    let (convolution, stem) = (conv_vectors(inputs, outputs), (outputs * stem::WORDS).div_ceil(words));
    let most = if convolution > stem { convolution } else { stem };
    if most > pointwise::MOST_WORDS / words { most } else { pointwise::MOST_WORDS / words }
}

/// Bytes of scratch that an operator of so many inputs and outputs takes.
pub const fn scratch_bytes(inputs: usize, outputs: usize) -> usize {
    if covered(inputs, outputs) { convolution::scratch_bytes(inputs) } else { 0 }
}

/// Kernels by F(4x3, 3x3), over the dual multiply-accumulates `P`.
#[derive(Debug)]
pub struct WinogradKernels<'b, P = NativeDualMac> {
    mac: P,
    /// Convolutions that are prepacked: all other operators share the place behind theirs.
    prepacked: usize,
    /// Vectors of those.
    ahead: usize,
    /// Of those, which run by the plain loops, by bit.
    uncovered: u64,
    /// Step of the operator that ran last, or runs, from which on the plain loops compute it, if they do.
    plain: Option<usize>,
    vectors: &'b mut [I16x8],
    /// Constants of every place.
    words: &'b mut [i32],
}

impl<'b> WinogradKernels<'b> {
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

impl<'b, P: DualMac> WinogradKernels<'b, P> {
    /// [`WinogradKernels::shared`] by the arithmetic `mac`.
    pub fn shared_with_mac(mac: P, WinogradMemory { vectors, words }: WinogradMemory<'b>) -> Self {
        WinogradKernels { mac, prepacked: 0, ahead: 0, uncovered: 0, plain: None, vectors, words }
    }

    /// [`WinogradKernels::new`] by the arithmetic `mac`.
    pub fn with_mac(model: &Model<'_>, mac: P, memory: WinogradMemory<'b>) -> Option<Self> {
        let channels = model.channels();
        let vectors = memory.vectors.len().checked_sub(last_vectors(channels, channels))?;
        let words = memory.words.len().checked_sub(conv_words(channels, channels))?;
        let fit = |have: usize, need: usize| have.checked_div(need).unwrap_or(0);
        let prepacked = fit(vectors, conv_vectors(channels, channels))
            .min(fit(words, conv_words(channels, channels)))
            .min(2 * model.blocks());
        let ahead = prepacked * conv_vectors(channels, channels);
        let mut kernels = WinogradKernels { prepacked, ahead, ..Self::shared_with_mac(mac, memory) };
        for number in 0..prepacked {
            let conv = model.block(number / 2)?.convs[number % 2];
            if (0..packing::steps(channels, channels))
                .any(|step| kernels.pack(number, &conv, 0, step).is_none())
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

    /// Packed weights and constants of convolution `number`.
    fn packed_memory(&mut self, number: usize, conv: &Conv<'_>) -> Option<(&mut [I16x8], &mut [i32])> {
        let slot = number.min(self.prepacked);
        let (inputs, outputs) = (conv.inputs, conv.quant.channels);
        let (vectors, words) = (conv_vectors(inputs, outputs), conv_words(inputs, outputs));
        let weights = self.vectors.get_mut(slot * vectors..)?.get_mut(..vectors)?;
        Some((weights, self.words.get_mut(slot * words..)?.get_mut(..words)?))
    }

    /// What an operator that is no convolution leaves to its next step.
    fn tables(&mut self) -> &mut [i32] {
        self.vectors.get_mut(self.ahead..).unwrap_or_default().as_flattened_mut()
    }

    /// Does a step of packing output channels of a convolution from `first` on; `None` if these kernels cannot compute it.
    fn pack(&mut self, number: usize, conv: &Conv<'_>, first: usize, step: usize) -> Option<()> {
        let (weights, constants) = self.packed_memory(number, conv)?;
        packing::pack::<P>(conv, first, step, weights, constants)
    }
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
#[inline(never)]
pub(crate) fn clamp_all(values: &mut [i8], (low, high): (i8, i8)) {
    if (low, high) != (i8::MIN, i8::MAX) {
        values.iter_mut().for_each(|value| *value = (*value).max(low).min(high));
    }
}

impl<P: DualMac> Kernels for WinogradKernels<'_, P> {
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
                let steps =
                    (packing + convolution::steps::<P>(layer.inputs, layer.quant.channels, size)).max(1);
                let first = step / steps * count;
                (first, step % steps, first + count >= layer.quant.channels)
            }
            _ => (0, step, true),
        };
        if step < packing {
            let done = match operator {
                Operator::Stem { layer, .. } => stem::pack(layer, self.tables()),
                Operator::BatchNormRelu { layer, .. } => pointwise::pack_batch_norm(layer, self.tables()),
                Operator::Conv { layer, .. } => self.pack(number, layer, first, step),
                Operator::Add { layer, .. } => pointwise::pack_add(layer, self.tables()),
                Operator::Average { .. } => None,
            };
            self.plain = done.is_none().then_some(next);
            return false;
        }
        let step = step - packing;
        match operator {
            Operator::Stem { layer, image, size, output, .. } => {
                Stem { layer, words: self.tables(), image, size, output }.run(step)
            }
            Operator::BatchNormRelu { layer, input, output } => {
                pointwise::batch_norm(layer, self.tables(), input, output, step)
            }
            Operator::Conv { layer, input, size, scratch, output } => {
                let mac = self.mac;
                let (weights, constants) = established(self.packed_memory(number, layer));
                Convolution { layer, first, weights, constants, input, size, scratch, output }.run(mac, step)
                    && all
            }
            Operator::Add { layer, x, branch } => pointwise::add(layer, self.tables(), x, branch, step),
            average => Portable.run(index, average, step),
        }
    }
}

const _: () = assert!(2 * MAX_BLOCKS <= 64, "a bit for every convolution");
