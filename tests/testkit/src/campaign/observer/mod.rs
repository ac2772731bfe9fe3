//! What the two contexts of a radar module must do, call by call, known without them.
//!
//! The observer has a schedule of its own that no fault reaches, and counts of its own: slots of each use, samples taken, messages on
//! their way. It is given the calls that the module is given, in the same order, and says what each must return and report.

mod kept;
mod processing;

use super::Outcome;
use core::mem::{replace, take};
use heapless::{Deque, Vec};
use kept::Kept;
pub(super) use processing::Step;
use processing::{Due, Recording};
use sdp3_core::dsn::ModelError;
use sdp3_core::radar::SLOT_BUFFERS;
use sdp3_core::scheduler::{Changes, PeriodCounts, Plan, Planner, SlotUse, USERS};
use sdp3_core::supervision::Fault;

/// Most skipped slots that are counted as lost; after more a new period begins.
pub(in crate::campaign) const CATCH_UP: u32 = 8;

/// Any change of a model.
pub(in crate::campaign) const MODEL_FAULT: Fault =
    Fault::Model(ModelError::Checksum { stated: 0, computed: 0 });

/// Exits of a module in a campaign.
pub(in crate::campaign) const EXITS: usize = 2;

/// Copies of the retained state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::campaign) enum Copies {
    Newest,
    Older,
    Both,
}

/// A report on its way.
pub(in crate::campaign) enum Report {
    Fault(Fault),
    Period { period: u32, replanned: bool, counts: PeriodCounts },
    Released { period: u32, rest: u32, served: [u32; USERS] },
    PlanNeeded,
}

/// A sensing slot on its way: its period, its number there, sensing slots behind it, and what is wrong with its samples.
#[derive(Debug, Clone)]
pub(in crate::campaign) struct Filled {
    pub numbers: [u32; 3],
    pub fault: Option<Fault>,
}

/// The observer.
pub(in crate::campaign) struct Observer {
    planner: Planner,
    pub kept: Kept,
    /// What was saved last and before that.
    saved: [Kept; 2],
    /// Number of saves.
    pub saves: u32,
    pub damaged: Option<Copies>,
    /// Whether the number of the next slot is known.
    anchored: bool,
    /// Whether a sensing slot waits for its samples, as they will be in the queue.
    pending: Option<Filled>,
    buffer: bool,
    free: usize,
    pub reports: Deque<Report, 8>,
    reports_lost: u32,
    /// The next plan, whether its period has begun, and whether it has changed on its way.
    pub plan: Option<Plan>,
    pub plan_begun: bool,
    pub plan_damaged: bool,
    plan_requested: bool,
    totals: Option<(u32, [u32; USERS])>,
    totals_used: bool,
    /// The period in which sensing ends early.
    release: u32,
    pub filled: Deque<Filled, SLOT_BUFFERS>,
    /// Losses that no plan gives back yet.
    counts: PeriodCounts,
    plan_due: bool,
    changes: Changes,
    recording: Recording,
    due: Deque<Due, 4>,
    /// Steps of the recognition under way, and of every exit's.
    steps: u32,
    learned: [Option<u32>; EXITS],
    /// Sensing slots of every exit.
    pub needs: Vec<u32, EXITS>,
    /// Steps of every model's check, at the end of its recognition.
    pub checks: [u32; EXITS],
    /// The model of which bits have changed, and steps of its recognition once that has been reported: it may run by other kernels.
    model_damaged: Option<usize>,
    damaged_steps: Option<u32>,
    /// Slots of the period if all so far were seen, and those of each user.
    seen: u32,
    served: [u32; USERS],
    /// What each user must have at the end of this period.
    goal: Option<(u32, [u32; USERS])>,
    pub outcome: Outcome,
}

impl Observer {
    pub fn new(planner: Planner, needs: &[u32], number: u32) -> Self {
        let kept = Kept::new(&planner.first_plan(), false, number);
        Observer {
            planner,
            saved: [kept.clone(), kept.clone()],
            kept,
            saves: 0,
            damaged: None,
            anchored: false,
            pending: None,
            buffer: false,
            free: SLOT_BUFFERS,
            reports: Deque::new(),
            reports_lost: 0,
            plan: None,
            plan_begun: false,
            plan_damaged: false,
            plan_requested: false,
            totals: None,
            totals_used: false,
            release: 0,
            filled: Deque::new(),
            counts: PeriodCounts::default(),
            plan_due: false,
            changes: Changes::default(),
            recording: Recording::default(),
            due: Deque::new(),
            steps: 0,
            learned: [None; EXITS],
            checks: [0; EXITS],
            needs: needs.iter().copied().take(EXITS).collect(),
            model_damaged: None,
            damaged_steps: None,
            seen: 0,
            served: [0; USERS],
            goal: None,
            outcome: Outcome::default(),
        }
    }

