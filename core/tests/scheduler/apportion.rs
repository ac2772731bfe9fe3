//! Tests of `scheduler::apportion`.

use rand_core::{Rng, SeedableRng};
use sdp3_core::scheduler::apportion::*;
use sdp3_core::scheduler::layout::{LONGEST_PERIOD, USERS};

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
