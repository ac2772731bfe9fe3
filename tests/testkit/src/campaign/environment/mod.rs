//! The radio and the task of a radar module on a virtual clock, and the observer beside them.
//!
//! Slots begin, transfers end, and faults happen at any tick of the [`clock`](super::clock), and so between any two steps of the task.

use super::Outcome;
mod flips;

use super::clock::Clock;
use super::observer::{Copies, MODEL_FAULT, Observer, Report, Step};
use super::samples::Corruption;
use crate::flip_bit;
use crate::signals::noise;
use core::ops::Range;
use heapless::Vec;
use rand_core::SeedableRng;
use rand_xoshiro::Xoshiro128PlusPlus;
use sdp3_core::config::RadarConfig;
use sdp3_core::dsn::Classification;
use sdp3_core::radar::{Event, ProcessingContext, Progress, SlotAction, SlotContext};
use sdp3_core::scheduler::{Planner, SensingLayout, SlotUse, USERS};
use sdp3_core::supervision::retained::Retained;
use sdp3_core::supervision::{Fault, sample_health};

/// The two contexts of a radar module.
pub type Contexts<const VALUES: usize> = (SlotContext<VALUES>, ProcessingContext<VALUES>);

/// What happens to the samples of a sensing slot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Transfer {
    Done,
    /// The radio says that the slot was lost.
    Lost,
    /// Neither samples nor word of a loss come.
    Missing,
    Corrupted(Corruption),
    /// This bit of the samples flips after they have been written, before or after the end of the transfer.
    Flipped(u32),
}

/// What a fault that nothing finds has done.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Effects {
    pub logits: bool,
    pub class: bool,
}

/// A radar module among its faults, and the observer.
pub(super) struct Environment<const VALUES: usize> {
    contexts: Contexts<VALUES>,
    retained: &'static Retained,
    clock: Clock,
    pub observer: Observer,
    /// Number of the radio's next slot.
    pub number: u32,
    /// Where the samples of the last sensing slot lie.
    buffer: Range<*const u8>,
    /// Seed of the samples; `None`: they do not matter.
    seed: Option<u64>,
    /// Classification that every exit must give.
    known: Vec<Classification, { super::observer::EXITS }>,
    /// Periods of the classifications since the event began, and whether each was as known.
    pub classified: Vec<(u32, bool), 8>,
    /// Whether classifications may differ.
    pub lenient: bool,
    pub effects: Effects,
    reported: Vec<Fault, 16>,
    expected: Vec<Fault, 16>,
}

impl<const VALUES: usize> Environment<VALUES> {
    /// Contexts made with the settings of `planner` on `retained`, for exits that need so many sensing slots.
    pub fn new(
        contexts: Contexts<VALUES>,
        retained: &'static Retained,
        planner: Planner,
        needs: &[u32],
        number: u32,
        seed: Option<u64>,
    ) -> Self {
        Environment {
            contexts,
            retained,
            clock: Clock::new(number.into()),
            observer: Observer::new(planner, needs, number),
            number,
            buffer: core::ptr::null()..core::ptr::null(),
            seed,
            known: Vec::new(),
            classified: Vec::new(),
            lenient: false,
            effects: Effects::default(),
            reported: Vec::new(),
            expected: Vec::new(),
        }
    }

    pub fn invariant(&mut self, holds: bool) {
        self.observer.invariant(holds);
    }

    pub fn violations(&self) -> u64 {
        self.observer.outcome.violations
    }

    /// Forgets the reports of the event before.
    pub fn begin_event(&mut self) {
        self.clock.change();
        self.reported.clear();
        self.expected.clear();
        self.classified.clear();
        (self.observer.outcome, self.effects, self.lenient) = (Outcome::default(), Effects::default(), false);
    }

    /// Counts the event; `recovered`: its last period is as it must be. Every report that is due has been made.
    pub fn end_event(&mut self, recovered: bool, outcome: &mut Outcome) {
        let waits = self.observer.reports.iter().any(|report| matches!(report, Report::Fault(_)));
        self.invariant(!waits);
        let detected = self.reported == self.expected;
        let silent = self.reported.len() < self.expected.len();
        outcome.injected += 1;
        outcome.detected += u64::from(detected);
        outcome.recovered += u64::from(recovered);
        outcome.silent += u64::from(silent);
        outcome.violations += self.violations() + u64::from(!detected && !silent);
    }

