//! What the boards' stations do besides what `docs/porting.md` shows: the self tests, the recording in place of a sensor, the counts.

use crate::{linked::stack_used, recording::Recording, run::Run};
use core::fmt::Arguments;
use core::sync::atomic::{AtomicBool, Ordering::Relaxed};
use rand_core::SeedableRng;
use rand_xoshiro::Xoshiro128PlusPlus;
use sdp3_core::radar::{Event, ProcessingContext};
use sdp3_core::scheduler::USERS;
use sdp3_core::selftest;

/// Bits that a slot carries to each user.
pub const BITS: [u32; USERS] = [1500, 2500, 3000, 0, 0, 0, 0, 0];
/// Slots of the recording; `tests/boards` makes it.
pub const RECORDED: usize = 200;
/// Slots after which the counts are printed.
const REPORTED: u32 = 10_000;

/// A station on recorded slots.
pub struct Station {
    recording: Recording,
    /// What it has seen so far.
    pub run: Run,
    printed: AtomicBool,
}

impl Station {
    /// A station that plays [`RECORDED`] slots of this data.
    pub const fn new(data: fn() -> &'static [u8]) -> Self {
        Station {
            recording: Recording::new(data, RECORDED),
            run: Run::new(),
            printed: AtomicBool::new(false),
        }
    }

    /// Tests the signal chain; says so if it fails.
    pub fn test_signal_chain(&self, say: impl FnOnce(Arguments<'_>)) -> bool {
        let good = selftest::run(&mut generator()) == selftest::KNOWN_ANSWERS;
        if !good {
            say(format_args!("error: the self test of the signal chain failed"));
        }
        good
    }

    /// Tests the networks; says so if one fails.
    pub fn test_networks<const VALUES: usize>(
        &self,
        task: &mut ProcessingContext<VALUES>,
        say: impl FnOnce(Arguments<'_>),
    ) -> bool {
        let good = task.self_test(&mut generator());
        if !good {
            say(format_args!("error: the self test of a network failed"));
        }
        good
    }

    /// Copies the samples of a slot: there is no sensor.
    pub fn start_transfer(&self, buffer: &mut [i16]) {
        self.recording.play(buffer);
        self.run.transfer();
    }

    /// Logs and counts an event, and prints a recognition.
    pub fn report<const VALUES: usize>(
        &self,
        task: &ProcessingContext<VALUES>,
        event: &Event,
        say: impl FnOnce(Arguments<'_>),
    ) {
        self.run.event(event);
        if let Event::Classification { period, classification, .. } = event {
            say(format_args!("period {period}: {}", task.class_name(classification.class)));
        }
    }

    /// Prints the counts once they are of enough slots.
    pub fn counts(&self, mut say: impl FnMut(Arguments<'_>)) {
        let [slots, late, faults, recognitions] = self.run.counts();
        if slots >= REPORTED && !self.printed.load(Relaxed) {
            self.printed.store(true, Relaxed);
            say(format_args!("slots {slots}, late {late}, faults {faults}, recognitions {recognitions}"));
            say(format_args!("stack {}", stack_used()));
            say(format_args!("done"));
        }
    }
}

/// The generator that the known answers belong to.
fn generator() -> Xoshiro128PlusPlus {
    Xoshiro128PlusPlus::seed_from_u64(3)
}
