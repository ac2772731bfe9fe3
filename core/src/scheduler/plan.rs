//! How many slots of a period each use gets, checked once.
//!
//! N_s + sum N_c,k = N, beside what [`layout`](super::layout) asks for; problem P of the paper in integers.

use super::apportion::apportion;
use super::layout::{PlanError, SensingLayout, USERS};
use crate::supervision::retained::State;

/// A checked division of a period.
#[derive(Debug, Clone, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Plan {
    sensing: SensingLayout,
    shares: [u32; USERS],
    users: u32,
}

impl Plan {
    /// A plan in which nothing happens.
    pub const IDLE: Self = Plan { sensing: SensingLayout::EMPTY, shares: [0; USERS], users: 0 };

    /// A plan of `period` (N) slots with `sensing` (N_s) of them `spacing` (N_m) slots apart and `shares` (N_c,k) for the users.
    ///
    /// # Errors
    ///
    /// [`PlanError`] names what does not fit.
    pub fn new(period: u32, spacing: u32, sensing: u32, shares: &[u32]) -> Result<Self, PlanError> {
        let sensing = SensingLayout::new(period, spacing, sensing)?;
        let (users, mut kept) = (shares.len(), [0; USERS]);
        if users == 0 || users > USERS {
            return Err(PlanError::Users { users });
        }
        kept.iter_mut().zip(shares).for_each(|(to, share)| *to = *share);
        let slots = u64::from(sensing.slots());
        let sum = shares.iter().map(|&share| u64::from(share)).fold(slots, u64::saturating_add);
        if sum != u64::from(period) {
            return Err(PlanError::Sum { sum, period });
        }
        Ok(Plan { sensing, shares: kept, users: users as u32 })
    }

    /// The optimal plan: what sensing leaves is [`apportion`]ed; `credit` are slots that users already have, or lack if negative. With no user present those slots stay idle.
    pub fn optimal(sensing: SensingLayout, rates: &[u32; USERS], credit: &[i32; USERS]) -> Self {
        let mut shares = [0; USERS];
        apportion(rates, credit, sensing.data_slots(), &mut shares);
        Plan { sensing, shares, users: USERS as u32 }
    }

    /// Where the sensing slots lie.
    pub fn layout(&self) -> SensingLayout {
        self.sensing
    }

    /// N.
    pub fn period(&self) -> u32 {
        self.sensing.period()
    }

    /// N_m.
    pub fn spacing(&self) -> u32 {
        self.sensing.spacing()
    }

    /// N_s.
    pub fn sensing(&self) -> u32 {
        self.sensing.slots()
    }

    /// N_c,k of every user.
    pub fn shares(&self) -> &[u32] {
        self.shares.get(..self.users as usize).unwrap_or(&self.shares)
    }

    /// Whether slot `j`, 1 to N, senses.
    pub fn senses(&self, j: u32) -> bool {
        let step = u64::from(self.spacing()) + 1;
        let (j, last) = (u64::from(j), u64::from(self.sensing()) * step);
        j % step == 1 % step && j <= last
    }

    /// Most slots that lie between two of user k's while this plan is played period after period; `None` without a share.
    ///
    /// Two order of n in C communication slots are at most D = ceil(2 C / n) communication slots apart (`slot_order`); in D steps
    /// from one communication slot to the next lie at most ceil(D / N_m) sensing slots, or all N_s of them if N_m = 0.
    pub fn longest_wait(&self, k: usize) -> Option<u32> {
        let share = self.shares().get(k).copied().filter(|&share| share > 0)?;
        let others: u32 = self.shares.iter().copied().fold(0, u32::saturating_add);
        let apart = others.saturating_mul(2).div_ceil(share);
        let sensing = match self.spacing() {
            0 => self.sensing(),
            spacing => apart.div_ceil(spacing).min(self.sensing()),
        };
        Some(apart.saturating_sub(1).saturating_add(sensing))
    }
}

impl State for Plan {
    fn words(&mut self, visit: &mut impl FnMut(&mut u32)) {
        self.sensing.words(visit);
        visit(&mut self.users);
        self.shares.iter_mut().for_each(visit);
    }
}
