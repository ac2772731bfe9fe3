//! The radio, the task, and the observer of a radar module, on one thread.
//!
//! The observer knows what the module must do by a schedule of its own that no fault reaches, and by counts of his own of the slots
//! that each use had and of the samples that were taken. The task polls after every slot or every second one, by chance.

use super::samples::Corruption;
use crate::signals::noise;
use core::mem::take;
use heapless::Vec;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;
use sdp3_core::config::RadarConfig;
use sdp3_core::dsn::{Logits, ModelError};
use sdp3_core::radar::{Event, ProcessingContext, Progress, SlotAction, SlotContext};
use sdp3_core::scheduler::sequencer::Release;
use sdp3_core::scheduler::{
    Changes, PeriodCounts, PeriodReport, Plan, Planner, SensingLayout, Sequencer, SlotUse, USERS,
};
use sdp3_core::supervision::retained::Retained;
use sdp3_core::supervision::{Fault, sample_health};

/// The two contexts of a radar module.
pub type Contexts<const VALUES: usize> = (SlotContext<VALUES>, ProcessingContext<VALUES>);

/// Most skipped slots that are counted as lost; after more a new period begins.
pub(super) const CATCH_UP: u32 = 8;

/// More polls than a recognition needs.
const POLLS: usize = 1 << 20;

/// What happens to the samples of a sensing slot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Transfer {
    Done,
    /// The radio says that the slot was lost.
    Lost,
    /// Nothing is heard of it.
    Missing,
    Corrupted(Corruption),
}

/// Copies of the retained state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Copies {
    Newest,
    Older,
    Both,
}

/// The schedule that no fault reaches: slots are played, and plans made, where the module must.
#[derive(Clone)]
struct Reference {
    planner: Planner,
    /// The plan on its way to the slot context, and whether its period has begun.
    sent: Option<Plan>,
    begun: bool,
    /// Why it differs.
    changes: Changes,
    sequencer: Sequencer,
    /// Losses of the running period, and of those before that no plan gives back yet.
    counts: PeriodCounts,
    before: PeriodCounts,
    plan_due: bool,
    plan_needed: bool,
    /// Whether there is no plan and slots stay idle.
    unplanned: bool,
    period: u32,
    sensed: u32,
    last: SlotUse,
    /// The period whose sensing ends early, and what is on its way between the contexts then.
    release: u32,
    released: Option<(u32, Release)>,
    totals: Option<(u32, [u32; USERS])>,
    reports: Vec<PeriodReport, 4>,
}

impl Reference {
    fn new(planner: Planner) -> Self {
        Reference {
            sequencer: Sequencer::new(&planner.first_plan()),
            planner,
            sent: None,
            begun: false,
            changes: Changes::default(),
            counts: PeriodCounts::default(),
            before: PeriodCounts::default(),
            plan_due: false,
            plan_needed: false,
            unplanned: false,
            period: 0,
            sensed: 0,
            last: SlotUse::Idle,
            release: 0,
            released: None,
            totals: None,
            reports: Vec::new(),
        }
    }

    /// The same after a reset that has kept the slot context's state.
    fn reset(&mut self, planner: Planner) {
        let Reference { sequencer, counts, period, sensed, last, .. } = self.clone();
        let plan_needed = true;
        *self = Reference { sequencer, counts, period, sensed, last, plan_needed, ..Reference::new(planner) };
    }

    /// The slot context has read its state back.
    fn load(&mut self) {
        if take(&mut self.begun) {
            self.sent = None;
        }
    }

    /// The slot context's state is lost.
    fn forget(&mut self) {
        self.sequencer = Sequencer::new(&Plan::IDLE);
        (self.unplanned, self.begun, self.release, self.period) = (true, false, 0, 0);
        self.counts = PeriodCounts::default();
    }

    fn on_lost(&mut self, slot: SlotUse) {
        self.counts.on_lost(slot);
    }

    /// The use of the next slot.
    fn next_slot(&mut self) -> SlotUse {
        if self.unplanned {
            self.unplanned = self.sent.is_none();
            self.plan_needed |= self.unplanned;
            if self.unplanned {
                return SlotUse::Idle;
            }
        }
        if self.sequencer.position() == 0 {
            self.begin_period();
        } else if self.release == self.period
            && let Some(release) = self.sequencer.release_sensing()
        {
            self.counts.released += release.released;
            self.released = Some((self.period, release));
        } else if let Some((period, totals)) = self.totals.take()
            && period == self.period
        {
            self.sequencer.reassign(&totals);
        }
        self.last = self.sequencer.next_slot();
        self.sensed += u32::from(self.last == SlotUse::Sensing);
        self.last
    }

