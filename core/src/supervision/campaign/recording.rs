//! Recordings that are disturbed on their way through the whole chain, samples to logits.
//!
//! An event is two periods of a [`Guarded`] station. In the first one thing goes wrong while a recording is under way; the second is
//! undisturbed. An observer counts slots on his own: which may sense, which troubles are to be told, and whether enough sensing slots
//! are left for a recording that begins anew. The n-th samples of every recording are the same seeded noise, so that every verdict,
//! of either period, must have the logits of the first.

use super::Outcome;
use super::samples::Spoil;
use crate::dims::{Iq, SLOT_SAMPLES, Slot};
use crate::dsn::Kernels;
use crate::dsn::head::MAX_CLASSES;
use crate::scheduler::{PlanError, Sensing, SlotUse};
use crate::selftest::noise;
use crate::signal::stft::Stft;
use crate::supervision::sample_health::check;
use crate::supervision::station::{Guarded, Trouble};
use crate::supervision::watch::{CATCH_UP, Fault, WORDS, Watch};
use heapless::Vec;
use rand_core::{Rng, SeedableRng};

/// What goes wrong.
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

/// Number of the radio's first slot: it wraps in the first periods.
const FIRST: u32 = u32::MAX - 2000;

/// The schedule a station must begin with for recordings of `slots` sensing slots: half as many again in a period.
///
/// # Errors
///
/// [`PlanError`]: a recording too long for a period.
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
    Spoiled(Spoil),
}

/// The radio, and the observer's books.
struct Radio<'s, 'm, 'b, K, T> {
    station: &'s mut Guarded<'m, 'b, K, T>,
    seed: u64,
    /// Sensing slots of a recording, and at most of a period.
    need: u32,
    most: u32,
    /// Number of the next slot.
    number: u32,
    /// Slots and sensing slots of the period that have passed.
    position: u32,
    used: u32,
    /// Slots of the recording.
    heard: u32,
    /// Whether the period senses no more.
    over: bool,
    /// Whether that was found as the next slot, planned for sensing or not, began.
    vain: bool,
    /// Of this event.
    told: Vec<Trouble, 16>,
    expected: Vec<Trouble, 16>,
    verdicts: u32,
    /// What every verdict must be.
    logits: Option<Vec<i8, MAX_CLASSES>>,
    broken: u64,
}

fn below(rng: &mut impl Rng, limit: u32) -> u32 {
    ((u64::from(rng.next_u32()).wrapping_mul(u64::from(limit))) >> 32) as u32
}

