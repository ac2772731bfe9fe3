//! The processor's own counter of cycles. It has no `mcycle`.
#![allow(unsafe_code)]

use core::arch::asm;

/// Counts cycles from now on.
pub(crate) fn enable() {
    // SAFETY: the registers of the performance counter (event, mode) change no memory and no other register.
    unsafe { asm!("csrwi 0x7e0, 1", "csrwi 0x7e1, 1", options(nomem, nostack)) };
}

/// Cycles so far, without those of `wfi`, modulo 2^32.
pub(crate) fn count() -> u32 {
    let cycles;
    // SAFETY: reading the performance counter changes nothing.
    unsafe { asm!("csrr {0}, 0x7e2", out(reg) cycles, options(nomem, nostack)) };
    cycles
}
