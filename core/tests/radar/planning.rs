//! What is accepted, plans and reports of periods, and early exits.

use super::*;

#[test]
fn what_does_not_fit_is_named() {
    let with = |layout: SensingLayout| make(retained(), Settings { layout, ..settings() }).err();
    let few = SensingLayout::new(1200, 3, 199).unwrap();
    assert_eq!(with(few), Some(Error::SensingSlots { need: 200, have: 199 }));
    let all = SensingLayout::new(200, 0, 200).unwrap();
    assert!(matches!(with(all), Some(Error::Deadline { .. })));
    // of 200 slots 25 of the next recording may wait for 38 steps
    let close = SensingLayout::new(400, 1, 200).unwrap();
    assert_eq!(with(close), Some(Error::Deadline { need: 63, have: 50 }));
    assert_eq!(with(SensingLayout::new(4000, 3, 1000).unwrap()), None, "the default is in time");
}

/// Exits of networks of random numbers, and the memory of the largest.
const EXIT_SLOTS: [u16; 3] = [144, 200, 264];
const THREE: Shape = Shape {
    sensing_slots: 264,
    frames: 18,
    channels: support::CHANNELS,
    stem_stride: 2,
    arena: 0,
    radar: RadarConfig::PAPER,
};

/// An exit, and what a recognition by it costs in steps of processing, as a pipeline alone shows it.
struct Cost {
    exit: EarlyExit<'static>,
    slots: u32,
    /// Until the slow time is made: then the next recording has room again.
    slow_time: u32,
    /// Until the classification.
    recognition: u32,
    /// One for each kilobyte of the model without its checksum, also a begun one, and one for what is found.
    check: u32,
}

impl Cost {
    fn of(file: &'static [u8]) -> Self {
        let model = Model::parse(file).expect("a model");
        let exit = EarlyExit { model, weights: [1000; EXITS] };
        let slots = model.sensing_slots();
        let mut memory = support::Memory::of(&model);
        let mut pipeline: Pipeline<'_, '_> =
            Pipeline::new([exit], 2.0, memory.view()).expect("enough memory");
        let samples = support::noise_slots(slots + 1, 4);
        let (next, samples) = samples.split_last().expect("samples");
        samples.iter().for_each(|slot| assert_eq!(pipeline.push(slot, &mut ()), Ok(())));
        pipeline.reset();
        let waiting = (0..slots).take_while(|_| pipeline.push(next, &mut ()).is_ok()).count();
        assert_eq!(waiting, slots / 8);
        let (mut recognition, mut slow_time) = (0, None);
        while recognition < 1000 {
            let done = pipeline.step(&mut ()).is_some();
            recognition += 1;
            if slow_time.is_none() && pipeline.push(next, &mut ()).is_ok() {
                slow_time = Some(recognition);
            }
            if done {
                let slow_time = slow_time.expect("room before the classification");
                let check = (file.len() - 4).div_ceil(1024) as u32 + 1;
                return Cost { exit, slots: slots as u32, slow_time, recognition, check };
            }
        }
        panic!("no classification after {recognition} steps");
    }
}

/// What is not in time by these exits in this layout. A slot has room for one step.
fn late(exits: &[Cost], layout: SensingLayout) -> Option<Error> {
    let (period, apart, sensing) = (layout.period(), layout.spacing() + 1, layout.slots());
    let reached: Vec<_> = exits.iter().filter(|exit| exit.slots <= sensing).collect();
    let first = reached[0].slots;
    let mut tasks = Vec::new();
    // until the next exit is due: its slots are taken, and the recognition before it is over
    for pair in reached.windows(2) {
        let slots = pair[1].slots - pair[0].slots;
        tasks.push((pair[0].recognition + pair[0].check + slots, slots * apart));
    }
    // behind the last: the period's remaining sensing slots, then the next recording's
    let last = reached[reached.len() - 1];
    let (more, rest) = (sensing - last.slots, period - last.slots * apart);
    // one in eight of the largest recording can wait for the slow time
    let waiting = first.min(exits[exits.len() - 1].slots / 8);
    tasks.push((last.slow_time + more + waiting, rest + waiting * apart));
    tasks.push((last.recognition + last.check + more + first, rest + first * apart));
    let (need, have) = tasks.into_iter().find(|(need, have)| need > have)?;
    Some(Error::Deadline { need, have })
}

