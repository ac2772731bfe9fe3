//! The use of the next slot, period after period, in integers and O(K) a slot.
//!
//! Smooth weighted round robin: every communication slot adds each share to its receiver's credit, the largest credit
//! wins and pays the sum of the shares. Over a period every receiver gets exactly its share.

use super::plan::{Plan, RECEIVERS};

/// What a slot is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SlotUse {
    /// The radar sweeps.
    Sensing,
    /// Downlink to this receiver.
    Communication(u8),
    /// Nothing is planned (no receiver has a share).
    Idle,
}

/// Plays a plan, slot by slot.
///
/// Wait: between two slots of receiver k lie at most `2 ceil(C / N_c,k) + K` communication slots, C being their sum: a
/// winner's credit was positive, so it falls no lower than -C, and it gains N_c,k each time. Tested on random plans.
#[derive(Debug, Clone)]
pub struct Sequencer {
    plan: Plan,
    credits: [i32; RECEIVERS],
    position: u32,
}

impl Sequencer {
    /// Begins a period of the plan.
    pub fn new(plan: &Plan) -> Self {
        Sequencer { plan: plan.clone(), credits: [0; RECEIVERS], position: 0 }
    }

    /// The plan.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Slots of the current period already played, 0..N.
    pub fn position(&self) -> u32 {
        self.position
    }

    /// Begins a new period at once, with another plan if one is given.
    pub fn restart(&mut self, plan: Option<&Plan>) {
        if let Some(plan) = plan {
            self.plan = plan.clone();
        }
        self.credits = [0; RECEIVERS];
        self.position = 0;
    }

    /// Use of the next slot; after the period's last slot the next period begins.
    ///
    /// Cost: O(K), no division but one remainder. Credits stay within +-2^25.
    #[allow(clippy::should_implement_trait)] // a period never ends: this is no iterator
    pub fn next(&mut self) -> SlotUse {
        self.position += 1;
        let senses = self.plan.senses(self.position);
        let slot = if senses { SlotUse::Sensing } else { self.communicate() };
        if self.position >= self.plan.period() {
            self.restart(None);
        }
        slot
    }

    fn communicate(&mut self) -> SlotUse {
        let mut winner: Option<(usize, i32)> = None;
        let mut total = 0_i32;
        for (k, (credit, &share)) in self.credits.iter_mut().zip(self.plan.shares()).enumerate() {
            let share = share as i32; // at most 2^24
            *credit = credit.saturating_add(share);
            total = total.saturating_add(share);
            if winner.is_none_or(|(_, most)| *credit > most) {
                winner = Some((k, *credit));
            }
        }
        let Some((k, _)) = winner.filter(|_| total > 0) else { return SlotUse::Idle };
        if let Some(credit) = self.credits.get_mut(k) {
            *credit = credit.saturating_sub(total);
        }
        SlotUse::Communication(k as u8)
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use rand_core::{Rng, SeedableRng};
    use std::vec::Vec;

    fn random_plan(rng: &mut impl Rng) -> Plan {
        let period = 1 + rng.next_u32() % 600;
        let spacing = rng.next_u32() % 5;
        let sensing = rng.next_u32() % (period / (spacing + 1) + 1);
        let receivers = 1 + rng.next_u32() as usize % RECEIVERS;
        let mut left = period - sensing;
        let mut shares: Vec<u32> = (1..receivers)
            .map(|_| {
                let share = rng.next_u32() % (left + 1);
                left -= share;
                share
            })
            .collect();
        shares.push(left);
        Plan::new(period, spacing, sensing, &shares).unwrap()
    }

    #[test]
    fn shares_positions_and_waits_hold_on_random_plans() {
        let mut rng = rand_xoshiro::Xoshiro128PlusPlus::seed_from_u64(11);
        for _ in 0..3000 {
            let plan = random_plan(&mut rng);
            let mut sequencer = Sequencer::new(&plan);
            let total: u32 = plan.shares().iter().sum();
            let mut counts = [0; RECEIVERS];
            let mut waits = [0; RECEIVERS];
            for j in 1..=2 * plan.period() {
                let within = (j - 1) % plan.period() + 1;
                let step = plan.spacing() + 1;
                let due = within % step == 1 % step && within <= plan.sensing() * step;
                match sequencer.next() {
                    SlotUse::Sensing => assert!(due),
                    SlotUse::Communication(k) => {
                        assert!(!due);
                        counts[usize::from(k)] += 1;
                        for (i, wait) in waits.iter_mut().enumerate().take(plan.shares().len()) {
                            *wait = if i == usize::from(k) { 0 } else { *wait + 1 };
                            let share = plan.shares()[i];
                            let bound = 2 * total.div_ceil(share.max(1)) + plan.shares().len() as u32;
                            assert!(share == 0 || *wait <= bound, "{plan:?}: receiver {i} waited {wait}");
                        }
                    }
                    SlotUse::Idle => assert!(total == 0),
                }
                if within == plan.period() {
                    assert_eq!(&counts[..plan.shares().len()], plan.shares());
                    assert_eq!(sequencer.credits, [0; RECEIVERS]);
                    counts = [0; RECEIVERS];
                }
            }
        }
    }
}
