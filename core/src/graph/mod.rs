//! Any int8 network: a list of operators with planned memory, run in bounded steps with the bits of TFLite's reference kernels.
//!
//! [`format`] is the layout of its bytes, which `sdp3 import` writes from a `.tflite` file. Operators are convolutions (any window and
//! stride, depthwise), additions, poolings, fully connected layers and softmax. [`crate::dsn`] is the paper's network, which has
//! faster kernels; a model file may hold a graph in its place.
//!
//! ```
//! use sdp3_core::graph::{Graph, Progress};
//! # fn classify(bytes: &[u8], image: &[i8], arena: &mut [i8]) -> Option<i8> {
//! let graph = Graph::parse(bytes).ok()?; // checked once; `arena` has graph.arena() bytes
//! graph.input_mut(arena).iter_mut().zip(image).for_each(|(to, from)| *to = *from);
//! let mut progress = Progress::new();
//! while !graph.step(&mut progress, arena)?.last {} // each step is bounded
//! graph.output(arena).iter().copied().max()
//! # }
//! ```

mod convolution;
mod dense;
pub mod format;
mod node;
mod pooling;
mod softmax;
mod steps;
mod window;

pub use dense::Dense;
pub use node::{Kind, Node, Tensor, Window};
pub use softmax::Softmax;
pub use steps::{Progress, Step};

use crate::crc32::crc32;
use crate::dsn::ModelError;
use crate::dsn::established;
use crate::dsn::model::error::check;
use core::ops::Range;
use format::{HEADER_LEN, MAGIC, MAX_ARENA, MAX_OPERATORS, OPERATOR_LEN, VERSION};

/// A checked graph: its bytes and the numbers of its header. Operators are views, made on demand.
#[derive(Debug, Clone, Copy)]
pub struct Graph<'m> {
    /// All operators.
    operators: &'m [u8],
    crc: u32,
    count: u16,
    arena: u32,
    input: Tensor,
    output: Tensor,
    zero_points: [i8; 2],
    scales: [f32; 2],
}

impl<'m> Graph<'m> {
    /// Checks a byte string; nothing is copied but the header's numbers. Everything that can be wrong with a graph is found here,
    /// but for a plan that overwrites an activation before it is read: the bits of such a graph are defined, and useless.
    ///
    /// Cost: some ten instructions a byte.
    ///
    /// # Errors
    ///
    /// Every defect has its [`ModelError`]; a truncated or altered graph never passes its length and checksum.
    pub fn parse(bytes: &'m [u8]) -> Result<Self, ModelError> {
        let have = bytes.len();
        let truncated = ModelError::Truncated { need: HEADER_LEN + OPERATOR_LEN + 4, have };
        let (content, checksum) = bytes.split_last_chunk::<4>().ok_or(truncated)?;
        let (header, operators) = content.split_first_chunk::<HEADER_LEN>().ok_or(truncated)?;
        let two = |at: usize| u16::from_le_bytes([header[at], header[at + 1]]);
        let four = |at: usize| [header[at], header[at + 1], header[at + 2], header[at + 3]];
        if four(0) != MAGIC {
            return Err(ModelError::Magic);
        }
        if two(4) != VERSION {
            return Err(ModelError::Version { found: two(4) });
        }
        let stated = u32::from_le_bytes(four(8)) as usize;
        if stated != have {
            return Err(ModelError::Length { stated, have });
        }
        let (stated, crc) = (u32::from_le_bytes(*checksum), crc32(content));
        if stated != crc {
            return Err(ModelError::Checksum { stated, computed: crc });
        }
        let (count, arena) = (two(6), u32::from_le_bytes(four(12)));
        check("graph.operators", i64::from(count), (1..=MAX_OPERATORS).contains(&usize::from(count)))?;
        check("graph.arena", i64::from(arena), (1..=MAX_ARENA).contains(&(arena as usize)))?;
        let input =
            Tensor { at: u32::from_le_bytes(four(32)), height: two(16), width: two(18), channels: two(20) };
        check("graph.input", i64::from(input.at), input.fits(arena))?;
        let scales = [24, 28].map(|at| f32::from_le_bytes(four(at)));
        for scale in scales {
            check("graph.scale", i64::from(scale.to_bits()), scale.is_normal() && scale > 0.0)?;
        }
        check("graph.reserved", 0, four(36) == [0; 4])?;
        let zero_points = [header[22], header[23]].map(|byte| byte as i8);
        let mut graph = Graph { operators, crc, count, arena, input, output: input, zero_points, scales };
        let mut at = 0;
        for _ in 0..count {
            let rest = operators.get(at..).unwrap_or(&[]);
            let need = Node::length(rest)
                .ok_or(ModelError::Layers { need: at + OPERATOR_LEN, have: operators.len() })?;
            let bytes =
                rest.get(..need).ok_or(ModelError::Layers { need: at + need, have: operators.len() })?;
            graph.output = Node::checked(bytes, arena)?.output;
            at += need;
        }
        if at != operators.len() {
            return Err(ModelError::Layers { need: at, have: operators.len() });
        }
        Ok(graph)
    }

