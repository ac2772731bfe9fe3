//! What stands between the radar module and a world that fails.
//!
//! | fault | found by | answer |
//! |---|---|---|
//! | slots skipped, repeated, late; a counter that wraps or jumps | [`watch`]: the radio numbers its slots | played through as lost, given again, refused; else a new period |
//! | a bit of the schedule's memory flips | [`watch`]: a seal over all its words | a new period from a sealed spare |
//! | a reset in any slot | [`watch`]: the state kept in memory that survives | goes on; without it a new period |
//! | a converter that saturates, sticks, is silent or off its zero | [`health`] | the slot counts as lost |
//! | a bit of a model flips | [`intact`]: the checksum taken when it was accepted | it is not run |
//!
//! Every fault is told once; the next whole period is as if it had not been. [`station::Guarded`] is the slot loop with all of it,
//! [`campaign`] breaks it on purpose, with a known number of outcomes on every processor.

pub mod campaign;
pub mod health;
pub mod intact;
pub mod station;
pub mod watch;

pub use health::SampleFault;
pub use intact::Intact;
pub use station::Guarded;
pub use watch::{Fault, Step, Watch};
