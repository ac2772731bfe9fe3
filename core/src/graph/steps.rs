//! A graph in bounded steps.

use super::convolution::{BLOCK, convolve, convolve_depthwise};
use super::node::{Kind, Node};
use super::pooling::{pool_average, pool_max};
use super::{Graph, Inputs, Window};
use crate::dsn::batch_norm::BatchNormRelu;
use crate::dsn::conv::{Conv, MAX_CHANNELS};
use crate::dsn::established;
use crate::dsn::kernels::piece;
use crate::dsn::winograd::{WinogradSizes, has_kernels, scratch_bytes};
use crate::dsn::{Kernels, Operator};

/// Instructions of a step on Cortex-M4F, roughly, if an output value does not take more.
const INSTRUCTIONS: usize = 45_000;

/// How far a graph has come with its input: the operator, and which of its steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Progress {
    /// Number of the operator.
    pub operator: u32,
    /// Its first byte in the list.
    at: u32,
    step: u32,
    /// Checksum of the graph, after the first step.
    graph: u32,
}

impl Progress {
    /// At the beginning.
    pub const fn new() -> Self {
        Progress { operator: 0, at: 0, step: 0, graph: 0 }
    }
}

/// What a step has done.
#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Step<'m> {
    /// Number of the operator.
    pub operator: usize,
    /// The operator.
    pub node: Node<'m>,
    /// Whether its output is complete.
    pub done: bool,
    /// Whether the graph's output is: this was the last step.
    pub last: bool,
}

impl<'m> Graph<'m> {
    /// Does one bounded step; after the last `progress` is at the beginning again.
    ///
    /// Nobody else writes to the arena, at least [`Graph::arena`] long, from the first step to the last. `None`, and `progress` is
    /// at the beginning again, if it is shorter or `progress` is of a graph with another checksum.
    pub fn step(&self, progress: &mut Progress, arena: &mut [i8]) -> Option<Step<'m>> {
        self.advance(progress, arena, |node, arena, at| run(node, arena, at.step as usize))
    }

    /// [`Graph::step`] by the kernels of the paper's network where they are made for an operator ([`Node::is_covered`]), else by the plain
    /// loops; the same bits. `scratch` has [`Graph::kernel_scratch`]; of fewer the plain loops compute everything.
    pub fn step_by(
        &self,
        progress: &mut Progress,
        arena: &mut [i8],
        kernels: &mut impl Kernels,
        scratch: &mut [i8],
    ) -> Option<Step<'m>> {
        self.advance(progress, arena, |node, arena, at| {
            match node.is_covered() && scratch.len() >= node.kernel_scratch() {
                true => run_by(node, arena, at, kernels, scratch),
                false => run(node, arena, at.step as usize),
            }
        })
    }

    /// Does a step by `run`, which returns true after an operator's last.
    fn advance(
        &self,
        progress: &mut Progress,
        arena: &mut [i8],
        run: impl FnOnce(&Node<'m>, &mut [i8], Progress) -> bool,
    ) -> Option<Step<'m>> {
        let others = *progress != Progress::new() && progress.graph != self.crc;
        if arena.len() < self.arena() || others || progress.operator >= u32::from(self.count) {
            *progress = Progress::new();
            return None;
        }
        let node = self.node_at(progress.at);
        let done = run(&node, arena, *progress);
        let operator = progress.operator as usize;
        (progress.step, progress.graph) = (progress.step + 1, self.crc);
        if done {
            (progress.operator, progress.step) = (progress.operator + 1, 0);
            progress.at += node.bytes() as u32;
        }
        let last = done && progress.at as usize >= self.operators.len();
        if last {
            *progress = Progress::new();
        }
        Some(Step { operator, node, done, last })
    }

    /// Bytes of scratch of the widest convolution that kernels are made for.
    pub fn kernel_scratch(&self) -> usize {
        self.nodes().filter(Node::is_covered).map(|node| node.kernel_scratch()).max().unwrap_or(0)
    }

    /// Memory of the kernels of [`WinogradKernels::shared`](crate::dsn::WinogradKernels::shared) for all operators that they are made for.
    pub fn winograd_sizes(&self) -> WinogradSizes {
        let sizes = |node: Node<'_>| match node.kind {
            Some(Kind::Convolution) => WinogradSizes::of_convolution(
                usize::from(node.input.channels),
                usize::from(node.output.channels),
            ),
            _ => WinogradSizes::new(0, 1),
        };
        self.nodes()
            .filter(Node::is_covered)
            .map(sizes)
            .fold(WinogradSizes { vectors: 0, words: 0 }, WinogradSizes::max)
    }
}

