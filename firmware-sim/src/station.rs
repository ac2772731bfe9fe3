//! The board of the stations: a timer interrupt every slot, a converter that plays a file of slots, and a log.
//!
//! `porting.rs` is the program that runs on it. The emulator writes the samples of a whole slot into the buffer at once, which takes
//! one instruction: that stands for a DMA and its interrupt.

use crate::log;
use crate::rt::{self, Owned, paint_stack, stack_used, start_ticks};
use crate::semihosting::{File, arguments, exit, println};
use core::fmt::Display;
use core::sync::atomic::{AtomicU32, Ordering::Relaxed};
use rand_core::SeedableRng;
use sdp3_core::config::RadarConfig;
use sdp3_core::radar::{Event, ProcessingContext, SlotContext};
use sdp3_core::scheduler::USERS;
use sdp3_core::{Error, Progress, RadarModule, SensingLayout, Settings, SlotAction, selftest};

const VALUES: usize = RadarConfig::PAPER.values_per_slot();

/// The slot interrupt's context.
pub type Slots = SlotContext<VALUES>;
/// The task's context.
pub type Processing = ProcessingContext<VALUES>;

/// Both.
pub type Module = RadarModule<VALUES>;

/// Bits that a slot carries to each user.
pub const BITS: [u32; USERS] = [1500, 2500, 3000, 0, 0, 0, 0, 0];

static SLOTS: Owned<Slots> = Owned::new();
static SAMPLES: Owned<File> = Owned::new();
/// Transfers of samples that have ended.
static TRANSFERS: AtomicU32 = AtomicU32::new(0);
/// Periods begun and faults reported.
static PERIODS: AtomicU32 = AtomicU32::new(0);
static FAULTS: AtomicU32 = AtomicU32::new(0);

fn count(counter: &AtomicU32) {
    counter.store(counter.load(Relaxed).wrapping_add(1), Relaxed); // one writer each: no atomic addition is needed
}

/// The interrupt of the slot timer, and of the transfer that it starts.
pub fn slot_interrupt(slot: impl FnOnce(&mut Slots, u32)) {
    SLOTS.with(|slots| {
        let before = TRANSFERS.load(Relaxed);
        slot(slots, rt::slots());
        if TRANSFERS.load(Relaxed) != before {
            slots.samples_ready();
        }
    });
}

/// The samples of the next slot of the file; behind its last one the first follows.
pub fn start_transfer(buffer: &mut [i16]) {
    SAMPLES.with(|samples| {
        if samples.read_values(buffer) || samples.seek(0) && samples.read_values(buffer) {
            count(&TRANSFERS);
        }
    });
}

/// The radio, which is not emulated.
pub fn transmit(_user: u8) {}

/// Sleeps until the next interrupt.
pub fn sleep() {
    rt::wait();
}

/// Ends the run with a message and exit code 2.
pub fn fail(what: impl Display) -> ! {
    println(format_args!("error: {what}"));
    exit(2)
}

/// Opens what the emulator's arguments name, the file of slots and optionally one for defmt records.
#[inline(never)] // its buffer is gone when the station runs
pub fn power_on() {
    paint_stack();
    let mut buffer = [0; 1024];
    let mut words = arguments(&mut buffer).split_ascii_whitespace();
    let Some(samples) = words.next().and_then(File::open) else { fail("no file of slots") };
    if words.next().is_some_and(|path| !log::open(path)) {
        fail("the file for records cannot be made");
    }
    SAMPLES.give(samples);
}

/// Tests signal chain and networks.
#[inline(never)] // `start` moves the slot context
fn test(processing: &mut Processing) {
    let mut rng = rand_xoshiro::Xoshiro128PlusPlus::seed_from_u64(3);
    if processing.test_signal_chain(&mut rng) != selftest::KNOWN_ANSWERS {
        fail("the self test of the signal chain failed");
    }
    if !processing.self_test(&mut rng) {
        fail("the self test of a network failed");
    }
}

/// Tests the module, then starts the slot timer.
pub fn start(slots: Slots, processing: &mut Processing) {
    test(processing);
    SLOTS.give(slots);
    start_ticks(rt::SLOT);
}

/// What `porting.rs` does in a slot.
pub fn slot(slots: &mut Slots, number: u32) {
    match slots.begin(number) {
        SlotAction::Sense(buffer) => start_transfer(&mut buffer.0),
        SlotAction::Serve(user) => transmit(user),
        SlotAction::Idle => {}
    }
}

/// What `porting.rs` does with a module, for stations that make it otherwise.
pub fn serve(module: Result<Module, Error>) -> ! {
    let (slots, mut task) = match module {
        Ok(module) => module.split(),
        Err(error) => fail(error),
    };
    start(slots, &mut task);
    loop {
        match task.poll() {
            Progress::Event(event) => report(&task, event),
            Progress::Busy => {}
            Progress::Idle => sleep(),
        }
    }
}

/// Settings of the paper's period; all exits are asked.
pub fn settings() -> Result<Settings, Error> {
    Ok(Settings { layout: SensingLayout::new(4000, 3, 1000)?, rates: BITS, threshold: 2.0 })
}

/// Logs an event; prints the first classification that needs no more slots, and ends the run.
pub fn report(processing: &Processing, event: Event) {
    defmt::info!("{}", event);
    match event {
        Event::Period(_) => count(&PERIODS),
        Event::Fault(_) => count(&FAULTS),
        Event::Classification { classification, .. } if classification.stop => {
            println(format_args!("recognised {}", processing.class_name(classification.class)));
            let [periods, faults] = [&PERIODS, &FAULTS].map(|counter| counter.load(Relaxed));
            println(format_args!("exit {}", classification.exit));
            println(format_args!("periods {periods}\nfaults {faults}\nstack {}\ndone", stack_used()));
            exit(0)
        }
        Event::Classification { .. } => {}
    }
}
