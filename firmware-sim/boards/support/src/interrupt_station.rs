//! The station without an executor: the slot interrupt has the slot context, `main` the processing. What a board of `porting.rs` adds.

use crate::line::{Serial, print};
use crate::station::Station;
use core::cell::RefCell;
use core::fmt::Arguments;
use critical_section::Mutex;
use sdp3_core::radar::{Event, ProcessingContext, SlotContext};

/// A timer that interrupts every slot.
pub trait SlotTimer {
    /// Interrupts every slot from now on; whether it does.
    fn start(&mut self) -> bool;
    /// At the begin of the interrupt.
    fn acknowledge(&mut self) {}
    /// Whether the next slot has begun.
    fn late(&self) -> bool;
}

/// A station on recorded slots.
pub struct InterruptStation<U, T, const VALUES: usize> {
    station: Station,
    slots: Mutex<RefCell<Option<SlotContext<VALUES>>>>,
    uart: Mutex<RefCell<Option<U>>>,
    timer: Mutex<RefCell<Option<T>>>,
}

impl<U: Serial, T: SlotTimer, const VALUES: usize> InterruptStation<U, T, VALUES> {
    /// A station that plays slots of this data.
    pub const fn new(data: fn() -> &'static [u8]) -> Self {
        InterruptStation {
            station: Station::new(data),
            slots: Mutex::new(RefCell::new(None)),
            uart: Mutex::new(RefCell::new(None)),
            timer: Mutex::new(RefCell::new(None)),
        }
    }

    /// Takes serial line and slot timer, which is off, and tests the signal chain; whether it is good.
    pub fn power_on(&self, uart: U, timer: T) -> bool {
        critical_section::with(|cs| {
            *self.uart.borrow_ref_mut(cs) = Some(uart);
            *self.timer.borrow_ref_mut(cs) = Some(timer);
        });
        self.station.test_signal_chain(|line| self.say(line))
    }

    /// Prints a line. Slot interrupts come in between.
    pub fn say(&self, line: Arguments<'_>) {
        let uart = critical_section::with(|cs| self.uart.borrow_ref_mut(cs).take());
        let Some(mut uart) = uart else { return };
        print(&mut uart, line);
        critical_section::with(|cs| *self.uart.borrow_ref_mut(cs) = Some(uart));
    }

    /// Tests the networks, then starts the slot timer.
    pub fn start(&self, slots: SlotContext<VALUES>, task: &mut ProcessingContext<VALUES>) {
        if !self.station.test_networks(task, |line| self.say(line)) {
            return;
        }
        let started = critical_section::with(|cs| {
            *self.slots.borrow_ref_mut(cs) = Some(slots);
            self.timer.borrow_ref_mut(cs).as_mut().is_some_and(T::start)
        });
        if !started {
            self.say(format_args!("error: the slot timer does not start"));
        }
    }

    /// The slot timer's interrupt, which calls `slot` with the slot's number.
    pub fn interrupt(&self, slot: impl FnOnce(&mut SlotContext<VALUES>, u32)) {
        critical_section::with(|cs| {
            let mut timer = self.timer.borrow_ref_mut(cs);
            if let Some(timer) = timer.as_mut() {
                timer.acknowledge();
            }
            if let Some(slots) = self.slots.borrow_ref_mut(cs).as_mut() {
                slot(slots, self.station.run.begin());
                if self.station.run.transferred() {
                    slots.samples_ready();
                }
            }
            if timer.as_ref().is_some_and(T::late) {
                self.station.run.late();
            }
        });
    }

    /// Copies the samples of a slot: there is no sensor.
    pub fn start_transfer(&self, buffer: &mut [i16]) {
        self.station.start_transfer(buffer);
    }

    /// Logs and counts an event, and prints a recognition.
    pub fn report(&self, task: &ProcessingContext<VALUES>, event: &Event) {
        self.station.report(task, event, |line| self.say(line));
    }

    /// Prints the counts once they are of enough slots.
    pub fn counts(&self) {
        self.station.counts(|line| self.say(line));
    }
}
