//! A model file in words and as JSON: its envelope, the memory it needs, and what its network does.

use super::QuantizedNetwork;
use super::read::header;
use crate::formats::graph_file::GraphSummary;
use schemars::JsonSchema;
use sdp3_core::dsn::{Model, ModelError};
use sdp3_core::graph::Graph;
use sdp3_core::graph::format::MAGIC;
use serde::Serialize;

/// What a model file says of itself.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Summary {
    /// Version of the layout.
    pub version: u16,
    /// Bytes of the file.
    pub bytes: usize,
    /// CRC-32 of all but itself.
    pub checksum: String,
    /// Its revision, which only grows.
    pub revision: u32,
    /// Whether it carries a signature.
    pub signed: bool,
    /// Bytes of scratch its network needs.
    pub scratch_bytes: usize,
    /// Bytes of all memory that the radar module borrows for it.
    pub required_bytes: usize,
    /// The network in words.
    pub network: String,
    /// Its operators, if it is a graph and not the paper's network.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub graph: Option<GraphSummary>,
}

/// What `model show` shows: of a model file or of a graph of its own.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Shown {
    /// A model file.
    Model(Summary),
    /// A graph.
    Graph(GraphSummary),
}

impl Shown {
    /// Of a file's bytes.
    ///
    /// # Errors
    /// What the radar module's parser finds wrong.
    pub fn of(bytes: &[u8]) -> Result<Self, ModelError> {
        match bytes.starts_with(&MAGIC) {
            true => Graph::parse(bytes).map(|graph| Shown::Graph(GraphSummary::of(&graph))),
            false => Summary::of(bytes).map(Shown::Model),
        }
    }

    /// In words.
    pub fn describe(&self) -> String {
        match self {
            Shown::Model(summary) => summary.describe(),
            Shown::Graph(graph) => format!("graph: {}", graph.describe().trim_end()),
        }
    }
}

impl Summary {
    /// Of a file's bytes; by whom it is signed is [`ModelCheck`]'s matter.
    ///
    /// # Errors
    /// What the radar module's parser finds wrong.
    pub fn of(bytes: &[u8]) -> Result<Self, ModelError> {
        let model = Model::parse(bytes)?;
        let network = match model.graph() {
            None => QuantizedNetwork::from_bytes(bytes)?.describe(),
            Some(_) => graph_words(bytes, &model)?,
        };
        let shape = model.shape();
        let checksum = bytes.last_chunk::<4>().map_or(0, |last| u32::from_le_bytes(*last));
        Ok(Summary {
            version: super::VERSION,
            bytes: bytes.len(),
            checksum: format!("{checksum:08x}"),
            revision: model.revision(),
            signed: model.is_signed(),
            scratch_bytes: shape.scratch_bytes(),
            required_bytes: shape.required_bytes(),
            network,
            graph: model.graph().map(GraphSummary::of),
        })
    }

    /// In words.
    pub fn describe(&self) -> String {
        let graph = self.graph.as_ref().map(GraphSummary::describe).unwrap_or_default();
        let signature = if self.signed { "signed" } else { "not signed" };
        format!(
            "model file, version {}, revision {}, {} bytes, checksum {} holds, {signature}\n{}{graph}memory: {} bytes, {} of them scratch of the network",
            self.version,
            self.revision,
            self.bytes,
            self.checksum,
            self.network,
            self.required_bytes,
            self.scratch_bytes
        )
    }
}

/// A model with a graph in words, but for its operators.
fn graph_words(bytes: &[u8], model: &Model<'_>) -> Result<String, ModelError> {
    let classes: Vec<&str> = (0..model.classes()).map(|class| model.class_name(class)).collect();
    let preprocessing = header(bytes).ok_or(ModelError::Magic)?.preprocessing.describe();
    Ok(format!("graph, {} classes: {}\n{preprocessing}", classes.len(), classes.join(", ")))
}

/// What firmware built with a public key answers to a model file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct ModelCheck {
    /// Whether it would run the model.
    pub accepted: bool,
    /// Its revision, if it is accepted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub revision: Option<u32>,
    /// Why it is refused, if it is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub refused: Option<String>,
}

impl ModelCheck {
    /// On a file's bytes, by the radar module's own parser with this key and the largest revision it has run.
    pub fn of(bytes: &[u8], key: &[u8; 32], oldest: u32) -> Self {
        match Model::parse_signed(bytes, key, oldest) {
            Ok(model) => ModelCheck { accepted: true, revision: Some(model.revision()), refused: None },
            Err(error) => ModelCheck { accepted: false, revision: None, refused: Some(error.to_string()) },
        }
    }

    /// In words.
    pub fn describe(&self) -> String {
        match (&self.refused, self.revision) {
            (Some(reason), _) => format!("refused: {reason}"),
            (None, revision) => format!("accepted: revision {}", revision.unwrap_or_default()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::signature::{public_key, sign};
    use super::super::tests::network;
    use super::*;

    #[test]
    fn the_words_tell_envelope_memory_and_network() {
        let plain = network().to_bytes().unwrap();
        let text = Summary::of(&plain).unwrap().describe();
        for part in ["version 1, revision 0", "not signed", "memory: ", "200 sensing slots", "block 1 conv2"]
        {
            assert!(text.contains(part), "{part} missing in {text}");
        }
    }

    #[test]
    fn a_verdict_is_what_firmware_says() {
        let plain = network().to_bytes().unwrap();
        let signed = sign(&plain, [1; 32], 3).unwrap();
        let say =
            |bytes: &[u8], seed, oldest| ModelCheck::of(bytes, &public_key([seed; 32]), oldest).describe();
        assert_eq!(say(&signed, 1, 3), "accepted: revision 3");
        for (answer, reason) in [
            (say(&signed, 2, 0), "its signature does not belong to this key"),
            (say(&signed, 1, 4), "revision 3 is a rollback"),
            (say(&plain, 1, 0), "not signed"),
            (say(&signed[..90], 1, 0), "truncated"),
        ] {
            assert!(answer.starts_with("refused: ") && answer.contains(reason), "{answer}");
        }
    }
}