    pub fn planner(&mut self) -> &mut Planner {
        &mut self.planner
    }

    fn report(&mut self, report: Report) {
        if self.reports_lost > 0 {
            let lost = Report::Fault(Fault::ReportsLost(self.reports_lost));
            self.reports_lost = if self.reports.push_back(lost).is_ok() { 0 } else { self.reports_lost };
        }
        self.reports_lost += u32::from(self.reports.push_back(report).is_err());
    }

    fn fault(&mut self, fault: Fault) {
        self.report(Report::Fault(fault));
    }

    /// The state is read; whether it had to be repaired.
    fn load(&mut self) -> bool {
        match self.damaged.take() {
            None | Some(Copies::Older) => {
                if take(&mut self.plan_begun) {
                    self.plan = None;
                }
                if take(&mut self.totals_used) {
                    self.totals = None;
                }
                return false;
            }
            Some(Copies::Newest) => {
                self.fault(Fault::StateRepaired);
                let (next, last) = (self.kept.next, self.kept.last);
                self.kept = self.saved[1].clone();
                (self.plan_begun, self.totals_used) = (false, false);
                for _ in 0..next.wrapping_sub(self.kept.next).min(CATCH_UP + 1) {
                    self.play(false);
                }
                // a slot that was played otherwise is not held to the period's totals
                self.seen = if self.kept.last == last { self.seen } else { 0 };
            }
            Some(Copies::Both) => {
                self.fault(Fault::StateLost);
                self.kept = Kept::new(&Plan::IDLE, true, 0);
                (self.plan_requested, self.plan_begun, self.totals_used) = (false, false, false);
                (self.pending, self.anchored, self.release, self.goal) = (None, false, 0, None);
                // the numbers go on, so that no period is taken for one before
                self.kept.period = self.saved[0].period;
            }
        }
        true
    }

    fn save(&mut self) {
        self.saved.swap(0, 1);
        self.saved[0] = self.kept.clone();
        (self.saves, self.anchored) = (self.saves.wrapping_add(1), true);
    }

    /// A slot with the next number, or one behind a gap.
    pub fn begin(&mut self, number: u32) -> SlotUse {
        let repaired = self.load();
        if !self.anchored {
            self.kept.next = number;
        }
        if self.kept.unplanned {
            self.check_plan();
            if self.plan.is_none() {
                if !self.plan_requested {
                    self.plan_requested = self.reports.push_back(Report::PlanNeeded).is_ok();
                }
                self.kept.next = number.wrapping_add(1);
                self.save();
                return SlotUse::Idle;
            }
            (self.kept.unplanned, self.kept.next) = (false, number);
        }
        if self.pending.take().is_some() {
            self.fault(Fault::MissingSamples);
            self.kept.counts.on_lost(SlotUse::Sensing);
        }
        match number.wrapping_sub(self.kept.next) {
            0 => (),
            gap if gap < 1 << 31 => self.pass(gap, if repaired { 0 } else { CATCH_UP }),
            _ => {
                self.fault(Fault::CounterReset);
                self.kept.sequencer.restart(None);
            }
        }
        self.kept.next = number;
        let mut slot = self.play(true);
        self.count(slot);
        if slot == SlotUse::Sensing {
            if !self.buffer && self.free > 0 {
                (self.buffer, self.free) = (true, self.free - 1);
            }
            if self.buffer {
                let Kept { period, sensing_slots, sequencer, .. } = &self.kept;
                let numbers = [*period, sensing_slots.wrapping_sub(1), sequencer.sensing_left()];
                self.pending = Some(Filled { numbers, fault: None });
            } else {
                self.fault(Fault::Overrun);
                self.kept.counts.on_lost(slot);
                (slot, self.kept.last) = (SlotUse::Idle, SlotUse::Idle);
            }
        }
        self.save();
        slot
    }

    /// The number of the last slot once more.
    pub fn repeat(&mut self) -> SlotUse {
        if self.load() {
            self.save();
        }
        self.fault(Fault::SlotRepeated);
        let waits = self.kept.last != SlotUse::Sensing || self.pending.is_some();
        if waits { self.kept.last } else { SlotUse::Idle }
    }

    /// A number of at least two slots before the next.
    pub fn late(&mut self) {
        self.load();
        self.fault(Fault::SlotLate);
        self.save();
    }

    /// The last slot was lost.
    pub fn lost(&mut self) {
        self.load();
        let last = replace(&mut self.kept.last, SlotUse::Idle);
        self.kept.counts.on_lost(last);
        self.pending = None;
        self.save();
    }

    /// Samples have come.
    pub fn samples_ready(&mut self, fault: Option<Fault>) {
        match self.pending.take() {
            Some(slot) if take(&mut self.buffer) => {
                let full = self.filled.push_back(Filled { fault, ..slot }).is_err();
                self.invariant(!full);
            }
            _ => self.fault(Fault::UnexpectedSamples),
        }
    }

