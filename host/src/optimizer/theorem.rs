//! Theorem 1: the boundary in closed form, over real numbers of slots.
//!
//! T_s Theta^-1(A) + [sum over users of T_s / r_k] R = N T_s, r_k being user k's bits in one slot: R falls linearly in
//! N_s.

/// What Theorem 1 needs: N and the users' bits per slot.
#[derive(Debug, Clone)]
pub struct Theorem {
    period: f64,
    /// Slots that one bit for every user takes: sum of 1 / r_k.
    slots_per_bit: f64,
}

impl Theorem {
    /// For a period of N slots and bits per slot, all positive.
    pub fn new(period: u32, slot_bits: &[f64]) -> Self {
        Theorem { period: f64::from(period), slots_per_bit: slot_bits.iter().map(|r| 1.0 / r).sum() }
    }

    /// R at N_s, bits per period.
    pub fn throughput_bit(&self, sensing_slots: f64) -> f64 {
        (self.period - sensing_slots).max(0.0) / self.slots_per_bit
    }
}