    fn begin_period(&mut self) {
        let plan = self.sent.as_ref().filter(|_| !self.begun);
        let replanned = plan.is_some() || self.period == 0;
        self.sequencer.restart(plan);
        self.begun |= plan.is_some();
        (self.period, self.sensed, self.plan_due) = (self.period.wrapping_add(1), 0, true);
        let counts = take(&mut self.counts);
        for (sum, lost) in self.before.lost.iter_mut().zip(counts.lost) {
            *sum += lost;
        }
        self.before.sensing_lost += counts.sensing_lost;
        self.before.released += counts.released;
        let changes = Changes {
            lost: counts.lost.iter().sum(),
            sensing_lost: counts.sensing_lost,
            released: counts.released,
            ..if replanned { take(&mut self.changes) } else { Changes::default() }
        };
        let _ = self.reports.push(PeriodReport { period: self.period, replanned, changes });
    }

    /// The reports of the slot context have been taken.
    fn take_reports(&mut self) {
        if let Some((period, release)) = self.released.take() {
            self.totals = self.totals.take().or(Some((period, self.planner.totals(&release))));
        }
        if take(&mut self.plan_needed) && self.sent.is_none() {
            self.sent = Some(self.planner.first_plan());
        }
    }

    /// A plan has been made if one is due and the last one has begun.
    fn make_plan(&mut self) {
        if (self.plan_due || self.planner.has_changes()) && self.sent.is_none() {
            self.plan_due = false;
            let (plan, changes) = self.planner.next_plan(&take(&mut self.before));
            if plan.is_some() {
                (self.sent, self.changes) = (plan, changes);
            }
        }
    }
}

/// A sensing slot on its way to processing.
#[derive(Debug, Clone, Copy)]
struct Taken {
    period: u32,
    index: u32,
    left: u32,
    fault: Option<Fault>,
}

/// What the observer counts of the recording.
#[derive(Debug, Clone, Default)]
struct Recording {
    /// Sensing slots of a recording.
    need: u32,
    period: u32,
    next_index: u32,
    taken: u32,
    /// Whether further slots of the period are not used.
    over: bool,
    queue: Vec<Taken, 4>,
}

impl Recording {
    /// Slots of the recording that one with this number goes on from: a gap begins it again.
    fn before(&self, period: u32, index: u32) -> u32 {
        if period == self.period && index == self.next_index { self.taken } else { 0 }
    }
}

/// What a jump of the radio's numbers is answered with.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
enum Jump {
    #[default]
    None,
    Forward(u32),
    Backward,
}

/// A radar module among its faults, and the observer.
pub(super) struct Environment<const VALUES: usize> {
    slots: SlotContext<VALUES>,
    processing: ProcessingContext<VALUES>,
    retained: &'static Retained,
    chance: Xoshiro128PlusPlus,
    /// Number of the radio's next slot.
    pub number: u32,
    jump: Jump,
    /// Whether the last slot senses and its samples are on their way.
    pending: bool,
    reference: Reference,
    recording: Recording,
    /// Seed of the samples; `None`: they do not matter.
    seed: Option<u64>,
    /// Times the state was saved, and whether the last time was for a lost sensing slot.
    saves: u32,
    saved_loss: bool,
    /// Whether the state that was saved last is damaged.
    damaged: bool,
    unpolled: bool,
    /// Slots of the period that were seen, by their use.
    served: [u32; USERS],
    sensed: u32,
    seen: u32,
    /// Whether bits of the model have changed, and that has been reported.
    pub model_damaged: bool,
    model_reported: bool,
    reported: Vec<Fault, 16>,
    expected: Vec<Fault, 16>,
    pub classifications: u32,
    /// Logits that every classification must have.
    logits: Option<Logits>,
    pub violations: u64,
}

impl<const VALUES: usize> Environment<VALUES> {
    /// Contexts made with the settings of `planner`, on `retained`; a recording needs `need` sensing slots.
    pub fn new(
        (slots, processing): Contexts<VALUES>,
        retained: &'static Retained,
        planner: Planner,
        need: u32,
        number: u32,
        seed: Option<u64>,
    ) -> Self {
        Environment {
            slots,
            processing,
            retained,
            chance: Xoshiro128PlusPlus::seed_from_u64(number.into()),
            number,
            jump: Jump::None,
            pending: false,
            reference: Reference::new(planner),
            recording: Recording { need, ..Recording::default() },
            seed,
            saves: 0,
            saved_loss: false,
            damaged: false,
            unpolled: false,
            served: [0; USERS],
            sensed: 0,
            seen: 0,
            model_damaged: false,
            model_reported: false,
            reported: Vec::new(),
            expected: Vec::new(),
            classifications: 0,
            logits: None,
            violations: 0,
        }
    }

