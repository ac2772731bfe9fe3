//! The radar module under a clock: a timer interrupt every slot, the slot context in it, processing in the idle loop.
//!
//! Arguments: `slots=N slot=INSTRUCTIONS seed=S [exits=1|2] [faults=0|1]`. One exit is the model for N_s = 1000, two begin with the
//! one for N_s = 200. Rates, users, layout and threshold change by seeded draws, and faults are injected at seeded slots; the program
//! keeps a book of them, in which every reported fault must find its injection. The interrupt copies a sensing slot's samples into
//! its buffer, which stands for a DMA: its instructions are not the slot context's. The transfer ends just before the next slot
//! begins, as late as it may.
//!
//! Prints `name value` lines. Exit code 0 if nothing was late, lost, missed or reported wrongly, 1 if something was, 2 for misuse.
//! When a recognition is done depends on the clock, and with it an early exit's end of sensing: so does the digest with two exits.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this is firmware: build it with firmware-sim/build");
}

#[cfg(target_os = "none")]
mod firmware {
    use core::sync::atomic::{AtomicU32, Ordering::Relaxed};
    use heapless::{Vec, spsc::Producer, spsc::Queue};
    use rand_core::{Rng, SeedableRng};
    use rand_xoshiro::Xoshiro128PlusPlus;
    use sdp3_core::digest::Digest;
    use sdp3_core::dsn::{Model, Shape};
    use sdp3_core::early_exit::EarlyExit;
    use sdp3_core::radar::{
        Event, ProcessingContext, Progress, RadarModule, Settings, SlotAction, SlotContext,
    };
    use sdp3_core::radar_memory;
    use sdp3_core::scheduler::{SensingLayout, USERS};
    use sdp3_core::supervision::retained::Retained;
    use sdp3_core::supervision::{Fault, SampleFault};
    use sdp3_firmware_sim::rt::{
        Owned, Single, foreground_instructions, instructions, lateness, paint_stack, pending, stack_used,
        start_counter, start_ticks, wait,
    };
    use sdp3_firmware_sim::semihosting::{arguments, exit, println};
    use sdp3_testkit::flip;
    use sdp3_testkit::models::{DSN_200, DSN_1000};
    use sdp3_testkit::signals::noise;

    // the larger of the two in everything
    const SHAPE: Shape = Shape::of(DSN_1000).expect("a model");
    const VALUES: usize = SHAPE.slot_values();
    /// Sensing slots of the first of two exits.
    const FIRST_EXIT: u32 = 200;

    static MEMORY: Single<radar_memory!(SHAPE)> = Single::new(<radar_memory!(SHAPE)>::new());
    #[allow(unsafe_code)] // a section that start-up leaves alone; the emulator's memory is zero at first
    #[unsafe(link_section = ".uninit.retained")]
    static RETAINED: Retained = Retained::new();
    static EXPECTED: Single<Queue<Expected, 32>> = Single::new(Queue::new());
    /// Noise, of which a slot's samples are a part.
    static NOISE: Single<[i16; 4 * VALUES]> = Single::new([0; 4 * VALUES]);
    static RADIO: Owned<Radio> = Owned::new();
    /// Interrupts so far.
    static PLAYED: AtomicU32 = AtomicU32::new(0);

    /// Slots to play.
    static TOTAL: AtomicU32 = AtomicU32::new(0);

    /// Slots within which a report comes, and without a fault at the end.
    const QUIET: u32 = 300;
    /// Instructions after which an interrupt is late: the one before had not returned.
    const LATE: u64 = 1000;
    /// Bytes of a use in the digest, beside the number of a user.
    const SENSES: u8 = 254;
    const IDLE: u8 = 255;
    /// N and N_s of the layouts that take turns; the last leaves too few sensing slots for any recording.
    const LAYOUTS: [(u32, u32); 7] =
        [(4000, 1000), (4400, 1000), (4000, 1000), (4100, 1010), (1200, 250), (1000, 220), (900, 150)];
    /// Kinds of processing steps.
    const STEPS: [&str; 4] = ["step", "fault", "period", "classification"];

