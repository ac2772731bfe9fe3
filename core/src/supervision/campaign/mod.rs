//! Faults on purpose: seeded, one after the other, counted by what became of them; the same counts on every processor.
//!
//! [`schedule`] runs a watched schedule beside an observer who knows what was wanted and counts slots on his own; [`samples`] spoils
//! slots; [`model`] flips bits of a model; [`recording`] disturbs recordings on their way through the whole chain. A fault of the schedule is *detected* if it is told exactly once and by its name,
//! *recovered* if the next whole period is as wanted to the slot, *silent* if nothing is told. What is told although nothing
//! happened, told twice, or breaks a promise of the schedule is *broken*.

pub mod model;
pub mod recording;
pub mod samples;
pub mod schedule;

use crate::digest::Digest;
use rand_core::Rng;

/// What became of the faults of one kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Outcome {
    /// Faults made.
    pub injected: u64,
    /// Told exactly once, by their name.
    pub detected: u64,
    /// Followed by a whole period as wanted; for samples and models, not used.
    pub recovered: u64,
    /// Not told.
    pub silent: u64,
    /// Promises broken on the way.
    pub broken: u64,
}

impl Outcome {
    /// Adds another's counts.
    pub fn add(&mut self, other: &Outcome) {
        let Outcome { injected, detected, recovered, silent, broken } = other;
        self.injected = self.injected.wrapping_add(*injected);
        self.detected = self.detected.wrapping_add(*detected);
        self.recovered = self.recovered.wrapping_add(*recovered);
        self.silent = self.silent.wrapping_add(*silent);
        self.broken = self.broken.wrapping_add(*broken);
    }
}

/// Kinds of faults, in the order of [`Table`].
pub const KINDS: [&str; 22] = [
    "slots skipped",
    "outage",
    "slot repeated",
    "slot late",
    "counter set anew",
    "receiver vanished",
    "plan changed at the boundary",
    "reset, memory kept",
    "reset, memory damaged",
    "schedule, one bit",
    "schedule, bits of a word",
    "spare, one bit",
    "schedule and a spare",
    "schedule and both spares",
    "clock drifts",
    "counter wraps in a gap",
    "model, one bit",
    "samples silent",
    "samples, bit stuck",
    "samples saturated",
    "samples, offset",
    "samples, glitch",
];

/// Kinds that a schedule suffers: the first so many.
pub const SCHEDULE: usize = 16;

/// Kinds that must never be silent: the first so many, schedule and model.
pub const CERTAIN: usize = 17;

/// Outcomes by [`KINDS`].
pub type Table = [Outcome; KINDS.len()];

/// Makes `events` faults of all kinds in turn; `model` is a model file and `copy` memory for it (without, or too small, no model is
/// damaged).
///
/// [`SCHEDULE`] of [`KINDS`] are the schedule's: a period of 20 to 59 slots before, and one after each.
pub fn run(rng: &mut impl Rng, events: u64, model: &[u8], copy: &mut [u8]) -> Table {
    let mut table = Table::default();
    let mut world = schedule::World::new(rng);
    let mut damage = model::Damage::new(model, copy);
    for event in 0..events {
        let kind = (event % KINDS.len() as u64) as usize;
        let Some(outcome) = table.get_mut(kind) else { continue };
        if kind < SCHEDULE {
            world.suffer(kind, rng, outcome);
        } else if kind < CERTAIN {
            if let Some(damage) = &mut damage {
                damage.flip(rng, outcome);
            }
        } else {
            samples::spoil(kind, rng, outcome);
        }
    }
    table
}

/// One number for a table.
pub fn digest(table: &[Outcome]) -> u64 {
    let mut digest = Digest::new();
    for o in table {
        for count in [o.injected, o.detected, o.recovered, o.silent, o.broken] {
            digest.value(count.to_le_bytes());
        }
    }
    digest.hash()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_core::SeedableRng;

    #[test]
    fn nothing_certain_is_silent_and_no_promise_breaks() {
        let mut rng = rand_xoshiro::Xoshiro128PlusPlus::seed_from_u64(8);
        let table = run(&mut rng, 40_000, &[], &mut []);
        for (name, o) in KINDS.iter().zip(&table).take(SCHEDULE) {
            assert_eq!(
                (o.detected, o.recovered, o.silent, o.broken),
                (o.injected, o.injected, 0, 0),
                "{name}"
            );
        }
        // spoiled samples are found as far as they show
        assert!(table[CERTAIN..].iter().all(|o| o.injected == o.detected + o.silent && o.broken == 0));
        let [silent, stuck, _, _, glitch] = table[CERTAIN..] else { panic!("kinds of samples") };
        assert_eq!((silent.silent, stuck.silent, glitch.detected), (0, 0, 0));
    }
}
