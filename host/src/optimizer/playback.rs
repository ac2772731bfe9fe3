//! One period of a plan as the core's scheduler plays it.

use super::OptimizerError;
use crate::results::{OperatingPoint, Schedule};
use sdp3_core::schedule::{Plan, Sequencer, SlotUse};

/// Appends a slot to a run-length coded period.
pub fn lengthen(timeline: &mut Vec<(i32, u32)>, slot: SlotUse) {
    let code = match slot {
        SlotUse::Communication(k) => i32::from(k),
        SlotUse::Sensing => -1,
        SlotUse::Idle => -2,
    };
    match timeline.last_mut() {
        Some((last, slots)) if *last == code => *slots += 1,
        _ => timeline.push((code, 1)),
    }
}

/// Plays an operating point for one period.
///
/// # Errors
///
/// [`OptimizerError::Plan`] if the numbers are not a plan.
pub fn play(point: &OperatingPoint) -> Result<Schedule, OptimizerError> {
    let plan =
        Plan::new(point.period_slots, point.spacing_slots, point.sensing_slots, &point.communication_slots)
            .map_err(OptimizerError::Plan)?;
    let mut sequencer = Sequencer::new(&plan);
    let receivers = point.communication_slots.len();
    let mut schedule = Schedule {
        period_slots: plan.period(),
        sensing_slots: 0,
        communication_slots: vec![0; receivers],
        longest_wait_slots: vec![0; receivers],
        delivered_bit: vec![0.0; receivers],
        timeline: Vec::new(),
        recognised: None,
    };
    let mut waits = vec![0; receivers];
    for _ in 0..plan.period() {
        waits.iter_mut().for_each(|wait| *wait += 1);
        let slot = sequencer.next();
        match slot {
            SlotUse::Communication(k) => {
                let k = usize::from(k);
                schedule.communication_slots[k] += 1;
                schedule.delivered_bit[k] += point.slot_bit.get(k).copied().unwrap_or(0.0);
                schedule.longest_wait_slots[k] = schedule.longest_wait_slots[k].max(waits[k] - 1);
                waits[k] = 0;
            }
            SlotUse::Sensing => schedule.sensing_slots += 1,
            SlotUse::Idle => (),
        }
        lengthen(&mut schedule.timeline, slot);
    }
    for (longest, wait) in schedule.longest_wait_slots.iter_mut().zip(waits) {
        *longest = (*longest).max(wait);
    }
    Ok(schedule)
}