    /// Bytes of the graph, with header and checksum.
    pub fn bytes(&self) -> usize {
        HEADER_LEN + self.operators.len() + 4
    }

    /// Bytes of the arena, which holds all activations.
    pub fn arena(&self) -> usize {
        self.arena as usize
    }

    /// Its input.
    pub fn input(&self) -> Tensor {
        self.input
    }

    /// Its last operator's output.
    pub fn output_tensor(&self) -> Tensor {
        self.output
    }

    /// Zero points of input and output.
    pub fn zero_points(&self) -> [i8; 2] {
        self.zero_points
    }

    /// Scales of input and output: what one step is worth.
    pub fn scales(&self) -> [f32; 2] {
        self.scales
    }

    /// Where the input, `[height, width, channels]`, is written before the first step; empty if the arena is too short.
    pub fn input_mut<'a>(&self, arena: &'a mut [i8]) -> &'a mut [i8] {
        arena.get_mut(self.input.range()).unwrap_or_default()
    }

    /// The output after the last step, `[height, width, channels]`; empty if the arena is too short.
    pub fn output<'a>(&self, arena: &'a [i8]) -> &'a [i8] {
        arena.get(self.output.range()).unwrap_or_default()
    }

    /// The operators in the order they run.
    pub fn nodes(&self) -> impl Iterator<Item = Node<'m>> + use<'m> {
        let mut rest = self.operators;
        (0..self.count).map_while(move |_| {
            let (first, after) = rest.split_at_checked(Node::length(rest)?)?;
            rest = after;
            Some(Node::view(first))
        })
    }

    /// Multiply-accumulates of a run.
    pub fn products(&self) -> u64 {
        self.nodes().map(|node| node.products()).sum()
    }

    /// The operator that begins at a byte of the list; an empty one, which computes nothing, behind the last.
    fn node_at(&self, at: u32) -> Node<'m> {
        let rest = self.operators.get(at as usize..).unwrap_or(&[]);
        Node::view(established(Node::length(rest).and_then(|length| rest.get(..length))))
    }
}

/// The activations that an operator does not write.
struct Inputs<'a> {
    before: &'a [i8],
    behind: &'a [i8],
    /// Bytes of the output between them.
    output: usize,
}

impl<'a> Inputs<'a> {
    /// The arena as an operator sees it: what it reads from, and its output.
    fn new(arena: &'a mut [i8], output: Range<usize>) -> (Self, &'a mut [i8]) {
        let (before, rest) = established(arena.split_at_mut_checked(output.start));
        let (output, behind) = established(rest.split_at_mut_checked(output.len()));
        (Inputs { before, behind, output: output.len() }, output)
    }

    /// A tensor that does not overlap the output.
    fn get(&self, range: Range<usize>) -> &'a [i8] {
        let first = self.before.len() + self.output;
        if range.end <= self.before.len() {
            established(self.before.get(range))
        } else {
            established(range.start.checked_sub(first).and_then(|at| self.behind.get(at..range.end - first)))
        }
    }
}
