//! The radio, the task, and the observer of a radar module, on one thread.
//!
//! The observer knows what the module must do by a schedule of its own that no fault reaches, and by counts of its own of the slots
//! that each use had and of the samples that were taken. The task polls after every slot or every second one, by chance.

use super::Outcome;
use super::samples::Corruption;
use crate::flip;
use crate::signals::noise;
use core::mem::take;
use heapless::Vec;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;
use sdp3_core::config::RadarConfig;
use sdp3_core::dsn::ModelError;
use sdp3_core::dsn::head::MAX_CLASSES;
use sdp3_core::radar::{Event, ProcessingContext, Progress, SlotAction, SlotContext};
use sdp3_core::scheduler::{
    Changes, PeriodCounts, PeriodReport, Plan, Planner, SensingLayout, Sequencer, SlotUse, USERS,
};
use sdp3_core::supervision::retained::Retained;
use sdp3_core::supervision::{Fault, sample_health};

/// The two contexts of a radar module.
pub type Contexts<const VALUES: usize> = (SlotContext<VALUES>, ProcessingContext<VALUES>);

/// Most skipped slots that are counted as lost; after more a new period begins.
pub(super) const CATCH_UP: u32 = 8;

/// Any change of a model.
pub(super) const MODEL_FAULT: Fault = Fault::Model(ModelError::Checksum { stated: 0, computed: 0 });

/// What happens to the samples of a sensing slot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Transfer {
    Done,
    /// The radio says that the slot was lost.
    Lost,
    /// Neither samples nor word of a loss come.
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

/// What the slot context keeps from slot to slot, and over a reset.
#[derive(Clone)]
struct Kept {
    sequencer: Sequencer,
    counts: PeriodCounts,
    period: u32,
    /// Sensing slots of the period so far.
    sensed: u32,
    last: SlotUse,
    /// Whether there is no plan and slots stay idle.
    unplanned: bool,
    /// Number of the next slot.
    next: u32,
}

impl Kept {
    fn new(plan: &Plan, unplanned: bool, next: u32) -> Self {
        let (sequencer, counts) = (Sequencer::new(plan), PeriodCounts::default());
        Kept { sequencer, counts, period: 0, sensed: 0, last: SlotUse::Idle, unplanned, next }
    }
}

/// What is on its way between the contexts, and lost by a reset.
#[derive(Default)]
struct Messages {
    /// The next plan, whether its period has begun, and why it differs.
    plan: Option<Plan>,
    begun: bool,
    changes: Changes,
    plan_due: bool,
    plan_needed: bool,
    /// Losses that no plan gives back yet.
    counts: PeriodCounts,
    /// The period in which sensing ends early.
    release: u32,
    /// Totals of the users then, and whether processing has computed them.
    totals: Option<(u32, [u32; USERS])>,
    computed: bool,
    reports: Vec<PeriodReport, 4>,
}

/// What the observer counts of a recording.
#[derive(Default)]
struct Recording {
    period: u32,
    next_index: u32,
    taken: u32,
    /// Whether further slots of the period are not used.
    over: bool,
}

impl Recording {
    /// Slots before one with this number: a gap begins the recording again.
    fn before(&self, period: u32, index: u32) -> u32 {
        if period == self.period && index == self.next_index { self.taken } else { 0 }
    }
}

/// A radar module among its faults, and the observer.
pub(super) struct Environment<const VALUES: usize> {
    contexts: Contexts<VALUES>,
    retained: &'static Retained,
    /// Chance of a poll.
    rng: Xoshiro128PlusPlus,
    polled: bool,
    /// Number of the radio's next slot.
    pub number: u32,
    /// Whether the samples of the last slot are on their way.
    pending: bool,
    planner: Planner,
    kept: Kept,
    messages: Messages,
    /// Times the state was saved, whether the last time was for a lost sensing slot, and whether that copy is damaged.
    saves: u32,
    saved_loss: bool,
    damaged: bool,
    /// Slots of the period if all so far were seen, and those of each user.
    seen: u32,
    served: [u32; USERS],
    recording: Recording,
    /// Sensing slots of a recording.
    need: u32,
    /// Seed of the samples; `None`: they do not matter.
    seed: Option<u64>,
    /// Logits that every classification must have.
    logits: Option<Vec<i8, MAX_CLASSES>>,
    pub classifications: u32,
    /// Whether bits of the model have changed.
    pub model_damaged: bool,
    reported: Vec<Fault, 16>,
    expected: Vec<Fault, 16>,
    pub violations: u64,
}

