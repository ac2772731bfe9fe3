//! The radar module's graph as bytes: operators in the order they run, and a plan of the memory of all activations.
//!
//! `sdp3_core::graph::format` is the layout. The plan is greedy: the largest activation first, each at the lowest place that none
//! of those alive at the same time has (Y. Pisarchyk, J. Lee, Efficient Memory Management for Deep Neural Net Inference, 2020,
//! "greedy by size"). The input lies at the end, where the radar module writes its image.

use super::model_file::closed;
use crate::error::Invalid;
use schemars::JsonSchema;
use sdp3_core::graph::format::{HEADER_LEN, MAGIC, MAX_ARENA, MAX_OPERATORS, VERSION};
use sdp3_core::graph::{Graph, Kind, Node, Window};
use serde::Serialize;
use std::fmt::Write as _;
use std::ops::Range;

/// Where activations begin: at multiples of so many bytes, but for the input.
const ALIGNMENT: usize = 4;

/// An operator: which activations it reads and writes, and everything else that its bytes say.
#[derive(Debug, Clone, PartialEq)]
pub struct Operator {
    /// What it does.
    pub kind: Kind,
    /// Activation it reads.
    pub input: usize,
    /// Height, width and channels as which it reads it.
    pub input_shape: [usize; 3],
    /// Second one, of an addition.
    pub second: Option<usize>,
    /// Activation it writes.
    pub output: usize,
    /// Window of a convolution or pooling.
    pub window: Window,
    /// Of input, output and second input.
    pub zero_points: [i8; 3],
    /// Smallest and largest output.
    pub activation: [i8; 2],
    /// As the layout has them.
    pub parameters: Vec<u8>,
}

impl Operator {
    /// Adds bytes and zeros up to a multiple of four to the parameters.
    pub fn append_padded(&mut self, bytes: &[u8]) {
        self.parameters.extend(bytes);
        self.parameters.resize(self.parameters.len().next_multiple_of(4), 0);
    }

    fn reads(&self, activation: usize) -> bool {
        self.input == activation || self.second == Some(activation)
    }
}

/// A network of operators, as any int8 file describes it.
#[derive(Debug, Clone, PartialEq)]
pub struct GraphNetwork {
    /// Height, width and channels of every activation.
    pub activations: Vec<[usize; 3]>,
    /// In the order they run.
    pub operators: Vec<Operator>,
    /// Activation that is given.
    pub input: usize,
    /// Scale and zero point of every activation.
    pub grids: Vec<(f32, i8)>,
}

/// Where every activation lies.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Plan {
    /// First byte of every activation.
    pub places: Vec<usize>,
    /// Bytes of all of them.
    pub arena: usize,
}

impl GraphNetwork {
    /// Activation that is the answer.
    pub fn output(&self) -> usize {
        self.operators.last().map_or(self.input, |last| last.output)
    }

    /// Bytes of an activation.
    fn bytes_of(&self, activation: usize) -> usize {
        self.activations[activation].iter().product()
    }

    /// The operators during which an activation must be kept: from the one that writes it to the last that reads it.
    fn lifetime(&self, activation: usize) -> Option<Range<usize>> {
        let written = self.operators.iter().position(|o| o.output == activation);
        let read = self.operators.iter().rposition(|o| o.reads(activation));
        let first = if activation == self.input { 0 } else { written? };
        Some(first..read.unwrap_or(first).max(first) + 1)
    }

    /// Places all activations.
    pub fn plan(&self) -> Plan {
        let alive: Vec<_> = (0..self.activations.len()).map(|k| self.lifetime(k).unwrap_or(0..0)).collect();
        let together = |a: usize, b: usize| alive[a].start < alive[b].end && alive[b].start < alive[a].end;
        let mut order: Vec<usize> =
            (0..alive.len()).filter(|&k| k != self.input && !alive[k].is_empty()).collect();
        order.sort_by_key(|&k| (std::cmp::Reverse(self.bytes_of(k)), k));
        let mut places = vec![0; alive.len()];
        let mut placed: Vec<usize> = Vec::new();
        for k in order {
            let mut taken: Vec<Range<usize>> = placed
                .iter()
                .filter(|&&other| together(k, other))
                .map(|&other| places[other]..places[other] + self.bytes_of(other))
                .collect();
            taken.sort_by_key(|range| range.start);
            let mut at = 0_usize;
            for range in taken {
                if at + self.bytes_of(k) <= range.start {
                    break;
                }
                at = at.max(range.end.next_multiple_of(ALIGNMENT));
            }
            places[k] = at;
            placed.push(k);
        }
        let end = |k: &usize| places[*k] + self.bytes_of(*k);
        let length = self.bytes_of(self.input);
        let beside = placed.iter().filter(|&&k| together(k, self.input)).map(end).max().unwrap_or(0);
        let arena =
            placed.iter().map(end).max().unwrap_or(0).max(beside.next_multiple_of(ALIGNMENT) + length);
        places[self.input] = arena - length;
        Plan { places, arena }
    }

