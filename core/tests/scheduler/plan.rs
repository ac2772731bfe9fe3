//! Tests of `scheduler::plan`.

use sdp3_core::scheduler::layout::{PlanError, SensingLayout};
use sdp3_core::scheduler::plan::*;

#[test]
fn what_does_not_fit_is_named() {
    assert_eq!(Plan::new(0, 3, 0, &[0]), Err(PlanError::Period { period: 0 }));
    assert_eq!(Plan::new(10, 0, 10, &[]), Err(PlanError::Users { users: 0 }));
    assert_eq!(Plan::new(10, 3, 3, &[7]), Err(PlanError::Spacing { need: 12, period: 10 }));
    assert_eq!(Plan::new(10, 3, 2, &[7]), Err(PlanError::Sum { sum: 9, period: 10 }));
    assert!(Plan::new(10, 3, 2, &[8]).is_ok());
}

#[test]
fn only_who_has_slots_waits() {
    let plan = Plan::new(40, 3, 5, &[35, 0]).unwrap();
    assert_eq!([0, 1, 2].map(|k| plan.longest_wait(k)), [Some(2), None, None]);
}

#[test]
fn without_users_nothing_is_shared() {
    let sensing = SensingLayout::new(40, 3, 5).unwrap();
    assert_eq!(Plan::optimal(sensing, &[0; 8], &[0; 8]).shares(), [0; 8]);
    let plan = Plan::optimal(sensing, &[0, 2, 0, 1, 0, 0, 0, 0], &[0; 8]);
    assert_eq!(plan.shares(), [0, 12, 0, 23, 0, 0, 0, 0]);
}
