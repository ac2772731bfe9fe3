//! Early exits, trained: the weight of each exit's logits, and the effect of a threshold.
//!
//! Of the logits of every exit's network ([`super::evaluation`]) [`calibration`] fits the weights of evidence, [`policy`] plays
//! thresholds, [`gallery`] says where the gallery's recordings stop. Evidence and decision are the core's own arithmetic
//! ([`sdp3_core::early_exit`]).

pub(crate) mod calibration;
pub(crate) mod gallery;
pub(crate) mod policy;

pub use policy::Policy;
