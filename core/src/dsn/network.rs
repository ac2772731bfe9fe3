//! The network operator by operator, in bounded steps, in three activation maps of the caller.
//!
//! Image to logits: stem with pooling, residual blocks, average, head.

use super::conv::same;
use super::established;
use super::head::{MAX_CLASSES, arg_max, confidence};
use super::kernels::{Kernels, Operator};
use super::model::Model;
use super::shape::Shape;
use super::winograd;
use crate::dims::ROWS;
#[cfg(feature = "graph")]
use crate::graph::{Graph, Progress};
use crate::probe::Probe;
use heapless::Vec;

/// Bytes of scratch the network needs: a convolution's and three activation maps; the image lies in the last two at first.
pub const fn scratch_bytes(frames: usize, channels: usize, stem_stride: usize) -> usize {
    let (height, width) = (same(ROWS, stem_stride) / 2, same(frames, stem_stride) / 2);
    let (map, image) = (height * width * channels, ROWS * frames);
    operator_bytes(channels) + map + if 2 * map > image { 2 * map } else { image }
}

/// Bytes of scratch of an operator: a convolution's, at least the outputs of the average.
const fn operator_bytes(channels: usize) -> usize {
    let bytes = winograd::scratch_bytes(channels, channels);
    if bytes > channels { bytes } else { channels }
}

impl Shape {
    /// Bytes of scratch its network needs.
    pub const fn scratch_bytes(&self) -> usize {
        if self.arena > 0 {
            return self.arena;
        }
        scratch_bytes(self.frames, self.channels, self.stem_stride)
    }
}

/// The network's output before the softmax, quantised, `[classes]`.
pub(crate) type Logits = Vec<i8, MAX_CLASSES>;

/// What a recording was recognised as.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Classification {
    /// The most probable class, the first of equals.
    pub class: u8,
    /// Its probability by softmax, 0 to 1.
    pub confidence: f32,
    /// Number of the early exit that gave it, from 0.
    pub exit: u8,
    /// Whether no more slots are needed: it is sure enough, or this is the last exit.
    pub stop: bool,
    /// Logits of that exit's network.
    pub logits: Logits,
}

impl Classification {
    /// The network's own: largest logit and softmax, as exit 0. `logits` are `model`'s.
    pub fn new(model: &Model<'_>, logits: Logits, probe: &mut impl Probe) -> Self {
        let class = arg_max(&logits);
        probe.class(class as u8);
        let confidence = confidence(&logits, class, model.logit_scale());
        probe.confidence(confidence);
        Classification { class: class as u8, confidence, exit: 0, stop: true, logits }
    }
}

/// How far the network has come with an image: which operator, and which of its steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Network {
    operator: u32,
    step: u32,
    #[cfg(feature = "graph")]
    graph: Progress,
}

impl Network {
    /// At the beginning.
    pub const fn new() -> Self {
        Network {
            operator: 0,
            step: 0,
            #[cfg(feature = "graph")]
            graph: Progress::new(),
        }
    }

    /// Gives up an unfinished image.
    pub fn reset(&mut self) {
        *self = Self::new();
    }

