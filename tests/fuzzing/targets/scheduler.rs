//! Whatever happens to a running schedule, every period keeps its plan: slots add up, sensing never drifts, nobody starves.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sdp3_core::scheduler::layout::LONGEST_PERIOD;
use sdp3_core::scheduler::{Plan, Scheduler, SensingLayout, SlotUse, USERS};
use sdp3_fuzz::Bytes;

/// Sensing of a period of at most 256 slots.
fn sensing(bytes: &mut Bytes<'_>) -> SensingLayout {
    let (period, spacing) = (1 + u32::from(bytes.u8()), u32::from(bytes.u8()) % 6);
    let slots = u32::from(bytes.u8()) % (period / (spacing + 1) + 1);
    SensingLayout::new(period, spacing, slots).expect("it fits")
}

/// A rate of any magnitude, 0 among them.
fn rate(bytes: &mut Bytes<'_>) -> u32 {
    bytes.u32() >> (bytes.u8() % 33).min(31)
}

/// A period as it is played.
struct Period {
    plan: Plan,
    served: [u32; USERS],
    sensed: u32,
    ended: bool,
}

impl Period {
    fn of(plan: &Plan) -> Self {
        Period { plan: plan.clone(), served: [0; USERS], sensed: 0, ended: false }
    }

    fn slot(&mut self, j: u32, slot: SlotUse) {
        assert_eq!(slot == SlotUse::Sensing, self.plan.senses(j) && !self.ended);
        match slot {
            SlotUse::Sensing => self.sensed += 1,
            SlotUse::Communication(k) => self.served[usize::from(k)] += 1,
            SlotUse::Idle => assert_eq!(self.plan.shares().iter().sum::<u32>(), 0),
        }
        if j == self.plan.period() && !self.ended {
            assert_eq!(self.sensed, self.plan.sensing());
            assert_eq!(self.served, self.plan.shares());
        }
    }
}

/// Events while a schedule of short periods is played.
fn play(bytes: &mut Bytes<'_>) {
    let mut scheduler = Scheduler::new(sensing(bytes), std::array::from_fn(|_| rate(bytes)));
    let mut period = Period::of(scheduler.plan());
    while !bytes.is_empty() {
        match bytes.u8() {
            0..32 => scheduler.planner_mut().set_rate(usize::from(bytes.u8()) % (USERS + 1), rate(bytes)),
            32..48 => scheduler.planner_mut().set_layout(sensing(bytes)),
            48..64 => _ = scheduler.planner_mut().set_sensing_slots(bytes.u32() >> (bytes.u8() % 32)),
            64..96 => scheduler.on_lost(),
            96..112 => {
                period.ended |= scheduler.position() > 0 && scheduler.sensing_left() > 0;
                scheduler.end_sensing();
            }
            count => {
                for _ in 0..count - 100 {
                    let j = scheduler.position() + 1;
                    let slot = scheduler.next_slot();
                    if j == 1 {
                        period = Period::of(scheduler.plan());
                        let boundary = scheduler.report();
                        assert!(boundary.replanned || boundary.changes.lost == 0);
                    }
                    period.slot(j, slot);
                }
            }
        }
    }
}

/// Periods up to the longest, rates up to the largest.
fn stretch(bytes: &mut Bytes<'_>) {
    let (period, spacing, slots) = (bytes.u32() % (LONGEST_PERIOD + 2), bytes.u32(), bytes.u32());
    let Ok(sensing) = SensingLayout::new(period, spacing >> (spacing % 32), slots >> (slots % 32)) else {
        return;
    };
    let mut scheduler = Scheduler::new(sensing, std::array::from_fn(|_| rate(bytes)));
    let others = |plan: &Plan| plan.shares().iter().sum::<u32>();
    let plan = scheduler.plan();
    assert!(others(plan) == sensing.data_slots() || others(plan) == 0);
    for _ in 0..bytes.u8() {
        scheduler.next_slot();
        if bytes.u8() < 32 {
            scheduler.on_lost();
        }
    }
    scheduler.end_sensing();
    (0..USERS).for_each(|k| {
        let _ = scheduler.plan().longest_wait(k);
    });
    scheduler.next_slot();
}

fuzz_target!(|data: &[u8]| {
    let mut bytes = Bytes(data);
    if bytes.u8() < 64 { stretch(&mut bytes) } else { play(&mut bytes) }
});
