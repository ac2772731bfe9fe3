//! Bits that flip where a checksum finds them: retained state, a waiting plan, the models of early exits.

use super::*;
use core::ops::Range;
use sdp3_testkit::flip_bit;

fn bytes<T>(values: &[T]) -> Range<*const u8> {
    let Range { start, end } = values.as_ptr_range();
    start.cast()..end.cast()
}

/// Flips a bit of the copy that was saved last; so many times was it saved.
fn flip_newest(kept: &Retained, saves: usize) {
    flip(kept, saves % 2 * (Retained::LEN / 2) + 5, 1);
}

#[test]
fn a_repaired_state_is_reported_once_though_a_number_is_repeated() {
    let kept = retained();
    let mut radio = Radio::with(make(kept, settings()).unwrap(), 0);
    let whole = planned(1);
    radio.play(9);
    flip_newest(kept, 9);
    assert_eq!(radio.given(8), Use::Idle, "its samples are there");
    assert_eq!(radio.play(60), whole[9..69]);
    assert_eq!(radio.faults(), [Fault::StateRepaired, Fault::SlotRepeated]);
}

/// Slots of each user in a period of which sensing ends early, with the newest copy flipped before slot `at`.
fn released(at: usize) -> (Vec<Use>, Vec<Fault>) {
    let kept = retained();
    // a user that has its share of the released slots only by a second division
    let (layout, rates) = (SensingLayout::new(60, 3, 12).unwrap(), [7, 1, 0, 0, 0, 0, 0, 0]);
    let mut radio = Radio::with(make(kept, Settings { rates, ..settings() }).unwrap(), 0);
    assert_eq!(radio.processing.set_layout(layout), Ok(()));
    radio.play(1200);
    let mut uses = radio.play(at);
    radio.faults();
    flip_newest(kept, 1200 + at);
    uses.extend(radio.play(60 - at));
    (uses, radio.faults())
}

#[test]
fn a_repaired_state_keeps_how_released_slots_are_divided() {
    let expected = totals(&released(60).0);
    // sensing ends by the first slot's samples; the users' totals are there two slots later
    for at in 3..20 {
        let (uses, faults) = released(at);
        assert_eq!((totals(&uses), faults), (expected, vec![Fault::StateRepaired]), "before slot {at}");
    }
}

#[test]
fn a_plan_that_has_changed_on_its_way_is_not_played() {
    let mut radio = Radio::new(0);
    radio.play(1200);
    for bit in 0..8 * size_of::<sdp3_core::scheduler::Plan>() as u32 {
        // another plan every time: a period of the old one, then one of the new one
        radio.processing.set_rate(0, 1 + bit % 2);
        radio.poll();
        let waiting = radio.slots.waiting_plan().expect("a plan waits");
        let before = waiting.clone();
        assert!(flip_bit(&bytes(core::slice::from_ref(waiting)), bit));
        assert!(!radio.play(1200).contains(&Use::Idle));
        assert_eq!(radio.faults(), [Fault::PlanDamaged], "bit {bit}");
        // the same plan, sent again
        let waiting = radio.slots.waiting_plan().expect("another one");
        assert_eq!((waiting.layout(), waiting.shares()), (before.layout(), before.shares()), "bit {bit}");
        radio.play(1200);
        assert_eq!(radio.faults(), []);
    }
}

#[test]
fn numbers_of_periods_go_on_when_the_state_is_lost() {
    let kept = retained();
    let mut radio = Radio::with(make(kept, settings()).unwrap(), 0);
    radio.polls = 1;
    // the recognition of period 1 is under way
    radio.play(4 * 200);
    assert_eq!(radio.classified(), []);
    flip(kept, 3, 1);
    flip(kept, 3 + Retained::LEN / 2, 1);
    radio.play(20 + 2 * 1200);
    assert_eq!(radio.classified(), [1, 2, 3]);
    assert_eq!(radio.faults(), [Fault::StateLost]);
}

const EXITS_SHAPE: Shape = Shape {
    sensing_slots: 200,
    frames: 10,
    channels: support::CHANNELS,
    stem_stride: 2,
    arena: 0,
    radar: RadarConfig::PAPER,
};

#[test]
fn a_damaged_model_is_reported_once_and_the_other_exits_go_on() {
    let layout = SensingLayout::new(2000, 7, 250).unwrap();
    for damaged in [0, 1] {
        let files: [&'static [u8]; 2] = [144, 200].map(|slots| &*support::random_model(slots, 3).leak());
        let exits =
            files.map(|file| EarlyExit { model: Model::parse(file).unwrap(), weights: [1000; EXITS] });
        let memory: &'static mut radar_memory!(EXITS_SHAPE) = Box::leak(Box::new(RadarMemory::new()));
        let module = RadarModule::new(&exits, Settings { layout, ..settings() }, memory, retained()).unwrap();
        let mut radio = Radio::with(module.split(), 0);
        let period = |radio: &mut Radio| {
            radio.play(2000);
            let found = radio.events.iter().filter_map(|event| match event {
                Event::Classification { classification, .. } => Some(classification.exit),
                _ => None,
            });
            (found.collect::<Vec<_>>(), radio.faults().len())
        };
        assert_eq!(period(&mut radio), (vec![0, 1], 0));
        // the last of its weights; the checksum of the file is not looked at again
        let weight = 8 * (files[damaged].len() - 5) as u32;
        assert!(flip_bit(&bytes(files[damaged]), weight));
        let left = if damaged == 0 { vec![] } else { vec![0] };
        assert_eq!(period(&mut radio), (left.clone(), 1), "model {damaged}");
        assert_eq!(period(&mut radio), (left.clone(), 0), "model {damaged}: reported once");
        assert!(flip_bit(&bytes(files[damaged]), weight));
        assert_eq!(period(&mut radio), (vec![0, 1], 0), "as it was");
        assert!(flip_bit(&bytes(files[damaged]), weight));
        assert_eq!(period(&mut radio), (left, 1), "reported again");
    }
}

#[test]
fn areas_without_a_checksum_exist_and_do_not_overlap() {
    use sdp3_core::areas::Area;
    let areas = [
        Area::WaitingSlot(0),
        Area::WaitingSlot(1),
        Area::WaitingSlot(2),
        Area::Beats,
        Area::Gram,
        Area::SlowTime,
        Area::LogMagnitudes,
        Area::Activations,
        Area::PackedWeights,
        Area::OperatorWords,
        Area::Weights(0),
        Area::Threshold,
    ];
    let mut radio = Radio::new(0);
    radio.polls = 4;
    // a module of one exit has no logits of an earlier one
    assert!(radio.processing.area(Area::Logits).is_empty());
    let mut found = [false; 12];
    for number in 0..2400 {
        if radio.given(number) == Use::Sense {
            radio.slots.samples_ready();
        }
        let ranges = areas.map(|area| radio.processing.area(area));
        for (k, range) in ranges.iter().enumerate() {
            found[k] |= !range.is_empty();
            let overlaps = |other: &Range<*const u8>| range.start < other.end && other.start < range.end;
            assert!(!ranges[..k].iter().any(overlaps), "{:?}", areas[k]);
        }
        radio.poll();
    }
    assert_eq!(found, [true; 12], "{areas:?}");
}