    pub fn invariant(&mut self, holds: bool) {
        self.violations += u64::from(!holds);
    }

    fn expect(&mut self, fault: Fault) {
        let full = self.expected.push(fault).is_err();
        self.invariant(!full);
    }

    /// Forgets the reports of the event before.
    pub fn begin_event(&mut self) {
        self.poll();
        self.reported.clear();
        self.expected.clear();
        (self.violations, self.classifications) = (0, 0);
    }

    /// Whether the reports are exactly those expected; counts the event.
    pub fn end_event(&mut self, whole: bool, outcome: &mut super::Outcome) {
        self.poll();
        let (detected, silent) = (self.reported == self.expected, self.reported.is_empty());
        outcome.injected += 1;
        outcome.detected += u64::from(detected);
        outcome.recovered += u64::from(whole);
        outcome.silent += u64::from(!detected && silent);
        outcome.violations += self.violations + u64::from(!detected && !silent);
    }

    /// The running plan.
    pub fn plan(&self) -> &Plan {
        self.reference.sequencer.plan()
    }

    /// Slots of the running period that have passed, 0 between two.
    pub fn position(&self) -> u32 {
        self.reference.sequencer.position()
    }

    pub fn rates(&self) -> [u32; USERS] {
        self.reference.planner.rates()
    }

    pub fn unplanned(&self) -> bool {
        self.reference.unplanned
    }

    pub fn set_rate(&mut self, user: usize, rate: u32) {
        self.processing.set_rate(user, rate);
        self.reference.planner.set_rate(user, rate);
    }

    pub fn set_layout(&mut self, layout: SensingLayout) {
        self.processing.set_layout(layout);
        self.reference.planner.set_layout(layout);
    }

    /// The slot with the next number.
    pub fn slot(&mut self, transfer: Transfer) -> SlotUse {
        if !take(&mut self.damaged) {
            self.reference.load();
        }
        if take(&mut self.pending) {
            self.expect(Fault::MissingSamples);
            self.reference.on_lost(SlotUse::Sensing);
        }
        match take(&mut self.jump) {
            Jump::None => (),
            Jump::Forward(slots) => self.pass(slots),
            Jump::Backward => {
                self.expect(Fault::CounterReset);
                self.reference.sequencer.restart(None);
            }
        }
        let expected = self.reference.next_slot();
        let number = self.number;
        self.number = number.wrapping_add(1);
        let (given, fault) = self.begin(number, transfer);
        self.invariant(given == expected);
        (self.saves, self.saved_loss) = (self.saves.wrapping_add(1), false);
        if !self.unplanned() {
            self.count(given);
        }
        if given == SlotUse::Sensing {
            self.pending = true;
            match transfer {
                Transfer::Missing => (),
                Transfer::Lost => self.lose(),
                Transfer::Done | Transfer::Corrupted(_) => self.deliver(fault),
            }
        }
        self.poll_sometimes();
        given
    }

    /// So many slots without a fault.
    pub fn play(&mut self, slots: u32, transfer: Transfer) {
        for _ in 0..slots {
            self.slot(transfer);
        }
    }

    /// To the end of the running period.
    pub fn finish(&mut self, transfer: Transfer) {
        for _ in 0..self.plan().period() {
            if self.position() > 0 {
                self.slot(transfer);
            }
        }
    }

    /// A whole period.
    pub fn whole_period(&mut self, transfer: Transfer) {
        self.slot(transfer);
        self.finish(transfer);
    }

    /// What the module gives a number; a sensing slot's buffer is filled, and what is wrong with it is returned.
    fn begin(&mut self, number: u32, transfer: Transfer) -> (SlotUse, Option<Fault>) {
        let before = self.recording.before(self.reference.period, self.reference.sensed.wrapping_sub(1));
        let buffer = match self.slots.begin(number) {
            SlotAction::Serve(user) => return (SlotUse::Communication(user), None),
            SlotAction::Idle => return (SlotUse::Idle, None),
            SlotAction::Sense(buffer) => &mut buffer.0,
        };
        let Some(seed) = self.seed else { return (SlotUse::Sensing, None) };
        noise(&mut Xoshiro128PlusPlus::seed_from_u64(seed.wrapping_add(before.into())), buffer);
        if let Transfer::Corrupted(corruption) = transfer {
            corruption.apply(buffer);
        }
        let fault = sample_health::check(buffer, &RadarConfig::PAPER).err();
        (SlotUse::Sensing, fault.map(Fault::Samples))
    }

