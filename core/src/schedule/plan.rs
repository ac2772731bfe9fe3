//! How many slots of a period each use gets, checked once.
//!
//! N_s + sum N_c,k = N and N_s (N_m + 1) <= N; problem P of the paper in integers.

use super::apportion::apportion;
use crate::state::State;
use heapless::Vec;

/// Most receivers of a plan.
pub const RECEIVERS: usize = 8;

/// Longest period in slots.
pub const LONGEST_PERIOD: u32 = 1 << 24;

/// Why numbers are not a plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum PlanError {
    /// The period is 0 or longer than [`LONGEST_PERIOD`].
    Period {
        /// N.
        period: u32,
    },
    /// No receiver, or more than [`RECEIVERS`].
    Receivers {
        /// K.
        receivers: usize,
    },
    /// The sensing slots with their spacing do not fit the period: N_s (N_m + 1) > N.
    Spacing {
        /// Slots they need.
        need: u64,
        /// N.
        period: u32,
    },
    /// The uses do not add up to the period.
    Sum {
        /// N_s + sum N_c,k.
        sum: u64,
        /// N.
        period: u32,
    },
}

impl core::fmt::Display for PlanError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match *self {
            PlanError::Period { period } => write!(f, "period {period} is not in 1..={LONGEST_PERIOD}"),
            PlanError::Receivers { receivers } => {
                write!(f, "{receivers} receivers; legal are 1..={RECEIVERS}")
            }
            PlanError::Spacing { need, period } => {
                write!(f, "sensing slots with their spacing need {need} slots; the period has {period}")
            }
            PlanError::Sum { sum, period } => {
                write!(f, "the uses sum to {sum} slots; the period has {period}")
            }
        }
    }
}

impl core::error::Error for PlanError {}

/// Where a period's sensing slots lie: N, N_m and N_s, checked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Sensing {
    period: u32,
    spacing: u32,
    slots: u32,
}

impl Sensing {
    /// `slots` (N_s) sensing slots `spacing` (N_m) apart in a period of `period` (N).
    ///
    /// # Errors
    ///
    /// [`PlanError::Period`], [`PlanError::Spacing`].
    pub fn new(period: u32, spacing: u32, slots: u32) -> Result<Self, PlanError> {
        if period == 0 || period > LONGEST_PERIOD {
            return Err(PlanError::Period { period });
        }
        let need = u64::from(slots).saturating_mul(u64::from(spacing) + 1);
        if need > u64::from(period) {
            return Err(PlanError::Spacing { need, period });
        }
        Ok(Sensing { period, spacing, slots })
    }

    /// N.
    pub fn period(&self) -> u32 {
        self.period
    }

    /// N_m.
    pub fn spacing(&self) -> u32 {
        self.spacing
    }

    /// N_s.
    pub fn slots(&self) -> u32 {
        self.slots
    }

    /// Slots left for communication, N - N_s.
    pub fn others(&self) -> u32 {
        self.period.saturating_sub(self.slots)
    }
}

impl State for Sensing {
    fn words(&mut self, visit: &mut impl FnMut(&mut u32)) {
        [&mut self.period, &mut self.spacing, &mut self.slots].into_iter().for_each(visit);
    }
}

/// A checked division of a period.
#[derive(Debug, Clone, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Plan {
    sensing: Sensing,
    shares: Vec<u32, RECEIVERS>,
}

impl Plan {
    /// A plan of `period` (N) slots with `sensing` (N_s) of them `spacing` (N_m) slots apart and `shares` (N_c,k)
    /// for the receivers.
    ///
    /// # Errors
    ///
    /// [`PlanError`] names what does not fit.
    pub fn new(period: u32, spacing: u32, sensing: u32, shares: &[u32]) -> Result<Self, PlanError> {
        let sensing = Sensing::new(period, spacing, sensing)?;
        let receivers = shares.len();
        let shares_kept = Vec::from_slice(shares).ok().filter(|_| receivers > 0);
        let Some(shares_kept) = shares_kept else { return Err(PlanError::Receivers { receivers }) };
        let slots = u64::from(sensing.slots);
        let sum = shares.iter().map(|&share| u64::from(share)).fold(slots, u64::saturating_add);
        if sum != u64::from(period) {
            return Err(PlanError::Sum { sum, period });
        }
        Ok(Plan { sensing, shares: shares_kept })
    }