    /// An injected fault.
    #[derive(Clone, Copy, PartialEq, Debug)]
    enum Injection {
        Repeated,
        Late,
        Unexpected,
        FlipOlder,
        FlipNewer,
        Skipped,
        Outage,
        Missing,
        /// Missing, and they come later.
        Delayed,
        Lost,
        Silent,
        Stuck,
        Saturated,
        Offset,
        FlipBoth,
        CounterReset,
    }

    use Injection::*;

    const KINDS: usize = HARMLESS.len() + HARMFUL.len();
    /// After these a recording goes on.
    const HARMLESS: [Injection; 5] = [Repeated, Late, Unexpected, FlipOlder, FlipNewer];
    /// After these it begins again.
    const HARMFUL: [Injection; 11] =
        [Skipped, Missing, Silent, Lost, FlipBoth, Stuck, Outage, Saturated, Delayed, Offset, CounterReset];

    impl Injection {
        fn is_of_samples(self) -> bool {
            matches!(self, Silent | Stuck | Saturated | Offset)
        }
    }

    /// A report that is to come.
    #[derive(Clone, Copy)]
    struct Expected {
        report: Report,
        /// Interrupts before it was injected.
        since: u32,
    }

    #[derive(Clone, Copy, PartialEq, Debug)]
    enum Report {
        Gap(u32),
        Repeated,
        Late,
        CounterReset,
        Repaired,
        StateLost,
        Missing,
        Unexpected,
        Silent,
        Stuck(u16),
        Saturated,
        Offset,
        /// By the period's counts.
        Lost,
    }

    impl Report {
        fn fits(self, fault: &Fault) -> bool {
            match *fault {
                Fault::SlotsSkipped { slots, .. } => self == Report::Gap(slots) && slots <= 8,
                Fault::Outage { slots } => self == Report::Gap(slots),
                Fault::SlotRepeated => self == Report::Repeated,
                Fault::SlotLate => self == Report::Late,
                Fault::CounterReset => self == Report::CounterReset,
                Fault::StateRepaired => self == Report::Repaired,
                Fault::StateLost => self == Report::StateLost,
                Fault::MissingSamples => self == Report::Missing,
                Fault::UnexpectedSamples => self == Report::Unexpected,
                Fault::Samples(SampleFault::Silent) => self == Report::Silent,
                Fault::Samples(SampleFault::Stuck { i, q }) => i == 0 && self == Report::Stuck(q),
                Fault::Samples(SampleFault::Saturated { .. }) => self == Report::Saturated,
                Fault::Samples(SampleFault::Offset { .. }) => self == Report::Offset,
                _ => false,
            }
        }
    }

    /// Largest count so far.
    fn most(worst: &mut u32, count: u64) {
        *worst = (*worst).max(count as u32);
    }

    /// The radio's side: numbers, samples, faults.
    struct Radio {
        slots: SlotContext<VALUES>,
        rng: Xoshiro128PlusPlus,
        noise: &'static [i16],
        expected: Producer<'static, Expected>,
        /// Slots to play.
        total: u32,
        /// Number of the next slot.
        number: u32,
        /// Whether a transfer is under way.
        transfer: bool,
        /// Times that the state was saved: the parity says which copy is newer.
        saves: usize,
        /// Sensing slots of the running period, and whether none of them was touched.
        sensed: u32,
        untouched: bool,
        faults: bool,
        /// What is injected next, as soon as it is possible.
        injection: Option<Injection>,
        /// The interrupt from which it may be.
        next: u32,
        injected: [u32; KINDS],
        harmful: usize,
        /// Instructions of measuring nothing.
        overhead: u64,
        /// Instructions of all calls in this interrupt.
        both: u64,
        late: u32,
        latest: u32,
        /// Of slots without a fault, and with each.
        worst_begin: [u32; KINDS + 1],
        worst_ready: u32,
        worst_both: u32,
        uses: Digest,
    }

    impl Radio {
        fn expect(&mut self, report: Report) {
            let since = PLAYED.load(Relaxed);
            let _ = self.expected.enqueue(Expected { report, since }); // a report without its entry is found as wrong
        }

