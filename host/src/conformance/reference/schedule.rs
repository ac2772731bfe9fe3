//! A whole period of the schedule in a `Vec`, slot by slot, by its definition.
//!
//! Slot j = 1 to N senses iff j mod (N_m + 1) = 1 (every slot for N_m = 0) and j <= N_s (N_m + 1). Of the other C slots, counted
//! t = 0, 1, ..., slot i = 0, 1, ... of a user with n of them may be played from floor(i C / n) on and is due before
//! ceil((i + 1) C / n); the slot due first is played, of equals the first user's.

/// Use of every slot: `None` sensing, else the user.
pub fn period(period: u32, spacing: u32, sensing: u32, shares: &[u32]) -> Vec<Option<usize>> {
    let step = u64::from(spacing) + 1;
    let total: u64 = shares.iter().map(|&share| u64::from(share)).sum();
    let mut had = vec![0_u64; shares.len()];
    let mut time = 0;
    (1..=u64::from(period))
        .map(|j| {
            if j % step == 1 % step && j <= u64::from(sensing) * step {
                return None;
            }
            let open = |&k: &usize| {
                let share = u64::from(shares[k]);
                had[k] < share && had[k] * total / share <= time
            };
            let due = |&k: &usize| ((had[k] + 1) * total).div_ceil(u64::from(shares[k]));
            let chosen = (0..shares.len()).filter(open).min_by_key(due)?;
            had[chosen] += 1;
            time += 1;
            Some(chosen)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_exact_and_sensing_is_periodic() {
        let uses = period(40, 3, 5, &[20, 10, 5]);
        assert_eq!(uses.iter().filter(|u| u.is_none()).count(), 5);
        for (k, share) in [20, 10, 5].into_iter().enumerate() {
            assert_eq!(uses.iter().filter(|u| **u == Some(k)).count(), share);
        }
        let sensing: Vec<usize> = (0..40).filter(|&j| uses[j].is_none()).collect();
        assert_eq!(sensing, [0, 4, 8, 12, 16]);
    }
}
