//! The executor of the slot task: in an interrupt of its own, below those of DMA and time, above the loop in thread mode.
#![allow(unsafe_code)]

use embassy_executor::{InterruptExecutor, SendSpawner};
use embassy_rp::interrupt;
use embassy_rp::interrupt::{InterruptExt, Priority};

static EXECUTOR: InterruptExecutor = InterruptExecutor::new();

/// Starts the executor, once.
pub fn start() -> SendSpawner {
    interrupt::SWI_IRQ_0.set_priority(Priority::P2);
    EXECUTOR.start(interrupt::SWI_IRQ_0)
}

/// For software.
#[interrupt]
unsafe fn SWI_IRQ_0() {
    // SAFETY: `start` unmasks this interrupt once the executor is there, and nothing else calls this.
    unsafe { EXECUTOR.on_interrupt() }
}