    /// Holds a slot to the plan, and the last slot of a whole period to its totals.
    fn count(&mut self, slot: SlotUse) {
        let sequencer = &self.reference.sequencer;
        let plan = sequencer.plan();
        let position = if sequencer.position() == 0 { plan.period() } else { sequencer.position() };
        if position == 1 {
            (self.served, self.sensed, self.seen) = ([0; USERS], 0, 0);
        }
        self.seen += 1;
        match slot {
            SlotUse::Sensing => self.sensed += 1,
            SlotUse::Communication(user) => {
                self.served.iter_mut().skip(user.into()).take(1).for_each(|n| *n += 1);
            }
            SlotUse::Idle => (),
        }
        let whole = position == plan.period() && self.seen == position;
        let holds = if self.reference.release == self.reference.period {
            slot != SlotUse::Sensing || plan.senses(position)
        } else {
            plan.senses(position) == (slot == SlotUse::Sensing)
                && (!whole || plan.shares() == self.served && self.sensed == plan.sensing())
        };
        self.invariant(holds);
    }

    /// The samples of the sensing slot that has just begun are there.
    fn deliver(&mut self, fault: Option<Fault>) {
        self.pending = false;
        self.slots.samples_ready();
        let Reference { period, sensed, sequencer, .. } = &self.reference;
        let taken =
            Taken { period: *period, index: sensed.wrapping_sub(1), left: sequencer.sensing_left(), fault };
        let full = self.recording.queue.push(taken).is_err();
        self.invariant(!full);
    }

    /// Samples that no slot waits for.
    pub fn unexpected_samples(&mut self) {
        self.slots.samples_ready();
        self.expect(Fault::UnexpectedSamples);
        self.poll_sometimes();
    }

    /// The last slot was lost.
    pub fn lose(&mut self) {
        self.slots.lost();
        self.reference.load();
        let last = core::mem::replace(&mut self.reference.last, SlotUse::Idle);
        self.reference.on_lost(last);
        self.pending = false;
        (self.saves, self.saved_loss) = (self.saves.wrapping_add(1), last == SlotUse::Sensing);
    }

    /// The radio's numbers jump forward.
    pub fn skip(&mut self, slots: u32) {
        self.number = self.number.wrapping_add(slots);
        self.jump = if slots > 0 { Jump::Forward(slots) } else { Jump::None };
    }

    /// Skipped slots pass: counted as lost, or, if too many, with a new period.
    fn pass(&mut self, slots: u32) {
        if slots > CATCH_UP || slots >= self.plan().period() - self.position() {
            self.reference.sequencer.restart(None);
            return self.expect(Fault::Outage { slots });
        }
        let mut sensing = 0;
        for _ in 0..slots {
            let slot = self.reference.next_slot();
            sensing += u32::from(slot == SlotUse::Sensing);
            self.reference.on_lost(slot);
        }
        self.expect(Fault::SlotsSkipped { slots, sensing });
    }

    /// The number of the last slot once more.
    pub fn repeat(&mut self) {
        self.reference.load();
        self.expect(Fault::SlotRepeated);
        let last = self.reference.last;
        let expected = if last == SlotUse::Sensing && !self.pending { SlotUse::Idle } else { last };
        let (given, _) = self.begin(self.number.wrapping_sub(1), Transfer::Done);
        self.invariant(given == expected);
        self.poll_sometimes();
    }

    /// A number of at least two slots before the next; the next comes after it.
    pub fn late(&mut self, number: u32) {
        self.reference.load();
        self.expect(Fault::SlotLate);
        let (given, _) = self.begin(number, Transfer::Done);
        self.invariant(given == SlotUse::Idle);
        (self.saves, self.saved_loss) = (self.saves.wrapping_add(1), false);
        self.poll_sometimes();
    }

    /// The radio counts from another number.
    pub fn count_from(&mut self, number: u32) {
        let gap = number.wrapping_sub(self.number);
        if gap < 1 << 31 {
            return self.skip(gap);
        }
        self.late(number);
        (self.number, self.jump) = (number.wrapping_add(1), Jump::Backward);
    }

    /// Changes a word of retained copies: its number in each, and the bits that are inverted.
    pub fn damage(&mut self, copies: Copies, change: (u32, u32)) {
        self.flip(copies, change);
        match copies {
            Copies::Older => (),
            Copies::Newest => {
                self.damaged = true;
                self.expect(Fault::StateRepaired);
                self.reference.counts.sensing_lost -= u32::from(self.saved_loss);
            }
            Copies::Both => {
                self.expect(Fault::StateLost);
                self.pending = false;
                self.reference.forget();
            }
        }
    }