impl<K: Kernels, T: Stft> Radio<'_, '_, '_, K, T> {
    fn promise(&mut self, kept: bool) {
        self.broken += u64::from(!kept);
    }

    fn tell(&mut self, trouble: Trouble) {
        let _ = self.told.push(trouble); // sixteen are too many anyway
    }

    fn expect(&mut self, trouble: Trouble) {
        let _ = self.expected.push(trouble);
    }

    fn period(&self) -> u32 {
        self.most * (SPACING + 1)
    }

    fn new_period(&mut self) {
        (self.position, self.used, self.heard, self.over) = (0, 0, 0, false);
    }

    /// The recording is spoiled: another one, if there are slots for it.
    fn gap(&mut self) {
        self.heard = 0;
        self.over |= self.most.saturating_sub(self.used) < self.need;
    }

    fn samples<R: Rng + SeedableRng>(&self) -> Slot {
        let mut slot: Slot = [Iq { i: 0, q: 0 }; SLOT_SAMPLES];
        noise(&mut R::seed_from_u64(self.seed.wrapping_add(u64::from(self.heard))), &mut slot);
        slot
    }

    /// A slot begins; whether it senses.
    fn begin(&mut self) -> bool {
        if self.position == self.period() {
            self.new_period();
        }
        let planned = self.position.is_multiple_of(SPACING + 1);
        let senses = planned && !self.over;
        let idle = core::mem::take(&mut self.vain) && planned;
        let begun = self.station.begin(self.number);
        self.number = self.number.wrapping_add(1);
        begun.troubles.iter().for_each(|&trouble| self.tell(trouble));
        self.promise(match begun.slot {
            SlotUse::Sensing => senses,
            SlotUse::Idle => idle,
            SlotUse::Communication(_) => !senses && !idle,
        });
        self.position += 1;
        self.used += u32::from(senses);
        senses
    }

    /// Samples for the slot of a number.
    fn give(&mut self, number: u32, slot: &Slot) {
        match self.station.sensed(number, slot) {
            Ok(verdict) => {
                self.heard += 1;
                let whole = self.heard == self.need;
                self.promise(verdict.is_some() == whole);
                if let Some(verdict) = verdict {
                    let first = self.logits.get_or_insert_with(|| verdict.answer.logits.clone());
                    let same = *first == verdict.answer.logits;
                    self.promise(same && verdict.stop);
                    self.verdicts += 1;
                }
                self.over |= whole;
            }
            Err(trouble) => self.tell(trouble),
        }
    }

    /// A slot, and what happens to its samples if it senses.
    fn slot<R: Rng + SeedableRng>(&mut self, what: Samples) {
        let number = self.number;
        if !self.begin() {
            return;
        }
        let slot = self.samples::<R>();
        match what {
            Samples::Given => self.give(number, &slot),
            Samples::Twice => {
                self.give(number, &slot);
                self.expect(Trouble::Unasked);
                self.give(number, &slot);
            }
            Samples::Missing | Samples::Late => {
                self.expect(Trouble::Missing);
                self.gap();
                if what == Samples::Late {
                    self.slot::<R>(Samples::Given);
                    self.expect(Trouble::Unasked);
                    self.give(number, &slot);
                }
            }
            Samples::Spoiled(spoil) => {
                let mut slot = slot;
                spoil.apply(&mut slot);
                match check(&slot) {
                    Ok(()) => self.broken += 1, // only certain ones are tried
                    Err(fault) => self.expect(Trouble::Samples(fault)),
                }
                self.gap();
                self.give(number, &slot);
            }
        }
    }

    /// To the end of the period.
    fn finish<R: Rng + SeedableRng>(&mut self) {
        for _ in self.position..self.period() {
            self.slot::<R>(Samples::Given);
        }
    }

    /// Numbers pass unnoticed.
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
        let sensing = match self.over {
            true => 0,
            false => passed(self.position + slots) - passed(self.position),
        };
        self.position += slots;
        self.used += sensing;
        self.expect(Trouble::Slot(Fault::Skipped { slots, sensing }));
        if sensing > 0 {
            let before = self.over;
            self.gap();
            self.vain = self.over && !before;
        }
    }

    /// The slot of a number that is none of the next ones.
    fn aside(&mut self, back: u32, fault: Fault) {
        let begun = self.station.begin(self.number.wrapping_sub(back));
        begun.troubles.iter().for_each(|&trouble| self.tell(trouble));
        self.expect(Trouble::Slot(fault));
        self.promise((begun.slot == SlotUse::Idle) == (fault == Fault::Late));
    }

    /// One thing goes wrong.
    fn disturb<R: Rng + SeedableRng>(&mut self, kind: usize, rng: &mut R) {
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
                    if fast { self.skip(1) } else { self.aside(1, Fault::Repeated) }
                }
            }
            4 => self.aside(1, Fault::Repeated),
            5 => self.aside(2 + below(rng, 1000), Fault::Late),
            6 => self.slot::<R>(Samples::Missing),
            7 => self.slot::<R>(Samples::Late),
            8 => self.slot::<R>(Samples::Twice),
            9 | 10 => self.slot::<R>(Samples::Spoiled(Spoil::random(kind - 9, rng))),
            _ => {
                let mut memory = [0; WORDS];
                self.station.watch().save(&mut memory);
                let restored = self.station.restore(&memory);
                self.promise(restored);
                self.gap();
                let slots = below(rng, 8);
                if slots > 0 {
                    self.skip(slots);
                }
            }
        }
    }

    /// One event.
    fn suffer<R: Rng + SeedableRng>(&mut self, kind: usize, rng: &mut R, outcome: &mut Outcome) {
        (self.broken, self.verdicts) = (0, 0);
        self.told.clear();
        self.expected.clear();
        // before a sensing slot of the recording, the first and the last among them
        let before = 1 + below(rng, self.need - 1);
        for _ in 0..before * (SPACING + 1) {
            self.slot::<R>(Samples::Given);
        }
        self.disturb(kind, rng);
        self.finish::<R>();
        let (told, silent) = (self.told == self.expected, self.told.is_empty());
        let broken = self.broken;
        (self.broken, self.verdicts) = (0, 0);
        self.told.clear();
        self.slot::<R>(Samples::Given);
        self.finish::<R>();
        outcome.injected += 1;
        outcome.detected += u64::from(told);
        outcome.recovered += u64::from(self.broken == 0 && self.told.is_empty() && self.verdicts == 1);
        outcome.silent += u64::from(!told && silent);
        outcome.broken += broken + self.broken + u64::from(!told && !silent);
    }
}

/// `events` disturbed recordings of all kinds in turn, through a station that was made with [`watch`] and has one exit.
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
        heard: 0,
        over: false,
        vain: false,
        told: Vec::new(),
        expected: Vec::new(),
        verdicts: 0,
        logits: None,
        broken: 0,
    };
    radio.finish::<R>();
    for event in 0..events {
        let kind = (event % KINDS.len() as u64) as usize;
        if let Some(outcome) = table.get_mut(kind) {
            radio.suffer(kind, &mut rng, outcome);
        }
    }
    table
}
