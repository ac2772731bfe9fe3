//! The int8 network on this machine's vector instructions, with the bits of the core's plain loops.
//!
//! [`VectorKernels`] computes one operator a step; [`Classifier`] is the whole network with its memory.

mod direct;
mod layer;
mod linear_add;
mod packing;
mod pointwise;
mod simd;
mod stem;
mod winograd_f4;

use layer::{Convolution, OutputGroup};
use linear_add::LinearAdd;
use packing::{ChannelPhase, PackedAdd};
use pointwise::{Average, PointwiseAdd, PointwiseBatchNorm, RequantizedAdd};
use sdp3_core::dsn::conv::Conv;
use sdp3_core::dsn::{Classification, Kernels, Model, Operator, Portable, infer};
use sdp3_core::probe::Probe;
pub use simd::Isa;
use simd::{Backend, LANES};
use stem::Stem;

/// The packed weights of an operator.
#[derive(Debug)]
enum Packed {
    Conv(Vec<OutputGroup>),
    BatchNormRelu(Vec<ChannelPhase>),
    Add(Box<LinearAdd>),
    /// Without a linear form.
    RequantizedAdd(Box<PackedAdd>),
}

/// The kernels of one instruction set, with a model's weights packed for them.
///
/// Operators that vectors cannot compute run by [`Portable`]: those with a right shift outside 1 to 20, or with sums that
/// could leave +-2^30. Training and TFLite's converter make none.
#[derive(Debug)]
pub struct VectorKernels {
    backend: Option<Backend>,
    /// By the operator's index; `None` for [`Portable`].
    operators: Vec<Option<Packed>>,
    /// The padded input of a convolution.
    words: Vec<i32>,
    /// The padded image, as bytes of words: the stem reads words that begin in the middle of one.
    bytes: Vec<[u8; 4]>,
}

impl VectorKernels {
    /// Packs a model's weights for an instruction set; `None` if the processor does not have it ([`Isa::available`]).
    pub fn new(model: &Model<'_>, isa: Isa) -> Option<Self> {
        let backend = Backend::new(isa);
        let mut operators = Vec::new();
        // a graph runs by the core's own steps
        if let Some(backend) = backend.filter(|_| model.graph().is_none()) {
            let conv = |conv: &Conv<'_>| packing::convolution(conv, backend.word_inputs()).map(Packed::Conv);
            operators.push(conv(&model.stem()));
            for block in (0..model.blocks()).map_while(|index| model.block(index)) {
                operators.push(packing::batch_norm(&block.batch_norm).map(Packed::BatchNormRelu));
                operators.extend(block.convs.iter().map(conv));
                let linear = linear_add::find(&block.add).map(|form| Packed::Add(Box::new(form)));
                let requantized =
                    || packing::add(&block.add).map(|add| Packed::RequantizedAdd(Box::new(add)));
                operators.push(linear.or_else(requantized));
            }
        }
        isa.available().then_some(VectorKernels { backend, operators, words: Vec::new(), bytes: Vec::new() })
    }

    /// [`VectorKernels::new`] for this processor's fastest instruction set.
    pub fn fastest(model: &Model<'_>) -> Self {
        Self::new(model, Isa::best()).expect("the best instruction set is available")
    }
}

impl Kernels for VectorKernels {
    /// One step does the whole operator.
    ///
    /// # Panics
    ///
    /// If the operator is not the one of the model at this index.
    fn run(&mut self, index: usize, operator: Operator<'_>, step: usize) -> bool {
        let Some(backend) = self.backend else { return Portable.run(index, operator, step) };
        let VectorKernels { operators, words, bytes, .. } = self;
        match (operator, operators.get(index).and_then(Option::as_ref)) {
            (Operator::Stem { layer, image, size, output, .. }, Some(Packed::Conv(groups))) => {
                backend.dispatch(Stem { layer, groups, words, bytes, image, size, output });
            }
            (Operator::BatchNormRelu { layer, input, output }, Some(Packed::BatchNormRelu(phases))) => {
                backend.dispatch(PointwiseBatchNorm { layer, phases, input, output });
            }
            (Operator::Conv { layer, input, size, output, .. }, Some(Packed::Conv(groups))) => {
                backend.dispatch(Convolution { layer, groups, words, input, size, output });
            }
            (Operator::Add { layer, x, branch }, Some(Packed::Add(form))) => {
                backend.dispatch(PointwiseAdd { layer, form, x, branch });
            }
            (Operator::Add { layer, x, branch }, Some(Packed::RequantizedAdd(packed))) => {
                backend.dispatch(RequantizedAdd { layer, packed, x, branch });
            }
            (Operator::Average { input, channels, output }, _) if LANES.is_multiple_of(channels) => {
                backend.dispatch(Average { input, channels, output });
            }
            (operator, _) => return Portable.run(index, operator, step),
        }
        true
    }
}

/// A model with its fastest kernels and all memory that it needs: images in, classes out.
#[derive(Debug)]
pub struct Classifier<'m> {
    model: Model<'m>,
    kernels: VectorKernels,
    scratch: Vec<i8>,
}

impl<'m> Classifier<'m> {
    /// Packs a model's weights.
    pub fn new(model: Model<'m>) -> Self {
        let scratch = vec![0; model.shape().scratch_bytes()];
        Classifier { kernels: VectorKernels::fastest(&model), model, scratch }
    }

    /// Classifies an image, `[64, frames]`.
    pub fn classify(&mut self, image: &[i8], probe: &mut impl Probe) -> Classification {
        infer(&self.model, image, &mut self.scratch, &mut self.kernels, probe)
    }
}

#[cfg(test)]
mod tests;