        /// What is injected into this slot, if that is possible now.
        fn draw(&mut self, sensed: bool) -> Option<Injection> {
            let now = PLAYED.load(Relaxed);
            if !self.faults || now < self.next || now + QUIET > self.total {
                return None;
            }
            let draw = self.rng.next_u32() as usize;
            let harmful = &mut self.harmful;
            let kind = *self.injection.get_or_insert_with(|| {
                let kinds = if draw.is_multiple_of(32) { &HARMFUL[..] } else { &HARMLESS[..] };
                let which = if draw.is_multiple_of(32) {
                    core::mem::replace(harmful, *harmful + 1)
                } else {
                    draw / 32
                };
                kinds.get(which % kinds.len()).copied().unwrap_or(Repeated)
            });
            let possible = match kind {
                Unexpected => !sensed,
                Missing | Delayed => sensed,
                // the report of the period before has been taken
                Lost => self.slots.position() > 16,
                // surely of a recording that is used
                kind if kind.is_of_samples() => self.untouched && (8..FIRST_EXIT - 50).contains(&self.sensed),
                _ => true,
            };
            possible.then_some(kind)
        }

        /// It has been injected.
        fn injected(&mut self, kind: Injection) {
            if let Some(count) = self.injected.get_mut(kind as usize) {
                *count += 1;
            }
            self.injection = None;
            self.untouched &= HARMLESS.contains(&kind);
            self.next = PLAYED.load(Relaxed) + 30 + self.rng.next_u32() % 200;
        }

        fn samples_ready(&mut self) {
            let before = instructions();
            self.slots.samples_ready();
            let count = (instructions() - before).saturating_sub(self.overhead);
            self.both += count;
            most(&mut self.worst_ready, count);
        }

        /// The number that the radio gives this slot, with what goes wrong before it.
        fn number(&mut self, injection: Option<Injection>) -> u32 {
            let draw = self.rng.next_u32();
            let next = self.number;
            let given = match injection {
                Some(Repeated) => next.wrapping_sub(1),
                Some(Late) => next.wrapping_sub(2 + draw % 1000),
                Some(Skipped) => next.wrapping_add(1 + draw % 8),
                Some(Outage) => next.wrapping_add(9 + draw % 5000),
                Some(CounterReset) => next.wrapping_sub(1000 + draw % (1 << 30)),
                _ => next,
            };
            if !matches!(injection, Some(Repeated | Late)) {
                self.number = given.wrapping_add(1);
            }
            let half = Retained::LEN / 2;
            let newer = self.saves % 2 * half;
            let (word, mask) = (draw as usize % half, 1 << (draw >> 27));
            match injection {
                Some(FlipOlder) => flip(&RETAINED, half - newer + word, mask),
                Some(FlipNewer) => flip(&RETAINED, newer + word, mask),
                Some(FlipBoth) => [word, half + word].into_iter().for_each(|at| flip(&RETAINED, at, mask)),
                _ => (),
            }
            self.saves += usize::from(injection != Some(Repeated));
            match injection {
                Some(Repeated) => self.expect(Report::Repeated),
                Some(Late) => self.expect(Report::Late),
                Some(Skipped | Outage) => self.expect(Report::Gap(given.wrapping_sub(next))),
                Some(CounterReset) => {
                    self.expect(Report::Late);
                    self.expect(Report::CounterReset);
                }
                Some(FlipNewer) => self.expect(Report::Repaired),
                Some(FlipBoth) => self.expect(Report::StateLost),
                Some(Missing) => self.expect(Report::Missing),
                Some(Delayed) => {
                    self.expect(Report::Missing);
                    self.expect(Report::Unexpected);
                }
                Some(Unexpected) => self.expect(Report::Unexpected),
                _ => (),
            }
            given
        }