impl Node<'_> {
    /// Bytes of scratch that the kernels of a convolution take.
    fn kernel_scratch(&self) -> usize {
        match self.kind {
            Some(Kind::Convolution) => scratch_bytes(self.input.channels.into(), self.output.channels.into()),
            _ => 0,
        }
    }

    /// Whether the kernels of the paper's network compute it: 3x3 convolutions of stride 1 that keep height and width, with 8, 16, 32
    /// or 64 inputs and outputs or three inputs and 8, 16 or 32 outputs; depthwise 1x1 convolutions of at most 32 channels; additions.
    pub fn is_covered(&self) -> bool {
        let ([height, width, inputs], [rows, columns, outputs]) = (self.input.shape(), self.output.shape());
        let keeps = (height, width) == (rows, columns);
        let window = |size: u8, padding: u8| {
            self.window == Window { size: [size; 2], stride: [1; 2], padding: [padding; 2] }
        };
        match self.kind {
            Some(Kind::Add) => true,
            Some(Kind::DepthwiseConvolution) => {
                keeps && window(1, 0) && inputs == outputs && outputs <= MAX_CHANNELS
            }
            Some(Kind::Convolution) => keeps && window(3, 1) && has_kernels(inputs, outputs),
            _ => false,
        }
    }
}

/// Does a step of an operator that `kernels` are made for; true after its last.
fn run_by(
    node: &Node<'_>,
    arena: &mut [i8],
    at: Progress,
    kernels: &mut impl Kernels,
    scratch: &mut [i8],
) -> bool {
    let (inputs, output) = Inputs::new(arena, node.output.range());
    let (input, [height, width, channels]) = (inputs.get(node.input.range()), node.input.shape());
    let (index, step) = (at.operator as usize, at.step as usize);
    match node.kind {
        Some(Kind::Add) => {
            if step == 0 {
                output.iter_mut().zip(input).for_each(|(to, from)| *to = *from);
            }
            let branch = inputs.get(node.second_range());
            kernels.run(index, Operator::Add { layer: &node.addition(), x: output, branch }, step)
        }
        Some(Kind::DepthwiseConvolution) => {
            let layer = &BatchNormRelu { quant: node.quantization() };
            kernels.run(index, Operator::BatchNormRelu { layer, input, output }, step)
        }
        _ => {
            let layer = &Conv { quant: node.quantization(), inputs: channels, stride: 1 };
            kernels.run(index, Operator::Conv { layer, input, size: (height, width), scratch, output }, step)
        }
    }
}

/// The values of a step if each takes so many instructions: whole blocks if there is one, at least one value.
fn whole_blocks(instructions: usize) -> usize {
    let values = INSTRUCTIONS / instructions.max(1);
    let blocks = values / BLOCK * BLOCK;
    if blocks > 0 { blocks } else { values.max(1) }
}

/// Does step `step` of an operator; true after its last.
fn run(node: &Node<'_>, arena: &mut [i8], step: usize) -> bool {
    let (inputs, output) = Inputs::new(arena, node.output.range());
    let input = inputs.get(node.input.range());
    if node.kind == Some(Kind::Convolution) {
        return convolve(node, &node.quantization(), input, (step, INSTRUCTIONS), output);
    }
    let values = match node.kind {
        Some(Kind::Softmax) => usize::from(node.output.channels),
        Some(Kind::FullyConnected) => whole_blocks(node.taps().saturating_mul(4)),
        _ => whole_blocks(node.taps().saturating_mul(8).saturating_add(64)),
    };
    let (range, last) = piece(output.len(), values, step);
    let second = if node.kind == Some(Kind::Add) { inputs.get(node.second_range()) } else { &[] };
    let output = established(output.get_mut(range.clone()));
    match node.kind {
        Some(Kind::DepthwiseConvolution) => {
            convolve_depthwise(node, &node.quantization(), input, range, output)
        }
        Some(Kind::Add) => {
            output.iter_mut().zip(established(input.get(range.clone()))).for_each(|(to, from)| *to = *from);
            node.addition().forward(output, established(second.get(range)));
        }
        Some(Kind::MaxPool) => pool_max(node, input, range, output),
        Some(Kind::AveragePool) => pool_average(node, input, range, output),
        Some(Kind::FullyConnected) => node.dense().forward(input, range, output),
        Some(Kind::Softmax) => node.softmax().forward(established(input.get(range)), output),
        Some(Kind::Convolution) | None => {}
    }
    last
}
