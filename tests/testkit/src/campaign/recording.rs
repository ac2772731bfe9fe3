//! Faults during a recording, through the whole signal chain from samples to logits.
//!
//! An event is two periods of a [`Guarded`] station. A fault is injected into a recording of the first; the second has none. An
//! observer counts by itself which slots may sense, which faults must be reported, and whether enough sensing slots are left for a
//! new recording. The n-th samples of every recording are the same seeded noise, so that the logits of every classification must be
//! those of the first.

use super::samples::Corruption;
use super::{Outcome, SAMPLES, slot};
use crate::signals::noise;
use heapless::Vec;
use rand_core::{Rng, SeedableRng};
use sdp3_core::dsn::Kernels;
use sdp3_core::dsn::head::MAX_CLASSES;
use sdp3_core::scheduler::{PlanError, Sensing, SlotUse};
use sdp3_core::signal::stft::Stft;
use sdp3_core::supervision::sample_health::check;
use sdp3_core::supervision::station::{Guarded, Trouble};
use sdp3_core::supervision::watch::{CATCH_UP, Fault, WORDS, Watch};

/// Kinds of faults, in the order of [`Table`].
pub const KINDS: [&str; 12] = [
    "slots skipped",
    "slots skipped at the boundary",
    "outage",
    "clock drifts",
    "slot repeated",
    "slot late",
    "samples missing",
    "samples late",
    "samples twice",
    "samples silent",
    "samples, bit stuck",
    "reset",
];

/// Outcomes by [`KINDS`].
pub type Table = [Outcome; KINDS.len()];

/// N_m.
const SPACING: u32 = 3;

/// Number of the first slot: it wraps in the first periods.
const FIRST: u32 = u32::MAX - 2000;

/// The schedule a station must start with for recordings of `slots` sensing slots: each period has half as many again.
///
/// # Errors
///
/// [`PlanError`]: the recording is too long for a period.
pub fn watch(slots: u32) -> Result<Watch, PlanError> {
    let most = slots.saturating_add(slots / 2);
    let sensing = Sensing::new(most.saturating_mul(SPACING + 1), SPACING, most)?;
    Ok(Watch::new(sensing, [1500, 2500, 3000, 0, 0, 0, 0, 0], FIRST))
}

/// What happens to the samples of a sensing slot.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Samples {
    Given,
    Missing,
    Late,
    Twice,
    Corrupted(Corruption),
}

/// The radio and the counts of the observer.
struct Radio<'s, 'm, 'b, K, T> {
    station: &'s mut Guarded<'m, 'b, K, T>,
    seed: u64,
    /// Sensing slots of a recording, and the most of a period.
    need: u32,
    most: u32,
    /// Number of the next slot.
    number: u32,
    /// Slots and sensing slots of the period that have passed.
    position: u32,
    used: u32,
    /// Slots taken of the recording.
    taken: u32,
    /// Whether sensing of this period has ended.
    ended: bool,
    /// Whether the end takes effect in the next slot, which is then idle if it was planned for sensing.
    ends_next: bool,
    /// Faults of this event.
    reported: Vec<Trouble, 16>,
    expected: Vec<Trouble, 16>,
    verdicts: u32,
    /// Logits that every classification must have.
    logits: Option<Vec<i8, MAX_CLASSES>>,
    violations: u64,
}

fn below(rng: &mut impl Rng, limit: u32) -> u32 {
    ((u64::from(rng.next_u32()).wrapping_mul(u64::from(limit))) >> 32) as u32
}

