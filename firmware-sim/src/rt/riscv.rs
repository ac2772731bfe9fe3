//! RV32: reset, trap entry, semihosting breakpoint, machine timer, retired instructions.

use core::sync::atomic::{AtomicU32, Ordering};

core::arch::global_asm!(
    ".section .vectors, \"ax\"",
    ".global reset",
    "reset:",
    "la sp, _stack_top",
    "la t0, fault",
    "csrw mtvec, t0",
    "li t0, 0x2000", // mstatus.FS: the FPU on, where there is one
    "csrs mstatus, t0",
    "call firmware_main",
    "1: j 1b",
    ".align 2",
    "fault:",
    "addi sp, sp, -144",
    "sw ra, 0(sp)",
    "sw t0, 4(sp)",
    "sw t1, 8(sp)",
    "sw t2, 12(sp)",
    "sw t3, 16(sp)",
    "sw t4, 20(sp)",
    "sw t5, 24(sp)",
    "sw t6, 28(sp)",
    "sw a0, 32(sp)",
    "sw a1, 36(sp)",
    "sw a2, 40(sp)",
    "sw a3, 44(sp)",
    "sw a4, 48(sp)",
    "sw a5, 52(sp)",
    "sw a6, 56(sp)",
    "sw a7, 60(sp)",
);

/// Registers a call may change, of the FPU.
#[cfg(target_feature = "f")]
macro_rules! float_registers {
    ($operation:literal) => {
        concat!(
            $operation,
            " ft0, 64(sp)\n",
            $operation,
            " ft1, 68(sp)\n",
            $operation,
            " ft2, 72(sp)\n",
            $operation,
            " ft3, 76(sp)\n",
            $operation,
            " ft4, 80(sp)\n",
            $operation,
            " ft5, 84(sp)\n",
            $operation,
            " ft6, 88(sp)\n",
            $operation,
            " ft7, 92(sp)\n",
            $operation,
            " ft8, 96(sp)\n",
            $operation,
            " ft9, 100(sp)\n",
            $operation,
            " ft10, 104(sp)\n",
            $operation,
            " ft11, 108(sp)\n",
            $operation,
            " fa0, 112(sp)\n",
            $operation,
            " fa1, 116(sp)\n",
            $operation,
            " fa2, 120(sp)\n",
            $operation,
            " fa3, 124(sp)\n",
            $operation,
            " fa4, 128(sp)\n",
            $operation,
            " fa5, 132(sp)\n",
            $operation,
            " fa6, 136(sp)\n",
            $operation,
            " fa7, 140(sp)\n",
        )
    };
}

#[cfg(target_feature = "f")]
core::arch::global_asm!(float_registers!("fsw"));

core::arch::global_asm!("csrr a0, mcause", "call firmware_trap");

#[cfg(target_feature = "f")]
core::arch::global_asm!(float_registers!("flw"));

core::arch::global_asm!(
    "lw ra, 0(sp)",
    "lw t0, 4(sp)",
    "lw t1, 8(sp)",
    "lw t2, 12(sp)",
    "lw t3, 16(sp)",
    "lw t4, 20(sp)",
    "lw t5, 24(sp)",
    "lw t6, 28(sp)",
    "lw a0, 32(sp)",
    "lw a1, 36(sp)",
    "lw a2, 40(sp)",
    "lw a3, 44(sp)",
    "lw a4, 48(sp)",
    "lw a5, 52(sp)",
    "lw a6, 56(sp)",
    "lw a7, 60(sp)",
    "addi sp, sp, 144",
    "mret",
);

/// Cause of a machine timer interrupt.
const TIMER: usize = 1 << 31 | 7;
/// Time and alarm of hart 0, low words first.
const MTIME: *mut u32 = 0x0200_bff8 as *mut u32;
const MTIMECMP: *mut u32 = 0x0200_4000 as *mut u32;

static PERIOD: AtomicU32 = AtomicU32::new(0);

unsafe extern "C" {
    /// What every exception but an interrupt ends in (`fault`).
    safe fn firmware_fault() -> !;
}

#[unsafe(no_mangle)]
extern "C" fn firmware_trap(cause: usize) {
    if cause != TIMER {
        firmware_fault();
    }
    set_alarm();
    super::tick();
}

/// The next interrupt, one period from now.
fn set_alarm() {
    // SAFETY: the timer belongs to this module; a high word of all ones keeps the alarm silent while it is set.
    unsafe {
        let high = MTIME.add(1).read_volatile();
        let now = u64::from(high) << 32 | u64::from(MTIME.read_volatile());
        let next = now.wrapping_add(u64::from(PERIOD.load(Ordering::Relaxed)));
        MTIMECMP.add(1).write_volatile(u32::MAX);
        MTIMECMP.write_volatile(next as u32);
        MTIMECMP.add(1).write_volatile((next >> 32) as u32);
    }
}

/// The semihosting trap.
///
/// # Safety
///
/// The argument must be what the operation takes.
pub unsafe fn trap(operation: usize, argument: usize) -> isize {
    let result: isize;
    // SAFETY: the caller vouches for the argument.
    unsafe {
        core::arch::asm!(
            ".option push",
            ".option norvc",
            ".balign 16",
            "slli x0, x0, 0x1f",
            "ebreak",
            "srai x0, x0, 7",
            ".option pop",
            inout("a0") operation => result,
            in("a1") argument
        );
    }
    result
}

/// An interrupt every so many instructions: 100 a tick of the 10 MHz timer.
pub fn start_ticks(instructions: u32) {
    PERIOD.store((instructions / 100).max(1), Ordering::Relaxed);
    set_alarm();
    // SAFETY: allows the machine timer interrupt; its handler is this module's.
    unsafe { core::arch::asm!("csrs mie, {}", "csrsi mstatus, 8", in(reg) 0x80) };
}

pub fn start_counter() {}

/// minstret, both words of one moment.
pub fn instructions() -> u64 {
    loop {
        let (before, low, after): (u32, u32, u32);
        // SAFETY: reads two counters.
        unsafe {
            core::arch::asm!("csrr {}, minstreth", "csrr {}, minstret", "csrr {}, minstreth", out(reg) before, out(reg) low, out(reg) after);
        }
        if before == after {
            return u64::from(before) << 32 | u64::from(low);
        }
    }
}

/// Sleeps until an interrupt has been served.
pub fn wait() {
    // SAFETY: a hint.
    unsafe { core::arch::asm!("wfi") };
}
