//! The slot interrupt: what the next slot is for, whatever numbers the radio gives and whatever bits have flipped.
//!
//! Slot numbers grow by one a slot and wrap after 2^32. The whole state lies in [`Retained`] between two calls.

use super::memory::SlotEnds;
use super::{Filled, Report, SlotBuffer, Totals};
use crate::scheduler::{PeriodCounts, Plan, Sequencer, SlotUse};
use crate::supervision::Fault;
use crate::supervision::retained::{Loaded, Message, Retained, State, flag};
use core::sync::atomic::Ordering;

/// Most skipped slots that are played through, so that a call stays short; after more a new period begins.
pub const CATCH_UP: u32 = 8;

/// What a slot is for.
#[derive(Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SlotAction<'a, const VALUES: usize> {
    /// The radar sweeps: its samples belong into this buffer, and [`SlotContext::samples_ready`] follows before the next slot.
    Sense(&'a mut SlotBuffer<VALUES>),
    /// Downlink to this user.
    Serve(u8),
    /// Nothing.
    Idle,
}

/// What is remembered from slot to slot.
#[derive(Debug, Clone)]
struct SlotState {
    sequencer: Sequencer,
    counts: PeriodCounts,
    period: u32,
    sensed: u32,
    last: SlotUse,
    next: u32,
    /// A number out of order that the next one may go on from.
    other: u32,
    resync_pending: bool,
    unplanned: bool,
}

impl State for SlotState {
    fn words(&mut self, visit: &mut impl FnMut(&mut u32)) {
        self.sequencer.words(visit);
        self.counts.words(visit);
        [&mut self.period, &mut self.sensed].into_iter().for_each(&mut *visit);
        self.last.words(visit);
        [&mut self.next, &mut self.other].into_iter().for_each(&mut *visit);
        flag(&mut self.resync_pending, visit);
        flag(&mut self.unplanned, visit);
    }
}

impl SlotState {
    /// A period of this plan begins with the next slot. Its number is not known yet.
    fn new(plan: &Plan) -> Self {
        SlotState {
            sequencer: Sequencer::new(plan),
            counts: PeriodCounts::default(),
            period: 0,
            sensed: 0,
            last: SlotUse::Idle,
            next: 0,
            other: 0,
            resync_pending: false,
            unplanned: false,
        }
    }
}

/// A sensing slot that waits for its samples.
#[derive(Debug, Clone, Copy)]
struct Pending {
    number: u32,
    period: u32,
    index: u32,
    left: u32,
}

/// The slot interrupt's side of a radar module.
///
/// All calls of one slot together take at most 2500 instructions on a Cortex-M4F.
pub struct SlotContext<const VALUES: usize> {
    ends: SlotEnds<VALUES>,
    retained: &'static Retained,
    /// What [`SlotContext::begin`] works on; between two calls the copies in `retained` count.
    state: SlotState,
    sequence: u32,
    /// Number of the running period, should both copies be lost: none is taken for one before.
    period: u32,
    /// Number of the slot after the one given last; `None` before the first: it is the radio's.
    expected: Option<u32>,
    /// Whether the plan at the head of its queue has begun; it is kept until the state that plays it has been read back.
    plan_begun: bool,
    /// Whether the totals at the head of theirs have been used, likewise.
    totals_used: bool,
    plan_requested: bool,
    buffer: Option<&'static mut SlotBuffer<VALUES>>,
    pending: Option<Pending>,
    reports_lost: u32,
}

impl<const VALUES: usize> SlotContext<VALUES> {
    /// Goes on from what survived a reset, else begins a period of `plan` with the first slot.
    pub(super) fn new(mut ends: SlotEnds<VALUES>, retained: &'static Retained, plan: &Plan) -> Self {
        let mut state = SlotState::new(plan);
        let (sequence, expected) = match retained.load(None, &mut state) {
            Loaded::Newest(sequence) | Loaded::Previous(sequence) if !state.unplanned => {
                // the running plan may be of other settings, or give slots back
                let _ = ends.reports.enqueue(Report::PlanNeeded); // the first report
                (sequence, Some(state.next))
            }
            _ => {
                state = SlotState::new(plan);
                (0, None)
            }
        };
        retained.save(sequence, &mut state);
        SlotContext {
            ends,
            retained,
            state,
            sequence,
            period: 0,
            expected,
            plan_begun: false,
            totals_used: false,
            plan_requested: false,
            buffer: None,
            pending: None,
            reports_lost: 0,
        }
    }

