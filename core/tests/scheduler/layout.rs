//! Tests of `scheduler::layout`.

use sdp3_core::scheduler::layout::*;
use std::string::ToString;

#[test]
fn what_does_not_fit_is_said() {
    for (error, words) in [
        (PlanError::Period { period: 0 }, "period 0 is not in 1 to 16777216"),
        (PlanError::Users { users: 9 }, "9 users; legal are 1 to 8"),
        (
            PlanError::Spacing { need: 12, period: 10 },
            "sensing slots with their spacing need 12 slots; the period has 10",
        ),
        (PlanError::Sum { sum: 9, period: 10 }, "the uses sum to 9 slots; the period has 10"),
    ] {
        assert_eq!(error.to_string(), words);
    }
}

#[test]
fn sensing_is_what_was_asked_for_up_to_the_whole_period() {
    let sensing = SensingLayout::new(40, 3, 10).unwrap();
    assert_eq!((sensing.period(), sensing.spacing(), sensing.slots(), sensing.data_slots()), (40, 3, 10, 30));
    assert_eq!(SensingLayout::new(40, 3, 11), Err(PlanError::Spacing { need: 44, period: 40 }));
    assert!(SensingLayout::new(LONGEST_PERIOD, 0, LONGEST_PERIOD).is_ok());
    let beyond = LONGEST_PERIOD + 1;
    assert_eq!(SensingLayout::new(beyond, 0, 1), Err(PlanError::Period { period: beyond }));
}