    /// A reset: only the retained copies are left, as far as they are not damaged, and `planner` is the new module's.
    pub fn reset(&mut self, damaged: Option<Copies>, planner: Planner, number: u32) {
        let needs = take(&mut self.needs);
        let mut new = Observer::new(planner, &needs, number);
        if damaged != Some(Copies::Both) {
            let newest = damaged != Some(Copies::Newest);
            new.kept = self.saved[usize::from(!newest)].clone();
            new.saved = [new.kept.clone(), new.kept.clone()];
            (new.saves, new.anchored) = (self.saves.wrapping_sub(u32::from(!newest)), true);
            new.report(Report::PlanNeeded);
        }
        (new.learned, new.checks, new.outcome) = (self.learned, self.checks, self.outcome);
        *self = new;
    }

    /// Skipped slots pass: counted as lost, or, if too many, with a new period.
    fn pass(&mut self, slots: u32, catch_up: u32) {
        let left = self.kept.sequencer.plan().period() - self.kept.sequencer.position();
        if slots > catch_up || slots >= left {
            self.kept.sequencer.restart(None);
            return self.fault(Fault::Outage { slots });
        }
        let mut sensing = 0;
        for _ in 0..slots {
            let slot = self.play(true);
            sensing += u32::from(slot == SlotUse::Sensing);
            self.kept.counts.on_lost(slot);
        }
        self.fault(Fault::SlotsSkipped { slots, sensing });
    }

    /// A plan that has changed on its way is reported, and another one asked for.
    fn check_plan(&mut self) {
        if !self.plan_begun && self.plan.is_some() && take(&mut self.plan_damaged) {
            self.plan = None;
            self.fault(Fault::PlanDamaged);
            self.report(Report::PlanNeeded);
        }
    }

    /// The use that the next slot must have; `fresh` unless it has been played before.
    fn play(&mut self, fresh: bool) -> SlotUse {
        if self.kept.sequencer.position() == 0 {
            self.check_plan();
            let kept = &mut self.kept;
            let plan = self.plan.as_ref().filter(|_| !self.plan_begun);
            let replanned = plan.is_some() || kept.period == 0;
            kept.sequencer.restart(plan);
            self.plan_begun |= plan.is_some();
            (kept.period, kept.sensing_slots) = (kept.period.wrapping_add(1), 0);
            let (period, counts) = (kept.period, take(&mut kept.counts));
            if fresh {
                self.report(Report::Period { period, replanned, counts });
            }
        } else if self.release == self.kept.period
            && let released @ 1.. = self.kept.sequencer.release_sensing()
        {
            self.kept.counts.released += released;
            let (period, sequencer) = (self.kept.period, &self.kept.sequencer);
            let (rest, served) = (sequencer.rest(), sequencer.served());
            self.report(Report::Released { period, rest, served });
        } else if let Some((period, totals)) = self.totals.filter(|_| !self.totals_used) {
            self.totals_used = true;
            if period == self.kept.period {
                // a user that has more already leaves others less
                let fits = self.kept.sequencer.served().iter().zip(totals).all(|(had, total)| *had <= total);
                self.goal = fits.then_some((period, totals));
                self.kept.sequencer.reassign(&totals);
            }
        }
        let kept = &mut self.kept;
        kept.last = kept.sequencer.next_slot();
        kept.sensing_slots += u32::from(kept.last == SlotUse::Sensing);
        kept.next = kept.next.wrapping_add(1);
        kept.last
    }

    /// Holds a slot to the plan, and the last slot of a whole period to its totals.
    fn count(&mut self, slot: SlotUse) {
        let Kept { sequencer, counts, period, .. } = &self.kept;
        let plan = sequencer.plan();
        let position = if sequencer.position() == 0 { plan.period() } else { sequencer.position() };
        if position == 1 {
            (self.seen, self.served) = (0, [0; USERS]);
        }
        // none if one before it was not seen
        self.seen = if self.seen + 1 == position { position } else { 0 };
        if let SlotUse::Communication(user) = slot {
            self.served.iter_mut().skip(user.into()).take(1).for_each(|n| *n += 1);
        }
        let (whole, senses) = (self.seen == plan.period(), slot == SlotUse::Sensing);
        let holds = if counts.released > 0 {
            let goal = self.goal.filter(|goal| whole && goal.0 == *period);
            !senses && goal.is_none_or(|(_, totals)| totals == self.served)
        } else {
            plan.senses(position) == senses && (!whole || plan.shares() == self.served)
        };
        self.invariant(holds);
    }

    pub fn invariant(&mut self, holds: bool) {
        self.outcome.violations += u64::from(!holds);
    }
}
