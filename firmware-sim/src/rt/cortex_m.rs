//! Cortex-M: vectors, start-up, semihosting breakpoint, SysTick as slot timer, a timer of the board as free-running counter.

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
    "ldr r0, =_stack_top",
    "mov sp, r0",
);

// an exception if the stack grows into the statics
#[cfg(armv8m)]
core::arch::global_asm!(".section .text.reset, \"ax\"", "ldr r0, =_stack_limit", "msr msplim, r0");

core::arch::global_asm!(
    ".section .text.reset, \"ax\"",
    "ldr r0, =_data_start",
    "ldr r1, =_data_end",
    "ldr r2, =_data_load",
    "1: cmp r0, r1",
    "bhs 2f",
    "ldmia r2!, {{r3}}",
    "stmia r0!, {{r3}}",
    "b 1b",
    "2: ldr r0, =_bss_start",
    "ldr r1, =_bss_end",
    "movs r3, #0",
    "3: cmp r0, r1",
    "bhs 4f",
    "stmia r0!, {{r3}}",
    "b 3b",
    "4:",
);

// CPACR: full access to the FPU, where there is one
#[cfg(not(armv6m))]
core::arch::global_asm!(
    ".section .text.reset, \"ax\"",
    "ldr r0, =0xE000ED88",
    "ldr r1, [r0]",
    "orr r1, r1, #0xF00000",
    "str r1, [r0]",
    "dsb",
    "isb",
);

core::arch::global_asm!(
    ".section .text.reset, \"ax\"",
    "bl firmware_main",
    "b .",
    ".global fault",
    ".thumb_func",
    "fault:", // on a stack of its own: the one before may be exhausted
    "ldr r0, =_stack_top",
    "mov sp, r0",
    "bl firmware_fault",
    "b .",
);

/// SysTick: control, reload value, current value.
const SYSTICK: [*mut u32; 3] = [0xE000_E010 as *mut u32, 0xE000_E014 as *mut u32, 0xE000_E018 as *mut u32];
/// Fewest and most ticks of SysTick: it is read before it has counted down, and has 24 bits.
const SHORTEST: u64 = 32;
const LONGEST: u64 = 1 << 24;
/// Application interrupt and reset control.
const AIRCR: *mut u32 = 0xE000_ED0C as *mut u32;

/// The free-running counter, of 32 bits: the register that enables it by bit 0, its value, which must run over its whole range,
/// and what makes that count upwards. It ticks at the rate of SysTick.
struct Counter {
    control: *mut u32,
    reload: Option<*mut u32>,
    value: *const u32,
    invert: u32,
}

/// CMSDK timer 0, which counts down.
#[cfg(not(board = "an547"))]
const COUNTER: Counter = {
    const BASE: usize = if cfg!(board = "an505") { 0x5000_0000 } else { 0x4000_0000 };
    Counter {
        control: BASE as *mut u32,
        reload: Some((BASE + 8) as *mut u32),
        value: (BASE + 4) as *const u32,
        invert: u32::MAX,
    }
};
/// The system counter of the SSE-300, as its timer 0 shows the low word of it.
#[cfg(board = "an547")]
const COUNTER: Counter =
    Counter { control: 0x5810_0000 as *mut u32, reload: None, value: 0x5800_0000 as *const u32, invert: 0 };

/// The counter when it was last read, and its overflows up to then.
static LAST: AtomicU32 = AtomicU32::new(0);
static WRAPS: AtomicU32 = AtomicU32::new(0);

#[unsafe(no_mangle)]
extern "C" fn firmware_systick() {
    super::timer_interrupt();
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

/// Runs `f` with interrupts masked.
pub fn masked<R>(f: impl FnOnce() -> R) -> R {
    let before: u32;
    // SAFETY: sets and restores PRIMASK; no `nomem`, so that no access moves out.
    unsafe { core::arch::asm!("mrs {}, primask", "cpsid i", out(reg) before) };
    let result = f();
    // SAFETY: as above.
    unsafe { core::arch::asm!("msr primask, {}", in(reg) before) };
    result
}

pub fn start_counter() {
    // SAFETY: the counter belongs to this module.
    unsafe {
        if COUNTER.control.read_volatile() & 1 == 1 {
            return;
        }
        if let Some(reload) = COUNTER.reload {
            reload.write_volatile(u32::MAX);
        }
        COUNTER.control.write_volatile(1);
    }
}

/// The counter with its overflows, in ticks. To be called with interrupts masked, at least once per overflow: SysTick's interrupt does.
pub fn ticks() -> u64 {
    // SAFETY: reads the counter.
    let now = unsafe { COUNTER.value.read_volatile() } ^ COUNTER.invert;
    let wraps = WRAPS.load(Ordering::Relaxed) + u32::from(now < LAST.load(Ordering::Relaxed));
    LAST.store(now, Ordering::Relaxed);
    WRAPS.store(wraps, Ordering::Relaxed);
    u64::from(wraps) << 32 | u64::from(now)
}

/// The next interrupt, at a value of the counter; before it, if that is too far. To be called with interrupts masked.
///
/// SysTick runs once: a reload value of zero, written when the counter has taken the other, stops it at the next zero.
/// (QEMU would skip an interrupt of a sleeping processor if its timer runs on.)
pub fn set_alarm(at: u64) {
    let [control, reload, value] = SYSTICK;
    // SAFETY: SysTick belongs to this module. It is loaded at the tick after its value was written.
    unsafe {
        control.write_volatile(0);
        reload.write_volatile(at.saturating_sub(ticks()).clamp(SHORTEST, LONGEST) as u32 - 1);
        value.write_volatile(0);
        control.write_volatile(7);
        while value.read_volatile() == 0 {}
        reload.write_volatile(0);
    }
}

/// SysTick needs nothing else.
pub fn enable_interrupt() {}

/// Sleeps until an interrupt has been served.
pub fn wait() {
    // SAFETY: a hint.
    unsafe { core::arch::asm!("wfi") };
}

/// Resets the machine; its memory stays as it is.
pub fn reset() -> ! {
    loop {
        // SAFETY: SYSRESETREQ.
        unsafe { AIRCR.write_volatile(0x05FA_0004) };
    }
}
