//! The porter's example runs on the host, with a board of its own.

#[path = "../../firmware-sim/src/porting.rs"]
mod porting;
mod static_cell {
    pub use ::static_cell::ConstStaticCell;
}

mod board {
    use rand_core::SeedableRng;
    use sdp3_core::scheduler::USERS;
    use sdp3_core::{Event, ProcessingContext, Shape, SlotContext};
    pub use sdp3_testkit::models::DSN_200 as MODEL;
    use sdp3_testkit::signals::noise;
    use std::cell::{Cell, RefCell};

    const SHAPE: Shape = Shape::of(MODEL).expect("a model");
    pub type Slots = SlotContext<{ SHAPE.slot_values() }>;
    pub type Task = ProcessingContext<{ SHAPE.slot_values() }>;
    pub const BITS: [u32; USERS] = [1500, 2500, 3000, 0, 0, 0, 0, 0];

    /// What ends the idle loop: the slots that sensed, and what was reported last.
    pub struct Ended(pub usize, pub Event);

    thread_local! {
        static SLOTS: RefCell<Option<Slots>> = const { RefCell::new(None) };
        static RNG: RefCell<rand_xoshiro::Xoshiro128PlusPlus> =
            RefCell::new(rand_xoshiro::Xoshiro128PlusPlus::seed_from_u64(3));
        static NUMBER: Cell<u32> = const { Cell::new(0) };
        static SENSED: Cell<usize> = const { Cell::new(0) };
    }

    pub fn start(slots: Slots, task: &mut Task) {
        let mut rng = rand_xoshiro::Xoshiro128PlusPlus::seed_from_u64(7);
        assert!(task.self_test(&mut rng));
        SLOTS.set(Some(slots));
    }

    /// The next slot's interrupt, and the end of the transfer if there was one.
    pub fn sleep() {
        let before = SENSED.get();
        assert!(NUMBER.get() < 8000, "no classification in two periods");
        SLOTS.with_borrow_mut(|slots| {
            let slots = slots.as_mut().expect("started");
            super::porting::slot(slots, NUMBER.replace(NUMBER.get() + 1));
            if SENSED.get() > before {
                slots.samples_ready();
            }
        });
    }

    pub fn start_transfer(buffer: &mut [i16]) {
        RNG.with_borrow_mut(|rng| noise(rng, buffer));
        SENSED.set(SENSED.get() + 1);
    }

    pub fn transmit(user: u8) {
        assert!(BITS[usize::from(user)] > 0);
    }

    pub fn report(_task: &Task, event: Event) {
        if !matches!(event, Event::Period(_)) {
            std::panic::resume_unwind(Box::new(Ended(SENSED.get(), event)));
        }
    }
}

use sdp3_core::dsn::Model;
use sdp3_core::early_exit::EarlyExit;
use sdp3_core::pipeline::Pipeline;
use sdp3_core::radar::Event;
use sdp3_core::{Shape, pipeline_memory};

#[test]
fn the_example_classifies_what_the_pipeline_does() {
    let ended = std::panic::catch_unwind(porting::run).expect_err("it runs until a classification");
    let board::Ended(sensed, event) = *ended.downcast().expect("the board ended it");
    const SHAPE: Shape = Shape::of(board::MODEL).expect("a model");
    let mut memory = Box::new(<pipeline_memory!(SHAPE)>::new());
    let exit = EarlyExit::single(Model::parse(board::MODEL).unwrap());
    let mut pipeline: Pipeline<'_, '_> = Pipeline::new([exit], 2.0, memory.view()).unwrap();
    let mut rng: rand_xoshiro::Xoshiro128PlusPlus = rand_core::SeedableRng::seed_from_u64(3);
    let mut slot = [0; SHAPE.slot_values()];
    for _ in 0..200 {
        sdp3_testkit::signals::noise(&mut rng, &mut slot);
        pipeline.push(&slot, &mut ()).unwrap();
    }
    let classification = pipeline.classify(&mut ()).unwrap();
    assert_eq!(event, Event::Classification { period: 1, classification });
    assert!((200..250).contains(&sensed), "sensing ended soon after the recording: {sensed}");
}

#[cfg(feature = "defmt")]
#[test]
fn what_a_port_logs_has_a_format() {
    use sdp3_core::{Progress, Settings, SlotAction, areas::Area, scheduler::PeriodCounts};
    fn formatted<T: defmt::Format>() {}
    formatted::<(Event, Progress, Settings)>();
    formatted::<(SlotAction<'_, 2>, PeriodCounts, Area)>();
    #[cfg(feature = "graph")]
    formatted::<(sdp3_core::graph::Node<'_>, sdp3_core::graph::Step<'_>)>();
}
