//! Which slot is for what: sensing slots exactly periodic, the others in optimal proportions, spread evenly.
//!
//! Section II of the paper: slot j of a period senses iff j mod (N_m + 1) = 1 and j <= N_s (N_m + 1). [`layout`] says where
//! those lie, [`plan`] how many slots each use gets ([`mod@apportion`]), [`sequencer`] what the next slot is for (`slot_order`),
//! [`planner`] which plan comes next when rates, users or losses change; [`scheduler`] is both in one.

pub mod apportion;
pub mod layout;
pub mod plan;
pub mod planner;
#[allow(clippy::module_inception)]
pub mod scheduler;
pub mod sequencer;
mod slot_order;

pub use apportion::apportion;
pub use layout::{PlanError, SensingLayout, USERS};
pub use plan::Plan;
pub use planner::{Changes, PeriodCounts, PeriodReport, Planner};
pub use scheduler::Scheduler;
pub use sequencer::{Sequencer, SlotUse};
