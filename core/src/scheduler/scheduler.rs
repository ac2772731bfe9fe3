//! Planner and sequencer in one object, for simulations and for radios that need no second context.
//!
//! Within a period the plan stands: its slots add up, sensing slots stay exactly periodic, waits stay bounded. The one thing that
//! may happen earlier is that sensing ends ([`Scheduler::end_sensing`]): then the users get the rest of the period at once.

use super::layout::{SensingLayout, USERS};
use super::plan::Plan;
use super::planner::{Changes, PeriodCounts, PeriodReport, Planner};
use super::sequencer::{Sequencer, SlotUse};

/// A running schedule.
#[derive(Debug, Clone)]
pub struct Scheduler {
    planner: Planner,
    sequencer: Sequencer,
    counts: PeriodCounts,
    period_index: u32,
    report: PeriodReport,
    last: SlotUse,
}

impl Scheduler {
    /// Plays optimal plans: sensing slots as laid out, the others shared by `rates` (bits a slot, 0 for an absent user).
    pub fn new(layout: SensingLayout, rates: [u32; USERS]) -> Self {
        let planner = Planner::new(layout, rates);
        Scheduler {
            sequencer: Sequencer::new(&planner.first_plan()),
            planner,
            counts: PeriodCounts::default(),
            period_index: 0,
            report: PeriodReport { period: 0, replanned: true, changes: Changes::default() },
            last: SlotUse::Idle,
        }
    }

    /// Target and rates of the plans.
    pub fn planner(&self) -> &Planner {
        &self.planner
    }

    /// The same, to be changed: changes take effect at the next period.
    pub fn planner_mut(&mut self) -> &mut Planner {
        &mut self.planner
    }

    /// The plan being played.
    pub fn plan(&self) -> &Plan {
        self.sequencer.plan()
    }

    /// Slots of the current period already played, 0..N; 0 between periods.
    pub fn position(&self) -> u32 {
        self.sequencer.position()
    }

    /// Sensing slots of the current period still to come.
    pub fn sensing_left(&self) -> u32 {
        self.sequencer.sensing_left()
    }

    /// Slots each user had in the current period.
    pub fn served(&self) -> [u32; USERS] {
        self.sequencer.served()
    }

    /// What the last boundary did.
    pub fn report(&self) -> PeriodReport {
        self.report
    }

    /// The slot that [`Scheduler::next_slot`] gave last was lost or pre-empted. Counted once a slot.
    pub fn on_lost(&mut self) {
        self.counts.on_lost(core::mem::replace(&mut self.last, SlotUse::Idle));
    }

    /// No more sensing in this period: its remaining slots go to the users so that the period's worst total is as large as it
    /// can be. Between periods nothing happens. Cost: O(K^3).
    pub fn end_sensing(&mut self) {
        let released = self.sequencer.release_sensing();
        if released > 0 {
            let totals = self.planner.totals(self.sequencer.rest(), &self.sequencer.served());
            self.sequencer.reassign(&totals);
            self.counts.released += released;
        }
    }

    /// Use of the next slot. A period begins with a new plan if anything changed; [`Scheduler::report`] says so.
    /// Cost: O(K) with one division, K more at the end of a period; O(K^3) at a boundary with changes.
    pub fn next_slot(&mut self) -> SlotUse {
        if self.sequencer.position() == 0 {
            let (mut plan, changes) = self.planner.next_plan(&core::mem::take(&mut self.counts));
            if self.period_index == 0 {
                plan = plan.or_else(|| Some(self.planner.first_plan()));
            }
            self.report = PeriodReport { period: self.period_index, replanned: plan.is_some(), changes };
            if plan.is_some() {
                self.sequencer.restart(plan.as_ref());
            }
            self.period_index = self.period_index.wrapping_add(1);
        }
        self.last = self.sequencer.next_slot();
        self.last
    }
}
