//! A training that can go on where it stopped, with the same bits: parameters, optimiser, history. Its file is a record
//! ([`crate::store::record`]) that belongs to an [`identity`].
//!
//! Floats are stored as their bits. Random numbers are functions of seed and epoch and need no state.

use super::parameters::{Architecture, Images, Parameters};
use crate::results::Epoch;
use crate::scenario::Learning;
use crate::store::digest::sha256;
use crate::store::record::{Identity, value};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// What makes two trainings the same; the architecture first.
pub fn identity(
    architecture: Architecture,
    settings: &Learning,
    seed: u64,
    images: &Images,
    backend: &str,
) -> Identity {
    let pixels: Vec<u8> = images.pixels.iter().map(|&p| p as u8).collect();
    let [rows, frames] = [images.rows, images.frames].map(|n| (n as u64).to_le_bytes());
    let images = sha256([&rows[..], &frames, &pixels, &images.labels]);
    vec![
        ("architecture", value(&architecture)),
        ("backend", value(&backend)),
        ("seed", value(&seed)),
        ("settings", value(settings)),
        ("images_sha256", value(&images)),
    ]
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
    pub epochs: Vec<Epoch>,
    pub parameters: Bits,
    /// The best so far, if there is a validation set.
    pub best: Option<Best>,
    /// State of the optimiser, a burnpack file in Base64.
    pub optimizer: String,
}

/// What of a checkpoint cannot be decoded.
#[derive(Debug, Error, PartialEq)]
#[error("{0} cannot be decoded")]
pub struct Undecodable(pub &'static str);

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
    /// [`Undecodable`] unless it has the architecture's size.
    pub fn parameters(&self, architecture: Architecture) -> Result<Parameters, Undecodable> {
        let damaged = Undecodable("parameters");
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

/// Bytes as Base64.
pub(super) fn encode(bytes: &[u8]) -> String {
    STANDARD.encode(bytes)
}

/// Bytes from Base64.
pub(super) fn decode(text: &str) -> Result<Vec<u8>, Undecodable> {
    STANDARD.decode(text).map_err(|_| Undecodable("optimizer"))
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
        assert_eq!(bits.parameters(wider), Err(Undecodable("parameters")));
    }

    #[test]
    fn a_training_is_known_by_architecture_seed_and_images() {
        let of = |architecture, seed, images: &Images| {
            identity(architecture, &Learning::default(), seed, images, "cpu")
        };
        let usual = of(SMALL, 7, &stripes(10, 1, 1));
        assert_eq!(usual, of(SMALL, 7, &stripes(10, 1, 1)));
        let wider = Architecture { channels: 8, ..SMALL };
        for (other, field) in [
            (of(wider, 7, &stripes(10, 1, 1)), "architecture"),
            (of(SMALL, 8, &stripes(10, 1, 1)), "seed"),
            (of(SMALL, 7, &stripes(10, 1, 2)), "images_sha256"),
        ] {
            let different: Vec<_> =
                usual.iter().zip(&other).filter(|(a, b)| a != b).map(|(a, _)| a.0).collect();
            assert_eq!(different, [field]);
        }
    }
}
