//! The slot interrupt: an alarm of TIMER0.
#![allow(unsafe_code)] // unmasks the interrupt

use rp235x_hal::arch::interrupt_unmask;
use rp235x_hal::fugit::MicrosDurationU64;
use rp235x_hal::pac::Interrupt;
use rp235x_hal::timer::{Alarm, Alarm0, CopyableTimer0, Instant, Timer};
use sdp3_board_support::interrupt_station::SlotTimer as Slots;

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
}

impl Slots for SlotTimer {
    fn start(&mut self) -> bool {
        self.next = self.timer.get_counter();
        self.alarm.enable_interrupt();
        self.acknowledge();
        // SAFETY: critical sections mask all interrupts, not this one.
        unsafe { interrupt_unmask(Interrupt::TIMER0_IRQ_0) };
        true
    }

    /// The next interrupt comes a slot after this one was due.
    fn acknowledge(&mut self) {
        self.alarm.clear_interrupt();
        self.next += SLOT;
        let _ = self.alarm.schedule_at(self.next); // a slot ahead is never too far
    }

    fn late(&self) -> bool {
        self.timer.get_counter() >= self.next
    }
}
