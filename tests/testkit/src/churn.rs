//! A scheduler under seeded churn: users join, leave and change their rates, slots are lost, sensing ends early, the layout changes.
//!
//! Its decisions have a known digest on every processor.

use rand_core::Rng;
use sdp3_core::digest::Digest;
use sdp3_core::scheduler::{Scheduler, SensingLayout, SlotUse, USERS};

/// Digest of [`run`] over [`PERIODS`] for `rand_xoshiro::Xoshiro128PlusPlus::seed_from_u64(3)`.
pub const KNOWN_ANSWER: u64 = 0x2645_ab31_0824_de99;

/// Periods of the known answer.
pub const PERIODS: u32 = 200;

/// A scheduler under seeded churn.
#[derive(Debug, Clone)]
pub struct Churn {
    /// The scheduler.
    pub scheduler: Scheduler,
    rates: [u32; USERS],
    /// Slots lost in this period, of 2^16.
    loss: u32,
    /// Slot after which sensing ends; 0: never.
    end: u32,
}

/// A layout with no, some or all of the possible sensing slots; `None` if the draw is illegal.
fn layout(rng: &mut impl Rng) -> Option<SensingLayout> {
    let word = rng.next_u32();
    let period = 20 + word % 381;
    let spacing = (word >> 9) % 5;
    let most = period / (spacing + 1);
    let slots = match (word >> 12) % 8 {
        0 => 0,
        1 => most,
        _ => (word >> 16) % (most + 1),
    };
    SensingLayout::new(period, spacing, slots).ok()
}

/// A rate of 1 to 28 bits.
fn rate(rng: &mut impl Rng) -> u32 {
    1 + (rng.next_u32() >> (4 + rng.next_u32() % 24))
}

impl Churn {
    /// A scheduler of three users with rates from `rng`.
    pub fn new(rng: &mut impl Rng) -> Self {
        let mut rates = [0; USERS];
        rates.iter_mut().take(3).for_each(|slot| *slot = rate(rng));
        let first = loop {
            if let Some(layout) = layout(rng) {
                break layout;
            }
        };
        Churn { scheduler: Scheduler::new(first, rates), rates, loss: 0, end: 0 }
    }

    /// Rates as last set.
    pub fn rates(&self) -> [u32; USERS] {
        self.rates
    }

    /// Draws and applies what changes before the next period.
    pub fn between(&mut self, rng: &mut impl Rng) {
        let word = rng.next_u32();
        for (k, own) in self.rates.iter_mut().enumerate() {
            match (word >> (2 * k)) % 4 {
                0 => *own = if *own == 0 { rate(rng) } else { 0 },
                1 if *own > 0 => *own = rate(rng),
                _ => continue,
            }
            self.scheduler.planner_mut().set_rate(k, *own);
        }
        if word >> 30 == 0
            && let Some(layout) = layout(rng)
        {
            self.scheduler.planner_mut().set_layout(layout);
        }
        self.loss = if (word >> 28).is_multiple_of(2) { (word >> 16) % 6554 } else { 0 };
        self.end = if (word >> 26).is_multiple_of(4) { 1 + rng.next_u32() % 400 } else { 0 };
    }

    /// Draws and applies what happens after a slot; not after the last slot of a period.
    pub fn during(&mut self, rng: &mut impl Rng) {
        if self.loss > 0 && rng.next_u32() >> 16 < self.loss {
            self.scheduler.on_lost();
        }
        if self.scheduler.position() == self.end {
            self.scheduler.end_sensing();
        }
    }
}

/// Runs `periods` under churn and digests the use of every slot and every report at a boundary.
pub fn run(rng: &mut impl Rng, periods: u32) -> Digest {
    let mut churn = Churn::new(rng);
    let mut digest = Digest::new();
    for _ in 0..periods {
        churn.between(rng);
        loop {
            let slot = churn.scheduler.next_slot();
            digest.value([match slot {
                SlotUse::Communication(k) => k,
                SlotUse::Sensing => 254,
                SlotUse::Idle => 255,
            }]);
            if churn.scheduler.position() == 0 {
                break;
            }
            churn.during(rng);
        }
        let boundary = churn.scheduler.report();
        let c = boundary.changes;
        let flags = [c.joined, c.left, c.rates, u8::from(c.sensing), u8::from(boundary.replanned)];
        digest.value(flags);
        [c.lost, c.sensing_lost, c.released].into_iter().for_each(|n| digest.value(n.to_le_bytes()));
    }
    digest
}