#[test]
fn what_is_in_time_is_accepted_to_the_slot() {
    let costs: Vec<Cost> = EXIT_SLOTS.map(|slots| Cost::of(support::random_model(slots, 9).leak())).into();
    for (number, exits) in
        [&costs[..1], &costs[1..2], &costs[..2], &costs[1..], &costs[..]].into_iter().enumerate()
    {
        let all: Vec<_> = exits.iter().map(|cost| cost.exit).collect();
        let made = |layout| {
            let memory: &'static mut radar_memory!(THREE) = Box::leak(Box::new(RadarMemory::new()));
            RadarModule::new(&all, Settings { layout, ..settings() }, memory, retained()).err()
        };
        let memory: &'static mut radar_memory!(THREE) = Box::leak(Box::new(RadarMemory::new()));
        let roomy = SensingLayout::new(6000, 9, 300).expect("a layout");
        let module = RadarModule::new(&all, Settings { layout: roomy, ..settings() }, memory, retained());
        let (_, mut processing) = module.expect("in time").split();
        for spacing in [0, 1, 2, 3, 5] {
            for sensing in [exits[0].slots, exits[0].slots + 30, 264, 300] {
                let layout = |period| SensingLayout::new(period, spacing, sensing).expect("a layout");
                let least = sensing * (spacing + 1);
                // the shortest period that is in time, if a longer one helps
                let enough = (least..least + 1000).find(|&period| late(exits, layout(period)).is_none());
                for period in enough.map_or([least; 2], |enough| [enough, least.max(enough - 1)]) {
                    let layout = layout(period);
                    assert_eq!(made(layout), late(exits, layout), "{number}: {layout:?}");
                    let set = processing.set_layout(layout).err();
                    assert_eq!(set, late(exits, layout), "{number}: {layout:?}, set later");
                }
            }
        }
    }
}

#[test]
fn two_changes_in_a_period_are_planned_one_after_the_other() {
    let mut radio = Radio::new(0);
    let played = radio.play(10);
    radio.processing.set_rate(1, 9);
    radio.poll();
    radio.processing.set_rate(1, 0);
    radio.processing.set_rate(2, 5);
    radio.poll();
    let first = [played, radio.play(1190)].concat();
    assert_eq!(first[..790], planned(1)[..790], "changes wait for the next period");
    let (second, third) = (radio.play(1200), radio.play(1200));
    assert_eq!(second[..790], start_of(layout(), [3, 9, 1, 0, 0, 0, 0, 0]));
    assert_eq!(third[..790], start_of(layout(), [3, 0, 5, 0, 0, 0, 0, 0]));
}

#[test]
fn classes_have_the_models_names() {
    let (_, processing) = make(retained(), settings()).unwrap();
    let model = Model::parse(DSN_200).unwrap();
    for class in 0..model.classes() {
        assert!(!model.class_name(class).is_empty());
        assert_eq!(processing.class_name(class as u8), model.class_name(class));
    }
    assert_eq!(processing.class_name(model.classes() as u8), "");
}

/// The first 790 slots of a period: sensing ends early only after the 797th.
fn start_of(layout: SensingLayout, rates: [u32; USERS]) -> Vec<Use> {
    let mut scheduler = Scheduler::new(layout, rates);
    (0..790).map(|_| scheduler.next_slot().into()).collect()
}

#[test]
fn another_layout_holds_from_the_next_period_on() {
    let mut radio = Radio::new(0);
    radio.play(400);
    assert!(matches!(radio.processing.set_sensing_slots(301), Err(Error::Plan(_))), "they do not fit");
    assert_eq!(radio.processing.set_sensing_slots(230), Ok(()));
    radio.play(800);
    let fewer = start_of(SensingLayout::new(1200, 3, 230).unwrap(), RATES);
    assert_ne!(fewer, start_of(layout(), RATES));
    assert_eq!(radio.play(1200)[..790], fewer);
    let wider = SensingLayout::new(1300, 4, 220).unwrap();
    assert_eq!(radio.processing.set_layout(wider), Ok(()));
    radio.poll();
    assert_eq!(radio.play(1300)[..790], start_of(wider, RATES));
    assert_eq!((radio.classified(), radio.faults()), (vec![1, 2, 3], vec![]));
}

#[test]
fn a_layout_that_would_be_late_is_refused_later_too() {
    let mut radio = Radio::new(0);
    radio.play(400);
    for (period, spacing) in [(200, 0), (400, 1)] {
        let late = SensingLayout::new(period, spacing, 200).unwrap();
        let refused = make(retained(), Settings { layout: late, ..settings() }).err();
        assert!(matches!(refused, Some(Error::Deadline { .. })));
        assert_eq!(radio.processing.set_layout(late).err(), refused);
    }
    let close = SensingLayout::new(800, 0, 200).unwrap();
    assert_eq!(radio.processing.set_layout(close), Ok(()));
    assert!(matches!(radio.processing.set_sensing_slots(790), Err(Error::Deadline { .. })));
    // with too few for a recording nothing can be late
    assert_eq!(radio.processing.set_sensing_slots(100), Ok(()));
    radio.play(800);
    let sensed = radio.play(800).into_iter().filter(|&slot| slot == Use::Sense).count();
    assert!(sensed <= 2, "the users have them: {sensed}");
    assert_eq!((radio.classified(), radio.faults()), (vec![1], vec![]));
}