impl<const VALUES: usize> Environment<VALUES> {
    /// Contexts made with the settings of `planner` on `retained`.
    pub fn new(
        contexts: Contexts<VALUES>,
        retained: &'static Retained,
        planner: Planner,
        need: u32,
        number: u32,
        seed: Option<u64>,
    ) -> Self {
        Environment {
            contexts,
            retained,
            rng: Xoshiro128PlusPlus::seed_from_u64(number.into()),
            polled: true,
            number,
            pending: false,
            kept: Kept::new(&planner.first_plan(), false, number),
            planner,
            messages: Messages::default(),
            saves: 0,
            saved_loss: false,
            damaged: false,
            seen: 0,
            served: [0; USERS],
            recording: Recording::default(),
            need,
            seed,
            logits: None,
            classifications: 0,
            model_damaged: false,
            reported: Vec::new(),
            expected: Vec::new(),
            violations: 0,
        }
    }

    pub fn invariant(&mut self, holds: bool) {
        self.violations += u64::from(!holds);
    }

    pub fn expect(&mut self, fault: Fault) {
        let _ = self.expected.push(fault); // no event has more than sixteen
    }

    /// Forgets the reports of the event before.
    pub fn begin_event(&mut self) {
        self.poll();
        self.reported.clear();
        self.expected.clear();
        (self.violations, self.classifications) = (0, 0);
    }

    /// Counts the event; `recovered`: its last period is as it must be.
    pub fn end_event(&mut self, recovered: bool, outcome: &mut Outcome) {
        self.poll();
        let (detected, silent) = (self.reported == self.expected, self.reported.is_empty());
        outcome.injected += 1;
        outcome.detected += u64::from(detected);
        outcome.recovered += u64::from(recovered);
        outcome.silent += u64::from(!detected && silent);
        outcome.violations += self.violations + u64::from(!detected && !silent);
    }

    /// Slots of the running period that have passed, 0 between two, and those that are left.
    pub fn position(&self) -> (u32, u32) {
        let position = self.kept.sequencer.position();
        (position, self.kept.sequencer.plan().period() - position)
    }

    pub fn unplanned(&self) -> bool {
        self.kept.unplanned
    }

    /// Changes what processing wants of the next plan.
    pub fn plan(&mut self, rates: &[u32; USERS], layout: Option<SensingLayout>) {
        for (user, &rate) in rates.iter().enumerate() {
            self.contexts.1.set_rate(user, rate);
            self.planner.set_rate(user, rate);
        }
        if let Some(layout) = layout {
            self.contexts.1.set_layout(layout);
            self.planner.set_layout(layout);
        }
    }

    pub fn rates(&self) -> [u32; USERS] {
        self.planner.rates()
    }

    /// The slot with the radio's next number.
    pub fn slot(&mut self, transfer: Transfer) -> SlotUse {
        self.load();
        if take(&mut self.pending) {
            self.expect(Fault::MissingSamples);
            self.kept.counts.on_lost(SlotUse::Sensing);
        }
        let number = self.number;
        match number.wrapping_sub(self.kept.next) {
            0 => (),
            gap if gap < 1 << 31 => self.pass(gap),
            _ => {
                self.expect(Fault::CounterReset);
                self.kept.sequencer.restart(None);
            }
        }
        self.number = number.wrapping_add(1);
        self.kept.next = self.number;
        let expected = self.next_slot();
        let (given, fault) = self.begin(number, transfer);
        self.invariant(given == expected);
        self.saves = self.saves.wrapping_add(1);
        if !self.kept.unplanned {
            self.count(given);
        }
        match (given, transfer) {
            (SlotUse::Sensing, Transfer::Done | Transfer::Corrupted(_)) => {
                self.contexts.0.samples_ready();
                self.poll_with(Some(fault));
            }
            (SlotUse::Sensing, Transfer::Lost) => self.lose(),
            (given, _) => self.pending = given == SlotUse::Sensing,
        }
        self.poll_sometimes();
        given
    }

