//! Who gets which slot: sensing slots exactly periodic, the others in optimal proportions, spread evenly.
//!
//! Section II of the paper: slot j of a period senses iff j mod (N_m + 1) = 1 and j <= N_s (N_m + 1). [`sensing`] lays
//! those out, [`plan`] says how many slots each use gets ([`mod@apportion`]), [`sequencer`] which slot is whose ([`turns`]),
//! [`scheduler`] what to do when the world changes.

pub mod apportion;
pub mod layout;
pub mod plan;
pub mod scheduler;
pub mod sequencer;
pub mod slot_order;

pub use apportion::apportion;
pub use layout::{PlanError, RECEIVERS, Sensing};
pub use plan::Plan;
pub use scheduler::{Boundary, Changes, Scheduler};
pub use sequencer::{Sequencer, SlotUse};
