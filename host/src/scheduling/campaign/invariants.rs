//! The scheduler's properties, checked from outside on every period.
//!
//! Slots add up; sensing slots lie where the plan says, up to where sensing was ended; without an end every user has exactly its
//! share; every user that is present gets a slot; no wait is longer than its bound, which where plans meet is both plans' together.

use sdp3_core::scheduler::{Plan, USERS};

/// Violations described in full; more are only counted.
const NAMED: usize = 20;

#[derive(Debug, Clone)]
pub struct Invariants {
    now: u64,
    /// Number of each user's last slot; `None` after a period in which it had no share.
    last: [Option<u64>; USERS],
    /// Longest wait of the period, and of all.
    waited: [u64; USERS],
    longest: [(u32, u32); USERS],
    /// Bound of this period's plan and of the one before.
    bounds: [(u32, u32); USERS],
    start: u64,
    sensed: u32,
    step: u32,
    drifted: bool,
}

impl Invariants {
    /// Before the first slot.
    pub fn new() -> Self {
        Invariants {
            now: 0,
            last: [None; USERS],
            waited: [0; USERS],
            longest: [(0, 0); USERS],
            bounds: [(0, 0); USERS],
            start: 0,
            sensed: 0,
            step: 1,
            drifted: false,
        }
    }

    /// Before a period's first slot.
    pub fn begin(&mut self) {
        self.start = self.now;
        (self.sensed, self.drifted, self.waited) = (0, false, [0; USERS]);
    }

    /// The period's plan, after its first slot was decided and before it is played.
    pub fn plan(&mut self, plan: &Plan) {
        self.step = plan.spacing() + 1;
        for (k, bound) in self.bounds.iter_mut().enumerate() {
            let now = plan.longest_wait(k);
            *bound = (now.unwrap_or(0), bound.0);
            if now.is_none() {
                self.last[k] = None;
            }
        }
    }

    /// A sensing slot at `position`, from 1.
    pub fn sense(&mut self, position: u32) {
        self.drifted |= position != 1 + self.sensed * self.step;
        self.sensed += 1;
    }

    /// A slot of user `k` at `position`, from 1.
    pub fn serve(&mut self, k: usize, position: u32) {
        let now = self.start + u64::from(position);
        if let Some(last) = self.last[k].replace(now) {
            self.waited[k] = self.waited[k].max(now - last - 1);
        }
    }

    /// After a period: `served`, sensed and idle slots; `ended` if its sensing was ended early.
    pub fn end(
        &mut self,
        period: u32,
        plan: &Plan,
        (served, sensed, idle): (&[u32; USERS], u32, u32),
        ended: bool,
        violations: &mut Vec<String>,
    ) {
        self.now = self.start + u64::from(plan.period());
        let mut fail = |what: String| {
            if violations.len() < NAMED {
                violations.push(format!("period {period}: {what}"));
            }
        };
        let slots = served.iter().sum::<u32>() + sensed + idle;
        if slots != plan.period() {
            fail(format!("{slots} slots instead of {}", plan.period()));
        }
        if self.drifted {
            fail("a sensing slot lies elsewhere".into());
        }
        if !ended && sensed != plan.sensing() {
            fail(format!("{sensed} sensing slots instead of {}", plan.sensing()));
        }
        let present = plan.shares().iter().filter(|&&share| share > 0).count() as u32;
        if idle > 0 && present > 0 {
            fail(format!("{idle} idle slots with {present} users"));
        }
        for k in 0..USERS {
            let share = plan.shares().get(k).copied().unwrap_or(0);
            if !ended && served[k] != share {
                fail(format!("user {} had {} slots instead of {share}", k + 1, served[k]));
            }
            if share > 0 && served[k] == 0 {
                fail(format!("user {} starved", k + 1));
            }
            let (now, before) = self.bounds[k];
            // the shares are reassigned where sensing ends: a user's slots may be twice as far apart there
            let bound = if ended { 2 * now + before + 1 } else { now + before + 1 };
            let wait = self.waited[k];
            if wait > u64::from(bound) {
                fail(format!("user {} waited {wait} slots, bound {bound}", k + 1));
            }
            self.longest[k].0 = self.longest[k].0.max(wait as u32);
            self.longest[k].1 = self.longest[k].1.max(bound);
        }
    }

    /// Longest wait of every user and the largest bound that held.
    pub fn waits(&self) -> [(u32, u32); USERS] {
        self.longest
    }
}

impl Default for Invariants {
    fn default() -> Self {
        Self::new()
    }
}
