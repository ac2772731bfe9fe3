//! The deep spectrogram network: its training, its quantisation to int8, its inference on the host, and its file formats' content.
//!
//! Paper, section V. What trains needs burn (the feature `train`).

#[cfg(feature = "train")]
pub(crate) mod backbone;
#[cfg(feature = "train")]
pub(crate) mod baselines;
#[cfg(feature = "train")]
pub(crate) mod burn_model;
pub(crate) mod calibration;
#[cfg(feature = "train")]
pub(crate) mod checkpoint;
pub mod classify;
pub(crate) mod early_exits;
pub(crate) mod evaluation;
pub(crate) mod float_network;
pub mod inference;
#[cfg(test)]
mod integer;
pub mod interchange;
pub mod memory;
pub mod operator_outputs;
pub mod parameters;
pub mod quantization;
#[cfg(feature = "train")]
pub(crate) mod recipe;
pub mod retest;
pub mod safetensors;
pub(crate) mod sample_supervision;
pub(crate) mod score;
pub(crate) mod spectrograms;
#[cfg(test)]
pub(crate) mod synthetic;
#[cfg(feature = "train")]
pub mod training;
#[cfg(feature = "train")]
pub(crate) mod tuning;
#[cfg(feature = "train")]
pub(crate) mod unknown;
mod vector_stft;
