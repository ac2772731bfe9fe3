//! The exact integer division of slots for real rates: the core's, settled to the last bit of an f64.
//!
//! The core divides by rates of 31 bits; users with products that differ by less than that may still exchange a slot.

use sdp3_core::scheduler::{USERS, apportion};

/// Rates in units that fill 31 bits: ratios to 1e-9.
pub fn integer_rates(slot_bits: &[f64]) -> Vec<u32> {
    let most = slot_bits.iter().copied().fold(0.0, f64::max);
    slot_bits.iter().map(|r| ((r / most * f64::from(i32::MAX)).round() as u32).max(1)).collect()
}

/// N_c,k with the largest worst `share x rate`, and that product in bits. At most eight users.
pub fn divide(slot_bits: &[f64], slots: u32) -> (Vec<u32>, f64) {
    let mut shares = vec![0; slot_bits.len()];
    apportion(&integer_rates(slot_bits), &[0; USERS][..shares.len()], slots, &mut shares);
    let bits = |shares: &[u32], k: usize| f64::from(shares[k]) * slot_bits[k];
    loop {
        let worst = (0..shares.len()).min_by(|&i, &j| bits(&shares, i).total_cmp(&bits(&shares, j)));
        let Some(worst) = worst else { return (shares, 0.0) };
        let least = bits(&shares, worst);
        // whoever stays above the worst without one slot can spare it; if nobody can, no division is better
        let spare = |k: usize| shares[k] > 0 && f64::from(shares[k] - 1) * slot_bits[k] > least;
        match (0..shares.len()).find(|&k| k != worst && spare(k)) {
            Some(k) => {
                shares[k] -= 1;
                shares[worst] += 1;
            }
            None => return (shares, least),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::random::Random;

    #[test]
    fn no_division_is_better_on_random_instances() {
        let mut random = Random::new(3, 0, 0, 0);
        for _ in 0..200 {
            let bits: Vec<f64> = (0..3).map(|_| libm::exp(2.0 * random.gaussian())).collect();
            let slots = (random.bits() % 40) as u32;
            let mut best = 0.0_f64;
            for a in 0..=slots {
                for b in 0..=slots - a {
                    let all = [a, b, slots - a - b];
                    best =
                        best.max((0..3).map(|k| f64::from(all[k]) * bits[k]).fold(f64::INFINITY, f64::min));
                }
            }
            let (shares, worst) = divide(&bits, slots);
            assert_eq!((shares.iter().sum::<u32>(), worst), (slots, best), "{bits:?} {slots}");
        }
    }
}
