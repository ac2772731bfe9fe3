//! Fault injection: seeded faults one after the other, counted by their outcome; the counts are the same on every processor.
//!
//! [`schedule`] injects faults into the schedule of a radar module, [`samples`] corrupts slots, and [`recording`] injects faults into
//! recordings on their way through the whole signal chain; [`unprotected`] those that nothing is meant to find. [`environment`] is
//! the radio and the task that polls, on a virtual clock, and beside them is the observer, who knows by counts of his own what the
//! module must do at every call. A fault is *detected* if the reports are exactly those that it must cause, in their order and by the
//! end of the next whole period, *recovered* if that period is right in every slot, *silent* if a report was due and did not come. A
//! report too many and a slot other than the plan's are *violations*.

mod clock;
pub mod environment;
mod observer;
pub mod recording;
pub mod samples;
pub mod schedule;
pub mod unprotected;

use core::fmt;
use rand_core::Rng;
use sdp3_core::digest::Digest;

/// Outcomes of the faults of one kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Outcome {
    /// Faults injected.
    pub injected: u64,
    /// Followed by exactly the reports that are due.
    pub detected: u64,
    /// Followed by a whole period that is right; of samples: not used.
    pub recovered: u64,
    /// Not reported.
    pub silent: u64,
    /// Invariants that did not hold.
    pub violations: u64,
}

impl Outcome {
    fn counts(&self) -> [u64; 5] {
        let Outcome { injected, detected, recovered, silent, violations } = *self;
        [injected, detected, recovered, silent, violations]
    }
}

impl core::ops::Add for Outcome {
    type Output = Outcome;

    fn add(self, other: Outcome) -> Outcome {
        Outcome {
            injected: self.injected.wrapping_add(other.injected),
            detected: self.detected.wrapping_add(other.detected),
            recovered: self.recovered.wrapping_add(other.recovered),
            silent: self.silent.wrapping_add(other.silent),
            violations: self.violations.wrapping_add(other.violations),
        }
    }
}

impl fmt::Display for Outcome {
    /// Five columns of 12 characters, in the order of [`HEADER`].
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.counts().into_iter().try_for_each(|count| write!(f, "{count:>12}"))
    }
}

/// Names of the columns of an [`Outcome`].
pub const HEADER: &str = "    injected    detected   recovered      silent  violations";

/// Kinds of faults against schedule and samples, in the order of [`Table`].
pub const KINDS: [&str; SCHEDULE + samples::KINDS.len()] = {
    let mut all = [""; SCHEDULE + samples::KINDS.len()];
    let (schedule, rest) = all.split_at_mut(SCHEDULE);
    schedule.copy_from_slice(&schedule::KINDS);
    rest.copy_from_slice(&samples::KINDS);
    all
};

const SCHEDULE: usize = schedule::KINDS.len();

/// The first so many of [`KINDS`] must never be silent.
pub const CERTAIN: usize = SCHEDULE + samples::CERTAIN;

/// Outcomes by [`KINDS`].
pub type Table = [Outcome; KINDS.len()];

/// Injects `events` faults of all kinds in turn.
///
/// A fault of the schedule takes a period of 20 to 59 slots and a whole one after it.
pub fn run<const VALUES: usize>(
    schedule: &mut schedule::Schedule<VALUES>,
    rng: &mut impl Rng,
    events: u64,
) -> Table {
    let mut table = Table::default();
    for event in 0..events {
        let kind = (event % KINDS.len() as u64) as usize;
        let Some(outcome) = table.get_mut(kind) else { continue };
        match kind.checked_sub(SCHEDULE) {
            None => schedule.inject(kind, rng, outcome),
            Some(kind) => samples::inject(kind, rng, outcome),
        }
    }
    table
}

/// Whether no invariant broke, and every fault of the first `certain` kinds was detected and recovered.
pub fn holds(table: &[Outcome], certain: usize) -> bool {
    table.iter().enumerate().all(|(kind, o)| {
        o.violations == 0 && (kind >= certain || o.counts() == [o.injected, o.injected, o.injected, 0, 0])
    })
}

/// One number for a table.
pub fn digest(table: &[Outcome]) -> u64 {
    let mut digest = Digest::new();
    table.iter().flat_map(Outcome::counts).for_each(|count| digest.value(count.to_le_bytes()));
    digest.hash()
}

/// A draw of 0..`limit`.
fn below(rng: &mut impl Rng, limit: u32) -> u32 {
    ((u64::from(rng.next_u32()).wrapping_mul(u64::from(limit))) >> 32) as u32
}