    /// The bytes.
    ///
    /// # Errors
    /// A size that the layout cannot hold, with its legal range.
    pub fn to_bytes(&self) -> Result<Vec<u8>, Invalid> {
        let Plan { places, arena } = self.plan();
        let count = self.operators.len();
        let most = format!("1 to {MAX_OPERATORS}");
        Invalid::unless((1..=MAX_OPERATORS).contains(&count), "number of operators", count, &most)?;
        Invalid::unless(arena <= MAX_ARENA, "bytes of activations", arena, format!("at most {MAX_ARENA}"))?;
        let mut out = Vec::with_capacity(HEADER_LEN);
        out.extend_from_slice(&MAGIC);
        out.extend_from_slice(&VERSION.to_le_bytes());
        out.extend_from_slice(&(count as u16).to_le_bytes());
        out.extend_from_slice(&[0; 4]);
        out.extend_from_slice(&(arena as u32).to_le_bytes());
        append_shape(self.activations[self.input], &mut out)?;
        let ends = [self.input, self.output()].map(|activation| self.grids[activation]);
        out.extend(ends.map(|(_, zero)| zero as u8));
        out.extend(ends.map(|(scale, _)| scale.to_le_bytes()).as_flattened());
        out.extend_from_slice(&(places[self.input] as u32).to_le_bytes());
        out.resize(HEADER_LEN, 0);
        for o in &self.operators {
            out.push(o.kind as u8);
            let [input, output, second] = o.zero_points;
            out.extend([input, output, o.activation[0], o.activation[1], second].map(|value| value as u8));
            out.extend([o.window.size, o.window.stride, o.window.padding].as_flattened());
            append_shape(o.input_shape, &mut out)?;
            append_shape(self.activations[o.output], &mut out)?;
            let second = o.second.map_or(0, |second| places[second]);
            for word in [places[o.input], places[o.output], second, o.parameters.len()] {
                out.extend_from_slice(&(word as u32).to_le_bytes());
            }
            out.extend_from_slice(&o.parameters);
        }
        Ok(closed(out))
    }
}

/// Adds the lengths of axes.
fn append_shape(shape: [usize; 3], out: &mut Vec<u8>) -> Result<(), Invalid> {
    for length in shape {
        let length = u16::try_from(length).ok().filter(|&length| length > 0).ok_or_else(|| {
            Invalid::new("height, width or channels of an activation", length, format!("1 to {}", u16::MAX))
        })?;
        out.extend_from_slice(&length.to_le_bytes());
    }
    Ok(())
}

/// A graph's operators and what they take, in words and as JSON.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct GraphSummary {
    /// Bytes of all activations at their planned places.
    pub arena_bytes: usize,
    /// Bytes of operators and parameters.
    pub bytes: usize,
    /// Multiply-accumulates of a run; padding counts.
    pub products: u64,
    /// In the order they run.
    pub operators: Vec<OperatorSummary>,
}

/// An operator of a graph.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct OperatorSummary {
    /// Its name in TensorFlow Lite's schema.
    pub kind: String,
    /// Height, width and channels of its input.
    pub input: [usize; 3],
    /// Height, width and channels of its output.
    pub output: [usize; 3],
    /// Height and width of its window.
    pub window: [usize; 2],
    /// Strides along the rows and the columns.
    pub stride: [u8; 2],
    /// Where its output lies in the arena.
    pub place: u32,
    /// Multiply-accumulates.
    pub products: u64,
}

