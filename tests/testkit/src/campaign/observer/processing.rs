//! The task's side: reports, sensing slots and recordings, plans, recognitions.

use super::{Filled, Observer, Report};
use core::mem::take;
use sdp3_core::dsn::Classification;
use sdp3_core::scheduler::{Changes, PeriodCounts, PeriodReport};
use sdp3_core::supervision::Fault;

/// What processing must do when it is polled.
pub(in crate::campaign) enum Step {
    Period(PeriodReport),
    Fault(Fault),
    Busy,
    /// Another step of a recognition or of a model's check.
    Recognition,
    Idle,
}

/// A recognition that is under way.
pub(super) struct Due {
    period: u32,
    exit: usize,
    /// Whether its recording is not the running one.
    outdated: bool,
}

/// What processing counts of a recording.
#[derive(Debug, Clone, Default)]
pub(super) struct Recording {
    period: u32,
    next_index: u32,
    taken: u32,
    /// Whether further slots of the period serve nothing.
    unused: bool,
    /// Whether a classification has ended the recording.
    stopped: bool,
}

/// What a slot did to a recording.
#[derive(Default)]
struct Taken {
    restarted: bool,
    ends_sensing: bool,
    fault: Option<Fault>,
    /// The exit that has its slots now.
    exit: Option<usize>,
}

impl Recording {
    fn take(&mut self, slot: &Filled, needs: &[u32]) -> Taken {
        let ([period, index, left], mut taken) = (slot.numbers, Taken::default());
        let (first, last) = (needs.first().copied().unwrap_or(0), needs.last().copied().unwrap_or(0));
        if period != self.period {
            *self = Recording { period, ..Recording::default() };
            taken.restarted = true;
        }
        if index != self.next_index && !self.unused && !self.stopped {
            (self.taken, self.next_index, taken.restarted) = (0, index, true);
        }
        if self.taken == 0 && left.wrapping_add(1) < first && !self.unused {
            (self.unused, taken.ends_sensing) = (true, true);
        }
        if self.unused || self.stopped {
            return taken;
        }
        self.next_index = index.wrapping_add(1);
        if slot.fault.is_some() {
            (self.taken, taken.restarted, taken.fault) = (0, true, slot.fault);
        } else if self.taken < last {
            self.taken += 1;
            taken.exit = needs.iter().position(|&need| need == self.taken);
        }
        taken
    }
}

impl Observer {
    /// Whether a recognition is under way.
    pub fn recognises(&self) -> bool {
        !self.due.is_empty()
    }

    /// Sensing slots of the recording that have been taken or are on their way; the next one has this number, if it goes on.
    pub fn before(&self) -> u32 {
        let mut recording = self.recording.clone();
        self.filled.iter().for_each(|slot| _ = recording.take(slot, &self.needs));
        let goes_on = (self.kept.period, self.kept.sensing_slots.wrapping_sub(1))
            == (recording.period, recording.next_index);
        if goes_on { recording.taken } else { 0 }
    }

    /// One step of processing: what is most urgent.
    pub fn poll(&mut self) -> Step {
        if let Some(report) = self.reports.pop_front() {
            return self.take_report(report);
        }
        if let Some(slot) = self.filled.pop_front() {
            self.free += 1;
            let Taken { restarted, ends_sensing, fault, exit } = self.recording.take(&slot, &self.needs);
            let period = self.recording.period;
            if restarted {
                self.due.iter_mut().for_each(|due| due.outdated = true);
            }
            self.release = if ends_sensing { period } else { self.release };
            if let Some(exit) = exit {
                let full = self.due.push_back(Due { period, exit, outdated: false }).is_err();
                self.invariant(!full);
            }
            return fault.map_or(Step::Busy, Step::Fault);
        }
        if (self.plan_due || self.planner.has_changes()) && self.plan.is_none() {
            self.plan_due = false;
            let (plan, changes) = self.planner.next_plan(&take(&mut self.counts));
            if plan.is_some() {
                (self.plan, self.changes, self.plan_damaged) = (plan, changes, false);
            }
            return Step::Busy;
        }
        let Some(&Due { exit, outdated, .. }) = self.due.front() else { return Step::Idle };
        self.steps += 1;
        // the last exit ends its recording before its model is checked
        let known = self.learned.get(exit).copied().flatten().zip(self.checks.get(exit));
        let classified = known.is_some_and(|(steps, check)| self.steps + check == steps);
        self.recording.stopped |= classified && !outdated && exit + 1 == self.needs.len();
        if self.model_damaged == Some(exit) && self.damaged_steps == Some(self.steps) {
            self.refused();
        }
        Step::Recognition
    }

    /// Bits of a model have changed, or are as they were again.
    pub fn damage_model(&mut self, number: usize) {
        self.model_damaged = if self.model_damaged.is_some() { None } else { Some(number) };
        self.damaged_steps = None;
    }

    /// The check of a model has found that it has changed; whether that was due.
    pub fn refused(&mut self) -> bool {
        let Some(due) = self.due.pop_front() else { return false };
        self.damaged_steps = Some(take(&mut self.steps));
        if due.period == self.recording.period {
            (self.release, self.recording.unused) = (due.period, true);
        }
        self.model_damaged == Some(due.exit)
    }

    fn take_report(&mut self, report: Report) -> Step {
        match report {
            Report::Fault(fault) => return Step::Fault(fault),
            Report::Period { period, replanned, counts: PeriodCounts { lost, sensing_lost, released } } => {
                self.counts.lost.iter_mut().zip(lost).for_each(|(sum, lost)| *sum = sum.saturating_add(lost));
                self.plan_due = true;
                let lost = lost.iter().copied().fold(0, u32::saturating_add);
                let because = if replanned { take(&mut self.changes) } else { Changes::default() };
                let changes = Changes { lost, sensing_lost, released, ..because };
                return Step::Period(PeriodReport { period, replanned, changes });
            }
            Report::Released { period, rest, served } => {
                let totals = self.planner.totals(rest, &served);
                self.totals = self.totals.or(Some((period, totals)));
            }
            Report::PlanNeeded if self.plan.is_none() => {
                (self.plan, self.plan_damaged) = (Some(self.planner.first_plan()), false);
            }
            Report::PlanNeeded => (),
        }
        Step::Busy
    }

    /// A classification has come; the exit and whether it is the one that is due, after as many steps as always.
    pub fn classified(&mut self, period: u32, classification: &Classification) -> bool {
        let steps = take(&mut self.steps);
        let Some(due) = self.due.pop_front() else { return false };
        let Some(known) = self.learned.get_mut(due.exit) else { return false };
        let known = *known.get_or_insert(steps);
        if classification.stop {
            self.recording.stopped |= !due.outdated;
            // a later period's release stays
            self.release = if due.period == self.recording.period { due.period } else { self.release };
        }
        (known, due.period, due.exit) == (steps, period, classification.exit.into())
    }
}
