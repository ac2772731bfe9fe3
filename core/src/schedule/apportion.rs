//! How many slots each receiver gets so that the worst served one gets as much as possible.
//!
//! The inner problem of Theorem 1 in integers: max over shares of min over receivers of bits, water-filling over whole slots.

use super::plan::RECEIVERS;

/// Most slots that the integer optimum lies below the continuous one's whole part: the others round up by less than one each.
const BELOW: u32 = RECEIVERS as u32;

/// Divides `slots` so that the smallest `(given + share) x rate` is as large as possible, exactly.
///
/// `rates` are bits per slot; a receiver with rate 0 is absent and gets nothing. `given` are slots each receiver already has (or
/// lacks, if negative), within +-2^24. All three slices are as long, at most [`RECEIVERS`]; nothing is given otherwise.
/// The worst `(given + share) x rate` is less than the continuous optimum's by less than K - 1 slots' worth of it.
/// Each step gives one slot to whoever is worst off, the lowest index of equals; all but K (K + 2) slots are given at once by
/// the continuous optimum, so that the loop is bounded. Cost: O(K^3), no more than `RECEIVERS` times 128-bit divisions twice.
pub fn apportion(rates: &[u32], given: &[i32], slots: u32, shares: &mut [u32]) {
    shares.fill(0);
    if rates.len() != shares.len() || given.len() != shares.len() || shares.len() > RECEIVERS {
        return;
    }
    let mut left = slots;
    for k in 0..shares.len() {
        let Some(whole) = level(rates, given, slots, k) else { continue };
        if let (Some(share), Some(&given)) = (shares.get_mut(k), given.get(k)) {
            let most = i64::from(left);
            *share = (whole - i64::from(given) - i64::from(BELOW)).clamp(0, most) as u32;
            left -= *share;
        }
    }
    while left > 0 {
        let totals = shares.iter().zip(given).zip(rates).enumerate();
        let worst = totals
            .filter(|&(_, (_, &rate))| rate > 0)
            .map(|(k, ((&share, &given), &rate))| {
                ((i64::from(given) + i64::from(share)) * i64::from(rate), k)
            })
            .min();
        let Some(share) = worst.and_then(|(_, k)| shares.get_mut(k)) else { return };
        *share += 1;
        left -= 1;
    }
}

