//! Tests of `scheduler::sequencer`.

use rand_core::{Rng, SeedableRng};
use sdp3_core::scheduler::layout::USERS;
use sdp3_core::scheduler::plan::Plan;
use sdp3_core::scheduler::sequencer::*;
use std::vec::Vec;

fn random_plan(rng: &mut impl Rng) -> Plan {
    let period = 1 + rng.next_u32() % 600;
    let spacing = rng.next_u32() % 5;
    let sensing = rng.next_u32() % (period / (spacing + 1) + 1);
    let users = 1 + rng.next_u32() as usize % USERS;
    let mut left = period - sensing;
    let mut shares: Vec<u32> = (1..users)
        .map(|_| {
            let share = rng.next_u32() % (left + 1);
            left -= share;
            share
        })
        .collect();
    shares.push(left);
    Plan::new(period, spacing, sensing, &shares).unwrap()
}

#[test]
fn shares_positions_and_waits_hold_on_random_plans() {
    let mut rng = rand_xoshiro::Xoshiro128PlusPlus::seed_from_u64(11);
    let mut close = 0;
    for _ in 0..3000 {
        let plan = random_plan(&mut rng);
        let mut sequencer = Sequencer::new(&plan);
        let total: u32 = plan.shares().iter().sum();
        let mut counts = [0; USERS];
        let mut waits = [None::<u32>; USERS];
        for j in 1..=3 * plan.period() {
            let within = (j - 1) % plan.period() + 1;
            let slot = sequencer.next_slot();
            waits.iter_mut().flatten().for_each(|wait| *wait += 1);
            assert_eq!(slot == SlotUse::Sensing, plan.senses(within));
            match slot {
                SlotUse::Sensing => (),
                SlotUse::Communication(k) => {
                    let k = usize::from(k);
                    counts[k] += 1;
                    // after every slot each user has its proportion to less than one: |had - played share / total| < 1
                    let played: u32 = counts.iter().sum();
                    for (&had, &share) in counts.iter().zip(plan.shares()) {
                        let lag = i64::from(had) * i64::from(total) - i64::from(played) * i64::from(share);
                        assert!(lag.abs() < i64::from(total), "{plan:?} {played}");
                    }
                    if let Some(wait) = waits[k] {
                        let bound = plan.longest_wait(k).unwrap();
                        assert!(wait - 1 <= bound, "{plan:?}: user {k} waited {}", wait - 1);
                        close += u32::from(wait == bound);
                    }
                    waits[k] = Some(0);
                }
                SlotUse::Idle => assert!(total == 0),
            }
            if within == plan.period() {
                assert_eq!(&counts[..plan.shares().len()], plan.shares());
                assert_eq!(sequencer.position(), 0);
                counts = [0; USERS];
            } else {
                assert_eq!(sequencer.served(), counts);
            }
        }
    }
    assert!(close > 1000, "the bound is reached but for one slot: {close}");
}
