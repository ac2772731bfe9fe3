//! The slot interrupt: an alarm of TIMER0.
#![allow(unsafe_code)] // unmasks the interrupt

use rp235x_hal::arch::{interrupt_enable, interrupt_unmask};
use rp235x_hal::fugit::MicrosDurationU64;
use rp235x_hal::pac::Interrupt;
use rp235x_hal::timer::{Alarm, Alarm0, CopyableTimer0, Instant, Timer};

/// A slot.
const SLOT: MicrosDurationU64 = MicrosDurationU64::micros(250);

/// An alarm at the begin of each slot, by which TIMER0_IRQ_0 is raised.
pub struct SlotTimer {
    timer: Timer<CopyableTimer0>,
    alarm: Alarm0<CopyableTimer0>,
    next: Instant,
}

impl SlotTimer {
    /// The timer, off.
    pub fn new(mut timer: Timer<CopyableTimer0>) -> Option<Self> {
        let alarm = timer.alarm_0()?;
        Some(SlotTimer { timer, alarm, next: timer.get_counter() })
    }

    /// Interrupts every slot from now on.
    pub fn start(&mut self) {
        self.next = self.timer.get_counter();
        self.alarm.enable_interrupt();
        self.again();
        // SAFETY: called outside of critical sections, which mask all interrupts.
        unsafe {
            interrupt_unmask(Interrupt::TIMER0_IRQ_0);
            interrupt_enable();
        }
    }

    /// At the begin of the interrupt: the next one comes a slot after this one was due.
    pub fn again(&mut self) {
        self.alarm.clear_interrupt();
        self.next += SLOT;
        let _ = self.alarm.schedule_at(self.next); // a slot ahead is never too far
    }

    /// Whether the next slot has begun.
    pub fn late(&self) -> bool {
        self.timer.get_counter() >= self.next
    }
}