    /// Whether something was reported since the event began.
    pub fn has_reported(&self) -> bool {
        !self.reported.is_empty()
    }

    /// Slots of the running period that have passed, 0 between two, and those that are left.
    pub fn position(&self) -> (u32, u32) {
        let sequencer = &self.observer.kept.sequencer;
        (sequencer.position(), sequencer.plan().period() - sequencer.position())
    }

    pub fn unplanned(&self) -> bool {
        self.observer.kept.unplanned
    }

    /// Changes what processing wants of the next plan.
    pub fn plan(&mut self, rates: &[u32; USERS], layout: Option<SensingLayout>) {
        for (user, &rate) in rates.iter().enumerate() {
            self.contexts.1.set_rate(user, rate);
            self.observer.planner().set_rate(user, rate);
        }
        if let Some(layout) = layout {
            let accepted = self.contexts.1.set_layout(layout).is_ok();
            self.invariant(accepted);
            self.observer.planner().set_layout(layout);
        }
        self.clock.wake();
    }

    pub fn rates(&mut self) -> [u32; USERS] {
        self.observer.planner().rates()
    }

    /// The task runs until then.
    fn advance(&mut self, until: u64) {
        while let Some(at) = self.clock.step.filter(|&at| at <= until) {
            let idle = self.poll();
            self.clock.step = if idle { None } else { Some(at + self.clock.ticks()) };
        }
        self.clock.now = until;
    }

    /// To any tick before the next slot.
    pub fn wait(&mut self) {
        let until = self.clock.within_slot();
        self.advance(until);
    }

    /// To the next slot.
    fn boundary(&mut self) {
        self.advance(self.clock.boundary);
        self.clock.next_slot();
    }

    /// The slot with the radio's next number, up to the end of its transfer.
    pub fn slot(&mut self, transfer: Transfer) -> SlotUse {
        self.boundary();
        let number = self.number;
        self.number = number.wrapping_add(1);
        let expected = self.observer.begin(number);
        let (action, fault) = self.begin(number, transfer);
        self.invariant(action == expected);
        self.clock.wake();
        if action != SlotUse::Sensing || transfer == Transfer::Missing {
            return action;
        }
        let flip = match transfer {
            Transfer::Flipped(bit) => Some((self.clock.within_slot(), bit)),
            _ => None,
        };
        let end = self.clock.within_slot();
        if let Some((at, bit)) = flip.filter(|(at, _)| *at < end) {
            self.advance(at);
            flip_bit(&self.buffer, bit);
        }
        self.advance(end);
        if transfer == Transfer::Lost {
            self.slot_lost();
            return action;
        }
        self.contexts.0.samples_ready();
        self.observer.samples_ready(fault);
        self.clock.wake();
        if let Some((at, bit)) = flip.filter(|(at, _)| *at >= end) {
            self.advance(at);
            flip_bit(&self.buffer, bit);
        }
        action
    }

    pub fn play(&mut self, slots: u32, transfer: Transfer) {
        for _ in 0..slots {
            self.slot(transfer);
        }
    }

    /// To the end of the running period.
    pub fn finish(&mut self, transfer: Transfer) {
        while self.position().0 > 0 {
            self.slot(transfer);
        }
    }

    /// A whole period.
    pub fn whole_period(&mut self, transfer: Transfer) {
        self.slot(transfer);
        self.finish(transfer);
    }

    /// What the module gives a number, and what is wrong with the samples that it gets.
    fn begin(&mut self, number: u32, transfer: Transfer) -> (SlotUse, Option<Fault>) {
        let samples = match self.contexts.0.begin(number) {
            SlotAction::Serve(user) => return (SlotUse::Communication(user), None),
            SlotAction::Idle => return (SlotUse::Idle, None),
            SlotAction::Sense(buffer) => &mut buffer.0,
        };
        let Range { start, end } = samples.as_ptr_range();
        self.buffer = start.cast()..end.cast();
        let Some(seed) = self.seed else { return (SlotUse::Sensing, None) };
        let before = self.observer.before();
        noise(&mut Xoshiro128PlusPlus::seed_from_u64(seed.wrapping_add(before.into())), samples);
        if let Transfer::Corrupted(corruption) = transfer {
            corruption.apply(samples);
        }
        (SlotUse::Sensing, sample_health::check(samples, &RadarConfig::PAPER).err().map(Fault::Samples))
    }

