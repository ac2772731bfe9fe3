//! The scheduler under churn: every period keeps its plan, and its decisions are the known ones.

#[path = "scheduler/apportion.rs"]
mod apportion;
#[path = "scheduler/layout.rs"]
mod layout;
#[path = "scheduler/plan.rs"]
mod plan;
#[path = "scheduler/sample_health.rs"]
mod sample_health;
#[path = "scheduler/scheduler.rs"]
mod scheduler;
#[path = "scheduler/sequencer.rs"]
mod sequencer;

use rand_core::SeedableRng;
use rand_xoshiro::Xoshiro128PlusPlus;
use sdp3_core::scheduler::SlotUse;
use sdp3_testkit::churn::{Churn, KNOWN_ANSWER, PERIODS, run};

fn count(slots: &[SlotUse], k: u8) -> u32 {
    slots.iter().filter(|&&slot| slot == SlotUse::Communication(k)).count() as u32
}

#[test]
fn the_decisions_are_known() {
    let digest = run(&mut Xoshiro128PlusPlus::seed_from_u64(3), PERIODS);
    assert_eq!(digest.hash(), KNOWN_ANSWER, "{:#018x} of {}", digest.hash(), digest.count());
}

#[test]
fn under_churn_every_period_keeps_its_plan() {
    let mut rng = Xoshiro128PlusPlus::seed_from_u64(4);
    let mut churn = Churn::new(&mut rng);
    let mut ended = 0;
    for index in 0..3000 {
        churn.between(&mut rng);
        let (mut slots, mut plan, mut end) = (Vec::new(), None, None);
        loop {
            let slot = churn.scheduler.next_slot();
            slots.push(slot);
            plan.get_or_insert_with(|| churn.scheduler.plan().clone());
            if churn.scheduler.position() == 0 {
                break;
            }
            let left = churn.scheduler.sensing_left();
            churn.during(&mut rng);
            if churn.scheduler.sensing_left() < left {
                end = Some(slots.len());
            }
        }
        let plan = plan.expect("at least one slot");
        assert_eq!(churn.scheduler.report().period, index);
        assert_eq!(slots.len(), plan.period() as usize);
        // sensing is where the plan says, up to where it was ended
        for (j, slot) in (1..).zip(&slots) {
            let planned = plan.senses(j) && end.is_none_or(|end| j as usize <= end);
            assert_eq!(*slot == SlotUse::Sensing, planned, "slot {j} of {plan:?}");
        }
        let present = plan.shares().iter().filter(|&&share| share > 0).count();
        let idle = slots.contains(&SlotUse::Idle);
        assert!(!idle || present == 0);
        match end {
            // every user has exactly its share
            None => (0..8).for_each(|k| assert_eq!(count(&slots, k), plan.shares()[usize::from(k)])),
            // nobody has less than without the end
            Some(_) => {
                ended += 1;
                let rates = churn.rates();
                let worst = |totals: [u32; 8]| {
                    let bits = totals.iter().zip(rates).filter(|(_, r)| *r > 0);
                    bits.map(|(&n, r)| u64::from(n) * u64::from(r)).min().unwrap_or(0)
                };
                let had = core::array::from_fn(|k| count(&slots, k as u8));
                let planned = core::array::from_fn(|k| plan.shares()[k]);
                assert!(worst(had) >= worst(planned), "{plan:?}");
            }
        }
        // no starvation
        let k = churn.rates().iter().filter(|&&rate| rate > 0).count() as u32;
        if plan.layout().data_slots() >= 2 * k {
            for (share, rate) in plan.shares().iter().zip(churn.rates()) {
                assert_eq!(*share > 0, rate > 0, "{plan:?}");
            }
        }
    }
    assert!(ended > 150, "{ended}");
}
