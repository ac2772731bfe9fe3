//! Tests of `scheduler::slot_order`.

use rand_core::{Rng, SeedableRng};
use sdp3_core::scheduler::layout::USERS;
use sdp3_core::scheduler::slot_order::*;

#[test]
fn every_prefix_is_proportionate_to_less_than_one_slot() {
    let mut rng = rand_xoshiro::Xoshiro128PlusPlus::seed_from_u64(2);
    for _ in 0..2000 {
        let users = 1 + rng.next_u32() as usize % USERS;
        let shares: std::vec::Vec<u32> =
            (0..users).map(|_| (rng.next_u32() % 300) >> (rng.next_u32() % 8)).collect();
        let slots: u32 = shares.iter().sum();
        let mut order = SlotOrder::new(&shares);
        let mut had = std::vec![0_u32; users];
        for played in 1..=slots {
            had[order.next().expect("a turn in every slot")] += 1;
            for (&had, &share) in had.iter().zip(&shares) {
                // |had - played share / slots| < 1
                let lag = i64::from(had) * i64::from(slots) - i64::from(played) * i64::from(share);
                assert!(lag.abs() < i64::from(slots), "{shares:?} {played}");
            }
        }
        assert_eq!((&had, order.next()), (&shares, None));
        assert_eq!(&order.served()[..users], &shares[..]);
    }
}