    /// The optimal plan: what sensing leaves is [`apportion`]ed. With no receiver present those slots stay idle.
    pub fn optimal(sensing: Sensing, rates: &[u32; RECEIVERS], given: &[i32; RECEIVERS]) -> Self {
        let mut shares = Vec::from_array([0; RECEIVERS]);
        apportion(rates, given, sensing.others(), &mut shares);
        Plan { sensing, shares }
    }

    /// Where the sensing slots lie.
    pub fn layout(&self) -> Sensing {
        self.sensing
    }

    /// N.
    pub fn period(&self) -> u32 {
        self.sensing.period
    }

    /// N_m.
    pub fn spacing(&self) -> u32 {
        self.sensing.spacing
    }

    /// N_s.
    pub fn sensing(&self) -> u32 {
        self.sensing.slots
    }

    /// N_c,k of every receiver.
    pub fn shares(&self) -> &[u32] {
        &self.shares
    }

    /// Whether slot `j`, 1..=N, senses.
    pub fn senses(&self, j: u32) -> bool {
        let step = u64::from(self.spacing()) + 1;
        let (j, last) = (u64::from(j), u64::from(self.sensing()) * step);
        j % step == 1 % step && j <= last
    }

    /// Most slots that lie between two of receiver k's while this plan is played period after period; `None` without a share.
    ///
    /// Two turns of n in C communication slots are at most D = ceil(2 C / n) communication slots apart ([`Turns`]); in D steps
    /// from one communication slot to the next lie at most ceil(D / N_m) sensing slots, or all N_s of them if N_m = 0.
    ///
    /// [`Turns`]: super::turns::Turns
    pub fn longest_wait(&self, k: usize) -> Option<u32> {
        let share = self.shares.get(k).copied().filter(|&share| share > 0)?;
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
        let mut receivers = self.shares.len() as u32;
        visit(&mut receivers);
        let _ = self.shares.resize((receivers as usize).min(RECEIVERS), 0); // it fits
        for k in 0..RECEIVERS {
            visit(self.shares.get_mut(k).unwrap_or(&mut 0));
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::string::ToString;

    #[test]
    fn what_does_not_fit_is_named() {
        assert_eq!(Plan::new(0, 3, 0, &[0]), Err(PlanError::Period { period: 0 }));
        assert_eq!(Plan::new(10, 0, 10, &[]), Err(PlanError::Receivers { receivers: 0 }));
        assert_eq!(Plan::new(10, 3, 3, &[7]), Err(PlanError::Spacing { need: 12, period: 10 }));
        assert_eq!(Plan::new(10, 3, 2, &[7]), Err(PlanError::Sum { sum: 9, period: 10 }));
        assert!(Plan::new(10, 3, 2, &[8]).is_ok());
        for (error, words) in [
            (PlanError::Period { period: 0 }, "period 0 is not in 1..=16777216"),
            (PlanError::Receivers { receivers: 9 }, "9 receivers; legal are 1..=8"),
            (
                PlanError::Spacing { need: 12, period: 10 },
                "sensing slots with their spacing need 12 slots; the period has 10",
            ),
            (PlanError::Sum { sum: 9, period: 10 }, "the uses sum to 9 slots; the period has 10"),
        ] {
            assert_eq!(error.to_string(), words);
        }
    }

    #[test]
    fn only_who_has_slots_waits() {
        let plan = Plan::new(40, 3, 5, &[35, 0]).unwrap();
        assert_eq!([0, 1, 2].map(|k| plan.longest_wait(k)), [Some(2), None, None]);
    }

    #[test]
    fn sensing_is_what_was_asked_for_up_to_the_whole_period() {
        let sensing = Sensing::new(40, 3, 10).unwrap();
        assert_eq!((sensing.period(), sensing.spacing(), sensing.slots(), sensing.others()), (40, 3, 10, 30));
        assert_eq!(Sensing::new(40, 3, 11), Err(PlanError::Spacing { need: 44, period: 40 }));
        assert!(Sensing::new(LONGEST_PERIOD, 0, LONGEST_PERIOD).is_ok());
        let beyond = LONGEST_PERIOD + 1;
        assert_eq!(Sensing::new(beyond, 0, 1), Err(PlanError::Period { period: beyond }));
    }

    #[test]
    fn without_receivers_nothing_is_shared() {
        let sensing = Sensing::new(40, 3, 5).unwrap();
        assert_eq!(Plan::optimal(sensing, &[0; 8], &[0; 8]).shares(), [0; 8]);
        let plan = Plan::optimal(sensing, &[0, 2, 0, 1, 0, 0, 0, 0], &[0; 8]);
        assert_eq!(plan.shares(), [0, 12, 0, 23, 0, 0, 0, 0]);
    }
}
