//! The two contexts of a radar module on the host: the slot interrupt and the task take turns as the test says.

mod support;

use core::sync::atomic::Ordering::Relaxed;
use rand_core::SeedableRng;
use sdp3_core::config::RadarConfig;
use sdp3_core::dsn::{Model, Shape};
use sdp3_core::early_exit::{EXITS, EarlyExit};
use sdp3_core::pipeline::Pipeline;
use sdp3_core::radar::{
    Event, ProcessingContext, Progress, RadarMemory, RadarModule, SLOT_BUFFERS, Settings, SlotAction,
    SlotContext,
};
use sdp3_core::scheduler::{Changes, Scheduler, SensingLayout, SlotUse, USERS};
use sdp3_core::supervision::retained::Retained;
use sdp3_core::supervision::{Fault, SampleFault};
use sdp3_core::{Error, pipeline_memory, radar_memory};
use sdp3_testkit::flip;
use sdp3_testkit::models::DSN_200;
use sdp3_testkit::signals::noise;

const SHAPE: Shape = Shape::of(DSN_200).expect("a model");
const VALUES: usize = SHAPE.slot_values();
type Memory = radar_memory!(SHAPE);
type Slots = SlotContext<VALUES>;
type Processing = ProcessingContext<VALUES>;

const RATES: [u32; USERS] = [3, 2, 1, 0, 0, 0, 0, 0];

fn layout() -> SensingLayout {
    SensingLayout::new(1200, 3, 250).expect("a layout")
}

fn settings() -> Settings {
    Settings { layout: layout(), rates: RATES, threshold: 2.0 }
}

fn retained() -> &'static Retained {
    Box::leak(Box::new(Retained::new()))
}

fn make(retained: &'static Retained, settings: Settings) -> Result<(Slots, Processing), Error> {
    let memory: &'static mut Memory = Box::leak(Box::new(Memory::new()));
    let exit = EarlyExit::single(Model::parse(DSN_200)?);
    Ok(RadarModule::new(&[exit], settings, memory, retained)?.split())
}

/// What a slot was used for.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Use {
    Sense,
    Serve(u8),
    Idle,
}

impl From<SlotUse> for Use {
    fn from(slot: SlotUse) -> Self {
        match slot {
            SlotUse::Sensing => Use::Sense,
            SlotUse::Communication(user) => Use::Serve(user),
            SlotUse::Idle => Use::Idle,
        }
    }
}

/// A radio: numbers, samples, and polls after every slot.
struct Radio {
    slots: Slots,
    processing: Processing,
    number: u32,
    rng: rand_xoshiro::Xoshiro128PlusPlus,
    events: Vec<Event>,
    polls: usize,
}

impl Radio {
    fn new(first: u32) -> Self {
        Self::with(make(retained(), settings()).expect("a module"), first)
    }

    fn with((slots, processing): (Slots, Processing), number: u32) -> Self {
        let rng = rand_xoshiro::Xoshiro128PlusPlus::seed_from_u64(3);
        Radio { slots, processing, number, rng, events: Vec::new(), polls: 1000 }
    }

    fn poll(&mut self) {
        for _ in 0..self.polls {
            match self.processing.poll() {
                Progress::Idle => return,
                Progress::Busy => (),
                Progress::Event(event) => self.events.push(event),
            }
        }
    }

    /// One slot with the next number; its samples come if it senses.
    fn slot(&mut self) -> Use {
        let given = self.given(self.number);
        self.number = self.number.wrapping_add(1);
        if given == Use::Sense {
            self.slots.samples_ready();
        }
        self.poll();
        given
    }

    /// What a number is given, and noise in its buffer.
    fn given(&mut self, number: u32) -> Use {
        match self.slots.begin(number) {
            SlotAction::Sense(buffer) => {
                noise(&mut self.rng, &mut buffer.0);
                Use::Sense
            }
            SlotAction::Serve(user) => Use::Serve(user),
            SlotAction::Idle => Use::Idle,
        }
    }

    fn play(&mut self, count: usize) -> Vec<Use> {
        (0..count).map(|_| self.slot()).collect()
    }

    fn faults(&mut self) -> Vec<Fault> {
        let faults = self.events.iter().filter_map(|event| match event {
            Event::Fault(fault) => Some(*fault),
            _ => None,
        });
        let faults = faults.collect();
        self.events.clear();
        faults
    }

    fn classified(&self) -> Vec<u32> {
        let period = |event: &Event| match event {
            Event::Classification { period, .. } => Some(*period),
            _ => None,
        };
        self.events.iter().filter_map(period).collect()
    }
}

/// The uses of so many periods without a fault.
fn planned(periods: usize) -> Vec<Use> {
    let mut scheduler = Scheduler::new(layout(), RATES);
    (0..periods * 1200).map(|_| scheduler.next_slot().into()).collect()
}

/// Slots of each user.
fn totals(uses: &[Use]) -> [usize; 3] {
    [0, 1, 2].map(|user| uses.iter().filter(|&&slot| slot == Use::Serve(user)).count())
}

