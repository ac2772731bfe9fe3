//! Faults against the supervised schedule, checked by an observer that counts slots by itself.

use super::Outcome;
use heapless::Vec;
use rand_core::Rng;
use sdp3_core::scheduler::{Changes, Plan, RECEIVERS, Sensing, SlotUse};
use sdp3_core::state::State;
use sdp3_core::supervision::watch::{Fault, Step, WORDS, Watch};

/// Slots that a drifting clock gains or loses in one event.
const SLIPS: usize = 4;

/// Words of the state of [`Watch`] before its two backups.
const BACKUPS_AT: u32 = WORDS as u32 - 24;

/// The schedule, its configuration, and what the observer saw of the running period.
#[derive(Debug)]
pub struct Environment {
    watch: Watch,
    /// Number of the radio's next slot.
    number: u32,
    sensing: Sensing,
    rates: [u32; RECEIVERS],
    plan: Plan,
    /// Slots of the period that have passed.
    position: u32,
    served: [u32; RECEIVERS],
    sensed: u32,
    /// Whether slots of this period were skipped, so that its totals differ from those of the plan.
    gap: bool,
    faults: Vec<Fault, 8>,
    /// Changes reported at the boundaries.
    changes: Changes,
    violations: u64,
}

fn below(rng: &mut impl Rng, limit: u32) -> u32 {
    ((u64::from(rng.next_u32()).wrapping_mul(u64::from(limit))) >> 32) as u32
}

fn layout(rng: &mut impl Rng) -> Sensing {
    loop {
        let (period, spacing) = (20 + below(rng, 40), below(rng, 5));
        if let Ok(sensing) = Sensing::new(period, spacing, below(rng, 20)) {
            return sensing;
        }
    }
}

fn rates(rng: &mut impl Rng) -> [u32; RECEIVERS] {
    let mut rates = [0; RECEIVERS];
    let users = 1 + below(rng, RECEIVERS as u32);
    rates.iter_mut().take(users as usize).for_each(|rate| *rate = 1 + below(rng, 1000));
    rates
}

impl Environment {
    /// A random schedule whose counter is about to wrap.
    pub fn new(rng: &mut impl Rng) -> Self {
        let (sensing, rates) = (layout(rng), rates(rng));
        let number = u32::MAX - below(rng, 1000);
        Environment {
            watch: Watch::new(sensing, rates, number),
            number,
            sensing,
            rates,
            plan: Plan::optimal(sensing, &rates, &[0; RECEIVERS]),
            position: 0,
            served: [0; RECEIVERS],
            sensed: 0,
            gap: false,
            faults: Vec::new(),
            changes: Changes::default(),
            violations: 0,
        }
    }

    fn invariant(&mut self, holds: bool) {
        self.violations += u64::from(!holds);
    }

    /// A period begins: its plan must be that of the configuration.
    fn begin(&mut self) {
        self.plan = self.watch.scheduler().plan().clone();
        let c = self.watch.scheduler().boundary().changes;
        self.changes.left |= c.left;
        self.changes.sensing |= c.sensing;
        (self.position, self.served, self.sensed, self.gap) = (0, [0; RECEIVERS], 0, false);
        let slots = self.plan.shares().iter().copied().fold(self.plan.sensing(), u32::saturating_add);
        let present = self.rates.iter().any(|&rate| rate > 0);
        self.invariant(self.plan.layout() == self.sensing);
        self.invariant(slots == self.sensing.period() || !present);
        let absent = self.plan.shares().iter().zip(self.rates).all(|(&share, rate)| share == 0 || rate > 0);
        self.invariant(absent);
    }

    /// Holds a slot to the plan, and the last slot of a period to the totals.
    fn observe(&mut self, step: Step) {
        self.position += 1;
        let senses = self.plan.senses(self.position);
        self.invariant(senses == (step.slot == SlotUse::Sensing));
        match step.slot {
            SlotUse::Sensing => self.sensed += 1,
            SlotUse::Communication(k) => self.served.iter_mut().skip(k.into()).take(1).for_each(|n| *n += 1),
            SlotUse::Idle => {
                let shared = self.plan.shares().iter().any(|&share| share > 0);
                self.invariant(!shared);
            }
        }
        if self.position == self.plan.period() && !self.gap {
            let totals = self.plan.shares().iter().zip(self.served).all(|(&share, served)| share == served);
            self.invariant(totals && self.sensed == self.plan.sensing());
        }
    }

