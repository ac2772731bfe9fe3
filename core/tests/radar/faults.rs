//! Slots and samples that are lost, late, unexpected or damaged, and resets.

use super::*;

#[test]
fn skipped_slots_are_lost_and_a_recording_with_a_gap_restarts() {
    let whole = planned(1);
    let mut radio = Radio::new(7);
    assert_eq!(radio.play(10), whole[..10]);
    radio.number += 6;
    assert_eq!(radio.play(50), whole[16..66]);
    let sensing = whole[10..16].iter().filter(|&&slot| slot == Use::Sense).count() as u32;
    assert_eq!(radio.faults(), [Fault::SlotsSkipped { slots: 6, sensing }]);
    // more than is played through
    radio.number += 9;
    assert_eq!(radio.play(10), whole[..10], "a new period");
    assert_eq!(radio.faults(), [Fault::Outage { slots: 9 }]);
    // 200 of 250 slots are needed: a gap at slot 60 ends the period's sensing
    radio.play(4 * 60);
    radio.number += 8;
    let rest = radio.play(1200 - 10 - 4 * 60 - 8);
    assert!(rest.iter().filter(|&&slot| slot == Use::Sense).count() < 5, "released");
    assert!(!rest.contains(&Use::Idle));
    assert_eq!(radio.classified(), []);
    radio.play(1200);
    assert_eq!(radio.classified().len(), 1);
}

#[test]
fn numbers_out_of_order_never_move_the_schedule() {
    let whole = planned(1);
    let mut radio = Radio::new(0);
    assert_eq!(radio.play(12), whole[..12]);
    assert_eq!(radio.given(11), whole[11]);
    assert_eq!(radio.given(3), Use::Idle);
    radio.poll();
    assert_eq!(radio.faults(), [Fault::SlotRepeated, Fault::SlotLate]);
    assert_eq!(radio.play(8), whole[12..20]);
    // the radio counts from another number: the second one shows it
    assert_eq!(radio.given(0x8000_0000 + 20), Use::Idle);
    radio.number = 0x8000_0000 + 21;
    assert_eq!(radio.play(30), whole[..30]);
    assert_eq!(radio.faults(), [Fault::SlotLate, Fault::CounterReset]);
}

#[test]
fn samples_that_are_missing_or_unexpected_are_reported_once() {
    let mut radio = Radio::new(0);
    assert_eq!(radio.given(0), Use::Sense);
    radio.number = 1;
    radio.play(3);
    assert_eq!(radio.faults(), [Fault::MissingSamples]);
    radio.slots.samples_ready();
    radio.poll();
    assert_eq!(radio.faults(), [Fault::UnexpectedSamples]);
    // the number of a sensing slot again: the same buffer
    assert_eq!((radio.given(4), radio.given(4)), (Use::Sense, Use::Sense));
    radio.slots.samples_ready();
    assert_eq!(radio.given(4), Use::Idle, "its samples are there");
    radio.poll();
    assert_eq!(radio.faults(), [Fault::SlotRepeated, Fault::SlotRepeated]);
    // a lost sensing slot begins the recording again, and nothing is missing
    radio.number = 5;
    radio.play(3);
    assert_eq!(radio.given(8), Use::Sense);
    radio.slots.lost();
    radio.number = 9;
    radio.play(4 * 205);
    assert_eq!(radio.faults(), []);
}

#[test]
fn samples_that_come_too_late_take_no_buffer_away() {
    let mut radio = Radio::new(0);
    for _ in 0..6 {
        assert_eq!(radio.given(radio.number), Use::Sense);
        radio.number += 1;
        radio.slot();
        radio.slots.samples_ready();
        radio.play(2);
    }
    assert_eq!(radio.faults(), [Fault::MissingSamples, Fault::UnexpectedSamples].repeat(6));
}

#[test]
fn without_a_poll_sensing_slots_are_lost_and_said_so() {
    let mut radio = Radio::new(0);
    radio.polls = 0;
    let uses = radio.play(40);
    assert_eq!(
        uses.iter().filter(|&&slot| slot == Use::Sense).count(),
        SLOT_BUFFERS,
        "as many as there are buffers"
    );
    radio.polls = 1000;
    radio.play(1);
    let faults = radio.faults();
    assert_eq!(faults, [Fault::Overrun; 7]);
}

#[test]
fn a_slot_is_counted_as_lost_once() {
    let mut radio = Radio::new(0);
    let lost = |radio: &Radio| {
        let mut period = radio.events.iter().filter_map(|event| match event {
            Event::Period(report) => Some((report.changes.sensing_lost, report.changes.lost)),
            _ => None,
        });
        period.next_back()
    };
    // twice the same, once a sensing slot and once a user's
    let whole = planned(1);
    for slot in &whole[..2] {
        assert_eq!(radio.given(radio.number), *slot);
        radio.number += 1;
        radio.slots.lost();
        radio.slots.lost();
    }
    radio.play(1198);
    // all buffers wait: a sensing slot that has none is lost, whatever the radio says of it
    radio.polls = 0;
    radio.play(13);
    radio.slots.lost();
    radio.polls = 1000;
    assert!(matches!(radio.given(radio.number), Use::Serve(_)), "not a sensing slot");
    radio.number += 1;
    radio.play(1200 - 14);
    assert_eq!(lost(&radio), Some((1, 1)), "of the first period");
    radio.play(1);
    assert_eq!(lost(&radio), Some((1, 0)), "of the second");
    assert_eq!(radio.faults(), [Fault::Overrun]);
}