        /// The interrupt of a slot.
        fn slot(&mut self) {
            let entered = lateness();
            self.both = 0;
            let sensed = core::mem::take(&mut self.transfer);
            let mut injection = self.draw(sensed);
            let lost = matches!(injection, Some(Missing | Delayed));
            if sensed && !lost || injection == Some(Unexpected) {
                self.samples_ready();
            }
            let number = self.number(injection);
            let before = instructions();
            let action = self.slots.begin(number);
            let count = (instructions() - before).saturating_sub(self.overhead);
            most(&mut self.latest, lateness());
            let mut report = None;
            let slot_use = match action {
                SlotAction::Sense(buffer) => {
                    let at = self.rng.next_u32() as usize % (2 * VALUES) & !1;
                    let samples = self.noise.get(at..at + VALUES).unwrap_or_default();
                    buffer.0.iter_mut().zip(samples).for_each(|(to, from)| *to = *from);
                    report = injection.and_then(|kind| corrupt(&mut buffer.0, kind));
                    self.transfer = true;
                    SENSES
                }
                SlotAction::Serve(user) => user,
                SlotAction::Idle => IDLE,
            };
            self.both += count;
            let kind = injection.map_or(KINDS, |kind| kind as usize);
            self.worst_begin.get_mut(kind).into_iter().for_each(|worst| most(worst, count));
            self.uses.value([slot_use]);
            if injection == Some(Delayed) {
                self.samples_ready();
            }
            if self.slots.position() == 1 {
                (self.sensed, self.untouched) = (0, true);
            }
            self.sensed += u32::from(slot_use == SENSES);
            match injection {
                Some(kind) if kind.is_of_samples() => match report {
                    Some(report) => self.expect(report),
                    None => injection = None, // the slot does not sense: another one
                },
                Some(Lost) if slot_use == IDLE => injection = None,
                Some(Lost) => {
                    self.expect(Report::Lost);
                    let before = instructions();
                    self.slots.lost();
                    self.both += (instructions() - before).saturating_sub(self.overhead);
                    self.saves += 1;
                    self.transfer = false;
                }
                _ => (),
            }
            if let Some(kind) = injection {
                self.injected(kind);
            }
            most(&mut self.worst_both, self.both);
            PLAYED.store(PLAYED.load(Relaxed) + 1, Relaxed);
            self.late += u32::from(entered > LATE || pending());
        }
    }

    /// Makes samples that cannot be trusted, and says how they are to be reported.
    fn corrupt(samples: &mut [i16], kind: Injection) -> Option<Report> {
        let quadrature = samples.iter_mut().skip(1).step_by(2);
        Some(match kind {
            Silent => {
                samples.fill(-7);
                Report::Silent
            }
            Stuck => {
                quadrature.for_each(|x| *x |= 1 << 5);
                Report::Stuck(1 << 5)
            }
            Saturated => {
                samples.iter_mut().for_each(|x| *x = x.saturating_mul(32));
                Report::Saturated
            }
            Offset => {
                quadrature.for_each(|x| *x -= 3000);
                Report::Offset
            }
            _ => return None,
        })
    }

    #[allow(unsafe_code)] // the symbol that the timer's interrupt calls
    #[unsafe(no_mangle)]
    extern "C" fn firmware_tick() {
        if PLAYED.load(Relaxed) < TOTAL.load(Relaxed) {
            RADIO.with(Radio::slot);
        }
    }

    /// What was injected and is not yet reported, and what was reported.
    struct Book {
        open: Vec<Expected, 32>,
        /// Lost slots that the end of the period must report.
        losses: u32,
        reported: u32,
        wrong: u32,
        missed: u32,
        /// Sensing slots lost that nobody injected.
        lost: u32,
        periods: u32,
        replanned: u32,
        classified: [u32; 2],
        stopped: u32,
        results: Digest,
    }

    impl Book {
        /// Takes the entry that a report fits.
        fn take(&mut self, fits: impl Fn(Report) -> bool) -> bool {
            let at = self.open.iter().position(|entry| fits(entry.report));
            at.map(|at| self.open.remove(at)).is_some()
        }

