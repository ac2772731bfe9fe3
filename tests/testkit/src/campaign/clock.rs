//! The virtual clock: ticks, slots, and the steps of a task.
//!
//! A slot begins every [`SLOT`] ticks, and its transfer ends at any tick before the next. A step of the task takes some ticks, at most
//! a slot, as `RadarModule::new` assumes, and has its effect at the last one. An idle task sleeps until the slot context is called.

use super::below;
use rand_core::SeedableRng;
use rand_xoshiro::Xoshiro128PlusPlus;

/// Ticks of a slot.
const SLOT: u32 = 1024;

/// The virtual clock.
pub(super) struct Clock {
    rng: Xoshiro128PlusPlus,
    pub now: u64,
    /// When the next slot begins.
    pub boundary: u64,
    /// Most ticks of a step, and whether each takes as many.
    longest: u32,
    steady: bool,
    /// When the step of the task ends; `None`: it sleeps.
    pub step: Option<u64>,
}

impl Clock {
    pub fn new(seed: u64) -> Self {
        let rng = Xoshiro128PlusPlus::seed_from_u64(seed);
        Clock { rng, now: 0, boundary: 0, longest: SLOT, steady: false, step: None }
    }

    /// The slot after the next is the next.
    pub fn next_slot(&mut self) {
        self.boundary += u64::from(SLOT);
    }

    /// Another processor: from one step a slot to some fifteen.
    pub fn change(&mut self) {
        let draw = below(&mut self.rng, 16);
        (self.longest, self.steady) = ([SLOT, SLOT / 3, SLOT / 8, SLOT][(draw & 3) as usize], draw == 3);
    }

    pub fn ticks(&mut self) -> u64 {
        u64::from(if self.steady { self.longest } else { 1 + below(&mut self.rng, self.longest) })
    }

    /// The task does something, if it sleeps.
    pub fn wake(&mut self) {
        if self.step.is_none() {
            self.step = Some(self.now + self.ticks());
        }
    }

    /// Any tick before the next slot.
    pub fn within_slot(&mut self) -> u64 {
        let left = self.boundary.saturating_sub(self.now + 1) as u32;
        self.now + u64::from(below(&mut self.rng, left + 1))
    }
}
