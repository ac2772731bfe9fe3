//! The program: start-up, the idle loop, changes of settings, and the figures at the end.

use super::injection::{Expected, HARMFUL, HARMLESS, KINDS};
use super::radio::Radio;
use super::reports::Reports;
use super::shared::{INTERRUPTS, QUIET, RETAINED, SHAPE, VALUES, maximum};
use core::sync::atomic::{AtomicU32, Ordering::Relaxed};
use heapless::{Vec, spsc::Queue};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;
use sdp3_core::digest::Digest;
use sdp3_core::dsn::Model;
use sdp3_core::early_exit::EarlyExit;
use sdp3_core::radar::{Event, ProcessingContext, Progress, RadarModule, Settings};
use sdp3_core::radar_memory;
use sdp3_core::scheduler::{SensingLayout, USERS};
use sdp3_firmware_sim::rt::{
    Owned, Single, foreground_instructions, instructions, paint_stack, stack_used, start_counter,
    start_ticks, wait,
};
use sdp3_firmware_sim::semihosting::{arguments, exit, println};
use sdp3_testkit::models::{DSN_200, DSN_1000};
use sdp3_testkit::signals::noise;

static MEMORY: Single<radar_memory!(SHAPE)> = Single::new(<radar_memory!(SHAPE)>::new());
static EXPECTED: Single<Queue<Expected, 32>> = Single::new(Queue::new());
/// Noise, of which a slot's samples are a part.
static NOISE: Single<[i16; 4 * VALUES]> = Single::new([0; 4 * VALUES]);
static RADIO: Owned<Radio> = Owned::new();

/// Slots to play.
static TOTAL: AtomicU32 = AtomicU32::new(0);

/// N and N_s of the layouts that are drawn; the last leaves too few sensing slots for any recording.
const LAYOUTS: [(u32, u32); 7] =
    [(4000, 1000), (4400, 1000), (4000, 1000), (4100, 1010), (1200, 250), (1000, 220), (900, 150)];
/// Kinds of processing steps.
const STEPS: [&str; 4] = ["step", "fault", "period", "classification"];

#[allow(unsafe_code)] // the symbol that the timer's interrupt calls
#[unsafe(no_mangle)]
extern "C" fn firmware_tick() {
    if INTERRUPTS.load(Relaxed) < TOTAL.load(Relaxed) {
        RADIO.with(Radio::slot);
    }
}

/// Changes rates, users, layout and threshold for a period to come.
fn change_settings(processing: &mut ProcessingContext<VALUES>, rng: &mut impl Rng) {
    let draw = rng.next_u32();
    if draw.is_multiple_of(2) {
        // the first user stays, so that no slot is idle
        let user = 1 + (draw >> 1) as usize % (USERS - 1);
        let rate =
            if processing.planner().rates().get(user) == Some(&0) { 1 + (draw >> 8) % 4000 } else { 0 };
        processing.set_rate(user, rate);
    }
    processing.set_rate((draw >> 4) as usize % 2, 1 + (draw >> 12) % 3000);
    if (draw >> 24).is_multiple_of(3) {
        let at = (draw >> 27) as usize % LAYOUTS.len();
        if let Some(&(period, slots)) = LAYOUTS.get(at)
            && let Ok(layout) = SensingLayout::new(period, 3, slots)
        {
            processing.set_layout(layout).expect("every layout here is in time");
        }
    } else if (draw >> 24) % 3 == 1 {
        // refused if they do not fit
        let _ = processing.set_sensing_slots([1000, 1000, 800, 220][(draw >> 27) as usize % 4]);
    }
    processing.set_threshold(if (draw >> 3).is_multiple_of(4) { 2.0 } else { 0.5 });
}

fn settings() -> Option<Settings> {
    let layout = SensingLayout::new(4000, 3, 1000).ok()?;
    Some(Settings { layout, rates: [1500, 2500, 3000, 0, 0, 0, 0, 0], threshold: 2.0 })
}

fn module(exits: u32) -> Option<RadarModule<VALUES>> {
    let first = EarlyExit::single(Model::parse(DSN_200).ok()?);
    let mut last = EarlyExit::single(Model::parse(DSN_1000).ok()?);
    let memory = MEMORY.take()?;
    let made = if exits == 1 {
        RadarModule::new(&[last], settings()?, memory, &RETAINED)
    } else {
        last.weights.rotate_right(1);
        last.weights[0] = first.weights[0];
        RadarModule::new(&[first, last], settings()?, memory, &RETAINED)
    };
    made.map_err(|error| println(format_args!("{error}"))).ok()
}

