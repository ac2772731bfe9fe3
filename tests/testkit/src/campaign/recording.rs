//! Faults during a recording, through the whole signal chain from samples to logits, at any tick of the virtual clock.
//!
//! A fault is injected into a recording of one period; the next has none. The n-th samples of every recording are the same seeded
//! noise, so that the classifications of every recording must be those of the first, by both of its exits.

use super::environment::{Contexts, Environment, Transfer};
use super::observer::{CATCH_UP, Copies, EXITS};
use super::samples::{self, Corruption};
use super::schedule::{drift, one_bit};
use super::{Outcome, below};
use core::mem::take;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;
use sdp3_core::crc32::crc32;
use sdp3_core::dsn::Model;
use sdp3_core::early_exit::EarlyExit;
use sdp3_core::radar::Settings;
use sdp3_core::scheduler::{PlanError, Planner, SensingLayout};
use sdp3_core::supervision::retained::Retained;

/// Kinds of faults, in the order of [`Table`].
pub const KINDS: [&str; 16] = [
    "slots skipped",
    "slots skipped at the boundary",
    "outage",
    "clock drifts",
    "slot repeated",
    "slot late",
    "samples lost",
    "samples missing",
    "samples late",
    "samples twice",
    "samples corrupted",
    "newest copy, one bit",
    "both copies, one bit each",
    "waiting plan, one bit",
    "model, one bit",
    "reset",
];

const MODEL: usize = KINDS.len() - 2;

/// Outcomes by [`KINDS`].
pub type Table = [Outcome; KINDS.len()];

/// N_m.
const SPACING: u32 = 4;

/// Number of the first slot: it wraps in the first periods.
const FIRST: u32 = u32::MAX - 2000;

/// Sensing slots of the first exit.
const FIRST_EXIT: u32 = 144;

/// The settings for recordings of `need` sensing slots: each period has half as many again.
///
/// # Errors
///
/// [`PlanError`]: the recording is too long for a period.
pub fn settings(need: u32) -> Result<Settings, PlanError> {
    let most = need.saturating_add(need / 2);
    let layout = SensingLayout::new(most.saturating_mul(SPACING + 1), SPACING, most)?;
    Ok(Settings { layout, rates: [1500, 2500, 3000, 0, 0, 0, 0, 0], threshold: 2.0 })
}

/// Writes the model of the first exit over a copy of the last one's: the same network for fewer sensing slots.
pub fn shorten(file: &mut [u8]) {
    let Ok(model) = Model::parse(file) else { return };
    let frames = model.preprocessing().frames(FIRST_EXIT as usize) as u16;
    for (at, value) in [(12, FIRST_EXIT as u16), (26, frames)] {
        file.iter_mut().skip(at).zip(value.to_le_bytes()).for_each(|(to, byte)| *to = byte);
    }
    if let Some((content, checksum)) = file.split_last_chunk_mut() {
        *checksum = crc32(content).to_le_bytes();
    }
}

