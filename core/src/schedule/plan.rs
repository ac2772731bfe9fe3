//! How many slots of a period each use gets, checked once.
//!
//! N_s + sum N_c,k = N and N_s (N_m + 1) <= N; problem P of the paper in integers.

use heapless::Vec;

/// Most receivers of a plan.
pub const RECEIVERS: usize = 8;

/// Longest period: sums of credits stay within i32.
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

/// A checked division of a period.
#[derive(Debug, Clone, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Plan {
    period: u32,
    spacing: u32,
    sensing: u32,
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
        if period == 0 || period > LONGEST_PERIOD {
            return Err(PlanError::Period { period });
        }
        let receivers = shares.len();
        let shares_kept = Vec::from_slice(shares).ok().filter(|_| receivers > 0);
        let Some(shares_kept) = shares_kept else { return Err(PlanError::Receivers { receivers }) };
        let need = u64::from(sensing).saturating_mul(u64::from(spacing) + 1);
        if need > u64::from(period) {
            return Err(PlanError::Spacing { need, period });
        }
        let sum = shares.iter().map(|&share| u64::from(share)).fold(u64::from(sensing), u64::saturating_add);
        if sum != u64::from(period) {
            return Err(PlanError::Sum { sum, period });
        }
        Ok(Plan { period, spacing, sensing, shares: shares_kept })
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
    pub fn sensing(&self) -> u32 {
        self.sensing
    }

    /// N_c,k of every receiver.
    pub fn shares(&self) -> &[u32] {
        &self.shares
    }

    /// Whether slot `j`, 1..=N, senses.
    pub fn senses(&self, j: u32) -> bool {
        let step = u64::from(self.spacing) + 1;
        let (j, last) = (u64::from(j), u64::from(self.sensing) * step);
        j % step == 1 % step && j <= last
    }
}

/// Divides `slots` among receivers so that the smallest `share x rate` is as large as possible, exactly.
///
/// `rates` are bits per slot, all positive; `shares` is as long. Each step gives one slot to the receiver that is
/// worst off, the lowest index of equals; all but K slots are given at once by proportion, so that the loop is
/// bounded by K. Nothing is given if a rate is zero. Cost: O(K^2).
pub fn apportion(rates: &[u32], slots: u32, shares: &mut [u32]) {
    shares.fill(0);
    if rates.is_empty() || rates.contains(&0) || rates.len() != shares.len() {
        return;
    }
    // continuous optimum slots (1/r_k) / sum (1/r_i), rounded down; 2^64 / r_k keeps 33 bits of the largest rate, so the
    // error stays below one slot for any period
    let inverse = |rate: u32| (1_u128 << 64) / u128::from(rate);
    let total: u128 = rates.iter().map(|&rate| inverse(rate)).fold(0, u128::saturating_add);
    let mut left = slots;
    for (share, &rate) in shares.iter_mut().zip(rates) {
        let exact = inverse(rate).saturating_mul(u128::from(slots)) / total.max(1);
        *share = (exact as u32).saturating_sub(1).min(left);
        left -= *share;
    }
    // at most 2 K + 1 slots are left: one of rounding and one held back for each receiver
    while left > 0 {
        let products = shares.iter().zip(rates).map(|(&share, &rate)| u64::from(share) * u64::from(rate));
        let Some((worst, _)) = products.enumerate().min_by_key(|&(k, product)| (product, k)) else { return };
        if let Some(share) = shares.get_mut(worst) {
            *share += 1;
        }
        left -= 1;
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use rand_core::{Rng, SeedableRng};

    #[test]
    fn what_does_not_fit_is_named() {
        assert_eq!(Plan::new(0, 3, 0, &[0]), Err(PlanError::Period { period: 0 }));
        assert_eq!(Plan::new(10, 0, 10, &[]), Err(PlanError::Receivers { receivers: 0 }));
        assert_eq!(Plan::new(10, 3, 3, &[7]), Err(PlanError::Spacing { need: 12, period: 10 }));
        assert_eq!(Plan::new(10, 3, 2, &[7]), Err(PlanError::Sum { sum: 9, period: 10 }));
        assert!(Plan::new(10, 3, 2, &[8]).is_ok());
    }

    #[test]
    fn shares_are_the_integer_optimum_found_by_trying_all() {
        let mut rng = rand_xoshiro::Xoshiro128PlusPlus::seed_from_u64(5);
        for _ in 0..300 {
            let rates = [0; 3].map(|_: u32| 1 + rng.next_u32() % 500);
            let slots = rng.next_u32() % 40;
            let mut shares = [0; 3];
            apportion(&rates, slots, &mut shares);
            assert_eq!(shares.iter().sum::<u32>(), slots);
            let worst = |s: [u32; 3]| s.iter().zip(rates).map(|(s, r)| s * r).min().unwrap();
            let mut best = 0;
            for a in 0..=slots {
                for b in 0..=slots - a {
                    best = best.max(worst([a, b, slots - a - b]));
                }
            }
            assert_eq!(worst(shares), best, "{rates:?} {slots}");
        }
    }

    #[test]
    fn long_periods_are_shared_exactly_too() {
        // no receiver can be one slot poorer without the worst getting worse: each share - 1 is worth no more than the worst
        let mut rng = rand_xoshiro::Xoshiro128PlusPlus::seed_from_u64(6);
        for _ in 0..200 {
            let rates = [0; 5].map(|_: u32| (1 << 27) + (rng.next_u32() >> 2));
            let mut shares = [0; 5];
            apportion(&rates, LONGEST_PERIOD, &mut shares);
            assert_eq!(shares.iter().sum::<u32>(), LONGEST_PERIOD);
            let products = shares.iter().zip(rates).map(|(&s, r)| u64::from(s) * u64::from(r));
            let worst = products.clone().min().unwrap();
            for (product, rate) in products.zip(rates) {
                assert!(product - u64::from(rate) <= worst);
            }
        }
    }
}
