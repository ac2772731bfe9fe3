//! A whole period of the schedule in a `Vec`, slot by slot, by its definition.
//!
//! Slot j = 1..=N senses iff j mod (N_m + 1) = 1 (every slot for N_m = 0) and j <= N_s (N_m + 1); the others go to
//! the receiver with the largest credit, each slot adding every share to its credit and taking their sum from the
//! chosen one.

/// Use of every slot: `None` sensing, else the receiver.
pub fn period(period: u32, spacing: u32, sensing: u32, shares: &[u32]) -> Vec<Option<usize>> {
    let step = u64::from(spacing) + 1;
    let total: i64 = shares.iter().map(|&share| i64::from(share)).sum();
    let mut credits = vec![0_i64; shares.len()];
    (1..=u64::from(period))
        .map(|j| {
            if j % step == 1 % step && j <= u64::from(sensing) * step {
                return None;
            }
            credits.iter_mut().zip(shares).for_each(|(credit, &share)| *credit += i64::from(share));
            let most = credits.iter().copied().max()?;
            let chosen = credits.iter().position(|&credit| credit == most)?;
            credits[chosen] -= total;
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
