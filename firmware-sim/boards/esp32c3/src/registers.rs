//! The processor's registers that esp-hal does not touch: its own counter of cycles (it has no `mcycle`), and the interrupts' switch.
#![allow(unsafe_code)]

use core::arch::asm;

/// Counts cycles from now on.
pub(crate) fn enable_cycles() {
    // SAFETY: the registers of the performance counter (event, mode) change no memory and no other register.
    unsafe { asm!("csrwi 0x7e0, 1", "csrwi 0x7e1, 1", options(nomem, nostack)) };
}

/// Cycles so far, without those of `wfi`, modulo 2^32.
pub(crate) fn cycles() -> u32 {
    let cycles;
    // SAFETY: reading the performance counter changes nothing.
    unsafe { asm!("csrr {0}, 0x7e2", out(reg) cycles, options(nomem, nostack)) };
    cycles
}

/// Lets interrupts through, whatever the bootloader has left. Not for use in a critical section.
pub(crate) fn enable_interrupts() {
    // SAFETY: the vector table is set before `main`, and the caller is in no critical section.
    unsafe { asm!("csrsi mstatus, 8", options(nostack)) };
}
