//! AArch64 at EL1: start-up, vectors, semihosting halt, generic timer through the GIC as free-running counter and slot timer.

core::arch::global_asm!(
    ".section .vectors, \"ax\"",
    ".global reset",
    "reset:",
    "adrp x0, _stack_top",
    "add x0, x0, :lo12:_stack_top",
    "mov sp, x0",
    "mov x0, #(3 << 20)", // CPACR_EL1.FPEN: the FPU on
    "msr cpacr_el1, x0",
    "adrp x0, exceptions",
    "add x0, x0, :lo12:exceptions",
    "msr vbar_el1, x0",
    "isb",
    "adrp x0, _data_start",
    "add x0, x0, :lo12:_data_start",
    "adrp x1, _data_end",
    "add x1, x1, :lo12:_data_end",
    "adrp x2, _data_load",
    "add x2, x2, :lo12:_data_load",
    "1: cmp x0, x1",
    "b.hs 2f",
    "ldr x3, [x2], #8",
    "str x3, [x0], #8",
    "b 1b",
    "2: adrp x0, _bss_start",
    "add x0, x0, :lo12:_bss_start",
    "adrp x1, _bss_end",
    "add x1, x1, :lo12:_bss_end",
    "3: cmp x0, x1",
    "b.hs 4f",
    "str xzr, [x0], #8",
    "b 3b",
    "4: bl firmware_main",
    "b .",
    ".balign 2048",
    "exceptions:",
    ".rept 5", // four of SP0, and the synchronous one of SPx
    "b fault",
    ".balign 128",
    ".endr",
    "b interrupt", // IRQ of SPx
    ".balign 128",
    ".rept 10",
    "b fault",
    ".balign 128",
    ".endr",
    "fault:",
    "bl firmware_fault",
    "b .",
    "interrupt:",
    "sub sp, sp, #704",
    "stp x0, x1, [sp, #0]",
    "stp x2, x3, [sp, #16]",
    "stp x4, x5, [sp, #32]",
    "stp x6, x7, [sp, #48]",
    "stp x8, x9, [sp, #64]",
    "stp x10, x11, [sp, #80]",
    "stp x12, x13, [sp, #96]",
    "stp x14, x15, [sp, #112]",
    "stp x16, x17, [sp, #128]",
    "stp x18, x30, [sp, #144]",
    "stp q0, q1, [sp, #176]",
    "stp q2, q3, [sp, #208]",
    "stp q4, q5, [sp, #240]",
    "stp q6, q7, [sp, #272]",
    "stp q8, q9, [sp, #304]",
    "stp q10, q11, [sp, #336]",
    "stp q12, q13, [sp, #368]",
    "stp q14, q15, [sp, #400]",
    "stp q16, q17, [sp, #432]",
    "stp q18, q19, [sp, #464]",
    "stp q20, q21, [sp, #496]",
    "stp q22, q23, [sp, #528]",
    "stp q24, q25, [sp, #560]",
    "stp q26, q27, [sp, #592]",
    "stp q28, q29, [sp, #624]",
    "stp q30, q31, [sp, #656]",
    "bl firmware_interrupt",
    "ldp x2, x3, [sp, #16]",
    "ldp x4, x5, [sp, #32]",
    "ldp x6, x7, [sp, #48]",
    "ldp x8, x9, [sp, #64]",
    "ldp x10, x11, [sp, #80]",
    "ldp x12, x13, [sp, #96]",
    "ldp x14, x15, [sp, #112]",
    "ldp x16, x17, [sp, #128]",
    "ldp x18, x30, [sp, #144]",
    "ldp q0, q1, [sp, #176]",
    "ldp q2, q3, [sp, #208]",
    "ldp q4, q5, [sp, #240]",
    "ldp q6, q7, [sp, #272]",
    "ldp q8, q9, [sp, #304]",
    "ldp q10, q11, [sp, #336]",
    "ldp q12, q13, [sp, #368]",
    "ldp q14, q15, [sp, #400]",
    "ldp q16, q17, [sp, #432]",
    "ldp q18, q19, [sp, #464]",
    "ldp q20, q21, [sp, #496]",
    "ldp q22, q23, [sp, #528]",
    "ldp q24, q25, [sp, #560]",
    "ldp q26, q27, [sp, #592]",
    "ldp q28, q29, [sp, #624]",
    "ldp q30, q31, [sp, #656]",
    "ldp x0, x1, [sp, #0]",
    "add sp, sp, #704",
    "eret",
);

/// Distributor and processor interface of the interrupt controller.
const GICD: *mut u32 = 0x0800_0000 as *mut u32;
const GICC: *mut u32 = 0x0801_0000 as *mut u32;
/// Private interrupt of the EL1 physical timer.
const TIMER: u32 = 30;

#[unsafe(no_mangle)]
extern "C" fn firmware_interrupt() {
    // SAFETY: acknowledges and ends the one interrupt that is enabled.
    unsafe {
        let which = GICC.add(3).read_volatile();
        super::timer_interrupt();
        GICC.add(4).write_volatile(which);
    }
}

/// Runs `f` with interrupts masked.
pub fn masked<R>(f: impl FnOnce() -> R) -> R {
    let before: u64;
    // SAFETY: sets and restores DAIF; no `nomem`, so that no access moves out.
    unsafe { core::arch::asm!("mrs {}, daif", "msr daifset, #2", out(reg) before) };
    let result = f();
    // SAFETY: as above.
    unsafe { core::arch::asm!("msr daif, {}", in(reg) before) };
    result
}

/// The generic timer's counter is never off.
pub fn start_counter() {}

/// The generic timer's counter.
pub fn ticks() -> u64 {
    let count: u64;
    // SAFETY: reads the counter, not ahead of time.
    unsafe { core::arch::asm!("isb", "mrs {}, cntpct_el0", out(reg) count) };
    count
}

/// The next interrupt, at a value of the counter.
pub fn set_alarm(at: u64) {
    // SAFETY: the timer belongs to this module.
    unsafe { core::arch::asm!("msr cntp_cval_el0, {}", in(reg) at) };
}

/// The semihosting trap.
///
/// # Safety
///
/// The argument must be what the operation takes.
pub unsafe fn trap(operation: usize, argument: usize) -> isize {
    let result: isize;
    // SAFETY: the caller vouches for the argument.
    unsafe { core::arch::asm!("hlt #0xF000", inout("x0") operation => result, in("x1") argument) };
    result
}

/// Allows the timer's interrupt.
pub fn enable_interrupt() {
    // SAFETY: enables the timer's interrupt; its handler is this module's.
    unsafe {
        GICD.write_volatile(1);
        GICD.add(0x100 / 4).write_volatile(1 << TIMER);
        GICC.add(1).write_volatile(0xff);
        GICC.write_volatile(1);
        core::arch::asm!("msr cntp_ctl_el0, {}", "msr daifclr, #2", in(reg) 1_u64);
    }
}

/// Sleeps until an interrupt has been served.
pub fn wait() {
    // SAFETY: a hint.
    unsafe { core::arch::asm!("wfi") };
}

/// Resets the machine; its memory stays as it is.
pub fn reset() -> ! {
    loop {
        // SAFETY: PSCI's SYSTEM_RESET, by the conduit of the emulated machine.
        unsafe { core::arch::asm!("hvc #0", in("x0") 0x8400_0009_u64) };
    }
}
