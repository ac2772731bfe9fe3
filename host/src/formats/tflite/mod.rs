//! int8 networks as TensorFlow Lite files, without TensorFlow: written for other runtimes, read from other trainers.
//!
//! FlatBuffers with the public schema's field numbers (`schema.fbs`, version 3) and TensorFlow Lite's 8-bit
//! quantisation specification. The graph is that of the radar module, one operator a layer:
//!
//! ```text
//! image [1, 64, frames, 1] -> CONV_2D 3x3 -> MAX_POOL_2D 2x2
//!   per block: DEPTHWISE_CONV_2D 1x1 (affine) -> CONV_2D 3x3 -> CONV_2D 3x3 -> ADD with the block's input
//! -> AVERAGE_POOL_2D over the image -> CONV_2D 1x1 -> logits [1, 1, 1, classes]
//! ```
//!
//! Any other network of the operators that the radar module has becomes a graph ([`import_graph`]).
//!
//! A RESHAPE or SOFTMAX behind the logits is passed over when read. Weights are int8, per output channel, zero point 0; biases int32; activations int8 with one grid per tensor.

mod export;
mod graph;
mod import;
mod operators;
mod reader;
mod schema;
mod traversal;
mod writer;

pub use export::export;
pub use import::{ImportDefaults, import, import_graph, import_model};

use super::model_file::ModelFileError;
use crate::error::Invalid;
use std::fmt::Display;
use thiserror::Error;

/// Why a file is not a network this program can run, or a network not one it can write.
#[derive(Debug, Error)]
pub enum TfliteError {
    /// A reference leads out of the file.
    #[error("truncated or damaged: {field} {what}")]
    Damaged {
        /// What was looked for.
        field: String,
        /// What was found.
        what: String,
    },
    /// A field that may not be what it is.
    #[error(transparent)]
    Invalid(#[from] Invalid),
    /// The network does not fit the model file.
    #[error(transparent)]
    Model(#[from] ModelFileError),
}

impl TfliteError {
    /// A field with an illegal value.
    fn value(field: impl Display, value: impl Display, legal: impl Display) -> Self {
        Invalid::new(field, value, legal).into()
    }
}

/// `Ok` if a field's value is legal.
fn require(good: bool, field: &str, value: impl Display, legal: &str) -> Result<(), TfliteError> {
    Ok(Invalid::unless(good, field, value, legal)?)
}

#[cfg(test)]
mod tests;
