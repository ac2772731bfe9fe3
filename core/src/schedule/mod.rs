//! Who gets which slot: sensing slots exactly periodic, the others shared by smooth weighted round robin.
//!
//! Section II of the paper: slot j of a period senses iff j mod (N_m + 1) = 1 and j <= N_s (N_m + 1).

pub mod plan;
pub mod sequencer;

pub use plan::{Plan, PlanError, RECEIVERS, apportion};
pub use sequencer::{Sequencer, SlotUse};
