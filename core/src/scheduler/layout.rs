//! Where a period's sensing slots lie, checked once: N_s (N_m + 1) <= N.

use crate::supervision::retained::State;

/// Most downlink users of a plan.
pub const USERS: usize = 8;

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
    /// No user, or more than [`USERS`].
    Users {
        /// K.
        users: usize,
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
            PlanError::Users { users } => {
                write!(f, "{users} users; legal are 1..={USERS}")
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
pub struct SensingLayout {
    period: u32,
    spacing: u32,
    slots: u32,
}

impl SensingLayout {
    /// A period of one slot without sensing.
    pub const EMPTY: Self = SensingLayout { period: 1, spacing: 0, slots: 0 };

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
        Ok(SensingLayout { period, spacing, slots })
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
    pub fn data_slots(&self) -> u32 {
        self.period.saturating_sub(self.slots)
    }
}

impl State for SensingLayout {
    fn words(&mut self, visit: &mut impl FnMut(&mut u32)) {
        [&mut self.period, &mut self.spacing, &mut self.slots].into_iter().for_each(visit);
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::string::ToString;

    #[test]
    fn what_does_not_fit_is_said() {
        for (error, words) in [
            (PlanError::Period { period: 0 }, "period 0 is not in 1..=16777216"),
            (PlanError::Users { users: 9 }, "9 users; legal are 1..=8"),
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
    fn sensing_is_what_was_asked_for_up_to_the_whole_period() {
        let sensing = SensingLayout::new(40, 3, 10).unwrap();
        assert_eq!(
            (sensing.period(), sensing.spacing(), sensing.slots(), sensing.data_slots()),
            (40, 3, 10, 30)
        );
        assert_eq!(SensingLayout::new(40, 3, 11), Err(PlanError::Spacing { need: 44, period: 40 }));
        assert!(SensingLayout::new(LONGEST_PERIOD, 0, LONGEST_PERIOD).is_ok());
        let beyond = LONGEST_PERIOD + 1;
        assert_eq!(SensingLayout::new(beyond, 0, 1), Err(PlanError::Period { period: beyond }));
    }
}