    /// The use of the slot that the radio gives this number.
    ///
    /// Cost: two passes over 83 words and O(K) for each slot played; after skipped slots at most eight more.
    pub fn begin(&mut self, number: u32) -> SlotAction<'_, VALUES> {
        let repaired = self.load();
        if self.expected.is_none() {
            self.state.next = number;
        }
        if self.state.unplanned && !self.find_plan(number) {
            return SlotAction::Idle;
        }
        let gap = number.wrapping_sub(self.state.next);
        let resync = self.state.resync_pending;
        if gap == u32::MAX && !resync {
            if repaired {
                self.save();
            }
            return self.repeat(number);
        }
        if gap >= 1 << 31 && !(resync && number == self.state.other) {
            self.report(Report::Fault(Fault::SlotLate));
            (self.state.resync_pending, self.state.other) = (true, number.wrapping_add(1));
            self.save();
            return SlotAction::Idle;
        }
        if self.pending.take().is_some() {
            self.report(Report::Fault(Fault::MissingSamples));
            self.state.counts.on_lost(SlotUse::Sensing);
        }
        if gap >= 1 << 31 {
            self.report(Report::Fault(Fault::CounterReset));
            self.state.sequencer.restart(None);
        } else if gap > 0 {
            self.skip(gap, if repaired { 0 } else { CATCH_UP });
        }
        self.state.resync_pending = false;
        self.state.next = number;
        let slot = self.play(true);
        let sensing = slot == SlotUse::Sensing;
        if sensing && self.buffer.is_none() {
            self.buffer = self.ends.free.dequeue();
        }
        if sensing && self.buffer.is_some() {
            let (period, index) = (self.state.period, self.state.sensed.wrapping_sub(1));
            let left = self.state.sequencer.sensing_left();
            self.pending = Some(Pending { number, period, index, left });
        } else if sensing {
            self.report(Report::Fault(Fault::Overrun));
            self.state.counts.on_lost(slot);
            self.state.last = SlotUse::Idle; // so that it is not counted again
        }
        self.save();
        self.action(slot)
    }

    /// The samples of the slot that [`SlotContext::begin`] gave last are in its buffer.
    pub fn samples_ready(&mut self) {
        // if nothing waits the buffer stays for the next slot
        let waiting = self.pending.take().and_then(|pending| Some((pending, self.buffer.take()?)));
        let Some((pending, buffer)) = waiting else {
            self.report(Report::Fault(Fault::UnexpectedSamples));
            return;
        };
        let Pending { period, index, left, .. } = pending;
        if let Err(filled) = self.ends.filled.enqueue(Filled { period, index, left, buffer }) {
            self.buffer = Some(filled.buffer); // there are as many places as buffers
        }
    }

    /// The slot that [`SlotContext::begin`] gave last was lost or pre-empted.
    pub fn lost(&mut self) {
        self.load();
        let last = core::mem::replace(&mut self.state.last, SlotUse::Idle);
        self.state.counts.on_lost(last);
        self.pending = None;
        self.save();
    }

    /// Slot by slot the running period so far, 0..N.
    pub fn position(&self) -> u32 {
        self.state.sequencer.position()
    }

    /// The plan that waits to begin, or has just begun: for a debugger, and for tests that change it.
    pub fn waiting_plan(&self) -> Option<&Plan> {
        self.ends.plans.peek().map(Message::state)
    }

    fn action(&mut self, slot: SlotUse) -> SlotAction<'_, VALUES> {
        match (slot, &mut self.buffer) {
            (SlotUse::Sensing, Some(buffer)) if self.pending.is_some() => SlotAction::Sense(buffer),
            (SlotUse::Communication(user), _) => SlotAction::Serve(user),
            _ => SlotAction::Idle,
        }
    }

    /// The number of the slot before: its use once more.
    fn repeat(&mut self, number: u32) -> SlotAction<'_, VALUES> {
        self.report(Report::Fault(Fault::SlotRepeated));
        let waiting = self.pending.is_some_and(|pending| pending.number == number);
        let last = self.state.last;
        self.action(if last == SlotUse::Sensing && !waiting { SlotUse::Idle } else { last })
    }

    /// Reads the state; a damaged one is answered at once. Whether it was.
    fn load(&mut self) -> bool {
        match self.retained.load(Some(self.sequence), &mut self.state) {
            Loaded::Newest(_) => {
                if core::mem::take(&mut self.plan_begun) {
                    self.ends.plans.dequeue();
                }
                if core::mem::take(&mut self.totals_used) {
                    self.ends.totals.dequeue();
                }
                return false;
            }
            Loaded::Previous(_) => {
                self.report(Report::Fault(Fault::StateRepaired));
                // the slots that the damaged copy had played
                (self.plan_begun, self.totals_used) = (false, false);
                let behind = self.expected.map_or(0, |expected| expected.wrapping_sub(self.state.next));
                for _ in 0..behind.min(CATCH_UP + 1) {
                    self.play(false);
                }
            }
            Loaded::Nothing => {
                self.report(Report::Fault(Fault::StateLost));
                self.state = SlotState { period: self.period, ..SlotState::new(&Plan::IDLE) };
                (self.state.unplanned, self.plan_requested) = (true, false);
                (self.plan_begun, self.totals_used) = (false, false);
                (self.pending, self.expected) = (None, None);
                self.ends.release.store(0, Ordering::Relaxed);
            }
        }
        true
    }

    fn save(&mut self) {
        (self.expected, self.period) = (Some(self.state.next), self.state.period);
        self.sequence = self.sequence.wrapping_add(1);
        self.retained.save(self.sequence, &mut self.state);
    }

    /// Begins with the plan that processing has sent; false while there is none.
    fn find_plan(&mut self, number: u32) -> bool {
        self.check_plan();
        if self.ends.plans.ready() {
            (self.state.unplanned, self.state.next) = (false, number);
            return true;
        }
        if !self.plan_requested {
            self.plan_requested = self.ends.reports.enqueue(Report::PlanNeeded).is_ok();
        }
        self.state.next = number.wrapping_add(1);
        self.save();
        false
    }

    /// Asks for another plan in place of one that has changed on its way.
    fn check_plan(&mut self) {
        if self.ends.plans.peek().is_some_and(|plan| !plan.is_intact()) {
            self.ends.plans.dequeue();
            self.report(Report::Fault(Fault::PlanDamaged));
            self.report(Report::PlanNeeded);
        }
    }

    /// Plays skipped slots as lost, at most `catch_up`; after more a new period begins.
    fn skip(&mut self, slots: u32, catch_up: u32) {
        let sequencer = &mut self.state.sequencer;
        // between periods none of the next one has been played
        if slots > catch_up || slots >= sequencer.plan().period().saturating_sub(sequencer.position()) {
            sequencer.restart(None);
            return self.report(Report::Fault(Fault::Outage { slots }));
        }
        let mut sensing = 0;
        for _ in 0..slots.min(CATCH_UP) {
            let slot = self.play(true);
            sensing += u32::from(slot == SlotUse::Sensing);
            self.state.counts.on_lost(slot);
        }
        self.report(Report::Fault(Fault::SlotsSkipped { slots, sensing }));
    }

    /// The use of the next slot; a period's first one begins the plan that waits. `fresh` unless the slot has been played before.
    fn play(&mut self, fresh: bool) -> SlotUse {
        if self.state.sequencer.position() == 0 && !self.plan_begun {
            self.check_plan();
        }
        let state = &mut self.state;
        if state.sequencer.position() == 0 {
            let plan = self.ends.plans.peek().filter(|_| !self.plan_begun);
            let replanned = plan.is_some() || state.period == 0;
            if let Some(plan) = plan {
                state.sequencer.restart(Some(plan.state()));
                self.plan_begun = true;
            }
            let counts = core::mem::take(&mut state.counts);
            state.period = state.period.wrapping_add(1);
            state.sensed = 0;
            let period = state.period;
            if fresh {
                self.report(Report::Period { period, replanned, counts });
            }
        } else if self.ends.release.load(Ordering::Acquire) == state.period
            && let released @ 1.. = state.sequencer.release_sensing()
        {
            state.counts.released = state.counts.released.wrapping_add(released);
            let (period, rest, served) = (state.period, state.sequencer.rest(), state.sequencer.served());
            self.report(Report::Released { period, rest, served });
        } else if let Some(Totals { period, totals }) = self.ends.totals.peek().filter(|_| !self.totals_used)
        {
            self.totals_used = true;
            if *period == state.period {
                state.sequencer.reassign(totals);
            }
        }
        let state = &mut self.state;
        let slot = state.sequencer.next_slot();
        state.sensed = state.sensed.wrapping_add(u32::from(slot == SlotUse::Sensing));
        state.next = state.next.wrapping_add(1);
        state.last = slot;
        slot
    }

    fn report(&mut self, report: Report) {
        if self.reports_lost > 0 {
            let lost = Report::Fault(Fault::ReportsLost(self.reports_lost));
            if self.ends.reports.enqueue(lost).is_ok() {
                self.reports_lost = 0;
            }
        }
        if self.ends.reports.enqueue(report).is_err() {
            self.reports_lost = self.reports_lost.saturating_add(1);
        }
    }
}
