//! How many slots each user gets so that the worst served one gets as much as possible.
//!
//! The inner problem of Theorem 1 in integers: max over shares of min over users of bits, water-filling over whole slots.

use super::layout::{LONGEST_PERIOD, USERS};

/// Most slots that the integer optimum lies below the continuous one's whole part: the others round up by less than one each.
const BELOW: u32 = USERS as u32;

/// Fraction bits of a user's weight: a level of [`LONGEST_PERIOD`] slots is exact to far below one.
pub(crate) const WEIGHT_BITS: u32 = 32;

/// Divides `slots` so that the smallest `(credit + share) x rate` is as large as possible, exactly.
///
/// `rates` are bits per slot; a user with rate 0 is absent and gets nothing. `credit` are slots each user already has (or
/// lacks, if negative). All three slices are as long, at most [`USERS`], and no number of slots is beyond [`LONGEST_PERIOD`]; nothing
/// is given otherwise. The worst `(credit + share) x rate` is less than the continuous optimum's by less than K - 1 slots' worth of
/// it. Each step gives one slot to whoever is worst off, the lowest index of equals; all but K (K + 2) slots are given at once by the
/// continuous optimum, so that the loop is bounded. Cost: O(K^3), with at most 2 K^2 divisions of 64 bits.
pub fn apportion(rates: &[u32], credit: &[i32], slots: u32, shares: &mut [u32]) {
    shares.fill(0);
    let as_long = rates.len() == shares.len() && credit.len() == shares.len() && shares.len() <= USERS;
    let as_short = credit.iter().all(|credit| credit.unsigned_abs() <= LONGEST_PERIOD);
    if !as_long || !as_short || slots > LONGEST_PERIOD {
        return;
    }
    let mut left = slots;
    let whole = levels(rates, credit, slots);
    for (((share, whole), &credit), _) in
        shares.iter_mut().zip(whole).zip(credit).zip(rates).filter(|(_, rate)| **rate > 0)
    {
        *share = (whole - i64::from(credit) - i64::from(BELOW)).clamp(0, i64::from(left)) as u32;
        left -= *share;
    }
    while left > 0 {
        let totals = shares.iter().zip(credit).zip(rates).enumerate();
        let worst = totals
            .filter(|&(_, (_, &rate))| rate > 0)
            .map(|(k, ((&share, &credit), &rate))| {
                ((i64::from(credit) + i64::from(share)) * i64::from(rate), k)
            })
            .min();
        let Some(share) = worst.and_then(|(_, k)| shares.get_mut(k)) else { return };
        *share += 1;
        left -= 1;
    }
}

/// Whole slots of every user, the credit included, at the level that the continuous optimum brings all to whom it gives
/// any; of the others, what they have.
fn levels(rates: &[u32], credit: &[i32], slots: u32) -> [i64; USERS] {
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
        for ((&rate, &credit), _) in rates.iter().zip(credit).zip(&served).filter(|(_, served)| **served) {
            total += i64::from(credit);
            sum += weight(rate);
        }
        let mut dropped = false;
        for (((&rate, &credit), served), whole) in rates.iter().zip(credit).zip(&mut served).zip(&mut whole) {
            if *served {
                *whole = (total * weight(rate)).checked_div(sum).unwrap_or(0);
                if *whole < i64::from(credit) {
                    *whole = i64::from(credit);
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
