//! What outlives a reset.

use sdp3_core::scheduler::{PeriodCounts, Plan, Sequencer, SlotUse};

/// What the slot context keeps from slot to slot, and over a reset.
#[derive(Clone)]
pub(in crate::campaign) struct Kept {
    pub sequencer: Sequencer,
    pub counts: PeriodCounts,
    pub period: u32,
    /// Sensing slots of the period so far.
    pub sensing_slots: u32,
    pub last: SlotUse,
    /// Whether there is no plan and slots stay idle.
    pub unplanned: bool,
    /// Number of the next slot.
    pub next: u32,
}

impl Kept {
    pub fn new(plan: &Plan, unplanned: bool, next: u32) -> Self {
        let (sequencer, counts) = (Sequencer::new(plan), PeriodCounts::default());
        Kept { sequencer, counts, period: 0, sensing_slots: 0, last: SlotUse::Idle, unplanned, next }
    }
}
