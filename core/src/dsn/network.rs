//! The network layer by layer in three activation buffers of the caller.
//!
//! Image to logits: stem and pooling row by row, residual blocks, average, head.

use super::conv::same;
use super::head::{MAX_CLASSES, arg_max};
use super::kernels::{Kernels, Portable};
use super::model::Model;
use super::shape::Shape;
use crate::dims::ROWS;
use crate::dsn::conv::MAX_CHANNELS;
use crate::probe::Probe;
use heapless::Vec;

/// Bytes of scratch the network needs: three activation maps and two rows of the stem.
pub const fn scratch_bytes(frames: usize, channels: usize, stem_stride: usize) -> usize {
    let (height, width) = (same(ROWS, stem_stride), same(frames, stem_stride));
    3 * (height / 2) * (width / 2) * channels + 2 * width * channels
}

impl Shape {
    /// Bytes of scratch its network needs.
    pub const fn scratch_bytes(&self) -> usize {
        scratch_bytes(self.frames, self.channels, self.stem_stride)
    }
}

/// The network's answer.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Answer {
    /// Class with the largest logit, the first of equals.
    pub class: u8,
    /// Its probability by softmax, 0..=1.
    pub confidence: f32,
    /// All logits, quantised, `[classes]`.
    pub logits: Vec<i8, MAX_CLASSES>,
}

/// A model with the scratch memory it runs in and the kernels it runs by.
#[derive(Debug)]
pub struct Network<'m, 'b, K = Portable> {
    model: Model<'m>,
    scratch: &'b mut [i8],
    kernels: K,
}

impl<'m, 'b> Network<'m, 'b> {
    /// Joins a model and its scratch memory; `None` if that has fewer than [`scratch_bytes`].
    pub fn new(model: Model<'m>, scratch: &'b mut [i8]) -> Option<Self> {
        Self::with_kernels(model, scratch, Portable)
    }
}

impl<'m, 'b, K: Kernels> Network<'m, 'b, K> {
    /// [`Network::new`] with a processor's own kernels, made for this model.
    pub fn with_kernels(model: Model<'m>, scratch: &'b mut [i8], kernels: K) -> Option<Self> {
        let need = scratch_bytes(model.frames(), model.channels(), model.stem_stride());
        (scratch.len() >= need).then_some(Network { model, scratch, kernels })
    }

    /// The model.
    pub fn model(&self) -> &Model<'m> {
        &self.model
    }

    /// Classifies an image, `[64, frames]`.
    pub fn infer(&mut self, image: &[i8], probe: &mut impl Probe) -> Answer {
        let (model, kernels) = (&self.model, &mut self.kernels);
        let (channels, stride) = (model.channels(), model.stem_stride());
        let (stem_height, stem_width) = (same(ROWS, stride), same(model.frames(), stride));
        let (height, width) = (stem_height / 2, stem_width / 2);
        let map = height * width * channels;
        let (rows, rest) = self.scratch.split_at_mut_checked(2 * stem_width * channels).unwrap_or_default();
        let (x, rest) = rest.split_at_mut_checked(map).unwrap_or_default();
        let (a, rest) = rest.split_at_mut_checked(map).unwrap_or_default();
        let (b, _) = rest.split_at_mut_checked(map).unwrap_or_default();

        kernels.stem(&model.stem, image, (ROWS, model.frames()), rows, x);
        probe.layer(0, x);

        let mut layer = 0;
        for block in &model.blocks {
            let [first, second] = &block.convs;
            kernels.affine(layer + 1, &block.batch_norm, x, a);
            probe.layer(layer + 1, a);
            kernels.conv(layer + 2, first, a, (height, width), rows, b);
            probe.layer(layer + 2, b);
            kernels.conv(layer + 3, second, b, (height, width), rows, a);
            probe.layer(layer + 3, a);
            kernels.add(layer + 4, &block.add, x, a);
            probe.layer(layer + 4, x);
            layer += 4;
        }

        let mut features = [0; MAX_CHANNELS];
        let features = features.get_mut(..channels).unwrap_or_default();
        kernels.average(x, channels, features);
        probe.layer(layer + 1, features);
        let mut logits = Vec::new();
        let _ = logits.resize(model.classes(), 0); // at most MAX_CLASSES: the parser has checked
        model.head.forward(features, &mut logits);
        probe.logits(&logits);
        let class = arg_max(&logits);
        probe.class(class as u8);
        let confidence = model.head.confidence(&logits, class);
        probe.confidence(confidence);
        Answer { class: class as u8, confidence, logits }
    }
}
