//! The real core in the loop: simulated I/Q into the station, verdicts out.

use crate::results::Recognitions;
use crate::scenario::{Class, Scenario};
use crate::simulator::dataset::{Set, recording};
use crate::simulator::random::Random;
use sdp3_core::dims::Slot;
use sdp3_core::dsn::Portable;
use sdp3_core::early_exit::Verdict;
use sdp3_core::station::Station;

/// Stream number of who moves when.
const STREAM: u64 = 204;

/// A station and the people before its radar.
pub struct Radar<'m, 'b> {
    /// The core's.
    pub station: Station<'m, 'b, Portable>,
    scenario: &'m Scenario,
    rho: f64,
    seed: u64,
    random: Random,
    /// Slots of the period's recording, from its end; empty if nobody moves.
    signal: Vec<Slot>,
    truth: Option<Class>,
    verdict: Option<Verdict>,
}

impl<'m, 'b> Radar<'m, 'b> {
    /// Before the first period.
    pub fn new(station: Station<'m, 'b, Portable>, scenario: &'m Scenario, rho: f64, seed: u64) -> Self {
        Radar {
            station,
            scenario,
            rho,
            seed,
            random: Random::new(seed, STREAM, 0, 0),
            signal: Vec::new(),
            truth: None,
            verdict: None,
        }
    }

    /// Somebody moves through the next period, or nobody.
    pub fn prepare(&mut self, somebody: bool, period: u32) {
        (self.truth, self.verdict) = (None, None);
        self.signal.clear();
        if somebody {
            let class = Class::ALL[(self.random.uniform() * Class::ALL.len() as f64) as usize];
            let slots = self.scenario.frame.period_slots / (self.scenario.frame.spacing_slots + 1);
            let found = recording(self.scenario, self.rho, self.seed, Set::Demo, class, 100 + period, slots);
            self.signal = found.slots.iter().map(crate::formats::slots::old_slot).collect();
            self.signal.reverse();
            self.truth = Some(class);
        }
    }

    /// A sensing slot's samples go to the station.
    pub fn sense(&mut self, recognitions: &mut Recognitions) {
        let Some(slot) = self.signal.pop() else { return };
        recognitions.slots += 1;
        if let Some(verdict) = self.station.sensed(&slot) {
            self.verdict = Some(verdict);
        }
    }

    /// Counts the period's last verdict.
    pub fn finish(&mut self, recognitions: &mut Recognitions) {
        let Some(truth) = self.truth else { return };
        recognitions.count += 1;
        let right = self.verdict.as_ref().is_some_and(|v| usize::from(v.class) == truth as usize);
        recognitions.right += u64::from(right);
        recognitions.silent += u64::from(self.verdict.is_none());
    }
}