    /// The slot with the next number of the radio.
    fn slot(&mut self) -> Step {
        let step = self.watch.next(self.number);
        self.number = self.number.wrapping_add(1);
        if step.begins {
            // a period ends early only with a reported fault
            let whole = self.position == self.plan.period() || step.fault.is_some() || self.position == 0;
            self.invariant(whole);
            self.begin();
        }
        if let Some(fault) = step.fault {
            if let Fault::Skipped { slots, .. } = fault {
                self.position = self.position.saturating_add(slots);
                self.gap = true;
            }
            let _ = self.faults.push(fault); // more than eight are wrong in any case
        }
        step
    }

    fn play(&mut self, slots: u32) {
        for _ in 0..slots {
            let step = self.slot();
            self.observe(step);
        }
    }

    /// To the end of the running period.
    fn finish(&mut self) {
        self.play(self.plan.period().saturating_sub(self.position));
    }

    /// Flips the bits of `mask` in a word of the supervised state. Returns whether that was effective.
    fn flip(&mut self, at: u32, mask: u32) -> bool {
        let (mut n, mut before) = (0, 0);
        self.watch.words(&mut |word| {
            if n == at {
                before = *word;
                *word ^= mask;
            }
            n += 1;
        });
        let (mut n, mut after) = (0, 0);
        self.watch.words(&mut |word| {
            after = if n == at { *word } else { after };
            n += 1;
        });
        before != after
    }

    /// Flips bits of a random word of `from..to`, until that is effective.
    fn flip_any(&mut self, (from, to): (u32, u32), mask: impl Fn(u32) -> u32, rng: &mut impl Rng) {
        for _ in 0..1000 {
            let at = from + below(rng, to - from);
            if self.flip(at, mask(rng.next_u32())) {
                return;
            }
        }
        self.violations += 1;
    }

    /// Injects a fault of `kind`, an index of [`super::KINDS`], at a random slot; a period without a fault follows.
    pub(super) fn inject(&mut self, kind: usize, rng: &mut impl Rng, outcome: &mut Outcome) {
        self.play(1);
        self.play(below(rng, self.plan.period().saturating_sub(3)));
        self.faults.clear();
        (self.changes, self.violations) = (Changes::default(), 0);
        let as_expected = self.apply(kind, rng);
        self.finish();
        let before = self.violations;
        self.play(1);
        self.finish();
        let c = &self.changes;
        let detected = match (kind, self.faults.as_slice()) {
            (0 | 15, [Fault::Skipped { .. }]) | (1, [Fault::Outage { .. }]) => true,
            (2, [Fault::Repeated]) | (3, [Fault::Late]) | (4, [Fault::Late, Fault::Recounted]) => true,
            (5, []) => c.left.count_ones() == 1,
            (6, []) => c.sensing,
            (7 | 8, [] | [Fault::Skipped { .. }]) => as_expected,
            (14, reported) => as_expected && reported.len() == SLIPS,
            (9 | 10 | 12, [Fault::Schedule]) | (11, [Fault::Spare]) | (13, [Fault::Forgotten]) => true,
            _ => false,
        };
        outcome.injected += 1;
        outcome.detected += u64::from(detected);
        outcome.recovered += u64::from(self.violations == before);
        outcome.silent += u64::from(!detected && self.faults.is_empty());
        outcome.violations += self.violations + u64::from(!detected && !self.faults.is_empty());
    }