    pub fn play(&mut self, slots: u32, transfer: Transfer) {
        for _ in 0..slots {
            self.slot(transfer);
        }
    }

    /// To the end of the running period.
    pub fn finish(&mut self, transfer: Transfer) {
        for _ in 0..self.position().1 {
            if self.position().0 > 0 {
                self.slot(transfer);
            }
        }
    }

    /// A whole period.
    pub fn whole_period(&mut self, transfer: Transfer) {
        self.slot(transfer);
        self.finish(transfer);
    }

    /// The slot context reads its state: a plan that has begun leaves its queue.
    fn load(&mut self) {
        if !take(&mut self.damaged) && take(&mut self.messages.begun) {
            self.messages.plan = None;
        }
        self.saved_loss = false;
    }

    /// Skipped slots pass: counted as lost, or, if too many, with a new period.
    fn pass(&mut self, slots: u32) {
        if slots > CATCH_UP || slots >= self.position().1 {
            self.kept.sequencer.restart(None);
            return self.expect(Fault::Outage { slots });
        }
        let mut sensing = 0;
        for _ in 0..slots {
            let slot = self.next_slot();
            sensing += u32::from(slot == SlotUse::Sensing);
            self.kept.counts.on_lost(slot);
        }
        self.expect(Fault::SlotsSkipped { slots, sensing });
    }

    /// The use that the next slot must have.
    fn next_slot(&mut self) -> SlotUse {
        let (kept, messages) = (&mut self.kept, &mut self.messages);
        if kept.unplanned && messages.plan.is_none() {
            messages.plan_needed = true;
            return SlotUse::Idle;
        }
        kept.unplanned = false;
        if kept.sequencer.position() == 0 {
            let plan = messages.plan.as_ref().filter(|_| !messages.begun);
            let replanned = plan.is_some() || kept.period == 0;
            kept.sequencer.restart(plan);
            messages.begun |= plan.is_some();
            (kept.period, kept.sensed, messages.plan_due) = (kept.period.wrapping_add(1), 0, true);
            let PeriodCounts { lost, sensing_lost, released } = take(&mut kept.counts);
            messages.counts.lost.iter_mut().zip(lost).for_each(|(sum, lost)| *sum += lost);
            let lost = lost.iter().sum();
            let because = if replanned { take(&mut messages.changes) } else { Changes::default() };
            let changes = Changes { lost, sensing_lost, released, ..because };
            let _ = messages.reports.push(PeriodReport { period: kept.period, replanned, changes });
        } else if messages.release == kept.period
            && let released @ 1.. = kept.sequencer.release_sensing()
        {
            kept.counts.released += released;
            let (rest, served) = (kept.sequencer.rest(), kept.sequencer.served());
            messages.totals = Some((kept.period, self.planner.totals(rest, &served)));
            messages.computed = false;
        } else if take(&mut messages.computed)
            && let Some((period, totals)) = messages.totals.take()
            && period == kept.period
        {
            kept.sequencer.reassign(&totals);
        }
        kept.last = kept.sequencer.next_slot();
        kept.sensed += u32::from(kept.last == SlotUse::Sensing);
        kept.last
    }

