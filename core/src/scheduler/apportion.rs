//! How many slots each user gets so that the worst served one gets as much as possible.
//!
//! The inner problem of Theorem 1 in integers: max over shares of min over users of bits, water-filling over whole slots.

use super::layout::{LONGEST_PERIOD, USERS};

/// Most slots that the integer optimum lies below the continuous one's whole part: the others round up by less than one each.
const BELOW: u32 = USERS as u32;

/// Fraction bits of a user's weight: a level of [`LONGEST_PERIOD`] slots is exact to far below one.
pub(crate) const WEIGHT_BITS: u32 = 32;

/// Divides `slots` so that the smallest `(given + share) x rate` is as large as possible, exactly.
///
/// `rates` are bits per slot; a user with rate 0 is absent and gets nothing. `given` are slots each user already has (or
/// lacks, if negative). All three slices are as long, at most [`USERS`], and no number of slots is beyond
/// [`LONGEST_PERIOD`]; nothing is given otherwise.
/// The worst `(given + share) x rate` is less than the continuous optimum's by less than K - 1 slots' worth of it.
/// Each step gives one slot to whoever is worst off, the lowest index of equals; all but K (K + 2) slots are given at once by
/// the continuous optimum, so that the loop is bounded. Cost: O(K^3), with at most 2 K^2 divisions of 64 bits.
pub fn apportion(rates: &[u32], given: &[i32], slots: u32, shares: &mut [u32]) {
    shares.fill(0);
    let as_long = rates.len() == shares.len() && given.len() == shares.len() && shares.len() <= USERS;
    let as_short = given.iter().all(|given| given.unsigned_abs() <= LONGEST_PERIOD);
    if !as_long || !as_short || slots > LONGEST_PERIOD {
        return;
    }
    let mut left = slots;
    let whole = levels(rates, given, slots);
    for (((share, whole), &given), _) in
        shares.iter_mut().zip(whole).zip(given).zip(rates).filter(|(_, rate)| **rate > 0)
    {
        *share = (whole - i64::from(given) - i64::from(BELOW)).clamp(0, i64::from(left)) as u32;
        left -= *share;
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

/// Whole slots of every user, those given included, at the level that the continuous optimum brings all to whom it gives
/// any; of the others, what they have.
fn levels(rates: &[u32], given: &[i32], slots: u32) -> [i64; USERS] {
    let mut served = [false; USERS];
    served.iter_mut().zip(rates).for_each(|(served, &rate)| *served = rate > 0);
    let mut whole = [0; USERS];
    // each round drops at least one user that has more than the level already
    for _ in 0..USERS {
        let slowest = rates.iter().zip(&served).filter(|(_, served)| **served).map(|(&rate, _)| rate).min();
        let Some(slowest) = slowest else { return whole };
        // 1 for the slowest, less for the others
        let weight = |rate: u32| {
            (u64::from(slowest) << WEIGHT_BITS).checked_div(u64::from(rate)).unwrap_or(0) as i64 // at most 2^32
        };
        let (mut total, mut sum) = (i64::from(slots), 0_i64);
        for ((&rate, &given), _) in rates.iter().zip(given).zip(&served).filter(|(_, served)| **served) {
            total += i64::from(given);
            sum += weight(rate);
        }
        let mut dropped = false;
        for (((&rate, &given), served), whole) in rates.iter().zip(given).zip(&mut served).zip(&mut whole) {
            if *served {
                *whole = (total * weight(rate)).checked_div(sum).unwrap_or(0);
                if *whole < i64::from(given) {
                    *whole = i64::from(given);
                    (*served, dropped) = (false, true);
                }
            }
        }
        if !dropped {
            break;
        }
    }
    whole
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
    fn nothing_is_given_where_the_question_is_none() {
        let given = |rates: &[u32], given: &[i32], slots, users| {
            let mut shares = std::vec![7_u32; users];
            apportion(rates, given, slots, &mut shares);
            shares.iter().sum::<u32>()
        };
        let longest = LONGEST_PERIOD as i32;
        assert_eq!(given(&[1, 2], &[0, -longest], 10, 2), 10);
        assert_eq!(given(&[1, 2], &[longest, 0], LONGEST_PERIOD, 2), LONGEST_PERIOD);
        for (rates, had, slots, users) in [
            (&[1, 2, 3][..], &[0, 0][..], 10, 2),
            (&[1, 2], &[0, 0, 0], 10, 2),
            (&[1, 2], &[0, 0], 10, 3),
            (&[1, 2], &[0, longest + 1], 10, 2),
            (&[1, 2], &[i32::MIN, 0], 10, 2),
            (&[1, 2], &[0, 0], LONGEST_PERIOD + 1, 2),
            (&[1; USERS + 1], &[0; USERS + 1], 10, USERS + 1),
        ] {
            assert_eq!(given(rates, had, slots, users), 0, "{rates:?}, {had:?}, {slots}, {users}");
        }
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
            let users = 1 + rng.next_u32() as usize % USERS;
            let draw = |rng: &mut Random| 1 + (rng.next_u32() >> (rng.next_u32() % 32));
            let mut rates: std::vec::Vec<u32> = (0..users).map(|_| draw(&mut rng)).collect();
            if rng.next_u32().is_multiple_of(4) {
                rates[rng.next_u32() as usize % users] = 0;
            }
            let reach = 1 + rng.next_u32() % 300;
            let given: std::vec::Vec<i32> =
                (0..users).map(|_| (rng.next_u32() % reach) as i32 - reach as i32 / 2).collect();
            let slots = rng.next_u32() % 1000;
            let mut shares = std::vec![0; users];
            apportion(&rates, &given, slots, &mut shares);
            assert_eq!(shares, slot_by_slot(&rates, &given, slots), "{rates:?} {given:?} {slots}");
        }
        // one slow user among seven fast ones falls six slots below the whole part of its continuous share
        let (rates, mut shares) = ([1, 100, 100, 100, 100, 100, 100, 100], [0; 8]);
        apportion(&rates, &[0; 8], 160, &mut shares);
        assert_eq!(shares, [146, 2, 2, 2, 2, 2, 2, 2]);
    }

    #[test]
    fn long_periods_are_shared_exactly_too() {
        // no user can be one slot poorer without the worst getting worse: each share - 1 is worth no more than the worst
        let mut rng = Random::seed_from_u64(6);
        for round in 0..400 {
            let rates = [0; 5].map(|_: u32| match round % 2 {
                0 => (1 << 27) + (rng.next_u32() >> 2),
                _ => 1 + (rng.next_u32() >> (rng.next_u32() % 32)),
            });
            let mut shares = [0; 5];
            apportion(&rates, &[0; 5], LONGEST_PERIOD, &mut shares);
            assert_eq!(shares.iter().sum::<u32>(), LONGEST_PERIOD);
            let products = shares.iter().zip(rates).map(|(&s, r)| u64::from(s) * u64::from(r));
            let worst = products.clone().min().unwrap();
            for (product, rate) in products.zip(rates) {
                assert!(product.saturating_sub(u64::from(rate)) <= worst);
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
