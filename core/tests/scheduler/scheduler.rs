//! Tests of `scheduler::scheduler`.

use sdp3_core::scheduler::layout::{LONGEST_PERIOD, SensingLayout, USERS};
use sdp3_core::scheduler::planner::{PeriodReport, Planner};
use sdp3_core::scheduler::scheduler::*;
use sdp3_core::scheduler::sequencer::SlotUse;
use std::vec::Vec;

/// One period as it was played.
fn period(scheduler: &mut Scheduler, mut during: impl FnMut(&mut Scheduler, SlotUse)) -> Vec<SlotUse> {
    let mut slots = Vec::new();
    loop {
        let slot = scheduler.next_slot();
        slots.push(slot);
        if scheduler.position() == 0 {
            return slots;
        }
        during(scheduler, slot);
    }
}

fn count(slots: &[SlotUse], k: u8) -> u32 {
    slots.iter().filter(|&&slot| slot == SlotUse::Communication(k)).count() as u32
}

#[test]
fn changes_wait_for_the_boundary_and_are_reported_there() {
    let sensing = SensingLayout::new(40, 3, 5).unwrap();
    let mut scheduler = Scheduler::new(sensing, [3, 3, 0, 0, 0, 0, 0, 0]);
    let plan = scheduler.plan().clone();
    let first = period(&mut scheduler, |s, slot| {
        s.planner_mut().set_rate(2, 7);
        s.planner_mut().set_rate(1, 5);
        assert_eq!(s.planner().rates(), [3, 5, 7, 0, 0, 0, 0, 0]);
        s.planner_mut().set_sensing_slots(4).unwrap();
        assert!(s.planner_mut().set_sensing_slots(11).is_err());
        if slot == SlotUse::Communication(0) {
            s.on_lost();
        }
    });
    assert_eq!((count(&first, 0), count(&first, 1)), (plan.shares()[0], plan.shares()[1]));
    scheduler.next_slot();
    let PeriodReport { period, replanned, changes } = scheduler.report();
    assert_eq!((period, replanned), (1, true));
    assert_eq!((changes.joined, changes.left, changes.rates, changes.sensing), (4, 0, 2, true));
    assert_eq!((changes.lost, changes.sensing_lost, changes.released), (count(&first, 0), 0, 0));
    assert_eq!(scheduler.plan().sensing(), 4);
}

#[test]
fn lost_slots_are_given_back_once() {
    let sensing = SensingLayout::new(100, 3, 10).unwrap();
    let mut scheduler = Scheduler::new(sensing, [4, 4, 4, 0, 0, 0, 0, 0]);
    let mut lost = 0;
    period(&mut scheduler, |s, slot| {
        if slot == SlotUse::Communication(1) && lost < 9 {
            (lost, ()) = (lost + 1, s.on_lost());
            s.on_lost(); // the same slot
        }
    });
    let second = period(&mut scheduler, |_, _| ());
    assert_eq!([count(&second, 0), count(&second, 1), count(&second, 2)], [27, 36, 27]);
    let third = period(&mut scheduler, |_, _| ());
    assert_eq!([count(&third, 0), count(&third, 1), count(&third, 2)], [30, 30, 30]);
    period(&mut scheduler, |_, _| ());
    assert!(!scheduler.report().replanned);
}

#[test]
fn served_counts_what_was_given_in_this_period() {
    let sensing = SensingLayout::new(400, 3, 100).unwrap();
    let mut scheduler = Scheduler::new(sensing, [1, 2, 4, 0, 0, 0, 0, 0]);
    for _ in 0..2 {
        let mut given = [0; USERS];
        for n in 0..400 {
            if n == 90 {
                scheduler.end_sensing();
            }
            if let SlotUse::Communication(k) = scheduler.next_slot() {
                given[usize::from(k)] += 1;
            }
            if n < 399 {
                assert_eq!(scheduler.served(), given, "after slot {n}");
            }
        }
    }
}

#[test]
fn ending_sensing_gives_its_slots_to_the_users() {
    let sensing = SensingLayout::new(400, 3, 100).unwrap();
    let mut scheduler = Scheduler::new(sensing, [1, 2, 4, 0, 0, 0, 0, 0]);
    let slots = period(&mut scheduler, |s, _| {
        if s.position() == 201 {
            s.end_sensing();
        }
    });
    assert_eq!(slots.iter().filter(|&&s| s == SlotUse::Sensing).count(), 51);
    let served = [count(&slots, 0), count(&slots, 1), count(&slots, 2)];
    // 349 slots by 1/1 : 1/2 : 1/4
    assert_eq!(served, [199, 100, 50]);
    scheduler.next_slot();
    assert_eq!(scheduler.report().changes.released, 49);
}

#[test]
fn totals_of_numbers_beyond_the_longest_period_are_what_was_served() {
    let planner = Planner::new(SensingLayout::new(400, 3, 100).unwrap(), [1; USERS]);
    assert_eq!(planner.totals(8, &[3; USERS]), [4; USERS]);
    for served in [LONGEST_PERIOD + 1, i32::MAX as u32, 1 << 31, u32::MAX] {
        assert_eq!(planner.totals(5, &[served; USERS]), [served; USERS]);
        let mixed = [served, 0, 0, 0, 0, 0, 0, 0];
        assert_eq!(planner.totals(5, &mixed), mixed);
    }
    assert_eq!(planner.totals(u32::MAX, &[3; USERS]), [3; USERS]);
}
