//! Cortex-M: vectors, semihosting breakpoint, SysTick as timer and instruction counter.

use core::sync::atomic::{AtomicU32, Ordering};

core::arch::global_asm!(
    ".section .vectors, \"a\"",
    ".word _stack_top",
    ".word reset",
    ".rept 13",
    ".word fault",
    ".endr",
    ".word firmware_systick",
    ".section .text.reset, \"ax\"",
    ".global reset",
    ".thumb_func",
    "reset:",
    "ldr r0, =0xE000ED88", // CPACR: full access to the FPU, where there is one
    "ldr r1, [r0]",
    "orr r1, r1, #0xF00000",
    "str r1, [r0]",
    "dsb",
    "isb",
    "bl firmware_main",
    "b .",
    ".global fault",
    ".thumb_func",
    "fault:",
    "bl firmware_fault",
    "b .",
);

/// SysTick: control, reload value, current value.
const SYSTICK: [*mut u32; 3] = [0xE000_E010 as *mut u32, 0xE000_E014 as *mut u32, 0xE000_E018 as *mut u32];
/// Ticks of the counter before it begins again.
const TURN: u32 = 1 << 24;
/// Virtual picoseconds of one instruction under `-icount shift=6`.
const INSTRUCTION_PS: u64 = 64_000;

static TURNS: AtomicU32 = AtomicU32::new(0);

#[unsafe(no_mangle)]
extern "C" fn firmware_systick() {
    TURNS.fetch_add(1, Ordering::Relaxed);
    super::tick();
}

/// The semihosting trap.
///
/// # Safety
///
/// The argument must be what the operation takes.
pub unsafe fn trap(operation: usize, argument: usize) -> isize {
    let result: isize;
    // SAFETY: the caller vouches for the argument.
    unsafe { core::arch::asm!("bkpt #0xAB", inout("r0") operation => result, in("r1") argument) };
    result
}

/// An interrupt every so many instructions, at most 2^24 ticks of the machine's clock.
pub fn start_ticks(instructions: u32) {
    start(u64::from(instructions) * INSTRUCTION_PS / super::TICK_PS);
}

fn start(ticks: u64) {
    let [control, reload, value] = SYSTICK;
    // SAFETY: SysTick belongs to this module.
    unsafe {
        reload.write_volatile(ticks.clamp(1, u64::from(TURN)) as u32 - 1);
        value.write_volatile(0);
        control.write_volatile(7);
    }
}

pub fn start_counter() {
    start(u64::from(TURN));
}

/// Turns and rest of SysTick, in picoseconds of virtual time, over those of one instruction.
pub fn instructions() -> u64 {
    let [_, _, value] = SYSTICK;
    loop {
        let turns = TURNS.load(Ordering::Relaxed);
        // SAFETY: reads SysTick's value.
        let left = unsafe { value.read_volatile() };
        if TURNS.load(Ordering::Relaxed) == turns {
            let ticks = u64::from(turns) * u64::from(TURN) + u64::from((TURN - left) % TURN);
            return ticks * super::TICK_PS / INSTRUCTION_PS;
        }
    }
}

/// Sleeps until an interrupt has been served.
pub fn wait() {
    // SAFETY: a hint.
    unsafe { core::arch::asm!("wfi") };
}
