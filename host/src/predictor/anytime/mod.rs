//! Anytime sensing, learnt: how much each exit's logits count, and what a threshold brings.
//!
//! [`answers`] runs recordings through every exit's network, [`calibration`] fits the weights of evidence, [`policy`] plays
//! thresholds, [`gallery`] lets the core hear the gallery's recordings. What is stopped by is the core's own arithmetic ([`sdp3_core::early_exit`]).

pub mod answers;
pub mod calibration;
pub mod gallery;
pub mod policy;

pub use answers::{Answers, Part, collect};
pub use policy::Policy;
