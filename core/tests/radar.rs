//! The two contexts of a radar module on the host: the slot interrupt and the task take turns as the test says.

#[path = "radar/faults.rs"]
mod faults;
#[path = "radar/flips.rs"]
mod flips;
#[path = "radar/planning.rs"]
mod planning;
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
