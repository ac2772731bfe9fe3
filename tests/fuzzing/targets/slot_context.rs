//! Whatever numbers a radio gives and whatever happens to the memory, a radar module answers, reports once, and recovers.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sdp3_core::config::RadarConfig;
use sdp3_core::dsn::Shape;
use sdp3_core::radar::{Event, ProcessingContext, Progress, RadarModule, Settings, SlotAction, SlotContext};
use sdp3_core::radar_memory;
use sdp3_core::scheduler::{Plan, SensingLayout, USERS};
use sdp3_core::supervision::Fault;
use sdp3_core::supervision::retained::Retained;
use sdp3_fuzz::{Bytes, Sizes, model};
use std::sync::LazyLock;

/// 14 sensing slots, 4 frames.
static MODEL: LazyLock<Vec<u8>> = LazyLock::new(|| {
    model(Sizes { channels: 4, blocks: 1, classes: 2, stride: 1, frames: 4 }, &mut Bytes(&[7; 200]))
});
const SHAPE: Shape =
    Shape { sensing_slots: 14, frames: 4, channels: 4, stem_stride: 1, arena: 0, radar: RadarConfig::PAPER };
const VALUES: usize = SHAPE.slot_values();
type Memory = radar_memory!(SHAPE);

fn layout(bytes: &mut Bytes<'_>) -> SensingLayout {
    let (period, spacing) = (1 + u32::from(bytes.u8()), u32::from(bytes.u8()) % 6);
    let slots = u32::from(bytes.u8()) % (period / (spacing + 1) + 1);
    SensingLayout::new(period, spacing, slots).expect("it fits")
}

/// The contexts, and the memory that every reset has taken.
struct Radio {
    contexts: Option<(SlotContext<VALUES>, ProcessingContext<VALUES>)>,
    retained: *mut Retained,
    memory: Vec<*mut Memory>,
    number: u32,
}

impl Drop for Radio {
    fn drop(&mut self) {
        self.contexts = None;
        // SAFETY: only the contexts, which are gone, had references to what `Radio` boxed.
        unsafe {
            drop(Box::from_raw(self.retained));
            self.memory.iter().for_each(|&memory| drop(Box::from_raw(memory)));
        }
    }
}

impl Radio {
    fn reset(&mut self) {
        self.contexts = None;
        let memory = Box::into_raw(Box::new(Memory::new()));
        self.memory.push(memory);
        let layout = SensingLayout::new(400, 3, 50).expect("it fits");
        let settings = Settings { layout, rates: [1; USERS], threshold: 2.0 };
        // SAFETY: both live until `drop`, and nobody else has this memory.
        let (memory, retained) = unsafe { (&mut *memory, &*self.retained) };
        self.contexts =
            Some(RadarModule::single(&MODEL, settings, memory, retained).expect("a module").split());
    }

    fn slots(&mut self) -> &mut SlotContext<VALUES> {
        &mut self.contexts.as_mut().expect("contexts").0
    }

    fn processing(&mut self) -> &mut ProcessingContext<VALUES> {
        &mut self.contexts.as_mut().expect("contexts").1
    }

    /// Polls until there is nothing to do; whether a fault was reported.
    fn poll(&mut self) -> bool {
        let mut faults = false;
        for _ in 0..100_000 {
            match self.processing().poll() {
                Progress::Idle => return faults,
                // those that were lost are counted with the next report, whenever that is
                Progress::Event(Event::Fault(Fault::ReportsLost(_))) => (),
                Progress::Event(Event::Fault(_)) => faults = true,
                _ => (),
            }
        }
        panic!("polls do not end")
    }

    /// The next slot: its user, [`USERS`] for sensing. Samples come, or are lost, or neither, by `transfer`.
    fn slot(&mut self, transfer: u8) -> Option<usize> {
        let number = self.number;
        self.number = number.wrapping_add(1);
        let given = match self.slots().begin(number) {
            SlotAction::Serve(user) => Some(user.into()),
            SlotAction::Idle => None,
            SlotAction::Sense(buffer) => {
                let scale = i16::from(transfer);
                buffer.0.iter_mut().zip(0_i16..).for_each(|(x, n)| *x = n.wrapping_mul(scale << 4));
                Some(USERS)
            }
        };
        match (given, transfer % 4) {
            (Some(USERS), 0) => self.slots().lost(),
            (Some(USERS), 1 | 2) => self.slots().samples_ready(),
            _ => (),
        }
        given
    }
}

fuzz_target!(|data: &[u8]| {
    let mut bytes = Bytes(data);
    let (retained, number) = (Box::into_raw(Box::new(Retained::new())), bytes.u32());
    let mut radio = Radio { contexts: None, retained, memory: Vec::new(), number };
    radio.reset();
    let _ = radio.processing().set_layout(layout(&mut bytes));
    while !bytes.is_empty() {
        match bytes.u8() {
            0..16 => {
                let (user, rate) = (usize::from(bytes.u8()) % (USERS + 1), bytes.u32());
                radio.processing().set_rate(user, rate);
            }
            16..32 => _ = radio.processing().set_layout(layout(&mut bytes)),
            32..44 => radio.slots().lost(),
            44..48 => radio.slots().samples_ready(),
            48..56 => _ = radio.processing().poll(),
            56..72 => radio.number = radio.number.wrapping_add(u32::from(bytes.u8())),
            72..80 => radio.number = bytes.u32(),
            80..88 if radio.memory.len() < 4 => radio.reset(),
            80..104 => {
                let (at, mask) = (usize::from(bytes.u8()), bytes.u32());
                // SAFETY: it lives until `drop`.
                let retained = unsafe { &*radio.retained };
                if let Some(word) = retained.words().get(at % Retained::LEN) {
                    word.fetch_xor(mask, std::sync::atomic::Ordering::Relaxed);
                }
            }
            count => {
                let transfer = bytes.u8();
                for _ in 0..count - 100 {
                    radio.slot(transfer);
                    if transfer < 128 {
                        radio.poll();
                    }
                }
                // after three slots in order nothing is reported any more
                for _ in 0..3 {
                    radio.poll();
                    radio.slot(0);
                }
                radio.poll();
                radio.slot(0);
                assert!(!radio.poll());
            }
        }
    }
    // a few periods later nothing is left of it
    let (mut layout, rates) = (layout(&mut bytes), [3, 2, 1, 0, 0, 0, 0, 0]);
    if radio.processing().set_layout(layout).is_err() {
        layout = SensingLayout::new(400, 3, 50).expect("it fits");
        radio.processing().set_layout(layout).expect("a reset's layout is in time");
    }
    rates.into_iter().enumerate().for_each(|(user, rate)| radio.processing().set_rate(user, rate));
    let mut whole = Vec::new();
    for _ in 0..12 {
        whole.clear();
        while whole.is_empty() || radio.slots().position() > 0 {
            radio.poll();
            whole.push(radio.slot(0));
            assert!(whole.len() < 1000, "no end of the period");
        }
    }
    let plan = Plan::optimal(layout, &rates, &[0; USERS]);
    assert_eq!(whole.len(), plan.period() as usize);
    (1..).zip(&whole).for_each(|(j, &given)| assert_eq!(given == Some(USERS), plan.senses(j)));
    let count = |user| whole.iter().filter(|&&given| given == Some(user)).count() as u32;
    assert_eq!(std::array::from_fn::<_, USERS, _>(count), plan.shares());
});