#[test]
fn without_faults_it_is_the_scheduler_and_the_number_may_wrap() {
    let mut radio = Radio::new(u32::MAX - 1500);
    let mut scheduler = Scheduler::new(layout(), RATES);
    for period in 0..3 {
        // the only exit stops sensing at its 200 slots of 250
        let (uses, mut expected) = (radio.play(1200), Vec::new());
        while expected.len() < 1200 {
            expected.push(Use::from(scheduler.next_slot()));
            if expected.len() == 4 * 199 + 1 {
                scheduler.end_sensing();
            }
        }
        assert_eq!(uses[..797], expected[..797]);
        assert_eq!(totals(&uses), totals(&expected), "the rest, in an order of its own");
        assert!(!uses[797..].contains(&Use::Sense));
        // other rates from the next period on
        radio.processing.set_rate(1, 9 + period);
        scheduler.planner_mut().set_rate(1, 9 + period);
        radio.poll();
    }
    assert_eq!(radio.classified(), [1, 2, 3]);
    assert_eq!(radio.faults(), []);
}

#[test]
fn a_module_classifies_as_the_pipeline_does() {
    let mut radio = Radio::new(0);
    radio.play(1200);
    type Alone = pipeline_memory!(SHAPE);
    let mut memory = Box::new(Alone::new());
    let exit = EarlyExit::single(Model::parse(DSN_200).unwrap());
    let mut pipeline: Pipeline<'_, '_> = Pipeline::new([exit], 2.0, memory.view()).unwrap();
    let mut rng = rand_xoshiro::Xoshiro128PlusPlus::seed_from_u64(3);
    let mut slot = [0; VALUES];
    for _ in 0..200 {
        noise(&mut rng, &mut slot);
        pipeline.push(&slot, &mut ()).unwrap();
    }
    let alone = pipeline.classify(&mut ()).unwrap();
    let event = Event::Classification { period: 1, classification: alone };
    assert!(radio.events.contains(&event), "{:?}", radio.events);
}

#[test]
fn a_recognition_may_overlap_the_next_periods_sensing() {
    // fifty slots behind the recording, and one step of processing a slot
    let layout = SensingLayout::new(850, 3, 200).unwrap();
    let mut radio = Radio::with(make(retained(), Settings { layout, ..settings() }).unwrap(), 0);
    radio.polls = 1;
    let uses = radio.play(4 * 850);
    assert_eq!((radio.classified(), radio.faults()), (vec![1, 2, 3], vec![]));
    assert_eq!(uses.iter().filter(|&&slot| slot == Use::Sense).count(), 800);
}

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
    assert_eq!(radio.classified(), [1]);
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

#[test]
fn what_does_not_fit_is_named() {
    let with = |layout: SensingLayout| make(retained(), Settings { layout, ..settings() }).err();
    let few = SensingLayout::new(1200, 3, 199).unwrap();
    assert_eq!(with(few), Some(Error::SensingSlots { need: 200, have: 199 }));
    let all = SensingLayout::new(200, 0, 200).unwrap();
    assert!(matches!(with(all), Some(Error::Deadline { .. })));
    // of 200 slots 25 of the next recording may wait for 37 steps
    let close = SensingLayout::new(400, 1, 200).unwrap();
    assert_eq!(with(close), Some(Error::Deadline { need: 62, have: 50 }));
    assert_eq!(with(SensingLayout::new(4000, 3, 1000).unwrap()), None, "the default is in time");
}

/// Exits of networks of random numbers, and the memory of the largest.
const EXIT_SLOTS: [u16; 3] = [144, 200, 264];
const THREE: Shape = Shape {
    sensing_slots: 264,
    frames: 18,
    channels: support::CHANNELS,
    stem_stride: 2,
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
        for spacing in [0, 1, 2, 3, 5] {
            for sensing in [exits[0].slots, exits[0].slots + 30, 264, 300] {
                let layout = |period| SensingLayout::new(period, spacing, sensing).expect("a layout");
                let least = sensing * (spacing + 1);
                // the shortest period that is in time, if a longer one helps
                let enough = (least..least + 1000).find(|&period| late(exits, layout(period)).is_none());
                for period in enough.map_or([least; 2], |enough| [enough, least.max(enough - 1)]) {
                    let layout = layout(period);
                    assert_eq!(made(layout), late(exits, layout), "{number}: {layout:?}");
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
    assert!(radio.processing.set_sensing_slots(301).is_err(), "they do not fit");
    assert_eq!(radio.processing.set_sensing_slots(230), Ok(()));
    radio.play(800);
    let fewer = start_of(SensingLayout::new(1200, 3, 230).unwrap(), RATES);
    assert_ne!(fewer, start_of(layout(), RATES));
    assert_eq!(radio.play(1200)[..790], fewer);
    let wider = SensingLayout::new(1300, 4, 220).unwrap();
    radio.processing.set_layout(wider);
    radio.poll();
    assert_eq!(radio.play(1300)[..790], start_of(wider, RATES));
    assert_eq!((radio.classified(), radio.faults()), (vec![1, 2, 3], vec![]));
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
