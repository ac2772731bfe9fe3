//! A graph in bounded steps.

use super::convolution::{BLOCK, convolve, convolve_depthwise};
use super::node::{Kind, Node};
use super::pooling::{pool_average, pool_max};
use super::{Graph, Views};
use crate::dsn::established;
use crate::dsn::kernels::piece;

/// Multiply-accumulates of a step, at least those of one output value; every output value counts another sixteen.
const PRODUCTS: usize = 7680;

/// How far a graph has come with its input: the operator, and which of its steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Progress {
    /// Number of the operator.
    pub operator: u32,
    /// Its first byte in the list.
    at: u32,
    step: u32,
}

impl Progress {
    /// At the beginning.
    pub const fn new() -> Self {
        Progress { operator: 0, at: 0, step: 0 }
    }
}

/// What a step has done.
#[derive(Debug, Clone, Copy)]
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
    /// Nobody else writes to the arena, at least [`Graph::arena`] long, from the first step to the last. `None` if it is shorter,
    /// or if `progress` is another graph's.
    pub fn step(&self, progress: &mut Progress, arena: &mut [i8]) -> Option<Step<'m>> {
        if arena.len() < self.arena() || progress.operator >= u32::from(self.count) {
            debug_assert!(arena.len() >= self.arena(), "the arena is smaller than the graph's");
            *progress = Progress::new();
            return None;
        }
        let node = self.node_at(progress.at);
        let done = run(&node, arena, progress.step as usize);
        let operator = progress.operator as usize;
        progress.step += 1;
        if done {
            *progress =
                Progress { operator: progress.operator + 1, at: progress.at + node.bytes() as u32, step: 0 };
        }
        let last = done && operator + 1 == usize::from(self.count);
        if last {
            *progress = Progress::new();
        }
        Some(Step { operator, node, done, last })
    }
}

/// So many values or a few fewer, whole blocks if it is one; at least one.
const fn whole_blocks(values: usize) -> usize {
    let blocks = values / BLOCK * BLOCK;
    if blocks > 0 {
        blocks
    } else if values > 0 {
        values
    } else {
        1
    }
}

/// Does step `step` of an operator; true after its last.
fn run(node: &Node<'_>, arena: &mut [i8], step: usize) -> bool {
    let views = Views::new(arena, node.output.range());
    let input = views.input(node.input.range());
    let values = match node.kind {
        Some(Kind::Softmax) => usize::from(node.output.channels),
        // a value under a pooling's window takes as long as some products
        Some(Kind::MaxPool | Kind::AveragePool) => whole_blocks(PRODUCTS / (4 * node.taps() + 16)),
        _ => whole_blocks(PRODUCTS / (node.taps() + 16)),
    };
    let (range, last) = piece(views.output.len(), values, step);
    let second = if node.kind == Some(Kind::Add) { views.input(node.second_range()) } else { &[] };
    let output = established(views.output.get_mut(range.clone()));
    match node.kind {
        Some(Kind::Convolution) => convolve(node, &node.quantization(), input, range, output),
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
        None => {}
    }
    last
}