impl GraphSummary {
    /// Of a graph.
    pub fn of(graph: &Graph<'_>) -> Self {
        let operator = |node: Node<'_>| OperatorSummary {
            kind: node.kind.map_or("", Kind::name).to_owned(),
            input: node.input.shape(),
            output: node.output.shape(),
            window: node.window_size(),
            stride: node.window.stride,
            place: node.output.at,
            products: node.products(),
        };
        GraphSummary {
            arena_bytes: graph.arena(),
            bytes: graph.bytes(),
            products: graph.products(),
            operators: graph.nodes().map(operator).collect(),
        }
    }

    /// A line each.
    pub fn describe(&self) -> String {
        let mut text = format!(
            "{} operators, {} bytes, {} multiply-accumulates, arena of {} bytes\n",
            self.operators.len(),
            self.bytes,
            self.products,
            self.arena_bytes
        );
        for (number, o) in self.operators.iter().enumerate() {
            let axes = |shape: [usize; 3]| shape.map(|n| n.to_string()).join("x");
            let ([h, w], [rows, columns]) = (o.window, o.stride);
            let _ = writeln!(
                text,
                "{number:>4} {:<17} {:>11} -> {:<11} window {h}x{w} stride {rows}x{columns} at {:<8} {} multiply-accumulates",
                o.kind,
                axes(o.input),
                axes(o.output),
                o.place,
                o.products
            );
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pool(input: usize, output: usize) -> Operator {
        Operator {
            kind: Kind::MaxPool,
            input,
            input_shape: [3, 5, 2],
            second: None,
            output,
            window: Window { size: [1, 1], stride: [1, 1], padding: [0, 0] },
            zero_points: [0; 3],
            activation: [-128, 127],
            parameters: Vec::new(),
        }
    }

    fn add(input: usize, second: usize, output: usize) -> Operator {
        let mut parameters: Vec<u8> = [1 << 30, 1 << 30, 1_i32 << 30].map(i32::to_le_bytes).concat();
        parameters.extend([0, 0, -19_i8 as u8, 0]);
        Operator { kind: Kind::Add, second: Some(second), parameters, ..pool(input, output) }
    }

    /// A residual block: 0 -> 1 -> 2 -> 3, and 1 + 3 -> 4.
    fn block() -> GraphNetwork {
        GraphNetwork {
            activations: vec![[3, 5, 2]; 5],
            operators: vec![pool(0, 1), pool(1, 2), pool(2, 3), add(1, 3, 4)],
            input: 0,
            grids: vec![(1.0, 0); 5],
        }
    }

    #[test]
    fn activations_that_live_together_lie_apart_and_others_share() {
        let network = block();
        let plan = network.plan();
        let range = |k: usize| plan.places[k]..plan.places[k] + 30;
        for (a, b) in [(0, 1), (1, 2), (2, 3), (1, 3), (1, 4), (3, 4)] {
            let (a, b) = (range(a), range(b));
            assert!(a.end <= b.start || b.end <= a.start, "{a:?} {b:?}");
        }
        // three at a time, each at a multiple of four
        assert_eq!(plan.arena, 32 + 32 + 30);
        assert_eq!(range(0).end, plan.arena);
    }

    #[test]
    fn the_core_reads_what_is_written_and_runs_it() {
        let bytes = block().to_bytes().unwrap();
        let graph = Graph::parse(&bytes).unwrap();
        assert_eq!((graph.nodes().count(), graph.arena()), (4, 94));
        let mut arena = vec![0; graph.arena()];
        let image: Vec<i8> = (0..30).map(|k| k * 4 - 60).collect();
        graph.input_mut(&mut arena).copy_from_slice(&image);
        let mut progress = Default::default();
        while !graph.step(&mut progress, &mut arena).unwrap().last {}
        // poolings of one pixel change nothing; 20 guard bits, halved twice and shifted by 19 make of x + x what x was
        assert_eq!(graph.output(&arena), image);
    }

    #[test]
    fn sizes_beyond_the_layout_are_refused() {
        let mut network = block();
        network.activations[2] = [1, 1, 70_000];
        assert!(network.to_bytes().unwrap_err().to_string().contains("70000"));
        network.operators.clear();
        assert!(network.to_bytes().unwrap_err().to_string().contains("number of operators"));
    }
}
