//! Supervision: what finds the faults of slot numbers, memory, samples and models, inside the two contexts of a radar module.
//!
//! | fault | found by | answer |
//! |---|---|---|
//! | slots skipped, repeated, late; a counter that wraps or restarts | the radio numbers its slots: [`SlotContext::begin`] | played through as lost, given again, refused; else a new period |
//! | a bit of the schedule's memory flips | a checksum over all words of [`retained`] | the copy of one slot before, played on |
//! | a bit of a plan flips that waits for its period | the same checksum | the running plan goes on until another has been sent |
//! | a reset in any slot | [`retained`] memory that start-up leaves alone | goes on after the slots skipped meanwhile; without it a new period |
//! | a converter that saturates, sticks, is silent or offset | [`sample_health`] | the slot is not used, the recording restarts |
//! | a bit of a model flips | its CRC-32 after every recognition, spread over polls | the classification is not given |
//!
//! Every fault is reported once, by [`ProcessingContext::poll`]; the next whole period is unaffected.
//!
//! [`SlotContext::begin`]: crate::radar::SlotContext::begin
//! [`ProcessingContext::poll`]: crate::radar::ProcessingContext::poll

pub mod retained;
pub mod sample_health;

use crate::dsn::ModelError;
pub use sample_health::SampleFault;

/// What went wrong. Reported once.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Fault {
    /// Numbers were skipped; the slots are lost to those they were planned for.
    SlotsSkipped {
        /// Slots.
        slots: u32,
        /// Those of them that were to sense.
        sensing: u32,
    },
    /// More numbers were skipped than are played through, or the rest of the period: a new period begins.
    Outage {
        /// Slots.
        slots: u32,
    },
    /// The number of the slot before: its use is given again.
    SlotRepeated,
    /// A number that was given before: the slot stays idle.
    SlotLate,
    /// The radio counts from another number: a new period begins.
    CounterReset,
    /// The schedule's memory had changed: it goes on from the copy of the slot before.
    StateRepaired,
    /// Both copies had changed: slots stay idle until the processing context has sent a plan, then a new period begins.
    StateLost,
    /// A plan had changed on its way to the slot interrupt: the running one goes on until another has been sent.
    PlanDamaged,
    /// A sensing slot's samples did not come before the next slot.
    MissingSamples,
    /// Samples that no slot waits for. They are not used.
    UnexpectedSamples,
    /// No buffer was free: the sensing slot is lost.
    Overrun,
    /// Samples that cannot be trusted: they are not used.
    Samples(SampleFault),
    /// A model has changed in memory: its classification is not given.
    Model(ModelError),
    /// So many reports were lost because nobody polled.
    ReportsLost(u32),
}