#[test]
fn the_position_counts_the_slots_of_a_period() {
    let mut radio = Radio::new(50);
    for slot in 1..=2500 {
        radio.slot();
        assert_eq!(radio.slots.position(), slot % 1200);
    }
}

#[test]
fn a_period_is_reported_with_what_the_one_before_lost() {
    let mut radio = Radio::new(0);
    let mut sensed = 0;
    for number in 0..1200 {
        let given = radio.given(number);
        sensed += u32::from(given == Use::Sense);
        match given {
            _ if [9, 10, 15, 16].contains(&number) => radio.slots.lost(), // the fifth sensing slot, and three of the users
            Use::Sense => radio.slots.samples_ready(),
            _ => (),
        }
        radio.poll();
    }
    radio.number = 1200;
    radio.processing.set_rate(0, 4);
    let senses = |uses: Vec<Use>| uses.iter().filter(|&&slot| slot == Use::Sense).count() as u32;
    let (second, _) = (senses(radio.play(1200)), radio.play(1));
    let reports = radio.events.iter().filter_map(|event| match event {
        Event::Period(report) => Some((report.period, report.replanned, report.changes)),
        _ => None,
    });
    let nothing = Changes::default();
    let losses = Changes { lost: 3, sensing_lost: 1, released: 250 - sensed, ..nothing };
    // nobody has polled between the new rate and the period
    let changed = Changes { rates: 1, released: 250 - second, ..nothing };
    let expected = [(1, true, nothing), (2, false, losses), (3, true, changed)];
    assert_eq!(reports.collect::<Vec<_>>(), expected);
}

#[test]
fn lost_slots_are_given_back_one_period_later_and_once() {
    let rates = [2, 2, 2, 0, 0, 0, 0, 0];
    let mut radio = Radio::with(make(retained(), Settings { rates, ..settings() }).unwrap(), 0);
    let mut scheduler = Scheduler::new(layout(), rates);
    let mut lost = 0;
    for number in 0..1200 {
        scheduler.next_slot();
        match radio.given(number) {
            Use::Serve(1) if lost < 30 => {
                radio.slots.lost();
                scheduler.on_lost();
                lost += 1;
            }
            Use::Sense => radio.slots.samples_ready(),
            _ => (),
        }
        radio.poll();
    }
    radio.number = 1200;
    let mut period = || radio.play(1200)[..790].to_vec();
    let (usual, repaying) = (start_of(layout(), rates), (0..790).map(|_| scheduler.next_slot().into()));
    let repaying: Vec<Use> = repaying.collect();
    let gained = totals(&repaying)[1] - totals(&usual)[1];
    assert!(gained > 5, "of the 20 more of the whole period: {gained}");
    assert_eq!(period(), usual, "the plan was not yet made");
    assert_eq!(period(), repaying);
    assert_eq!(period(), usual);
}

#[test]
fn reports_that_nobody_takes_are_counted() {
    let mut radio = Radio::new(0);
    radio.polls = 0;
    radio.play(200);
    radio.polls = 1000;
    radio.poll();
    // 50 sensing slots, of which three had a buffer; eight reports wait, the first that a period began
    assert_eq!(radio.faults(), [Fault::Overrun; 7]);
    radio.slots.samples_ready();
    radio.poll();
    assert_eq!(radio.faults(), [Fault::ReportsLost(40), Fault::UnexpectedSamples]);
    radio.slots.samples_ready();
    radio.poll();
    assert_eq!(radio.faults(), [Fault::UnexpectedSamples], "they are counted once");
}

#[test]
fn numbers_that_do_not_follow_each_other_are_late_each() {
    let whole = planned(1);
    let mut radio = Radio::new(0);
    assert_eq!(radio.play(12), whole[..12]);
    for number in [0, 3, 8, 5, 11] {
        assert_eq!(radio.given(number), Use::Idle, "{number}");
        radio.poll();
        assert_eq!(radio.faults(), [Fault::SlotLate], "{number}");
    }
    assert_eq!(radio.play(30), whole[12..42]);
}

