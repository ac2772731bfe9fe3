//! RV32: start-up, trap entry, semihosting breakpoint, machine timer as free-running counter and slot timer.

core::arch::global_asm!(
    ".section .vectors, \"ax\"",
    ".global reset",
    "reset:",
    "la sp, _stack_top",
    "la t0, fault",
    "csrw mtvec, t0",
    "li t0, 0x2200", // mstatus.FS and VS: FPU and vectors on, where there are any
    "csrs mstatus, t0",
    "la t0, _data_start",
    "la t1, _data_end",
    "la t2, _data_load",
    "1: bgeu t0, t1, 2f",
    "lw t3, 0(t2)",
    "sw t3, 0(t0)",
    "addi t0, t0, 4",
    "addi t2, t2, 4",
    "j 1b",
    "2: la t0, _bss_start",
    "la t1, _bss_end",
    "3: bgeu t0, t1, 4f",
    "sw zero, 0(t0)",
    "addi t0, t0, 4",
    "j 3b",
    "4: call firmware_main",
    "5: j 5b",
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

// Where there are vectors of 128 bits, all their registers and what they are configured by.
#[cfg(vectors)]
core::arch::global_asm!(
    ".option push",
    ".option arch, +zve32x",
    "addi sp, sp, -528",
    "csrr t0, vl",
    "csrr t1, vtype",
    "csrr t2, vstart",
    "sw t0, 512(sp)",
    "sw t1, 516(sp)",
    "sw t2, 520(sp)",
    "mv t0, sp",
    "vs8r.v v0, (t0)",
    "addi t0, t0, 128",
    "vs8r.v v8, (t0)",
    "addi t0, t0, 128",
    "vs8r.v v16, (t0)",
    "addi t0, t0, 128",
    "vs8r.v v24, (t0)",
    ".option pop",
);

core::arch::global_asm!("csrr a0, mcause", "call firmware_trap");

#[cfg(vectors)]
core::arch::global_asm!(
    ".option push",
    ".option arch, +zve32x",
    "mv t0, sp",
    "vl8re8.v v0, (t0)",
    "addi t0, t0, 128",
    "vl8re8.v v8, (t0)",
    "addi t0, t0, 128",
    "vl8re8.v v16, (t0)",
    "addi t0, t0, 128",
    "vl8re8.v v24, (t0)",
    "lw t0, 512(sp)",
    "lw t1, 516(sp)",
    "lw t2, 520(sp)",
    "vsetvl zero, t0, t1",
    "csrw vstart, t2",
    "addi sp, sp, 528",
    ".option pop",
);

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

/// The test finisher, which can reset the machine.
const FINISHER: *mut u32 = 0x0010_0000 as *mut u32;

unsafe extern "C" {
    /// What every exception but an interrupt ends in (`fault`).
    safe fn firmware_fault() -> !;
}

#[unsafe(no_mangle)]
extern "C" fn firmware_trap(cause: usize) {
    if cause != TIMER {
        firmware_fault();
    }
    super::timer_interrupt();
}

/// Runs `f` with interrupts masked.
pub fn masked<R>(f: impl FnOnce() -> R) -> R {
    let before: usize;
    // SAFETY: clears and restores mstatus.MIE; no `nomem`, so that no access moves out.
    unsafe { core::arch::asm!("csrrci {}, mstatus, 8", out(reg) before) };
    let result = f();
    // SAFETY: as above.
    unsafe { core::arch::asm!("csrs mstatus, {}", in(reg) before & 8) };
    result
}

/// mtime is never off.
pub fn start_counter() {}

/// mtime, both words of one moment.
pub fn ticks() -> u64 {
    loop {
        // SAFETY: reads the time.
        let [high, low, after] =
            unsafe { [MTIME.add(1).read_volatile(), MTIME.read_volatile(), MTIME.add(1).read_volatile()] };
        if high == after {
            return u64::from(high) << 32 | u64::from(low);
        }
    }
}

/// The next interrupt, at a value of the counter.
pub fn set_alarm(at: u64) {
    // SAFETY: the timer belongs to this module; a high word of all ones keeps the alarm silent while it is set.
    unsafe {
        MTIMECMP.add(1).write_volatile(u32::MAX);
        MTIMECMP.write_volatile(at as u32);
        MTIMECMP.add(1).write_volatile((at >> 32) as u32);
    }
}

/// Allows the machine timer interrupt.
pub fn enable_interrupt() {
    // SAFETY: its handler is this module's.
    unsafe { core::arch::asm!("csrs mie, {}", "csrsi mstatus, 8", in(reg) 0x80) };
}

/// The services of a test bench around a core's RTL (`tests/rtl`), which has no semihosting: text and exit code.
///
/// # Safety
///
/// The argument must be what the operation takes.
#[cfg(board = "rtl")]
pub unsafe fn trap(operation: usize, argument: usize) -> isize {
    /// A byte written here is printed; a word written behind it ends the simulation.
    const TEXT: *mut u32 = 0xf000_0000 as *mut u32;
    match operation {
        0x04 => {
            let mut at = argument as *const u8;
            // SAFETY: the caller vouches for text that ends with a zero.
            while let byte @ 1.. = unsafe { at.read_volatile() } {
                // SAFETY: the test bench's.
                unsafe { TEXT.write_volatile(u32::from(byte)) };
                at = at.wrapping_add(1);
            }
            0
        }
        0x20 => {
            // SAFETY: the caller vouches for a block of a reason and a code; the word is the test bench's.
            unsafe { TEXT.add(1).write_volatile((argument as *const u32).add(1).read_volatile()) };
            0
        }
        _ => -1,
    }
}

/// The semihosting trap.
///
/// # Safety
///
/// The argument must be what the operation takes.
#[cfg(not(board = "rtl"))]
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

/// Sleeps until an interrupt has been served.
pub fn wait() {
    // SAFETY: a hint.
    unsafe { core::arch::asm!("wfi") };
}

/// Resets the machine; its memory stays as it is.
pub fn reset() -> ! {
    loop {
        // SAFETY: the finisher's code for a reset.
        unsafe { FINISHER.write_volatile(0x7777) };
    }
}
