//! A training that can go on where it stopped, with the same bits: parameters, optimiser, history.
//!
//! Floats are stored as their bits. Random numbers are functions of seed and epoch and need no state.

use super::parameters::{Architecture, Images, Parameters};
use crate::error::Invalid;
use crate::results::Epoch;
use crate::scenario::Learning;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use thiserror::Error;

/// What makes two trainings the same.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Identity {
    /// Shape of the network.
    pub architecture: Architecture,
    /// Settings of the training.
    pub settings: Learning,
    /// Seed of weights and shuffling.
    pub seed: u64,
    /// SHA-256 of the images and labels, in hexadecimal.
    pub images: String,
    pub backend: String,
}

impl Identity {
    pub fn new(
        architecture: Architecture,
        settings: &Learning,
        seed: u64,
        images: &Images,
        backend: &str,
    ) -> Identity {
        let mut hash = Sha256::new();
        hash.update((images.rows as u64).to_le_bytes());
        hash.update((images.frames as u64).to_le_bytes());
        hash.update(images.pixels.iter().map(|&p| p as u8).collect::<Vec<u8>>());
        hash.update(&images.labels);
        let images = hash.finalize().iter().map(|b| format!("{b:02x}")).collect();
        Identity { architecture, settings: settings.clone(), seed, images, backend: backend.into() }
    }
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Bits(String);

/// The best epoch on the validation set.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Best {
    /// Its number, from 0.
    pub epoch: usize,
    /// Its mean cross entropy on the validation set, in nats.
    pub loss: f64,
    /// The network after it.
    pub parameters: Bits,
}

/// A training after a number of epochs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Checkpoint {
    pub identity: Identity,
    pub epochs: Vec<Epoch>,
    pub parameters: Bits,
    /// The best so far, if there is a validation set.
    pub best: Option<Best>,
    /// State of the optimiser, a burnpack file in Base64.
    pub optimizer: String,
}

/// Why a checkpoint cannot be resumed from.
#[derive(Debug, Error, PartialEq)]
pub enum CheckpointError {
    /// A field that may not be what it is.
    #[error(transparent)]
    Invalid(#[from] Invalid),
    /// Its contents are damaged.
    #[error("{0} cannot be decoded")]
    Damaged(&'static str),
}

fn lists(p: &mut Parameters) -> Vec<&mut Vec<f32>> {
    let mut all = vec![&mut p.stem.weights, &mut p.stem.biases];
    for b in &mut p.blocks {
        for norm in [&mut b.norm1, &mut b.norm2] {
            all.extend([&mut norm.gamma, &mut norm.beta, &mut norm.mean, &mut norm.variance]);
        }
        all.extend([&mut b.conv1, &mut b.conv2.weights, &mut b.conv2.biases]);
    }
    all.extend([&mut p.head.weights, &mut p.head.biases]);
    all
}

impl Bits {
    pub fn new(parameters: &Parameters) -> Bits {
        let mut parameters = parameters.clone();
        let bytes: Vec<u8> =
            lists(&mut parameters).into_iter().flat_map(|l| l.iter().flat_map(|v| v.to_le_bytes())).collect();
        Bits(STANDARD.encode(bytes))
    }

    /// The network.
    ///
    /// # Errors
    ///
    /// [`CheckpointError::Damaged`] unless it has the architecture's size.
    pub fn parameters(&self, architecture: Architecture) -> Result<Parameters, CheckpointError> {
        let damaged = CheckpointError::Damaged("parameters");
        let Ok(bytes) = STANDARD.decode(&self.0) else { return Err(damaged) };
        let mut parameters = Parameters::initial(architecture, 0);
        let mut lists = lists(&mut parameters);
        if bytes.len() != 4 * lists.iter().map(|l| l.len()).sum::<usize>() {
            return Err(damaged);
        }
        let (values, _) = bytes.as_chunks::<4>();
        lists
            .iter_mut()
            .flat_map(|l| l.iter_mut())
            .zip(values)
            .for_each(|(v, &b)| *v = f32::from_le_bytes(b));
        Ok(parameters)
    }
}

impl Checkpoint {
    /// Whether it belongs to this training.
    ///
    /// # Errors
    ///
    /// [`CheckpointError::Invalid`] naming what differs, the architecture first.
    pub fn check(&self, wanted: &Identity) -> Result<(), CheckpointError> {
        let found = &self.identity;
        for (field, value, legal) in [
            ("architecture", json(&found.architecture), json(&wanted.architecture)),
            ("backend", json(&found.backend), json(&wanted.backend)),
            ("seed", json(&found.seed), json(&wanted.seed)),
            ("settings", json(&found.settings), json(&wanted.settings)),
            ("digest of the images", json(&found.images), json(&wanted.images)),
        ] {
            let legal_text = format!("{legal}; train without --resume to restart");
            Invalid::unless(value == legal, field, &value, legal_text)?;
        }
        Ok(())
    }
}

fn json(value: &impl Serialize) -> String {
    serde_json::to_string(value).unwrap_or_default()
}

/// Bytes as Base64.
pub(super) fn encode(bytes: &[u8]) -> String {
    STANDARD.encode(bytes)
}

/// Bytes from Base64.
pub(super) fn decode(text: &str) -> Result<Vec<u8>, CheckpointError> {
    STANDARD.decode(text).map_err(|_| CheckpointError::Damaged("optimizer"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::synthetic::{stripes, trained_looking};

    const SMALL: Architecture = Architecture { channels: 4, blocks: 2, stem_stride: 2, classes: 5 };

    #[test]
    fn parameters_keep_their_bits() {
        let parameters = trained_looking(SMALL, 3);
        let bits = Bits::new(&parameters);
        assert_eq!(bits.parameters(SMALL), Ok(parameters));
        let wider = Architecture { channels: 8, ..SMALL };
        assert_eq!(bits.parameters(wider), Err(CheckpointError::Damaged("parameters")));
    }

    #[test]
    fn another_training_is_refused_by_name() {
        let images = stripes(10, 1, 1);
        let identity = Identity::new(SMALL, &Learning::default(), 7, &images, "flex");
        let parameters = Bits::new(&trained_looking(SMALL, 3));
        let checkpoint = Checkpoint {
            identity: identity.clone(),
            epochs: vec![],
            parameters,
            best: None,
            optimizer: String::new(),
        };
        assert_eq!(checkpoint.check(&identity), Ok(()));
        let refusal = |wanted: &Identity| checkpoint.check(wanted).unwrap_err().to_string();
        let architecture = Architecture { channels: 8, ..SMALL };
        let wider = refusal(&Identity { architecture, seed: 8, ..identity.clone() });
        assert!(wider.starts_with("architecture is {\"channels\":4,"), "{wider}");
        assert!(wider.contains("must be {\"channels\":8,"), "{wider}");
        let reseeded = refusal(&Identity { seed: 8, ..identity.clone() });
        assert!(reseeded.starts_with("seed is 7, must be 8"), "{reseeded}");
    }
}
