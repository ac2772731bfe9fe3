//! The network's layers on a processor's vectors, bit for bit the plain loops.
//!
//! Weights are packed once into the caller's memory. A layer whose numbers no vector form covers (a shift outside
//! -20..=-1, an accumulator beyond 2^30) runs by the plain loops; training and TFLite's converter make none.

mod convolution;
mod direct;
mod layer;
mod packing;
mod pointwise;
mod stem;
mod winograd;

use super::add::Add;
use super::batch_norm::BatchNormRelu;
use super::conv::{Conv, same};
use super::kernels::{Kernels, Portable};
use super::model::{MAX_BLOCKS, Model};
use crate::dims::ROWS;
use crate::simd::{Isa, Line, Unit};
use heapless::Vec;
use layer::Convolution;
use packing::Packer;
use pointwise::{Average, PointwiseAdd, PointwiseAffine};
use stem::Stem;

/// Layers with packed numbers: the stem and four a block.
const LAYERS: usize = 1 + 4 * MAX_BLOCKS;

/// The caller's memory of a [`Vector`].
#[derive(Debug)]
pub struct VectorMemory<'b> {
    /// Packed weights, [`Vector::lines`] of them.
    pub lines: &'b mut [Line],
    /// One padded activation map, [`Vector::words`] of them.
    pub words: &'b mut [i32],
}

/// A model's packed weights with the instruction set they are packed for.
#[derive(Debug)]
pub struct Vector<'b> {
    unit: Option<Unit>,
    isa: Isa,
    lines: &'b [Line],
    words: &'b mut [i32],
    /// Where the layer's lines begin; `None` for the plain loops.
    layers: Vec<Option<usize>, LAYERS>,
}

impl<'b> Vector<'b> {
    /// Lines of 64 bytes that a model's weights take.
    pub fn lines(model: &Model<'_>) -> usize {
        let channels = model.channels();
        let groups = channels.div_ceil(16);
        let stem = groups * (6 + 3 * 2);
        let points = if packing::transforms(channels) { winograd::POINTS } else { 9 };
        let conv = groups * (6 + points * channels / 2);
        stem + model.blocks() * (2 * conv + packing::phases(channels) * 7 + packing::ADD_LINES)
    }

    /// Words of the largest padded activation map.
    pub fn words(model: &Model<'_>) -> usize {
        let stride = model.stem_stride();
        let (height, width) = (same(ROWS, stride), same(model.frames(), stride));
        let stem = ((height.max(1) - 1) * stride + 3) * width.next_multiple_of(8) * 2;
        let rows = (height / 2).next_multiple_of(winograd::TILE) + 2 + winograd::ROWS;
        let map = rows * ((width / 2).next_multiple_of(16) + 2) * model.channels() / 2;
        stem.max(map)
    }

    /// Packs a model's weights for an instruction set.
    ///
    /// `None` if the processor does not have it ([`Isa::available`]) or the memory is too small.
    pub fn new(model: &Model<'_>, isa: Isa, memory: VectorMemory<'b>) -> Option<Self> {
        let VectorMemory { lines, words } = memory;
        if !isa.available() || lines.len() < Self::lines(model) || words.len() < Self::words(model) {
            return None;
        }
        let unit = Unit::new(isa);
        let mut layers = Vec::new();
        if let Some(unit) = unit {
            let mut packer = Packer::new(lines, unit.inputs());
            let _ = layers.push(packer.convolution(&model.stem));
            for block in &model.blocks {
                let [first, second] = &block.conv;
                let _ = layers.push(packer.affine(&block.affine));
                let _ = layers.push(packer.convolution(first));
                let _ = layers.push(packer.convolution(second));
                let _ = layers.push(packer.add(&block.add));
            }
        }
        Some(Vector { unit, isa, lines, words, layers })
    }

    /// The instruction set.
    pub fn isa(&self) -> Isa {
        self.isa
    }

    /// Layers that run by the plain loops although the instruction set has vectors.
    pub fn plain_layers(&self) -> usize {
        self.layers.iter().filter(|at| at.is_none()).count()
    }

    /// The vectors and a layer's lines.
    fn packed(&self, at: usize) -> Option<(Unit, &'b [Line])> {
        let lines: &'b [Line] = self.lines;
        let start = self.layers.get(at).copied().flatten()?;
        Some((self.unit?, lines.get(start..)?))
    }
}

impl Kernels for Vector<'_> {
    fn stem(
        &mut self,
        stem: &Conv<'_>,
        image: &[i8],
        size: (usize, usize),
        rows: &mut [i8],
        pooled: &mut [i8],
    ) {
        let Some((unit, lines)) = self.packed(0) else {
            return Portable.stem(stem, image, size, rows, pooled);
        };
        unit.run(Stem { layer: stem, lines, words: self.words, image, size, pooled });
    }

    fn affine(&mut self, at: usize, layer: &BatchNormRelu<'_>, input: &[i8], output: &mut [i8]) {
        let Some((unit, lines)) = self.packed(at) else { return layer.forward(input, output) };
        unit.run(PointwiseAffine { layer, lines, input, output });
    }

    fn conv(
        &mut self,
        at: usize,
        layer: &Conv<'_>,
        input: &[i8],
        size: (usize, usize),
        _rows: &mut [i8],
        output: &mut [i8],
    ) {
        let Some((unit, lines)) = self.packed(at) else {
            return layer.forward(input, size.0, size.1, output);
        };
        unit.run(Convolution { layer, lines, words: self.words, input, size, output });
    }

    fn add(&mut self, at: usize, layer: &Add, x: &mut [i8], branch: &[i8]) {
        let Some((unit, lines)) = self.packed(at) else { return layer.forward(x, branch) };
        unit.run(PointwiseAdd { layer, lines, x, branch });
    }

    fn average(&mut self, input: &[i8], channels: usize, output: &mut [i8]) {
        match self.unit {
            Some(unit) if packing::phases(channels) == 1 => {
                unit.run(Average { input, channels, output });
            }
            _ => Portable.average(input, channels, output),
        }
    }
}

#[cfg(test)]
mod tests;