#[test]
fn a_damaged_copy_is_played_over_behind_skipped_slots() {
    let whole = planned(1);
    let kept = retained();
    let mut radio = Radio::with(make(kept, settings()).unwrap(), 0);
    radio.play(9);
    radio.number += 8;
    radio.play(1);
    // eleven saves: the last, number 10, is the first copy; the other one is nine slots older
    flip(kept, 3, 1);
    assert_eq!(radio.play(60), whole[18..78]);
    let sensing = whole[9..17].iter().filter(|&&slot| slot == Use::Sense).count() as u32;
    assert_eq!(radio.faults(), [Fault::SlotsSkipped { slots: 8, sensing }, Fault::StateRepaired]);
}

#[test]
fn the_threshold_ends_sensing_at_the_first_exit_that_is_sure_enough() {
    let exits = EXIT_SLOTS.map(|slots| Cost::of(support::random_model(slots, 9).leak()).exit);
    let memory: &'static mut radar_memory!(THREE) = Box::leak(Box::new(RadarMemory::new()));
    let layout = SensingLayout::new(1400, 3, 300).unwrap();
    let module = RadarModule::new(&exits, Settings { layout, ..settings() }, memory, retained());
    let mut radio = Radio::with(module.expect("in time").split(), 0);
    let exits_of_a_period = |radio: &mut Radio| {
        let sensed = radio.play(1400).iter().filter(|&&slot| slot == Use::Sense).count();
        let exits = radio.events.drain(..).filter_map(|event| match event {
            Event::Classification { classification, .. } => Some((classification.exit, classification.stop)),
            _ => None,
        });
        (sensed, exits.collect::<Vec<_>>())
    };
    assert_eq!(exits_of_a_period(&mut radio), (264, vec![(0, false), (1, false), (2, true)]));
    radio.processing.set_threshold(0.0);
    assert_eq!(exits_of_a_period(&mut radio), (144, vec![(0, true)]));
    radio.processing.set_threshold(2.0);
    assert_eq!(exits_of_a_period(&mut radio).0, 264);
}

/// One slot; if it senses, all samples are the same.
fn silent_slot(radio: &mut Radio) {
    if let SlotAction::Sense(buffer) = radio.slots.begin(radio.number) {
        buffer.0.fill(5);
        radio.slots.samples_ready();
    }
    radio.number += 1;
    radio.poll();
}

#[test]
fn samples_behind_a_classification_are_not_looked_at() {
    let layout = SensingLayout::new(1600, 3, 400).unwrap();
    let slow = || {
        let mut radio = Radio::with(make(retained(), Settings { layout, ..settings() }).unwrap(), 0);
        radio.polls = 1;
        radio
    };
    let mut radio = slow();
    while radio.classified().is_empty() && radio.number < 1600 {
        radio.slot();
    }
    // while the model is checked, one kilobyte a slot that does not sense, the recording is complete
    let (classified, check) = (radio.number, DSN_200.len() as u32 / 1024 + 1);
    assert!(check >= 8 && classified < 1600, "two sensing slots at least");
    let mut silent = slow();
    silent.play((classified - check) as usize);
    while silent.number < 1600 {
        silent_slot(&mut silent);
    }
    let classification = |radio: &Radio| {
        radio.events.iter().find(|event| matches!(event, Event::Classification { .. })).cloned()
    };
    assert_eq!(classification(&silent), classification(&radio));
    assert_eq!(silent.faults(), []);
}

#[test]
fn samples_of_a_period_without_a_recording_are_not_looked_at() {
    let mut radio = Radio::new(0);
    radio.play(4 * 60);
    // a gap after which too few sensing slots are left: nobody polls until three more have been taken
    radio.number += 8;
    radio.polls = 0;
    radio.play(4);
    (0..8).for_each(|_| silent_slot(&mut radio));
    radio.polls = 1000;
    radio.poll();
    let faults = radio.faults();
    assert!(matches!(faults[..], [Fault::SlotsSkipped { slots: 8, .. }]), "{faults:?}");
    assert!(!radio.play(900).contains(&Use::Sense), "released");
}

#[test]
fn a_late_recognition_leaves_the_release_of_the_next_period() {
    let layout = SensingLayout::new(800, 3, 200).unwrap();
    // when the class of period 1 comes depends on the polls
    for polls in 1..20 {
        let mut radio = Radio::with(make(retained(), Settings { layout, ..settings() }).unwrap(), 0);
        radio.polls = polls;
        radio.play(804);
        // the second sensing slot of period 2: too few are left
        silent_slot(&mut radio);
        let sensed = radio.play(795).into_iter().filter(|&slot| slot == Use::Sense).count();
        assert!(sensed <= 1, "{polls} polls: {sensed} sensed");
        assert_eq!(radio.classified(), [1], "{polls} polls");
    }
}