#[allow(unsafe_code)] // the symbol that start-up calls
#[unsafe(no_mangle)]
extern "C" fn firmware_main() -> ! {
    paint_stack();
    let mut text = [0; 1024];
    let mut words = arguments(&mut text).split_ascii_whitespace();
    let mut number = |name: &str| words.next().and_then(|word| word.strip_prefix(name)?.parse::<u32>().ok());
    let (Some(total), Some(slot), Some(seed)) = (number("slots="), number("slot="), number("seed=")) else {
        println(format_args!("arguments: slots=N slot=INSTRUCTIONS seed=S exits=1|2 faults=0|1"));
        exit(2)
    };
    let (exits, faults) = (number("exits=").unwrap_or(2), number("faults=").unwrap_or(1));
    let mut rng = Xoshiro128PlusPlus::seed_from_u64(seed.into());
    let (Some(pool), Some(queue), Some(module)) = (NOISE.take(), EXPECTED.take(), module(exits)) else {
        exit(2)
    };
    noise(&mut rng, pool);
    let (expected, mut entries) = queue.split();
    let (slots, mut processing) = module.split();
    start_counter();
    let before = instructions();
    let overhead = instructions() - before;
    TOTAL.store(total, Relaxed);
    RADIO.give(Radio {
        slots,
        rng: Xoshiro128PlusPlus::seed_from_u64(u64::from(seed) << 32),
        noise: pool,
        expected,
        total,
        number: 0_u32.wrapping_sub(total / 2), // numbers wrap in the middle
        transfer: false,
        saves: 0,
        sensed: 0,
        untouched: false,
        faults: faults != 0,
        injection: None,
        next: 100,
        injected: [0; KINDS],
        harmful: seed as usize,
        overhead,
        both: 0,
        late: 0,
        latest: 0,
        worst_begin: [0; KINDS + 1],
        worst_ready: 0,
        worst_both: 0,
        uses: Digest::new(),
    });
    let mut reports = Reports {
        open: Vec::new(),
        losses: 0,
        reported: 0,
        wrong: 0,
        missed: 0,
        lost: 0,
        periods: 0,
        replanned: 0,
        classified: [0; 2],
        stopped: 0,
        results: Digest::new(),
    };
    let before = foreground_instructions();
    let overhead = foreground_instructions() - before;
    let (mut worst, mut steps, mut sum) = ([0_u32; STEPS.len()], 0_u64, 0_u64);
    start_ticks(slot);
    loop {
        let over = INTERRUPTS.load(Relaxed) >= total;
        let before = foreground_instructions();
        let progress = processing.poll();
        let count = (foreground_instructions() - before).saturating_sub(overhead);
        let kind = match &progress {
            Progress::Idle if over => break,
            Progress::Idle => {
                wait();
                continue;
            }
            Progress::Busy => 0,
            Progress::Event(Event::Fault(_)) => 1,
            Progress::Event(Event::Period(_)) => 2,
            Progress::Event(Event::Classification { .. }) => 3,
        };
        maximum(&mut worst[kind], count);
        (steps, sum) = (steps + 1, sum + count);
        while let Some(entry) = entries.dequeue() {
            reports.missed += u32::from(reports.open.push(entry).is_err());
        }
        reports.age(QUIET);
        if let Progress::Event(event) = &progress {
            reports.check(event);
            if matches!(event, Event::Period(_)) && faults != 0 {
                change_settings(&mut processing, &mut rng);
            }
        }
    }
    reports.age(0);
    RADIO.with(|radio| report(radio, &reports, &worst, sum.checked_div(steps).unwrap_or(0)));
    exit(2) // the radio was not there
}

fn report(radio: &Radio, reports: &Reports, worst: &[u32; STEPS.len()], mean: u64) -> ! {
    let kinds = [
        ("slots", INTERRUPTS.load(Relaxed)),
        ("late", radio.late),
        ("latest-decision", radio.latest),
        ("lost", reports.lost),
        ("wrong-faults", reports.wrong),
        ("missed-faults", reports.missed),
        ("reported-faults", reports.reported),
        ("periods", reports.periods),
        ("replanned", reports.replanned),
        ("first-exit", reports.classified[0]),
        ("last-exit", reports.classified[1]),
        ("stopped-early", reports.stopped),
        ("begin", radio.worst_begin.iter().copied().max().unwrap_or(0)),
        ("begin-without-fault", radio.worst_begin[KINDS]),
        ("samples-ready", radio.worst_ready),
        ("slot-context", radio.worst_both),
        ("poll", worst.iter().copied().max().unwrap_or(0)),
        ("mean-poll", mean as u32),
        ("stack", stack_used() as u32),
    ];
    kinds.iter().for_each(|(name, value)| println(format_args!("{name} {value}")));
    STEPS.iter().zip(worst).for_each(|(name, count)| println(format_args!("poll-{name} {count}")));
    HARMLESS.iter().chain(&HARMFUL).for_each(|&kind| {
        let count = radio.injected.get(kind as usize).copied().unwrap_or(0);
        let worst = radio.worst_begin.get(kind as usize).copied().unwrap_or(0);
        println(format_args!("injected-{kind:?} {count}\nbegin-{kind:?} {worst}"));
    });
    println(format_args!("digest-uses {:016x}", radio.uses.hash()));
    println(format_args!("digest-classifications {:016x}", reports.results.hash()));
    let bad = radio.late + reports.lost + reports.wrong + reports.missed;
    exit(usize::from(bad > 0))
}
