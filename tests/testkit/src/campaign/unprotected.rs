//! Faults that nothing is meant to find, and what they cost: flipped bits of data without a checksum, and weak corruptions of samples.
//!
//! One fault is injected at any tick of a period; data that nothing writes again are put back at its end. The next whole period has
//! no fault.

use super::below;
use super::environment::{Contexts, Environment, Transfer};
use super::observer::EXITS;
use super::recording::Recordings;
use super::samples::{self, Corruption};
use core::fmt;
use rand_core::Rng;
use sdp3_core::areas::Area;
use sdp3_core::digest::Digest;

/// Data of which bits flip, and how many of them there are in use, if not all.
const AREAS: [(Area, u32); 14] = [
    (Area::WaitingSlot(0), u32::MAX),
    (Area::WaitingSlot(1), u32::MAX),
    (Area::WaitingSlot(2), u32::MAX),
    (Area::Beats, u32::MAX),
    (Area::Gram, u32::MAX),
    (Area::SlowTime, u32::MAX),
    (Area::LogMagnitudes, u32::MAX),
    (Area::Activations, u32::MAX),
    (Area::PackedWeights, u32::MAX),
    (Area::OperatorWords, u32::MAX),
    (Area::Weights(0), 32),
    (Area::Weights(1), 64),
    (Area::Threshold, u32::MAX),
    (Area::Logits, u32::MAX),
];

/// Kinds of faults, in the order of [`Table`]: one bit of [`AREAS`], one bit of a slot's samples, and weak corruptions.
pub const KINDS: [&str; AREAS.len() + 1 + WEAK] = [
    "waiting slot's period, one bit",
    "waiting slot's number, one bit",
    "waiting slot's rest, one bit",
    "range samples, one bit",
    "Gram matrix, one bit",
    "slow time, one bit",
    "log magnitudes, one bit",
    "activations, one bit",
    "packed weights, one bit",
    "operator's words, one bit",
    "first exit's weight, one bit",
    "last exit's weights, one bit",
    "exits' threshold, one bit",
    "first exit's logits, one bit",
    "slot buffer, one bit",
    "samples, some saturated",
    "samples, small offset",
    "samples, glitch",
];

const WEAK: usize = samples::KINDS.len() - samples::CERTAIN;

/// What the faults of one kind cost.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Cost {
    /// Faults injected.
    pub injected: u64,
    /// Followed by a report.
    pub reported: u64,
    /// Followed by a classification with other logits.
    pub logits: u64,
    /// With another class.
    pub class: u64,
    /// The period has fewer classifications than exits.
    pub missing: u64,
    /// The next whole period was right.
    pub recovered: u64,
    /// Slots or reports that the fault does not explain.
    pub violations: u64,
}

impl Cost {
    fn counts(&self) -> [u64; 7] {
        let Cost { injected, reported, logits, class, missing, recovered, violations } = *self;
        [injected, reported, logits, class, missing, recovered, violations]
    }
}

impl core::ops::Add for Cost {
    type Output = Cost;

    fn add(self, other: Cost) -> Cost {
        Cost {
            injected: self.injected.wrapping_add(other.injected),
            reported: self.reported.wrapping_add(other.reported),
            logits: self.logits.wrapping_add(other.logits),
            class: self.class.wrapping_add(other.class),
            missing: self.missing.wrapping_add(other.missing),
            recovered: self.recovered.wrapping_add(other.recovered),
            violations: self.violations.wrapping_add(other.violations),
        }
    }
}

impl fmt::Display for Cost {
    /// Seven columns of 12 characters, in the order of [`HEADER`].
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.counts().into_iter().try_for_each(|count| write!(f, "{count:>12}"))
    }
}

/// Names of the columns of a [`Cost`].
pub const HEADER: &str =
    "    injected    reported      logits       class     missing   recovered  violations";

/// Costs by [`KINDS`].
pub type Table = [Cost; KINDS.len()];

/// Whether every next period was right, and the faults explain all slots and reports.
pub fn holds(table: &[Cost]) -> bool {
    table.iter().all(|cost| cost.recovered == cost.injected && cost.violations == 0)
}

/// One number for a table.
pub fn digest(table: &[Cost]) -> u64 {
    let mut digest = Digest::new();
    table.iter().flat_map(Cost::counts).for_each(|count| digest.value(count.to_le_bytes()));
    digest.hash()
}

impl<const VALUES: usize, M: FnMut() -> Option<Contexts<VALUES>>> Recordings<VALUES, M> {
    /// Injects `events` faults of all kinds of this module in turn.
    pub fn run_unprotected(&mut self, events: u64) -> Table {
        let mut table = Table::default();
        for event in 0..events {
            let kind = (event % KINDS.len() as u64) as usize;
            let Some(cost) = table.get_mut(kind) else { continue };
            self.radio.begin_event();
            self.radio.slot(Transfer::Done);
            let period = self.radio.observer.kept.period;
            self.radio.lenient = true;
            let bit = self.rng.next_u32();
            match AREAS.get(kind) {
                Some(&(area, bits)) => self.flip(area, bit % bits),
                None => self.corrupt(kind - AREAS.len(), bit),
            }
            cost.recovered += u64::from(self.end());
            let radio = &self.radio;
            let classified = radio.classified.iter().filter(|found| found.0 == period).count();
            cost.injected += 1;
            cost.reported += u64::from(radio.has_reported());
            cost.logits += u64::from(radio.effects.logits);
            cost.class += u64::from(radio.effects.class);
            cost.missing += u64::from(classified < EXITS);
            cost.violations += radio.violations();
        }
        table
    }

    /// A bit of an area flips, at any tick of the period or the next at which there is one.
    fn flip(&mut self, area: Area, bit: u32) {
        let flipped = self.at_any_slot(|radio, _| {
            radio.wait();
            Self::flip_soon(radio, area, bit)
        });
        self.radio.finish(Transfer::Done);
        if flipped && matches!(area, Area::Weights(_) | Area::Threshold) {
            self.radio.flip_area(area, bit);
        }
    }

    fn flip_soon(radio: &mut Environment<VALUES>, area: Area, bit: u32) -> bool {
        while !radio.flip_area(area, bit) {
            if radio.position().0 == 0 {
                return false;
            }
            radio.slot(Transfer::Done);
            radio.wait();
        }
        true
    }

    /// The samples of a sensing slot change.
    fn corrupt(&mut self, kind: usize, bit: u32) {
        let transfer = match kind.checked_sub(1) {
            None => Transfer::Flipped(bit),
            Some(weak) => Transfer::Corrupted(Corruption::random(samples::CERTAIN + weak, &mut self.rng)),
        };
        let slots = below(&mut self.rng, self.need);
        self.play_sensing(slots);
        self.radio.slot(transfer);
    }
}