    /// What the module gives a number, and what is wrong with the samples that it gets.
    fn begin(&mut self, number: u32, transfer: Transfer) -> (SlotUse, Option<Fault>) {
        let before = self.recording.before(self.kept.period, self.kept.sensed.wrapping_sub(1));
        let samples = match self.contexts.0.begin(number) {
            SlotAction::Serve(user) => return (SlotUse::Communication(user), None),
            SlotAction::Idle => return (SlotUse::Idle, None),
            SlotAction::Sense(buffer) => &mut buffer.0,
        };
        let Some(seed) = self.seed else { return (SlotUse::Sensing, None) };
        noise(&mut Xoshiro128PlusPlus::seed_from_u64(seed.wrapping_add(before.into())), samples);
        if let Transfer::Corrupted(corruption) = transfer {
            corruption.apply(samples);
        }
        (SlotUse::Sensing, sample_health::check(samples, &RadarConfig::PAPER).err().map(Fault::Samples))
    }

    /// Holds a slot to the plan, and the last slot of a whole period to its totals.
    fn count(&mut self, slot: SlotUse) {
        let sequencer = &self.kept.sequencer;
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
        let holds = if self.messages.release == self.kept.period {
            !senses || plan.senses(position)
        } else {
            plan.senses(position) == senses && (!whole || plan.shares() == self.served)
        };
        self.invariant(holds);
    }

    /// Samples that no slot waits for.
    pub fn unexpected_samples(&mut self) {
        self.contexts.0.samples_ready();
        self.expect(Fault::UnexpectedSamples);
        self.poll_sometimes();
    }

    /// The last slot was lost.
    pub fn lose(&mut self) {
        self.contexts.0.lost();
        self.load();
        let last = core::mem::replace(&mut self.kept.last, SlotUse::Idle);
        self.kept.counts.on_lost(last);
        (self.saves, self.saved_loss) = (self.saves.wrapping_add(1), last == SlotUse::Sensing);
    }

    /// The radio's numbers jump forward.
    pub fn skip(&mut self, slots: u32) {
        self.number = self.number.wrapping_add(slots);
    }

    /// The number of the last slot once more.
    pub fn repeat(&mut self) {
        self.load();
        self.expect(Fault::SlotRepeated);
        let waiting = self.kept.last != SlotUse::Sensing || self.pending;
        let expected = if waiting { self.kept.last } else { SlotUse::Idle };
        let (given, _) = self.begin(self.number.wrapping_sub(1), Transfer::Done);
        self.invariant(given == expected);
        self.poll_sometimes();
    }

    /// A number of at least two slots before the next.
    pub fn late(&mut self, number: u32) {
        self.load();
        self.expect(Fault::SlotLate);
        let (given, _) = self.begin(number, Transfer::Done);
        self.invariant(given == SlotUse::Idle);
        self.saves = self.saves.wrapping_add(1);
        self.poll_sometimes();
    }

    /// The radio counts from another number: one behind is given twice, so that it is not taken for a late one.
    pub fn count_from(&mut self, number: u32) {
        self.number = number;
        if number.wrapping_sub(self.kept.next) >= 1 << 31 {
            self.late(number);
            self.skip(1);
        }
    }

    /// Changes a word of retained copies: its number in each, and the bits that are inverted.
    pub fn damage(&mut self, copies: Copies, change: (u32, u32)) {
        self.flip(copies, change);
        match copies {
            Copies::Older => (),
            Copies::Newest => {
                self.damaged = true;
                self.expect(Fault::StateRepaired);
                self.kept.counts.sensing_lost -= u32::from(self.saved_loss);
            }
            Copies::Both => {
                self.expect(Fault::StateLost);
                self.kept = Kept::new(&Plan::IDLE, true, self.number);
                (self.pending, self.messages.begun, self.messages.release) = (false, false, 0);
            }
        }
    }

    fn flip(&self, copies: Copies, (at, mask): (u32, u32)) {
        let words = Retained::LEN / 2;
        // the first half is written with even numbers
        let (newest, at) = (words * (self.saves % 2) as usize, at as usize % words);
        if copies != Copies::Older {
            flip(self.retained, newest + at, mask);
        }
        if copies != Copies::Newest {
            flip(self.retained, words - newest + at, mask);
        }
    }

