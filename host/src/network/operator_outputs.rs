//! A network on arrays: int8 inputs to the outputs of its last operator, or of every operator.
//!
//! By the radar module's own code, for a graph and for a model file: what firmware computes.

use crate::error::{Failure, Invalid};
use crate::formats::numpy;
use crate::store::limited;
use crate::store::output::Output;
use rayon::prelude::*;
use schemars::JsonSchema;
use sdp3_core::dims::ROWS;
use sdp3_core::dsn::{Model, ModelError};
use sdp3_core::graph::format::MAGIC;
use sdp3_core::graph::{Graph, Progress};
use sdp3_core::probe::Probe;
use serde::Serialize;
use std::path::{Path, PathBuf};

use super::inference::Classifier;

/// A checked network.
#[derive(Debug, Clone, Copy)]
pub enum Network<'m> {
    /// Operators of their own.
    Graph(Graph<'m>),
    /// A radar module's, from its image on.
    Model(Model<'m>),
}

/// Outputs of one input.
#[derive(Debug, Default)]
struct Outputs {
    last: Vec<i8>,
    all: Vec<i8>,
}

impl Probe for Outputs {
    fn layer(&mut self, _index: usize, activations: &[i8]) {
        self.all.extend_from_slice(activations);
    }

    fn logits(&mut self, logits: &[i8]) {
        self.last = logits.to_vec();
    }
}

impl<'m> Network<'m> {
    /// The network of a file's bytes, `SDP3` or `SDPG` by its first four.
    ///
    /// # Errors
    /// What the radar module's parser finds wrong.
    pub fn parse(bytes: &'m [u8]) -> Result<Self, ModelError> {
        if bytes.starts_with(&MAGIC) {
            return Graph::parse(bytes).map(Network::Graph);
        }
        Model::parse(bytes).map(Network::Model)
    }

    /// Height, width and channels of its input.
    pub fn input(&self) -> [usize; 3] {
        match self {
            Network::Graph(graph) => graph.input().shape(),
            Network::Model(model) => [ROWS, model.frames(), 1],
        }
    }

    /// Runs inputs, `[count, height, width, channels]`: the answers, `[count, values]`, or with `every` the outputs of all operators one
    /// behind the other. In parallel; the same bytes for any number of threads.
    ///
    /// # Errors
    /// Fewer or more values than whole inputs.
    pub fn run(&self, inputs: &[i8], every: bool) -> Result<Vec<i8>, Invalid> {
        let size: usize = self.input().iter().product();
        let legal = format!("a multiple of {size}, {:?}", self.input());
        let whole = !inputs.is_empty() && inputs.len().is_multiple_of(size);
        Invalid::unless(whole, "number of values", inputs.len(), legal)?;
        let outputs = inputs.par_chunks_exact(size).map_init(
            || Runner::new(*self),
            |runner, input| {
                let found = runner.run(input);
                if every { found.all } else { found.last }
            },
        );
        Ok(outputs.collect::<Vec<_>>().concat())
    }
}

/// A network with the memory that it needs, for one input after the other.
enum Runner<'m> {
    Graph(Graph<'m>, Vec<i8>),
    Model(Box<Classifier<'m>>),
}

impl<'m> Runner<'m> {
    fn new(network: Network<'m>) -> Self {
        match network {
            Network::Graph(graph) => Runner::Graph(graph, vec![0; graph.arena()]),
            Network::Model(model) => Runner::Model(Box::new(Classifier::new(model))),
        }
    }

    fn run(&mut self, input: &[i8]) -> Outputs {
        let mut found = Outputs::default();
        match self {
            Runner::Graph(graph, arena) => {
                graph.input_mut(arena).copy_from_slice(input);
                let mut progress = Progress::new();
                while let Some(step) = graph.step(&mut progress, arena) {
                    if step.done {
                        found.all.extend_from_slice(&arena[step.node.output.range()]);
                    }
                    if step.last {
                        break;
                    }
                }
                found.last = graph.output(arena).to_vec();
            }
            Runner::Model(classifier) => {
                classifier.classify(input, &mut found);
            }
        }
        found
    }
}

/// What was computed, and where it is.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Inferred {
    /// Network.
    pub network: PathBuf,
    /// Array of inputs.
    pub from: PathBuf,
    /// Array that was written, int8.
    pub to: PathBuf,
    /// Inputs, and values of each.
    pub shape: [usize; 2],
}

/// Runs a network on an array of inputs, int8 `[count, height, width, channels]`, and writes the answers, or with `every` the outputs of
/// all operators, as an array `[count, values]`.
///
/// # Errors
/// The file and what is wrong with it.
pub fn infer(network: &Path, from: &Path, to: &Path, every: bool) -> Result<Inferred, Failure> {
    let named =
        |file: &Path, error: &dyn std::fmt::Display| Failure::from(format!("{}: {error}", file.display()));
    let bytes = limited::read(network, limited::NETWORK).map_err(|e| named(network, &e))?;
    let parsed = Network::parse(&bytes).map_err(|e| named(network, &e))?;
    let file = limited::open(from, limited::WHOLE).map_err(|e| named(from, &e))?;
    let array = numpy::array(std::io::BufReader::new(file)).map_err(|e| named(from, &e))?;
    let size: usize = parsed.input().iter().product();
    let [count, axes @ ..] = &array.shape[..] else {
        return Err(Invalid::new("shape", "()", "[count, height, width, channels]")
            .at(from.display())
            .into());
    };
    let values = axes.iter().try_fold(1_u64, |all, &axis| all.checked_mul(axis));
    let (count, found) = (*count as usize, format!("{:?}", array.shape));
    let legal = format!("[count, {}], int8 by rows", parsed.input().map(|n| n.to_string()).join(", "));
    let fits = values == Some(size as u64) && !array.fortran_order;
    Invalid::unless(fits, "shape", found, legal).map_err(|e| e.at(from.display()))?;
    let inputs: Vec<i8> = array.into_vec().map_err(|e| named(from, &e))?;
    let outputs = parsed.run(&inputs, every).map_err(|e| e.at(from.display()))?;
    let shape = [count, outputs.len() / count.max(1)];
    let values: Vec<u8> = outputs.iter().map(|&value| value as u8).collect();
    Output::write_file(to, &[numpy::header("|i1", &shape), values].concat())?;
    Ok(Inferred { network: network.to_owned(), from: from.to_owned(), to: to.to_owned(), shape })
}

impl Inferred {
    /// In words.
    pub fn describe(&self) -> String {
        let [count, values] = self.shape;
        format!("{} -> {}, {count} x {values} values", self.from.display(), self.to.display())
    }
}
