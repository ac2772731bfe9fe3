//! A model file in words and as JSON: its envelope, the memory it needs, and what its network does.

use super::QuantizedNetwork;
use super::signature::read_key;
use schemars::JsonSchema;
use sdp3_core::dsn::{Model, ModelError};
use serde::Serialize;
use std::path::Path;

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
    /// Whether the signature is the given key's; absent if none was given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub signature_holds: Option<bool>,
    /// Bytes of scratch its network needs.
    pub scratch_bytes: usize,
    /// Bytes of all memory a receiver borrows for it.
    pub required_bytes: usize,
    /// The network in words.
    pub network: String,
}

impl Summary {
    /// Of a file's bytes, its signature held to a public key if one is given.
    ///
    /// # Errors
    /// What the radar module's parser finds wrong; a signature that does not hold is no error here.
    pub fn of(bytes: &[u8], key: Option<&[u8; 32]>) -> Result<Self, ModelError> {
        let model = Model::parse(bytes)?;
        let network = QuantizedNetwork::from_bytes(bytes)?.describe();
        let shape = model.shape();
        let checksum = bytes.last_chunk::<4>().map_or(0, |last| u32::from_le_bytes(*last));
        Ok(Summary {
            version: super::VERSION,
            bytes: bytes.len(),
            checksum: format!("{checksum:08x}"),
            revision: model.revision(),
            signed: model.is_signed(),
            signature_holds: key.map(|key| Model::parse_signed(bytes, key, 0).is_ok()),
            scratch_bytes: shape.scratch_bytes(),
            required_bytes: shape.required_bytes(),
            network,
        })
    }

    /// Of a file, its signature held to the key in another.
    ///
    /// # Errors
    /// Names the file that cannot be read or is no model, or no key.
    pub fn read(file: &Path, key: Option<&Path>) -> Result<Self, Box<dyn std::error::Error + Send + Sync>> {
        let key = key.map(read_key).transpose()?;
        let name = file.display();
        let bytes = std::fs::read(file).map_err(|error| format!("{name}: {error}"))?;
        Ok(Self::of(&bytes, key.as_ref()).map_err(|error| format!("{name}: {error}"))?)
    }

    /// In words.
    pub fn describe(&self) -> String {
        let signature = match (self.signed, self.signature_holds) {
            (false, _) => "not signed",
            (true, None) => "signed (give --key to check by whom)",
            (true, Some(true)) => "signed with the given key",
            (true, Some(false)) => "signed, but not with the given key or not for this content",
        };
        format!(
            "model file, version {}, revision {}, {} bytes, checksum {} holds, {signature}\n{}memory: {} bytes, {} of them scratch of the network",
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

#[cfg(test)]
mod tests {
    use super::super::signature::{public_key, sign};
    use super::super::tests::network;
    use super::*;

    #[test]
    fn the_words_tell_envelope_memory_and_network() {
        let plain = network().to_bytes().unwrap();
        let text = Summary::of(&plain, None).unwrap().describe();
        for part in ["version 1, revision 0", "not signed", "memory: ", "200 sensing slots", "block 1 conv2"]
        {
            assert!(text.contains(part), "{part} missing in {text}");
        }
        let signed = sign(&plain, [1; 32], 3).unwrap();
        let holds = |seed| Summary::of(&signed, Some(&public_key([seed; 32]))).unwrap().signature_holds;
        assert_eq!((holds(1), holds(2)), (Some(true), Some(false)));
    }
}
