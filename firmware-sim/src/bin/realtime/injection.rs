//! The faults that the program injects, and the reports that each must cause.

use Injection::*;
use sdp3_core::supervision::{Fault, SampleFault};

/// An injected fault.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Injection {
    Repeated,
    Late,
    Unexpected,
    FlipOlder,
    FlipNewer,
    Skipped,
    Outage,
    Missing,
    /// Missing, and they come later.
    Delayed,
    Lost,
    Silent,
    Stuck,
    Saturated,
    Offset,
    FlipBoth,
    CounterReset,
}

pub const KINDS: usize = HARMLESS.len() + HARMFUL.len();
/// After these a recording goes on.
pub const HARMLESS: [Injection; 5] = [Repeated, Late, Unexpected, FlipOlder, FlipNewer];
/// After these it begins again.
pub const HARMFUL: [Injection; 11] =
    [Skipped, Missing, Silent, Lost, FlipBoth, Stuck, Outage, Saturated, Delayed, Offset, CounterReset];

impl Injection {
    pub fn is_of_samples(self) -> bool {
        matches!(self, Silent | Stuck | Saturated | Offset)
    }
}

/// A report that must come.
#[derive(Clone, Copy)]
pub struct Expected {
    pub report: Report,
    /// Interrupts before it was injected.
    pub since: u32,
}

#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Report {
    Gap(u32),
    Repeated,
    Late,
    CounterReset,
    Repaired,
    StateLost,
    Missing,
    Unexpected,
    Silent,
    Stuck(u16),
    Saturated,
    Offset,
    /// By the period's counts.
    Lost,
}

impl Report {
    pub fn fits(self, fault: &Fault) -> bool {
        match *fault {
            Fault::SlotsSkipped { slots, .. } => self == Report::Gap(slots) && slots <= 8,
            Fault::Outage { slots } => self == Report::Gap(slots),
            Fault::SlotRepeated => self == Report::Repeated,
            Fault::SlotLate => self == Report::Late,
            Fault::CounterReset => self == Report::CounterReset,
            Fault::StateRepaired => self == Report::Repaired,
            Fault::StateLost => self == Report::StateLost,
            Fault::MissingSamples => self == Report::Missing,
            Fault::UnexpectedSamples => self == Report::Unexpected,
            Fault::Samples(SampleFault::Silent) => self == Report::Silent,
            Fault::Samples(SampleFault::Stuck { i, q }) => i == 0 && self == Report::Stuck(q),
            Fault::Samples(SampleFault::Saturated { .. }) => self == Report::Saturated,
            Fault::Samples(SampleFault::Offset { .. }) => self == Report::Offset,
            _ => false,
        }
    }
}

/// Corrupts samples as `kind` says; how that is to be reported.
pub fn corrupt(samples: &mut [i16], kind: Injection) -> Option<Report> {
    let quadrature = samples.iter_mut().skip(1).step_by(2);
    Some(match kind {
        Silent => {
            samples.fill(-7);
            Report::Silent
        }
        Stuck => {
            quadrature.for_each(|x| *x |= 1 << 5);
            Report::Stuck(1 << 5)
        }
        Saturated => {
            samples.iter_mut().for_each(|x| *x = x.saturating_mul(32));
            Report::Saturated
        }
        Offset => {
            quadrature.for_each(|x| *x -= 3000);
            Report::Offset
        }
        _ => return None,
    })
}