/// Whole slots of receiver `k`, those given included, at the level the continuous optimum brings all it serves to; what it has
/// if it lies above that level; `None` if it is absent.
fn level(rates: &[u32], given: &[i32], slots: u32, k: usize) -> Option<i64> {
    rates.get(k).filter(|&&rate| rate > 0)?;
    // 2^64 / rate keeps 33 bits of the largest rate: the error stays below one slot for any period
    let inverse = |rate: u32| (1_i128 << 64) / i128::from(rate.max(1));
    let mut served = [false; RECEIVERS];
    served.iter_mut().zip(rates).for_each(|(served, &rate)| *served = rate > 0);
    let mut whole = 0;
    // each round drops at least one receiver that has more than the level already
    for _ in 0..RECEIVERS {
        let (mut total, mut sum) = (i128::from(slots), 0_i128);
        for ((&rate, &given), _) in rates.iter().zip(given).zip(&served).filter(|(_, served)| **served) {
            total += i128::from(given);
            sum += inverse(rate);
        }
        if sum == 0 {
            return given.get(k).map(|&given| i64::from(given));
        }
        let mut dropped = false;
        for (i, ((&rate, &given), served)) in rates.iter().zip(given).zip(&mut served).enumerate() {
            let own = total * inverse(rate) / sum;
            if *served && own < i128::from(given) {
                (*served, dropped) = (false, true);
            }
            if i == k {
                whole = if *served { own as i64 } else { i64::from(given) };
            }
        }
        if !dropped {
            break;
        }
    }
    Some(whole)
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use rand_core::{Rng, SeedableRng};

    type Random = rand_xoshiro::Xoshiro128PlusPlus;

    /// The greedy rule from nothing: one slot after the other to whoever is worst off.
    fn slot_by_slot(rates: &[u32], given: &[i32], slots: u32) -> std::vec::Vec<u32> {
        let mut shares = std::vec![0_u32; rates.len()];
        for _ in 0..slots {
            let worst = (0..rates.len())
                .filter(|&k| rates[k] > 0)
                .min_by_key(|&k| ((i64::from(given[k]) + i64::from(shares[k])) * i64::from(rates[k]), k));
            let Some(worst) = worst else { break };
            shares[worst] += 1;
        }
        shares
    }

    #[test]
    fn shares_are_the_integer_optimum_found_by_trying_all() {
        let mut rng = Random::seed_from_u64(5);
        for _ in 0..300 {
            let rates = [0; 3].map(|_: u32| 1 + rng.next_u32() % 500);
            let given = [0; 3].map(|_: i32| (rng.next_u32() % 11) as i32 - 5);
            let slots = rng.next_u32() % 40;
            let mut shares = [0; 3];
            apportion(&rates, &given, slots, &mut shares);
            assert_eq!(shares.iter().sum::<u32>(), slots);
            let worst = |s: [u32; 3]| {
                (0..3).map(|k| (i64::from(given[k]) + i64::from(s[k])) * i64::from(rates[k])).min().unwrap()
            };
            let mut best = i64::MIN;
            for a in 0..=slots {
                for b in 0..=slots - a {
                    best = best.max(worst([a, b, slots - a - b]));
                }
            }
            assert_eq!(worst(shares), best, "{rates:?} {given:?} {slots}");
        }
    }

    #[test]
    fn the_shortcut_gives_what_slot_by_slot_gives_for_rates_of_any_ratio() {
        let mut rng = Random::seed_from_u64(6);
        for _ in 0..3000 {
            let receivers = 1 + rng.next_u32() as usize % RECEIVERS;
            let draw = |rng: &mut Random| 1 + (rng.next_u32() >> (rng.next_u32() % 32));
            let mut rates: std::vec::Vec<u32> = (0..receivers).map(|_| draw(&mut rng)).collect();
            if rng.next_u32().is_multiple_of(4) {
                rates[rng.next_u32() as usize % receivers] = 0;
            }
            let reach = 1 + rng.next_u32() % 300;
            let given: std::vec::Vec<i32> =
                (0..receivers).map(|_| (rng.next_u32() % reach) as i32 - reach as i32 / 2).collect();
            let slots = rng.next_u32() % 1000;
            let mut shares = std::vec![0; receivers];
            apportion(&rates, &given, slots, &mut shares);
            assert_eq!(shares, slot_by_slot(&rates, &given, slots), "{rates:?} {given:?} {slots}");
        }
        // one slow receiver among seven fast ones falls six slots below the whole part of its continuous share
        let (rates, mut shares) = ([1, 100, 100, 100, 100, 100, 100, 100], [0; 8]);
        apportion(&rates, &[0; 8], 160, &mut shares);
        assert_eq!(shares, [146, 2, 2, 2, 2, 2, 2, 2]);
    }

    #[test]
    fn long_periods_are_shared_exactly_too() {
        // no receiver can be one slot poorer without the worst getting worse: each share - 1 is worth no more than the worst
        let mut rng = Random::seed_from_u64(6);
        for _ in 0..200 {
            let rates = [0; 5].map(|_: u32| (1 << 27) + (rng.next_u32() >> 2));
            let mut shares = [0; 5];
            apportion(&rates, &[0; 5], super::super::plan::LONGEST_PERIOD, &mut shares);
            assert_eq!(shares.iter().sum::<u32>(), super::super::plan::LONGEST_PERIOD);
            let products = shares.iter().zip(rates).map(|(&s, r)| u64::from(s) * u64::from(r));
            let worst = products.clone().min().unwrap();
            for (product, rate) in products.zip(rates) {
                assert!(product - u64::from(rate) <= worst);
            }
        }
    }

    #[test]
    fn the_worst_loses_less_than_k_minus_one_slots_against_the_continuous_optimum() {
        let mut rng = Random::seed_from_u64(7);
        for _ in 0..2000 {
            let rates = [0; 4].map(|_: u32| 1 + rng.next_u32() % 100_000);
            let slots = 4 + rng.next_u32() % 4000;
            let mut shares = [0; 4];
            apportion(&rates, &[0; 4], slots, &mut shares);
            let continuous = f64::from(slots) / rates.iter().map(|&r| 1.0 / f64::from(r)).sum::<f64>();
            let products = shares.iter().zip(rates).map(|(&s, r)| f64::from(s) * f64::from(r));
            let worst = products.fold(f64::INFINITY, f64::min);
            assert!(1.0 - worst / continuous < 3.0 / f64::from(slots) + 1e-12, "{rates:?} {slots}");
        }
    }
}