#[test]
fn samples_that_cannot_be_trusted_are_not_used() {
    let mut radio = Radio::new(0);
    radio.play(4 * 20);
    let SlotAction::Sense(buffer) = radio.slots.begin(80) else { panic!("slot 80 senses") };
    buffer.0.fill(5);
    radio.slots.samples_ready();
    radio.number = 81;
    radio.poll();
    assert_eq!(radio.faults(), [Fault::Samples(SampleFault::Silent)]);
    // 229 sensing slots are left: enough for another recording
    radio.play(4 * 205);
    assert_eq!(radio.classified(), [1]);
}

#[test]
fn any_flipped_bit_of_the_state_is_found_and_played_over() {
    let whole = planned(1);
    for at in 0..Retained::LEN {
        for bit in [0, 7, 15, 31] {
            let kept = retained();
            let mut radio = Radio::with(make(kept, settings()).unwrap(), 0);
            radio.processing.set_rate(0, 3);
            assert_eq!(radio.play(9), whole[..9]);
            flip(kept, at, 1 << bit);
            assert_eq!(radio.play(60), whole[9..69], "word {at}, bit {bit}");
            let newest = at / (Retained::LEN / 2) == 1; // ten saves: the last, number 9, is the second copy
            let expected = if newest { vec![Fault::StateRepaired] } else { vec![] };
            assert_eq!(radio.faults(), expected, "word {at}, bit {bit}");
        }
    }
}

#[test]
fn with_both_copies_damaged_a_new_period_follows() {
    let kept = retained();
    let mut radio = Radio::with(make(kept, settings()).unwrap(), 0);
    radio.play(5);
    flip(kept, 3, 1);
    flip(kept, 3 + Retained::LEN / 2, 1);
    let uses = radio.play(30);
    assert_eq!(radio.faults(), [Fault::StateLost]);
    let idle = uses.iter().take_while(|&&slot| slot == Use::Idle).count();
    assert!((1..3).contains(&idle), "{uses:?}");
    assert_eq!(uses[idle..], planned(1)[..30 - idle]);
    radio.play(1200);
    assert_eq!(radio.classified(), [2], "the numbers go on");
}

#[test]
fn a_reset_goes_on_from_retained_memory() {
    let whole = planned(1);
    let kept = retained();
    let mut radio = Radio::with(make(kept, settings()).unwrap(), 100);
    radio.play(10);
    let mut back = Radio::with(make(kept, settings()).unwrap(), 112);
    assert_eq!(back.play(60), whole[12..72], "two slots have passed");
    assert!(matches!(back.faults()[..], [Fault::SlotsSkipped { slots: 2, .. }]));
    back.play(4 * 210);
    assert_eq!(back.classified(), [1], "the recording began again");
}

#[test]
fn a_reset_within_a_write_loses_at_most_one_slot() {
    let whole = planned(1);
    let written = |slots: usize| {
        let kept = retained();
        Radio::with(make(kept, settings()).unwrap(), 0).play(slots);
        kept.words().iter().map(|word| word.load(Relaxed)).collect::<Vec<u32>>()
    };
    let (before, after) = (written(10), written(11));
    let half = Retained::LEN / 2;
    let first = if before[0] == after[0] { half } else { 0 };
    assert_eq!(before[half - first..][..half], after[half - first..][..half], "one copy is written");
    for stop in 0..=half {
        let kept = retained();
        for (at, word) in kept.words().iter().enumerate() {
            let new = (first..first + stop).contains(&at);
            word.store(if new { after[at] } else { before[at] }, Relaxed);
        }
        let mut back = Radio::with(make(kept, settings()).unwrap(), 11);
        assert_eq!(back.play(20), whole[11..31], "stopped after {stop} words");
        let skipped = Fault::SlotsSkipped { slots: 1, sensing: u32::from(whole[10] == Use::Sense) };
        let expected = if stop < half { vec![skipped] } else { vec![] };
        assert_eq!(back.faults(), expected, "stopped after {stop} words");
    }
}

#[test]
fn memory_that_nothing_was_written_to_is_not_a_state() {
    for filled in [0, u32::MAX, 0xAAAA_AAAA, 0x5555_5555, 0xDEAD_BEEF] {
        let kept = retained();
        kept.words().iter().for_each(|word| word.store(filled, Relaxed));
        let mut radio = Radio::with(make(kept, settings()).unwrap(), 77);
        assert_eq!((radio.play(30), radio.faults()), (planned(1)[..30].to_vec(), vec![]), "{filled:#x}");
    }
}
