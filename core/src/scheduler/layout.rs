//! Where a period's sensing slots lie, checked once: N_s (N_m + 1) <= N.

use crate::supervision::retained::State;

/// Most downlink users of a plan.
pub const USERS: usize = 8;

/// Longest period in slots.
pub const LONGEST_PERIOD: u32 = 1 << 24;

/// Why numbers are not a plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum PlanError {
    /// The period is 0 or longer than [`LONGEST_PERIOD`].
    #[error("period {period} is not in 1 to {LONGEST_PERIOD}")]
    Period {
        /// N.
        period: u32,
    },
    /// No user, or more than [`USERS`].
    #[error("{users} users; legal are 1 to {USERS}")]
    Users {
        /// K.
        users: usize,
    },
    /// The sensing slots with their spacing do not fit the period: N_s (N_m + 1) > N.
    #[error("sensing slots with their spacing need {need} slots; the period has {period}")]
    Spacing {
        /// Slots they need.
        need: u64,
        /// N.
        period: u32,
    },
    /// The uses do not add up to the period.
    #[error("the uses sum to {sum} slots; the period has {period}")]
    Sum {
        /// N_s + sum N_c,k.
        sum: u64,
        /// N.
        period: u32,
    },
}

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
