//! The deep spectrogram network: its training, its quantisation to int8, its inference on the host, and its file formats' content.
//!
//! Paper, section V. What trains needs burn (the feature `train`).

#[cfg(feature = "train")]
pub mod backbone;
#[cfg(feature = "train")]
pub mod baselines;
#[cfg(feature = "train")]
pub mod burn_model;
pub mod calibration;
#[cfg(feature = "train")]
pub mod checkpoint;
pub mod early_exits;
pub mod evaluation;
pub mod float_network;
pub mod inference;
#[cfg(test)]
mod integer;
pub mod interchange;
pub mod memory;
pub mod parameters;
pub mod quantization;
#[cfg(feature = "train")]
pub mod recipe;
pub mod safetensors;
pub mod spectrograms;
#[cfg(test)]
pub(crate) mod synthetic;
#[cfg(feature = "train")]
pub mod training;
#[cfg(feature = "train")]
pub mod tuning;