/// The early exits of two models.
pub fn exits(files: [&'static [u8]; EXITS]) -> Option<[EarlyExit<'static>; EXITS]> {
    let [first, mut last] =
        [Model::parse(files[0]).ok()?, Model::parse(files[1]).ok()?].map(EarlyExit::single);
    (last.weights[0], last.weights[1]) = (first.weights[0], last.weights[0]);
    Some([first, last])
}

/// A module that makes recordings.
pub struct Recordings<const VALUES: usize, M> {
    pub(super) radio: Environment<VALUES>,
    settings: Settings,
    pub(super) need: u32,
    files: [&'static [u8]; EXITS],
    make: M,
    pub(super) rng: Xoshiro128PlusPlus,
}

impl<const VALUES: usize, M: FnMut() -> Option<Contexts<VALUES>>> Recordings<VALUES, M> {
    /// `make` makes contexts with [`settings`] and [`exits`] of `files`, in memory that can be written, on `retained`: once now, and
    /// for every reset.
    pub fn new(
        need: u32,
        files: [&'static [u8]; EXITS],
        retained: &'static Retained,
        mut make: M,
        seed: u64,
    ) -> Option<Self> {
        let settings = settings(need).ok()?;
        let planner = Planner::new(settings.layout, settings.rates);
        let samples = Some(seed.wrapping_mul(1 << 16));
        let radio = Environment::new(make()?, retained, planner, &[FIRST_EXIT, need], FIRST, samples);
        let rng = Xoshiro128PlusPlus::seed_from_u64(seed);
        let mut recordings = Recordings { radio, settings, need, files, make, rng };
        // a kilobyte a step, and one for what is found
        let steps = |file: &[u8]| file.len().saturating_sub(4).div_ceil(1024) as u32 + 1;
        recordings.radio.observer.checks = files.map(steps);
        recordings.radio.whole_period(Transfer::Done);
        recordings.classify();
        Some(recordings)
    }

    /// Injects `events` faults of all kinds in turn.
    pub fn run(&mut self, events: u64) -> Table {
        let mut table = Table::default();
        for event in 0..events {
            let kind = (event % KINDS.len() as u64) as usize;
            let Some(outcome) = table.get_mut(kind) else { continue };
            self.radio.begin_event();
            self.play_some();
            self.apply(kind);
            self.radio.slot(Transfer::Done);
            let recovered = self.end();
            self.radio.end_event(recovered, outcome);
        }
        table
    }

    /// To a random sensing slot of a recording that is not yet complete.
    fn play_some(&mut self) {
        let passed = self.radio.position().0.div_ceil(SPACING + 1);
        let slots = 1 + below(&mut self.rng, self.need.saturating_sub(1 + passed).max(1));
        self.play_sensing(slots);
    }

    /// Up to a slot that senses, unless sensing has ended, behind so many of them.
    pub(super) fn play_sensing(&mut self, slots: u32) {
        for _ in 0..slots {
            self.radio.slot(Transfer::Done);
            while !self.radio.position().0.is_multiple_of(SPACING + 1) {
                self.radio.slot(Transfer::Done);
            }
        }
    }

    /// Until the last recording has been classified.
    fn classify(&mut self) {
        let mut left = self.settings.layout.period();
        while self.radio.observer.recognises() && left > 0 {
            self.radio.slot(Transfer::Done);
            left -= 1;
        }
    }

    /// The rest of the period, and another one with its classifications; whether that one is as it must be.
    pub(super) fn end(&mut self) -> bool {
        self.radio.finish(Transfer::Done);
        let (before, period) = (self.radio.violations(), self.radio.observer.kept.period.wrapping_add(1));
        // after a reset the numbers may begin again
        self.radio.classified.retain(|found| found.0 != period);
        self.radio.whole_period(Transfer::Done);
        self.classify();
        let of_it = self.radio.classified.iter().filter(|found| found.0 == period);
        let as_known = of_it.filter(|found| found.1).count() == EXITS;
        as_known && self.radio.violations() == before
    }

    fn apply(&mut self, kind: usize) {
        let (radio, rng) = (&mut self.radio, &mut self.rng);
        match kind {
            0 => radio.skip(1 + below(rng, CATCH_UP)),
            1 => {
                radio.finish(Transfer::Done);
                radio.skip(1 + below(rng, CATCH_UP));
            }
            2 => radio.skip(CATCH_UP + 1 + below(rng, 500)),
            3 => drift(radio, 100, Transfer::Done, rng),
            4 => radio.repeat(),
            5 => radio.late(radio.number.wrapping_sub(2 + below(rng, 1000))),
            6 => _ = radio.slot(Transfer::Lost),
            7 => _ = radio.slot(Transfer::Missing),
            8 => {
                radio.play(1, Transfer::Missing);
                radio.play(1, Transfer::Done);
                radio.unexpected_samples();
            }
            9 => {
                radio.play(1, Transfer::Done);
                radio.unexpected_samples();
            }
            10 => {
                let kind = below(rng, samples::CERTAIN as u32) as usize;
                radio.slot(Transfer::Corrupted(Corruption::random(kind, rng)));
            }
            11 => self.at_any_slot(|radio, rng| radio.damage(Copies::Newest, one_bit(rng))),
            12 => {
                radio.damage(Copies::Both, one_bit(rng));
                // until processing has sent a plan
                radio.play(11, Transfer::Done);
                radio.invariant(!radio.unplanned());
            }
            13 => {
                while !radio.flip_plan(rng.next_u32()) {
                    let mut rates = radio.rates();
                    rates[0] = 1 + below(rng, 3000);
                    radio.plan(&rates, None);
                    radio.slot(Transfer::Done);
                    radio.wait();
                }
            }
            MODEL => self.damage_model(),
            _ => {
                let copies = [Copies::Newest, Copies::Older, Copies::Both];
                let copies = copies.get(below(rng, 4) as usize); // or none
                let damage = copies.map(|&copies| (copies, one_bit(rng)));
                let planner = Planner::new(self.settings.layout, self.settings.rates);
                radio.reset(damage, below(rng, CATCH_UP), planner, &mut self.make);
            }
        }
    }

    /// A fault at any slot of the rest of the period: also while sensing ends.
    pub(super) fn at_any_slot<R>(
        &mut self,
        fault: impl FnOnce(&mut Environment<VALUES>, &mut Xoshiro128PlusPlus) -> R,
    ) -> R {
        let (_, left) = self.radio.position();
        let slots = below(&mut self.rng, left.saturating_sub(1));
        self.radio.play(slots, Transfer::Done);
        fault(&mut self.radio, &mut self.rng)
    }

    /// A bit of a model flips while none is being checked, and back after the next period.
    fn damage_model(&mut self) {
        self.classify();
        let number = below(&mut self.rng, EXITS as u32) as usize;
        let (bytes, bit) = (self.files[number], self.rng.next_u32());
        // the last four bytes are the checksum, which is not looked at again
        let bytes = bytes.split_last_chunk::<4>().map_or(bytes, |(content, _)| content);
        self.radio.wait();
        self.radio.flip_model(number, bytes, bit, false);
        self.radio.classified.clear();
        self.radio.finish(Transfer::Done);
        self.radio.whole_period(Transfer::Done);
        self.radio.whole_period(Transfer::Done);
        self.classify();
        let wrong = take(&mut self.radio.classified).iter().filter(|found| !found.1).count();
        self.radio.invariant(wrong == 0);
        self.radio.flip_model(number, bytes, bit, true);
    }
}
