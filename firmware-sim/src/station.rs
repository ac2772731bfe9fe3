//! A base station's firmware, the example of `docs/porting.md`: an interrupt every slot, the chain in the idle loop.
//!
//! The interrupt plays the scheduler and, in a sensing slot, moves the converter's samples into a double buffer; the idle
//! loop takes them out, dechirps and adds to the Gram matrix, and classifies when a recording is complete, in the
//! communication slots that follow. The converter is a file of slots, i16 I/Q.

use crate::dma::{DoubleBuffer, Reader, Writer};
use crate::log;
use crate::rt::{Owned, paint_stack, stack_used, start_ticks, wait};
use crate::semihosting::{File, arguments, exit, print, print_number};
use core::sync::atomic::{AtomicU32, Ordering};
use sdp3_core::dims::Iq;
use sdp3_core::dsn::Model;
use sdp3_core::pipeline::{Buffers, Receiver};
use sdp3_core::scheduler::{USERS, Scheduler, Sensing, SlotUse};

/// Instructions of a 250 us slot on a processor that does 240 million a second.
const SLOT_INSTRUCTIONS: u32 = 60_000;
/// Slots of a period: two seconds.
const PERIOD_SLOTS: u32 = 8000;
/// Bits that a slot carries to each receiver, as the link last said.
const SLOT_BITS: [u32; 3] = [1500, 2500, 3000];

static BUFFER: DoubleBuffer = DoubleBuffer::new();
static CONVERTER: Owned<Converter> = Owned::new();
/// Sensing slots lost because the idle loop was two behind.
static OVERRUNS: AtomicU32 = AtomicU32::new(0);
/// Periods begun.
static PERIODS: AtomicU32 = AtomicU32::new(0);

/// What the interrupt owns.
struct Converter {
    scheduler: Scheduler,
    samples: File,
    writer: Writer,
}

impl Converter {
    /// One slot begins.
    fn slot(&mut self) {
        if self.scheduler.position() == 0 {
            PERIODS.store(PERIODS.load(Ordering::Relaxed) + 1, Ordering::Relaxed);
        }
        if self.scheduler.next() != SlotUse::Sensing {
            return;
        }
        let samples = &mut self.samples;
        let moved = self.writer.fill(|slot| {
            for sample in slot {
                let mut bytes = [0; 4];
                samples.read(&mut bytes);
                *sample = Iq::from_le_bytes(bytes);
            }
        });
        if !moved {
            OVERRUNS.store(OVERRUNS.load(Ordering::Relaxed) + 1, Ordering::Relaxed);
        }
    }
}

/// What a program's `firmware_tick` calls.
pub fn slot_interrupt() {
    CONVERTER.with(Converter::slot);
}

/// Ends the run with a message and exit code 2.
fn fail(what: &str) -> ! {
    defmt::error!("{=str}", what);
    print("error: ");
    print(what);
    print("\n");
    exit(2)
}

/// Recognises one recording of a model, prints the class, and ends the run.
///
/// Arguments of the emulator: the file of slots, and optionally one for defmt records.
pub fn run(model: Model<'static>, buffers: Buffers<'static>) -> ! {
    paint_stack();
    let mut buffer = [0; 1024];
    let mut words = arguments(&mut buffer).split_ascii_whitespace();
    let Some(samples) = words.next().and_then(File::open) else { fail("no file of slots") };
    if words.next().is_some_and(|path| !log::open(path)) {
        fail("the file for records cannot be made");
    }
    // every fourth slot senses until the recording is complete; the rest go to three receivers, and of them at least a second,
    // 4000 slots, lies behind the recording: the time to classify it before the next begins
    let Ok(sensing) = Sensing::new(PERIOD_SLOTS, 3, model.sensing_slots() as u32) else {
        fail("no plan has so many sensing slots")
    };
    let mut rates = [0; USERS];
    rates.iter_mut().zip(SLOT_BITS).for_each(|(rate, bits)| *rate = bits);
    let scheduler = Scheduler::new(sensing, rates);
    let mut receiver = match Receiver::new(model, buffers) {
        Ok(receiver) => receiver,
        Err(error) => {
            defmt::error!("{}", error);
            fail("the model needs more memory than there is")
        }
    };
    let Some((writer, mut reader)) = BUFFER.split() else { fail("the buffer is taken") };
    defmt::info!("{}", scheduler.plan());
    CONVERTER.give(Converter { scheduler, samples, writer });
    start_ticks(SLOT_INSTRUCTIONS);
    idle(&mut receiver, &mut reader);
    let Ok(answer) = receiver.classify(&mut ()) else { fail("the recording is not complete") };
    defmt::info!("{}", answer);
    print("recognised ");
    print(receiver.model().class_name(usize::from(answer.class)));
    for (name, value) in [
        ("\nperiods ", PERIODS.load(Ordering::Relaxed) as usize),
        ("\noverruns ", OVERRUNS.load(Ordering::Relaxed) as usize),
        ("\nstack ", stack_used()),
    ] {
        print(name);
        print_number(value);
    }
    print("\ndone\n");
    exit(0)
}

/// The idle loop until a recording is complete: sleeps unless a slot lies in the buffer.
fn idle(receiver: &mut Receiver<'_, '_>, reader: &mut Reader) {
    loop {
        match reader.read(|slot| receiver.push(slot, &mut ())) {
            Some(Ok(0) | Err(_)) => return,
            Some(Ok(_)) => (),
            None => wait(),
        }
    }
}
