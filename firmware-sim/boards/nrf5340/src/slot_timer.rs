//! Slots of a timer of their own: the time driver counts 32 768 a second, of which a slot is no whole number.
#![allow(unsafe_code)] // unmasks the interrupt

use core::future::poll_fn;
use core::sync::atomic::{AtomicU32, Ordering::Relaxed};
use core::task::Poll;
use embassy_nrf::interrupt::{InterruptExt, Priority};
use embassy_nrf::pac;
use embassy_nrf::peripherals::TIMER1;
use embassy_nrf::timer::{Frequency, Timer};
use embassy_nrf::{Peri, interrupt};
use embassy_sync::waitqueue::AtomicWaker;
use sdp3_board_support::slots::{SLOT_US, SlotClock};

/// Slots that have begun.
static BEGUN: AtomicU32 = AtomicU32::new(0);
static WAKER: AtomicWaker = AtomicWaker::new();

/// Compares TIMER1 with the length of a slot.
pub struct SlotTimer {
    seen: u32,
}

impl SlotTimer {
    /// Starts the timer.
    pub fn new(timer: Peri<'static, TIMER1>) -> Self {
        let mut timer = Timer::new(timer);
        timer.set_frequency(Frequency::F1MHz);
        let compare = timer.cc(0);
        compare.write(SLOT_US as u32);
        compare.short_compare_clear();
        timer.regs().intenset().write(|w| w.set_compare(0, true));
        interrupt::TIMER1.set_priority(Priority::P1);
        // SAFETY: the interrupt uses atomics only, and no critical section relies on its being masked.
        unsafe { interrupt::TIMER1.enable() };
        timer.start();
        timer.persist();
        SlotTimer { seen: BEGUN.load(Relaxed) }
    }
}

impl SlotClock for SlotTimer {
    async fn next(&mut self) -> u32 {
        poll_fn(|context| {
            WAKER.register(context.waker());
            let begun = BEGUN.load(Relaxed);
            if begun == self.seen {
                return Poll::Pending;
            }
            self.seen = begun;
            Poll::Ready(begun)
        })
        .await
    }
}

#[interrupt]
fn TIMER1() {
    pac::TIMER1_S.events_compare(0).write_value(0);
    BEGUN.store(BEGUN.load(Relaxed).wrapping_add(1), Relaxed);
    WAKER.wake();
}
