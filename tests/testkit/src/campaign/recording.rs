//! Faults during a recording, through the whole signal chain from samples to logits.
//!
//! A fault is injected into a recording of one period; the next has none. The n-th samples of every recording are the same seeded
//! noise, so that the logits of every classification must be those of the first.

use super::environment::{CATCH_UP, Contexts, Copies, Environment, MODEL_FAULT, Transfer};
use super::samples::{self, Corruption};
use super::schedule::{drift, one_bit};
use super::{Outcome, below};
use rand_core::SeedableRng;
use rand_xoshiro::Xoshiro128PlusPlus;
use sdp3_core::radar::Settings;
use sdp3_core::scheduler::{PlanError, Planner, SensingLayout};
use sdp3_core::supervision::retained::Retained;

/// Kinds of faults, in the order of [`Table`]; the last is the only one that makes new contexts.
pub const KINDS: [&str; 12] = [
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
    "reset",
];

/// Outcomes by [`KINDS`].
pub type Table = [Outcome; KINDS.len()];

/// N_m.
const SPACING: u32 = 3;

/// Number of the first slot: it wraps in the first periods.
const FIRST: u32 = u32::MAX - 2000;

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

/// A module that makes recordings.
pub struct Recordings<const VALUES: usize, M> {
    radio: Environment<VALUES>,
    settings: Settings,
    need: u32,
    make: M,
    rng: Xoshiro128PlusPlus,
}

impl<const VALUES: usize, M: FnMut() -> Option<Contexts<VALUES>>> Recordings<VALUES, M> {
    /// `make` makes contexts with [`settings`] on `retained`: once now, and for every reset.
    pub fn new(need: u32, retained: &'static Retained, mut make: M, seed: u64) -> Option<Self> {
        let settings = settings(need).ok()?;
        let planner = Planner::new(settings.layout, settings.rates);
        let samples = Some(seed.wrapping_mul(1 << 16));
        let mut radio = Environment::new(make()?, retained, planner, need, FIRST, samples);
        radio.whole_period(Transfer::Done);
        Some(Recordings { radio, settings, need, make, rng: Xoshiro128PlusPlus::seed_from_u64(seed) })
    }

    /// Injects `events` faults of all kinds in turn.
    pub fn run(&mut self, events: u64) -> Table {
        let mut table = Table::default();
        for event in 0..events {
            let kind = (event % KINDS.len() as u64) as usize;
            let Some(outcome) = table.get_mut(kind) else { continue };
            self.begin();
            self.apply(kind);
            self.radio.slot(Transfer::Done);
            self.end(outcome);
        }
        table
    }

    /// Flips `events` random bits of a model of so many bytes by `flip`, each for two periods.
    pub fn damage_model(&mut self, events: u64, bytes: usize, mut flip: impl FnMut(usize)) -> Outcome {
        let mut outcome = Outcome::default();
        for _ in 0..events {
            let bit = below(&mut self.rng, bytes as u32 * 8) as usize;
            self.begin();
            flip(bit);
            self.radio.expect(MODEL_FAULT);
            self.radio.model_damaged = true;
            self.radio.finish(Transfer::Done);
            self.radio.whole_period(Transfer::Done);
            self.radio.invariant(self.radio.classifications == 0);
            flip(bit);
            self.radio.model_damaged = false;
            self.end(&mut outcome);
        }
        outcome
    }

    /// To a random sensing slot of a recording that is not yet complete.
    fn begin(&mut self) {
        self.radio.begin_event();
        let slots = 1 + below(&mut self.rng, self.need - 1);
        self.radio.play(slots * (SPACING + 1), Transfer::Done);
    }

    /// The rest of the period, and another one with its classification.
    fn end(&mut self, outcome: &mut Outcome) {
        self.radio.finish(Transfer::Done);
        let before = (self.radio.violations, self.radio.classifications);
        self.radio.whole_period(Transfer::Done);
        let whole = (self.radio.violations, self.radio.classifications) == (before.0, before.1 + 1);
        self.radio.end_event(whole, outcome);
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
            _ => {
                let copies = [Copies::Newest, Copies::Older, Copies::Both];
                let copies = copies.get(below(rng, 4) as usize); // or none
                let damage = copies.map(|&copies| (copies, one_bit(rng)));
                let planner = Planner::new(self.settings.layout, self.settings.rates);
                radio.reset(damage, below(rng, CATCH_UP), planner, &mut self.make);
            }
        }
    }
}