        fn enter(&mut self, event: &Event) {
            match event {
                Event::Fault(fault) => {
                    if self.take(|report| report.fits(fault)) {
                        self.reported += 1;
                    } else {
                        self.wrong += 1;
                        self.lost += u32::from(matches!(fault, Fault::Overrun | Fault::MissingSamples));
                        let now = PLAYED.load(Relaxed);
                        println(format_args!("not injected: {fault:?} in slot {now}"));
                    }
                    match fault {
                        Fault::SlotsSkipped { slots, .. } => self.losses += slots,
                        Fault::MissingSamples | Fault::Overrun => self.losses += 1,
                        Fault::StateLost => {
                            self.losses = 0;
                            while self.take(|report| report == Report::Lost) {}
                        }
                        _ => (),
                    }
                }
                Event::Period(report) => {
                    self.periods += 1;
                    self.replanned += u32::from(report.replanned);
                    let mut losses = core::mem::take(&mut self.losses);
                    while self.take(|report| report == Report::Lost) {
                        losses += 1;
                        self.reported += 1;
                    }
                    let found = report.changes.lost + report.changes.sensing_lost;
                    if found != losses {
                        self.wrong += 1;
                        let now = PLAYED.load(Relaxed);
                        println(format_args!("{losses} slots lost, {found} reported, in slot {now}"));
                    }
                }
                Event::Classification { period, classification } => {
                    let exit = usize::from(classification.exit);
                    if let Some(count) = self.classified.get_mut(exit) {
                        *count += 1;
                    }
                    self.stopped += u32::from(classification.stop && exit == 0);
                    self.results.value(period.to_le_bytes());
                    self.results.value([classification.class, classification.exit]);
                    classification.logits.iter().for_each(|logit| self.results.value(logit.to_le_bytes()));
                }
            }
        }

        /// Entries that have waited too long are of faults that were not reported.
        fn age(&mut self, waited: u32) {
            let now = PLAYED.load(Relaxed);
            // a loss is reported at the end of the period
            let old = |entry: &Expected| entry.report != Report::Lost && now - entry.since >= waited;
            while let Some(at) = self.open.iter().position(old) {
                let entry = self.open.remove(at);
                self.missed += 1;
                println(format_args!("not reported: {:?} of slot {}", entry.report, entry.since));
            }
        }
    }

    /// Changes rates, users, layout and threshold for a period to come.
    fn churn(processing: &mut ProcessingContext<VALUES>, rng: &mut impl Rng) {
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
                processing.set_layout(layout);
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
        let mut number =
            |name: &str| words.next().and_then(|word| word.strip_prefix(name)?.parse::<u32>().ok());
        let (Some(total), Some(slot), Some(seed)) = (number("slots="), number("slot="), number("seed="))
        else {
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
        let mut book = Book {
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
            let over = PLAYED.load(Relaxed) >= total;
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
            most(&mut worst[kind], count);
            (steps, sum) = (steps + 1, sum + count);
            while let Some(entry) = entries.dequeue() {
                book.missed += u32::from(book.open.push(entry).is_err());
            }
            book.age(QUIET);
            if let Progress::Event(event) = &progress {
                book.enter(event);
                if matches!(event, Event::Period(_)) && faults != 0 {
                    churn(&mut processing, &mut rng);
                }
            }
        }
        book.age(0);
        RADIO.with(|radio| report(radio, &book, &worst, sum.checked_div(steps).unwrap_or(0)));
        exit(2) // the radio was not there
    }

    fn report(radio: &Radio, book: &Book, worst: &[u32; STEPS.len()], mean: u64) -> ! {
        let kinds = [
            ("slots", PLAYED.load(Relaxed)),
            ("late", radio.late),
            ("latest-decision", radio.latest),
            ("lost", book.lost),
            ("wrong-faults", book.wrong),
            ("missed-faults", book.missed),
            ("reported-faults", book.reported),
            ("periods", book.periods),
            ("replanned", book.replanned),
            ("first-exit", book.classified[0]),
            ("last-exit", book.classified[1]),
            ("stopped-early", book.stopped),
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
        println(format_args!("digest-classifications {:016x}", book.results.hash()));
        let bad = radio.late + book.lost + book.wrong + book.missed;
        exit(usize::from(bad > 0))
    }
}
