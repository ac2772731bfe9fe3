//! Fault injection: seeded faults one after the other, counted by their outcome; the counts are the same on every processor.
//!
//! [`schedule`] injects faults into the supervised schedule, [`samples`] corrupts slots, [`model`] flips bits of a model, and
//! [`recording`] injects faults into recordings on their way through the whole signal chain. A fault is *detected* if it is reported
//! exactly once and by its name, *recovered* if the next whole period is right in every slot, *silent* if nothing is reported. A
//! report without a fault, a second report, and a schedule that breaks an invariant are *violations*.

pub mod model;
pub mod recording;
pub mod samples;
pub mod schedule;

use core::fmt;
use rand_core::Rng;
use sdp3_core::digest::Digest;
use sdp3_core::dims::{Iq, SLOT_SAMPLES, Slot};

/// Interleaved samples of a slot.
pub const SAMPLES: usize = 2 * SLOT_SAMPLES;

/// Interleaved samples as the core takes them.
pub fn slot(samples: &[i16; SAMPLES]) -> Slot {
    let (pairs, _) = samples.as_chunks::<2>();
    let mut slot = [Iq { i: 0, q: 0 }; SLOT_SAMPLES];
    slot.iter_mut().zip(pairs).for_each(|(sample, &[i, q])| *sample = Iq { i, q });
    slot
}

/// Outcomes of the faults of one kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Outcome {
    /// Faults injected.
    pub injected: u64,
    /// Reported exactly once, by their name.
    pub detected: u64,
    /// Followed by a whole period that is right; of samples and models: not used.
    pub recovered: u64,
    /// Not reported.
    pub silent: u64,
    /// Invariants that did not hold.
    pub violations: u64,
}

impl Outcome {
    /// Adds the counts of another.
    pub fn add(&mut self, other: &Outcome) {
        let Outcome { injected, detected, recovered, silent, violations } = other;
        self.injected = self.injected.wrapping_add(*injected);
        self.detected = self.detected.wrapping_add(*detected);
        self.recovered = self.recovered.wrapping_add(*recovered);
        self.silent = self.silent.wrapping_add(*silent);
        self.violations = self.violations.wrapping_add(*violations);
    }
}

impl fmt::Display for Outcome {
    /// Five columns of 12 characters, in the order of [`HEADER`].
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Outcome { injected, detected, recovered, silent, violations } = self;
        write!(f, "{injected:>12}{detected:>12}{recovered:>12}{silent:>12}{violations:>12}")
    }
}

/// Names of the columns of an [`Outcome`].
pub const HEADER: &str = "    injected    detected   recovered      silent  violations";

/// Kinds of faults, in the order of [`Table`].
pub const KINDS: [&str; 22] = [
    "slots skipped",
    "outage",
    "slot repeated",
    "slot late",
    "counter reset",
    "user vanished",
    "plan changed at the boundary",
    "reset, memory kept",
    "reset, memory damaged",
    "schedule, one bit",
    "schedule, bits of a word",
    "backup, one bit",
    "schedule and a backup",
    "schedule and both backups",
    "clock drifts",
    "counter wraps in a gap",
    "model, one bit",
    "samples silent",
    "samples, bit stuck",
    "samples saturated",
    "samples, offset",
    "samples, glitch",
];

/// The first so many of [`KINDS`] are faults of the schedule.
pub const SCHEDULE: usize = 16;

/// The first so many of [`KINDS`], faults of schedule and model, must never be silent.
pub const CERTAIN: usize = 17;

/// Outcomes by [`KINDS`].
pub type Table = [Outcome; KINDS.len()];

/// Injects `events` faults of all kinds in turn. `model` is a model file and `copy` memory for it; if `model` is no model or `copy` is
/// too short, no model is damaged.
///
/// A fault of the schedule takes a period of 20 to 59 slots before it and one after it.
pub fn run(rng: &mut impl Rng, events: u64, model: &[u8], copy: &mut [u8]) -> Table {
    let mut table = Table::default();
    let mut environment = schedule::Environment::new(rng);
    let mut damage = model::Damage::new(model, copy);
    for event in 0..events {
        let kind = (event % KINDS.len() as u64) as usize;
        let Some(outcome) = table.get_mut(kind) else { continue };
        if kind < SCHEDULE {
            environment.inject(kind, rng, outcome);
        } else if kind < CERTAIN {
            if let Some(damage) = &mut damage {
                damage.inject(rng, outcome);
            }
        } else {
            samples::inject(kind, rng, outcome);
        }
    }
    table
}

/// Whether no invariant broke, and every fault of the first `certain` kinds was detected and recovered.
pub fn holds(table: &[Outcome], certain: usize) -> bool {
    table.iter().enumerate().all(|(kind, o)| {
        let expected = Outcome {
            injected: o.injected,
            detected: o.injected,
            recovered: o.injected,
            ..Outcome::default()
        };
        o.violations == 0 && (kind >= certain || *o == expected)
    })
}

/// One number for a table.
pub fn digest(table: &[Outcome]) -> u64 {
    let mut digest = Digest::new();
    for o in table {
        for count in [o.injected, o.detected, o.recovered, o.silent, o.violations] {
            digest.value(count.to_le_bytes());
        }
    }
    digest.hash()
}