    /// Samples that no slot waits for.
    pub fn unexpected_samples(&mut self) {
        self.wait();
        self.contexts.0.samples_ready();
        self.observer.samples_ready(None);
        self.clock.wake();
    }

    /// The last slot was lost.
    pub fn slot_lost(&mut self) {
        self.wait();
        self.contexts.0.lost();
        self.observer.lost();
        self.clock.wake();
    }

    /// The radio's numbers jump forward.
    pub fn skip(&mut self, slots: u32) {
        self.number = self.number.wrapping_add(slots);
    }

    /// The number of the last slot once more.
    pub fn repeat(&mut self) {
        self.boundary();
        let expected = self.observer.repeat();
        let (action, _) = self.begin(self.number.wrapping_sub(1), Transfer::Done);
        self.invariant(action == expected);
        self.clock.wake();
    }

    /// A number of at least two slots before the next.
    pub fn late(&mut self, number: u32) {
        self.boundary();
        self.observer.late();
        let (action, _) = self.begin(number, Transfer::Done);
        self.invariant(action == SlotUse::Idle);
        self.clock.wake();
    }

    /// The radio counts from another number: one behind is given twice, so that it is not taken for a late one.
    pub fn count_from(&mut self, number: u32) {
        self.number = number;
        if number.wrapping_sub(self.observer.kept.next) >= 1 << 31 {
            self.late(number);
            self.skip(1);
        }
    }

    /// A reset at any tick: only the retained copies are left, as far as they are not damaged, and some slots pass.
    pub fn reset(
        &mut self,
        damage: Option<(Copies, (u32, u32))>,
        passed: u32,
        planner: Planner,
        make: impl FnOnce() -> Option<Contexts<VALUES>>,
    ) {
        self.slot(Transfer::Done);
        self.wait();
        if let Some((copies, change)) = damage {
            self.flip_retained(copies, change);
        }
        let Some(contexts) = make() else { return self.invariant(false) };
        self.contexts = contexts;
        self.observer.reset(damage.map(|(copies, _)| copies), planner, self.number);
        self.clock.wake();
        self.skip(passed);
    }

    /// One step of the task; whether it has nothing to do.
    fn poll(&mut self) -> bool {
        let (step, progress) = (self.observer.poll(), self.contexts.1.poll());
        let (idle, recognises) = (matches!(step, Step::Idle), matches!(step, Step::Recognition));
        let due = match step {
            Step::Period(report) => {
                self.invariant(progress == Progress::Event(Event::Period(report)));
                return false;
            }
            Step::Fault(fault) => self.expected.push(fault),
            Step::Busy | Step::Recognition | Step::Idle => Ok(()),
        };
        let known = match progress {
            Progress::Idle => idle,
            Progress::Busy => !idle,
            Progress::Event(Event::Fault(Fault::Model(_))) => {
                self.observer.refused() && recognises && self.reported.push(MODEL_FAULT).is_ok()
            }
            Progress::Event(Event::Fault(fault)) => self.reported.push(fault).is_ok(),
            Progress::Event(Event::Period(_)) => false,
            Progress::Event(Event::Classification { period, classification }) => {
                self.classified(period, &classification) && recognises
            }
        };
        self.invariant(due.is_ok() && known);
        idle
    }

    /// Whether a classification is the one that is due.
    fn classified(&mut self, period: u32, found: &Classification) -> bool {
        let due = self.observer.classified(period, found) || self.lenient;
        let exit = usize::from(found.exit);
        if exit == self.known.len() {
            return due && self.known.push(found.clone()).is_ok();
        }
        let Some(known) = self.known.get(exit) else { return false };
        self.effects.logits |= known.logits != found.logits;
        self.effects.class |= known.class != found.class;
        let same = known == found;
        let counted = self.classified.push((period, same)).is_ok();
        due && counted && (same || self.lenient)
    }
}