    /// A reset after a slot: only the retained copies are left, as far as they are not damaged, and some slots pass.
    pub fn reset(
        &mut self,
        damage: Option<(Copies, (u32, u32))>,
        passed: u32,
        planner: Planner,
        make: impl FnOnce() -> Option<Contexts<VALUES>>,
    ) {
        let before = self.kept.clone();
        self.slot(Transfer::Done);
        self.poll();
        if let Some((copies, change)) = damage {
            self.flip(copies, change);
        }
        let Some(contexts) = make() else { return self.invariant(false) };
        (self.contexts, self.planner, self.recording) = (contexts, planner, Recording::default());
        (self.pending, self.saved_loss) = (false, false);
        self.messages = Messages { plan_needed: true, ..Messages::default() };
        self.skip(passed);
        match damage {
            Some((Copies::Newest, _)) => {
                // the last slot is lost from the state, and with it one that was skipped
                (self.kept, self.saves) = (before, self.saves.wrapping_sub(1));
            }
            Some((Copies::Both, _)) => {
                self.kept = Kept::new(&self.planner.first_plan(), false, self.number);
                (self.saves, self.messages.plan_needed) = (0, false);
            }
            _ => (),
        }
    }

    /// Polls, unless it has polled after the last slot and chance says no.
    fn poll_sometimes(&mut self) {
        self.polled = !self.polled || self.rng.next_u32() & 1 == 0;
        if self.polled {
            self.poll();
        }
    }

    fn poll(&mut self) {
        self.poll_with(None);
    }

    /// Polls until there is nothing to do; `slot`: with a sensing slot in the queue, and what is wrong with its samples.
    fn poll_with(&mut self, slot: Option<Option<Fault>>) {
        self.messages.computed = self.messages.totals.is_some();
        if take(&mut self.messages.plan_needed) && self.messages.plan.is_none() {
            self.messages.plan = Some(self.planner.first_plan());
        }
        let mut complete = slot.is_some_and(|fault| self.take_slot(fault)) && !self.model_damaged;
        let messages = &mut self.messages;
        if (messages.plan_due || self.planner.has_changes()) && messages.plan.is_none() {
            messages.plan_due = false;
            let (plan, changes) = self.planner.next_plan(&take(&mut messages.counts));
            if plan.is_some() {
                (messages.plan, messages.changes) = (plan, changes);
            }
        }
        let reports = take(&mut messages.reports);
        let mut reports = reports.iter();
        loop {
            match self.contexts.1.poll() {
                Progress::Idle => break,
                Progress::Busy => (),
                Progress::Event(Event::Period(report)) => self.invariant(reports.next() == Some(&report)),
                Progress::Event(Event::Fault(fault)) => {
                    let fault = if matches!(fault, Fault::Model(_)) { MODEL_FAULT } else { fault };
                    let full = self.reported.push(fault).is_err();
                    self.invariant(!full);
                }
                Progress::Event(Event::Classification { period, classification }) => {
                    let first = self.logits.get_or_insert_with(|| classification.logits.clone());
                    let same = *first == classification.logits && period == self.recording.period;
                    self.invariant(same && classification.stop && take(&mut complete));
                    self.classifications += 1;
                }
            }
        }
        self.invariant(!complete && reports.next().is_none());
    }

    /// What processing does with the sensing slot in its queue. Returns whether the recording is complete.
    fn take_slot(&mut self, fault: Option<Fault>) -> bool {
        let Kept { period, sensed, sequencer, .. } = &self.kept;
        let (period, index, recording) = (*period, sensed.wrapping_sub(1), &mut self.recording);
        let taken = recording.before(period, index);
        let over = recording.over && period == recording.period;
        *recording = Recording { period, next_index: index.wrapping_add(1), taken, over };
        if over {
            return false;
        }
        if taken == 0 && sequencer.sensing_left() + 1 < self.need {
            recording.over = true;
        } else if let Some(fault) = fault {
            recording.taken = 0;
            self.expect(fault);
            return false;
        } else {
            recording.taken += 1;
            recording.over = recording.taken == self.need;
        }
        if recording.over {
            self.messages.release = period;
        }
        recording.over && recording.taken == self.need
    }
}