    /// Applies the fault. Returns whether a reset took intact memory and refused damaged memory, and whether every slip of a clock
    /// was reported by its name.
    fn apply(&mut self, kind: usize, rng: &mut impl Rng) -> bool {
        let left = self.plan.period().saturating_sub(self.position);
        match kind {
            0 => self.number = self.number.wrapping_add(1 + below(rng, left.saturating_sub(1).min(8))),
            1 => self.number = self.number.wrapping_add(left.max(1) + below(rng, 500)),
            2 | 3 => {
                let (back, slot) = match kind {
                    2 => (1, self.watch.scheduler().last()),
                    _ => (2 + below(rng, 1000), SlotUse::Idle),
                };
                let step = self.watch.next(self.number.wrapping_sub(back));
                self.invariant(step.slot == slot && !step.begins);
                let _ = step.fault.map(|fault| self.faults.push(fault));
            }
            4 => {
                self.number = self.number.wrapping_sub(2 + below(rng, 1 << 30));
                let step = self.slot();
                self.invariant(step.slot == SlotUse::Idle);
            }
            5 => {
                let gone = self.rates.iter().position(|&rate| rate > 0).unwrap_or(0);
                self.set_rate(gone, 0);
            }
            6 => {
                self.play(left.saturating_sub(1));
                let (sensing, wanted) = (layout(rng), rates(rng));
                self.watch.set_sensing(sensing);
                // the same layout again would be no change
                self.changes.sensing = sensing == self.sensing;
                self.sensing = sensing;
                wanted.into_iter().enumerate().for_each(|(k, rate)| self.set_rate(k, rate));
            }
            7 | 8 => return self.reset(kind == 8, left, rng),
            14 => return self.drift(rng),
            15 => {
                let before = 2 + below(rng, self.sensing.period() - 12);
                self.restart(before.wrapping_neg());
                self.play(before - 2);
                // the last number before the wrap is among those skipped
                self.number = self.number.wrapping_add(1 + below(rng, 8));
            }
            9 => self.flip_any((0, BACKUPS_AT), |word| 1 << (word % 32), rng),
            10 => self.flip_any((0, BACKUPS_AT), |word| word.max(1), rng),
            11 => self.flip_any((BACKUPS_AT, WORDS as u32), |word| 1 << (word % 32), rng),
            _ => {
                self.flip_any((0, BACKUPS_AT), |word| 1 << (word % 32), rng);
                self.flip_any((BACKUPS_AT, BACKUPS_AT + 12), |word| 1 << (word % 32), rng);
                if kind == 13 {
                    self.flip_any((BACKUPS_AT + 12, WORDS as u32), |word| 1 << (word % 32), rng);
                    let step = self.slot();
                    let next = self.slot();
                    self.invariant(step.slot == SlotUse::Idle && next.slot == SlotUse::Idle);
                    self.watch.configure(self.sensing, self.rates);
                    self.position = self.plan.period();
                    self.play(1);
                }
            }
        }
        false
    }

    fn set_rate(&mut self, k: usize, rate: u32) {
        self.watch.set_rate(k, rate);
        self.rates.iter_mut().skip(k).take(1).for_each(|own| *own = rate);
    }

    /// A reset: all state but the kept memory is lost, and some slots pass. Returns whether intact memory was taken and damaged
    /// memory refused.
    fn reset(&mut self, damage: bool, left: u32, rng: &mut impl Rng) -> bool {
        let (mut memory, mut again) = ([0; WORDS], [0; WORDS]);
        self.watch.save(&mut memory);
        let intact = memory;
        if damage {
            let (at, bit) = (below(rng, WORDS as u32) as usize, below(rng, 32));
            memory.iter_mut().skip(at).take(1).for_each(|word| *word ^= 1 << bit);
        }
        self.number = self.number.wrapping_add(below(rng, left.saturating_sub(1).min(4)));
        match Watch::restore(&memory) {
            Some(mut watch) => {
                // upper bits of a byte are not state
                watch.save(&mut again);
                self.watch = watch;
                again == intact
            }
            None => {
                self.restart(self.number);
                damage
            }
        }
    }

    /// Starts without kept memory; the first slot of a period passes.
    fn restart(&mut self, number: u32) {
        self.number = number;
        self.watch = Watch::new(self.sensing, self.rates, number);
        self.position = self.plan.period();
        self.play(1);
    }

    /// The clock of the radio runs fast (a number is missing now and then) or slow (a number comes twice). Returns whether each slip
    /// was reported.
    fn drift(&mut self, rng: &mut impl Rng) -> bool {
        let fast = below(rng, 2) == 0;
        let mut reported = true;
        for _ in 0..SLIPS {
            self.play(below(rng, 60));
            if fast {
                self.number = self.number.wrapping_add(1);
                self.play(1);
                let skipped = matches!(self.faults.last(), Some(Fault::Skipped { slots: 1, .. }));
                // the last slot of a period and an outage are the same
                reported &= skipped || self.faults.last() == Some(&Fault::Outage { slots: 1 });
            } else {
                self.play(1);
                let step = self.watch.next(self.number.wrapping_sub(1));
                self.invariant(step.slot == self.watch.scheduler().last() && !step.begins);
                let _ = step.fault.map(|fault| self.faults.push(fault));
                reported &= self.faults.last() == Some(&Fault::Repeated);
            }
        }
        reported
    }
}
