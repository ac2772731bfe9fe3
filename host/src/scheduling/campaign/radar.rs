//! The real core in the loop: simulated samples into scheduler and pipeline, classifications out.

use crate::formats::slots::Slots;
use crate::numerics::random::Random;
use crate::results::Recognitions;
use crate::scenario::{Class, Scenario};
use crate::simulator::dataset::{Set, recording};
use sdp3_core::dsn::{Classification, Portable};
use sdp3_core::pipeline::Pipeline;
use sdp3_core::scheduler::{Scheduler, SlotUse};

/// Stream number of who moves when.
const STREAM: u64 = 204;

/// Scheduler and pipeline of the radar module in one context: every recognition is over within its slot.
pub struct Station<'m, 'b> {
    pub scheduler: Scheduler,
    pipeline: Pipeline<'m, 'b, Portable>,
}

impl<'m, 'b> Station<'m, 'b> {
    /// Plays `scheduler`'s plans and recognises with `pipeline`.
    pub fn new(scheduler: Scheduler, pipeline: Pipeline<'m, 'b, Portable>) -> Self {
        Station { scheduler, pipeline }
    }

    /// Use of the next slot. A recording never crosses a period.
    pub fn begin(&mut self) -> SlotUse {
        if self.scheduler.position() == 0 {
            self.pipeline.reset();
        }
        self.scheduler.next_slot()
    }

    /// Takes the samples of a sensing slot. The classification that stops ends the period's sensing.
    pub fn on_samples(&mut self, slot: &[i16]) -> Option<Classification> {
        self.pipeline.push(slot, &mut ()).ok()?;
        let classification = self.pipeline.classify(&mut ())?;
        if classification.stop {
            self.scheduler.end_sensing();
        }
        Some(classification)
    }

    /// The slot that [`Station::begin`] gave last was lost. A recording with a gap restarts, or ends the period's sensing if too few
    /// slots are left for the first exit.
    pub fn on_lost(&mut self, slot: SlotUse) {
        self.scheduler.on_lost();
        if slot == SlotUse::Sensing && !self.pipeline.stopped() {
            self.pipeline.reset();
            if (self.scheduler.sensing_left() as usize) < self.pipeline.first_exit_slots() {
                self.scheduler.end_sensing();
            }
        }
    }
}

/// A station and the people before its radar.
pub struct Radar<'m, 'b> {
    pub station: Station<'m, 'b>,
    scenario: &'m Scenario,
    rho: f64,
    seed: u64,
    random: Random,
    /// The period's recording, and how many of its slots have been sensed.
    signal: Option<(Slots, usize)>,
    truth: Option<Class>,
    found: Option<Classification>,
}

impl<'m, 'b> Radar<'m, 'b> {
    /// Before the first period.
    pub fn new(station: Station<'m, 'b>, scenario: &'m Scenario, rho: f64, seed: u64) -> Self {
        Radar {
            station,
            scenario,
            rho,
            seed,
            random: Random::new(seed, STREAM, 0, 0),
            signal: None,
            truth: None,
            found: None,
        }
    }

    /// A person moves in the next period, or none.
    pub fn prepare(&mut self, person: bool, period: u32) {
        (self.truth, self.found, self.signal) = (None, None, None);
        if person {
            let class = Class::ALL[(self.random.uniform() * Class::ALL.len() as f64) as usize];
            let slots = self.scenario.frame.period_slots / (self.scenario.frame.spacing_slots + 1);
            let found = recording(self.scenario, self.rho, self.seed, Set::Demo, class, 100 + period, slots);
            self.signal = Some((found.slots, 0));
            self.truth = Some(class);
        }
    }

    /// A sensing slot's samples go to the station.
    pub fn sense(&mut self, recognitions: &mut Recognitions) {
        let Some((signal, sensed)) = &mut self.signal else { return };
        let Some(slot) = signal.iter().nth(*sensed) else { return };
        *sensed += 1;
        recognitions.slots += 1;
        if let Some(classification) = self.station.on_samples(slot) {
            self.found = Some(classification);
        }
    }

    /// Counts the period's last classification.
    pub fn finish(&mut self, recognitions: &mut Recognitions) {
        let Some(truth) = self.truth else { return };
        recognitions.count += 1;
        let right = self.found.as_ref().is_some_and(|found| usize::from(found.class) == truth as usize);
        recognitions.correct += u64::from(right);
        recognitions.unclassified += u64::from(self.found.is_none());
    }
}
