//! The reference: every stage of the core written again, plainly, from its definition alone.
//!
//! Shares no code and no table with the core. Integer stages are exact; float stages are f64. Slow and obvious
//! on purpose: direct sums, tables from `cos`, whole periods in a `Vec`.

pub(crate) mod network;
pub(crate) mod schedule;
pub(crate) mod signal;

pub use network::{ReferenceOutput, infer};
