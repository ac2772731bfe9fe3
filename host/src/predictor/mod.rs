//! The predictor: learn to recognise motions from spectrograms, carry the network over to int8, predict accuracy.
//!
//! Paper, section V. `network`, `training`, `backbone` and `tuning` need burn (the feature `train`).
pub mod accuracy;
pub mod anytime;
#[cfg(feature = "train")]
pub mod backbone;
#[cfg(feature = "train")]
pub mod baselines;
pub mod calibration;
#[cfg(feature = "train")]
pub mod checkpoint;
pub mod float_network;
#[cfg(test)]
mod integer;
pub mod interchange;
pub mod learning_curve;
pub mod memory;
#[cfg(feature = "train")]
pub mod network;
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