    /// Does one bounded step with the image, `[64, frames]`, in the last bytes of `scratch`: [`image_mut`]; the logits after the
    /// last step, and then the next image may be written there.
    ///
    /// From the first step to the last `model` stays the same, and nobody else writes to `scratch`, at least
    /// [`Shape::scratch_bytes`] long, or uses `kernels`. Too short a scratch gives empty logits at once.
    pub fn step(
        &mut self,
        model: &Model<'_>,
        scratch: &mut [i8],
        kernels: &mut impl Kernels,
        probe: &mut impl Probe,
    ) -> Option<Logits> {
        if scratch.len() < model.shape().scratch_bytes() {
            self.reset();
            return Some(Logits::new());
        }
        #[cfg(feature = "graph")]
        if let Some(graph) = model.graph() {
            return self.step_graph(graph, scratch, probe);
        }
        let (frames, channels, stride) = (model.frames(), model.channels(), model.stem_stride());
        let (stem_height, stem_width) = (same(ROWS, stride), same(frames, stride));
        let size = (stem_height / 2, stem_width / 2);
        let map = size.0 * size.1 * channels;
        let (scratch, rest) = established(scratch.split_at_mut_checked(operator_bytes(channels)));
        let (x, rest) = established(rest.split_at_mut_checked(map));

        let (index, step) = (self.operator as usize, self.step as usize);
        let number = index.wrapping_sub(1) / 4;
        let (done, output): (bool, &[i8]) = if index == 0 {
            let (layer, image) = (&model.stem(), &*image_mut(rest, frames));
            let stem = Operator::Stem { layer, image, size: (ROWS, frames), output: x };
            (kernels.run(index, stem, step), x)
        } else {
            // the image is no longer needed
            let (a, rest) = established(rest.split_at_mut_checked(map));
            let b = established(rest.get_mut(..map));
            let end = number >= model.blocks();
            match index % 4 {
                _ if end => {
                    let output = established(scratch.get_mut(..channels));
                    (kernels.run(index, Operator::Average { input: x, channels, output }, step), output)
                }
                1 => {
                    let layer = &model.batch_norm(number);
                    (kernels.run(index, Operator::BatchNormRelu { layer, input: x, output: a }, step), a)
                }
                k @ (2 | 3) => {
                    let layer = &model.conv(number, k - 2);
                    let (input, output) = if k == 2 { (a, b) } else { (b, a) };
                    (kernels.run(index, Operator::Conv { layer, input, size, scratch, output }, step), output)
                }
                _ => {
                    let layer = &model.add(number);
                    (kernels.run(index, Operator::Add { layer, x, branch: a }, step), x)
                }
            }
        };
        self.step += 1;
        if !done {
            return None;
        }
        probe.layer(index, output);
        (self.operator, self.step) = (self.operator + 1, 0);
        if number < model.blocks() || index == 0 {
            return None;
        }
        self.reset();
        let mut logits = Logits::new();
        let resized = logits.resize(model.classes(), 0);
        debug_assert!(resized.is_ok(), "the parser has checked the number of classes");
        model.head().forward(output, &mut logits);
        probe.logits(&logits);
        Some(logits)
    }

    /// The same of a graph; its arena is the end of the scratch.
    #[cfg(feature = "graph")]
    fn step_graph(
        &mut self,
        graph: &Graph<'_>,
        scratch: &mut [i8],
        probe: &mut impl Probe,
    ) -> Option<Logits> {
        let before = scratch.len().saturating_sub(graph.arena());
        let arena = established(scratch.get_mut(before..));
        if let Some(step) = graph.step(&mut self.graph, arena) {
            if step.done {
                probe.layer(step.operator, established(arena.get(step.node.output.range())));
            }
            if !step.last {
                return None;
            }
        }
        self.reset();
        let mut logits = Logits::new();
        let stored = logits.extend_from_slice(graph.output(arena));
        debug_assert!(stored.is_ok(), "the parser has checked the number of classes");
        probe.logits(&logits);
        Some(logits)
    }
}

/// Where an image of so many frames lies in the scratch of [`Network::step`].
pub fn image_mut(scratch: &mut [i8], frames: usize) -> &mut [i8] {
    let rest = scratch.len().saturating_sub(ROWS * frames);
    scratch.get_mut(rest..).unwrap_or_default()
}

/// Classifies an image, `[64, frames]`, without a pause; memory as of [`Network::step`].
pub fn infer(
    model: &Model<'_>,
    image: &[i8],
    scratch: &mut [i8],
    kernels: &mut impl Kernels,
    probe: &mut impl Probe,
) -> Classification {
    let mut network = Network::new();
    image_mut(scratch, model.frames()).iter_mut().zip(image).for_each(|(to, from)| *to = *from);
    loop {
        if let Some(logits) = network.step(model, scratch, kernels, probe) {
            return Classification::new(model, logits, probe);
        }
    }
}
