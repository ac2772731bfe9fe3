//! Early exits, trained: the weight of each exit's logits, and the effect of a threshold.
//!
//! [`exit_logits`] runs recordings through every exit's network, [`calibration`] fits the weights of evidence, [`policy`] plays
//! thresholds, [`gallery`] classifies the gallery's recordings with the core. The decision to
//! stop is the core's own arithmetic ([`sdp3_core::early_exit`]).

pub mod calibration;
pub mod exit_logits;
pub mod gallery;
pub mod policy;

pub use exit_logits::{ExitLogits, Part, collect};
pub use policy::Policy;