    fn flip(&self, copies: Copies, (at, mask): (u32, u32)) {
        let words = Retained::LEN / 2;
        // the first half is written with even numbers
        let newest = words * (self.saves % 2) as usize;
        let at = at as usize % words;
        if copies != Copies::Older {
            self.retained.flip(newest + at, mask);
        }
        if copies != Copies::Newest {
            self.retained.flip(words - newest + at, mask);
        }
    }

    /// A reset: only the retained copies are left, as far as they are not damaged, and some slots pass.
    pub fn reset(
        &mut self,
        damaged: Option<Copies>,
        change: (u32, u32),
        passed: u32,
        planner: Planner,
        make: impl FnOnce() -> Option<Contexts<VALUES>>,
    ) {
        self.poll();
        let before = self.reference.clone();
        self.slot(Transfer::Done);
        self.poll();
        if let Some(copies) = damaged {
            self.flip(copies, change);
        }
        let Some(contexts) = make() else { return self.invariant(false) };
        (self.slots, self.processing) = contexts;
        self.recording = Recording { need: self.recording.need, ..Recording::default() };
        (self.pending, self.saved_loss, self.damaged) = (false, false, false);
        match damaged {
            Some(Copies::Both) => {
                self.number = self.number.wrapping_add(passed);
                self.reference = Reference::new(planner);
                self.saves = 0;
            }
            Some(Copies::Newest) => {
                // the last slot is forgotten, and therefore one that was skipped
                self.reference = before;
                self.reference.reset(planner);
                self.saves = self.saves.wrapping_sub(1);
                self.number = self.number.wrapping_sub(1);
                self.skip(passed + 1);
            }
            _ => {
                self.reference.reset(planner);
                self.skip(passed);
            }
        }
    }

    /// Polls, unless it has polled after the last slot and chance says no.
    fn poll_sometimes(&mut self) {
        self.unpolled = !self.unpolled && self.chance.next_u32() & 1 == 0;
        if !self.unpolled {
            self.poll();
        }
    }

    /// Polls until there is nothing to do.
    fn poll(&mut self) {
        self.reference.take_reports();
        let mut due = self.take_slots();
        self.reference.make_plan();
        let mut reports = take(&mut self.reference.reports).into_iter();
        for _ in 0..POLLS {
            match self.processing.poll() {
                Progress::Idle => {
                    self.invariant(due.is_none() && reports.next().is_none());
                    return;
                }
                Progress::Busy => (),
                Progress::Event(Event::Period(report)) => self.invariant(reports.next() == Some(report)),
                Progress::Event(Event::Fault(Fault::Model(_))) => self.reported(MODEL_FAULT),
                Progress::Event(Event::Fault(fault)) => self.reported(fault),
                Progress::Event(Event::Classification { period, classification }) => {
                    self.invariant(due.take() == Some(period) && classification.stop);
                    let first = self.logits.get_or_insert_with(|| classification.logits.clone());
                    let same = *first == classification.logits;
                    self.invariant(same);
                    self.classifications += 1;
                }
            }
        }
        self.violations += 1;
    }

    fn reported(&mut self, fault: Fault) {
        let full = self.reported.push(fault).is_err();
        self.invariant(!full);
    }

    /// What processing does with the slots in its queue; the period of the classification that follows.
    fn take_slots(&mut self) -> Option<u32> {
        let mut due = None;
        for Taken { period, index, left, fault } in take(&mut self.recording.queue) {
            let recording = &mut self.recording;
            recording.over &= period == recording.period;
            recording.taken = recording.before(period, index);
            (recording.period, recording.next_index) = (period, index.wrapping_add(1));
            if recording.over {
                continue;
            }
            if recording.taken == 0 && left + 1 < recording.need {
                recording.over = true;
                self.reference.release = period;
            } else if let Some(fault) = fault {
                recording.taken = 0;
                self.expect(fault);
            } else {
                recording.taken += 1;
                if recording.taken == recording.need {
                    recording.over = true;
                    self.reference.release = period;
                    match (
                        self.model_damaged,
                        core::mem::replace(&mut self.model_reported, self.model_damaged),
                    ) {
                        (false, _) => due = Some(period),
                        (true, false) => self.expect(MODEL_FAULT),
                        (true, true) => (),
                    }
                }
            }
        }
        due
    }
}

/// Any change of a model.
const MODEL_FAULT: Fault = Fault::Model(ModelError::Checksum { stated: 0, computed: 0 });