impl<K: Kernels, T: Stft> Radio<'_, '_, '_, K, T> {
    fn invariant(&mut self, holds: bool) {
        self.violations += u64::from(!holds);
    }

    fn report(&mut self, trouble: Trouble) {
        let _ = self.reported.push(trouble); // more than sixteen are wrong in any case
    }

    fn expect(&mut self, trouble: Trouble) {
        let _ = self.expected.push(trouble);
    }

    fn period(&self) -> u32 {
        self.most * (SPACING + 1)
    }

    fn new_period(&mut self) {
        (self.position, self.used, self.taken, self.ended) = (0, 0, 0, false);
    }

    /// The recording is lost: another one starts if there are slots for it.
    fn gap(&mut self) {
        self.taken = 0;
        self.ended |= self.most.saturating_sub(self.used) < self.need;
    }

    fn samples<R: Rng + SeedableRng>(&self) -> [i16; SAMPLES] {
        let mut samples = [0; SAMPLES];
        noise(&mut R::seed_from_u64(self.seed.wrapping_add(u64::from(self.taken))), &mut samples);
        samples
    }

    /// Begins a slot. Returns whether it senses.
    fn begin(&mut self) -> bool {
        if self.position == self.period() {
            self.new_period();
        }
        let planned = self.position.is_multiple_of(SPACING + 1);
        let senses = planned && !self.ended;
        let idle = core::mem::take(&mut self.ends_next) && planned;
        let begun = self.station.begin(self.number);
        self.number = self.number.wrapping_add(1);
        begun.troubles.iter().for_each(|&trouble| self.report(trouble));
        self.invariant(match begun.slot {
            SlotUse::Sensing => senses,
            SlotUse::Idle => idle,
            SlotUse::Communication(_) => !senses && !idle,
        });
        self.position += 1;
        self.used += u32::from(senses);
        senses
    }

    /// Gives the samples of slot `number`.
    fn give(&mut self, number: u32, samples: &[i16; SAMPLES]) {
        match self.station.sensed(number, &slot(samples)) {
            Ok(verdict) => {
                self.taken += 1;
                let complete = self.taken == self.need;
                self.invariant(verdict.is_some() == complete);
                if let Some(verdict) = verdict {
                    let first = self.logits.get_or_insert_with(|| verdict.answer.logits.clone());
                    let same = *first == verdict.answer.logits;
                    self.invariant(same && verdict.stop);
                    self.verdicts += 1;
                }
                self.ended |= complete;
            }
            Err(trouble) => self.report(trouble),
        }
    }

    /// A slot; `what` happens to its samples if it senses.
    fn slot<R: Rng + SeedableRng>(&mut self, what: Samples) {
        let number = self.number;
        if !self.begin() {
            return;
        }
        let mut samples = self.samples::<R>();
        match what {
            Samples::Given => self.give(number, &samples),
            Samples::Twice => {
                self.give(number, &samples);
                self.expect(Trouble::Unasked);
                self.give(number, &samples);
            }
            Samples::Missing | Samples::Late => {
                self.expect(Trouble::Missing);
                self.gap();
                if what == Samples::Late {
                    self.slot::<R>(Samples::Given);
                    self.expect(Trouble::Unasked);
                    self.give(number, &samples);
                }
            }
            Samples::Corrupted(corruption) => {
                corruption.apply(&mut samples);
                match check(&slot(&samples)) {
                    Ok(()) => self.violations += 1, // only kinds that are always detected are injected
                    Err(fault) => self.expect(Trouble::Samples(fault)),
                }
                self.gap();
                self.give(number, &samples);
            }
        }
    }

    /// Runs to the end of the period.
    fn finish<R: Rng + SeedableRng>(&mut self) {
        for _ in self.position..self.period() {
            self.slot::<R>(Samples::Given);
        }
    }

    /// Skips slot numbers.
    fn skip(&mut self, slots: u32) {
        if self.position == self.period() {
            self.new_period();
        }
        self.number = self.number.wrapping_add(slots);
        if slots > CATCH_UP || slots >= self.period() - self.position {
            self.expect(Trouble::Slot(Fault::Outage { slots }));
            self.new_period();
            return;
        }
        let passed = |position: u32| position.div_ceil(SPACING + 1);
        let sensing = match self.ended {
            true => 0,
            false => passed(self.position + slots) - passed(self.position),
        };
        self.position += slots;
        self.used += sensing;
        self.expect(Trouble::Slot(Fault::Skipped { slots, sensing }));
        if sensing > 0 {
            let before = self.ended;
            self.gap();
            self.ends_next = self.ended && !before;
        }
    }

    /// A slot with an earlier number.
    fn out_of_order(&mut self, back: u32, fault: Fault) {
        let begun = self.station.begin(self.number.wrapping_sub(back));
        begun.troubles.iter().for_each(|&trouble| self.report(trouble));
        self.expect(Trouble::Slot(fault));
        self.invariant((begun.slot == SlotUse::Idle) == (fault == Fault::Late));
    }

    /// Applies the fault.
    fn apply<R: Rng + SeedableRng>(&mut self, kind: usize, rng: &mut R) {
        match kind {
            0 => self.skip(1 + below(rng, 8)),
            1 => {
                self.finish::<R>();
                self.skip(1 + below(rng, 8));
            }
            2 => self.skip(CATCH_UP + 1 + below(rng, 500)),
            3 => {
                let fast = below(rng, 2) == 0;
                for _ in 0..4 {
                    for _ in 0..1 + below(rng, 100) {
                        self.slot::<R>(Samples::Given);
                    }
                    if fast { self.skip(1) } else { self.out_of_order(1, Fault::Repeated) }
                }
            }
            4 => self.out_of_order(1, Fault::Repeated),
            5 => self.out_of_order(2 + below(rng, 1000), Fault::Late),
            6 => self.slot::<R>(Samples::Missing),
            7 => self.slot::<R>(Samples::Late),
            8 => self.slot::<R>(Samples::Twice),
            9 | 10 => self.slot::<R>(Samples::Corrupted(Corruption::random(kind - 9, rng))),
            _ => {
                let mut memory = [0; WORDS];
                self.station.watch().save(&mut memory);
                let restored = self.station.restore(&memory);
                self.invariant(restored);
                self.gap();
                let slots = below(rng, 8);
                if slots > 0 {
                    self.skip(slots);
                }
            }
        }
    }

    /// One event.
    fn inject<R: Rng + SeedableRng>(&mut self, kind: usize, rng: &mut R, outcome: &mut Outcome) {
        (self.violations, self.verdicts) = (0, 0);
        self.reported.clear();
        self.expected.clear();
        // before any sensing slot of the recording
        let before = 1 + below(rng, self.need - 1);
        for _ in 0..before * (SPACING + 1) {
            self.slot::<R>(Samples::Given);
        }
        self.apply(kind, rng);
        self.finish::<R>();
        let (detected, silent) = (self.reported == self.expected, self.reported.is_empty());
        let violations = self.violations;
        (self.violations, self.verdicts) = (0, 0);
        self.reported.clear();
        self.slot::<R>(Samples::Given);
        self.finish::<R>();
        outcome.injected += 1;
        outcome.detected += u64::from(detected);
        outcome.recovered +=
            u64::from(self.violations == 0 && self.reported.is_empty() && self.verdicts == 1);
        outcome.silent += u64::from(!detected && silent);
        outcome.violations += violations + self.violations + u64::from(!detected && !silent);
    }
}

/// Injects `events` faults of all kinds in turn into recordings of a station with the schedule [`watch`] and one exit.
pub fn run<R, K, T>(station: &mut Guarded<'_, '_, K, T>, seed: u64, events: u64) -> Table
where
    R: Rng + SeedableRng,
    K: Kernels,
    T: Stft,
{
    let need = station.receiver().exits().first().map_or(1, |exit| exit.model.sensing_slots()) as u32;
    let most = station.watch().scheduler().wanted().slots();
    let mut rng = R::seed_from_u64(seed);
    let mut table = Table::default();
    let mut radio = Radio {
        station,
        seed: seed.wrapping_mul(1 << 16),
        need,
        most,
        number: FIRST,
        position: 0,
        used: 0,
        taken: 0,
        ended: false,
        ends_next: false,
        reported: Vec::new(),
        expected: Vec::new(),
        verdicts: 0,
        logits: None,
        violations: 0,
    };
    radio.finish::<R>();
    for event in 0..events {
        let kind = (event % KINDS.len() as u64) as usize;
        if let Some(outcome) = table.get_mut(kind) {
            radio.inject(kind, &mut rng, outcome);
        }
    }
    table
}
