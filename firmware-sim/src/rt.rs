//! Start-up, semihosting call, instruction counter, stack paint and single-owner statics: all the unsafe code.
//!
//! Each unsafe block says why it is sound. QEMU loads the ELF's segments and starts with zeroed memory, so nothing is
//! copied or cleared.
#![allow(unsafe_code)]

use core::cell::UnsafeCell;
use core::sync::atomic::{AtomicBool, Ordering};

unsafe extern "C" {
    static mut _bss_end: u32;
    static mut _stack_top: u32;
}

#[cfg(target_arch = "arm")]
mod start {
    core::arch::global_asm!(
        ".section .vectors, \"a\"",
        ".word _stack_top",
        ".word reset",
        ".rept 14",
        ".word fault",
        ".endr",
        ".section .text.reset, \"ax\"",
        ".global reset",
        ".thumb_func",
        "reset:",
        "ldr r0, =0xE000ED88", // CPACR: full access to the FPU
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
}

#[cfg(target_arch = "riscv32")]
mod start {
    core::arch::global_asm!(
        ".section .vectors, \"ax\"",
        ".global reset",
        "reset:",
        "la sp, _stack_top",
        "la t0, fault",
        "csrw mtvec, t0",
        "call firmware_main",
        "1: j 1b",
        ".align 2",
        "fault:",
        "call firmware_fault",
        "2: j 2b",
    );
}

/// A processor fault ends the run with exit code 102.
#[unsafe(no_mangle)]
extern "C" fn firmware_fault() -> ! {
    super::semihosting::print("fault: the processor raised an exception\n");
    super::semihosting::exit(102)
}

/// Semihosting call; the result of the emulator.
pub(crate) fn call(operation: usize, block: &[usize; 4]) -> isize {
    // SAFETY: the emulator reads the four words of the block, which outlive the call, and writes only to the buffers whose
    // addresses `semihosting` put there from live exclusive slices.
    unsafe { trap(operation, block.as_ptr() as usize) }
}

/// Prints zero-terminated text.
pub(crate) fn write0(text: &[u8; 128]) {
    // SAFETY: SYS_WRITE0 reads up to the zero that ends the text; `semihosting::print` leaves the last byte zero.
    unsafe { trap(0x04, text.as_ptr() as usize) };
}

/// The semihosting trap.
unsafe fn trap(operation: usize, argument: usize) -> isize {
    let result: isize;
    // SAFETY: the caller vouches for the argument.
    unsafe {
        #[cfg(target_arch = "arm")]
        core::arch::asm!("bkpt #0xAB", inout("r0") operation => result, in("r1") argument);
        #[cfg(target_arch = "riscv32")]
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

/// Starts the counter behind [`instructions`].
pub fn start_counter() {
    #[cfg(target_arch = "arm")]
    // SAFETY: CMSDK TIMER0 of the machine; nothing else touches it.
    unsafe {
        (0x4000_0000 as *mut u32).write_volatile(0);
        (0x4000_0004 as *mut u32).write_volatile(u32::MAX);
        (0x4000_0008 as *mut u32).write_volatile(u32::MAX);
        (0x4000_0000 as *mut u32).write_volatile(1);
    }
}

/// Instructions executed so far, modulo 2^32, under `-icount shift=6` (Arm) or `shift=0` (RISC-V).
///
/// Arm: a 25 MHz timer and 64 ns an instruction, so 40/64 of a tick an instruction: resolution one tick, 0.6
/// instructions. RISC-V: minstret.
pub fn instructions() -> u64 {
    #[cfg(target_arch = "arm")]
    {
        // SAFETY: reads the timer's value register.
        let left = unsafe { (0x4000_0004 as *const u32).read_volatile() };
        u64::from(u32::MAX - left) * 40 / 64
    }
    #[cfg(target_arch = "riscv32")]
    {
        let (low, high): (u32, u32);
        // SAFETY: reads two counters.
        unsafe { core::arch::asm!("csrr {}, minstret", "csrr {}, minstreth", out(reg) low, out(reg) high) };
        u64::from(high) << 32 | u64::from(low)
    }
}

const PAINT: u32 = 0xACED_C0DE;

/// Fills the free memory below the stack with a pattern.
#[inline(never)]
pub fn paint_stack() {
    let here = 0_u32;
    let bottom = &raw mut _bss_end;
    // a kilobyte below this frame is left alone
    let top = (&raw const here as usize).saturating_sub(1024);
    let words = top.saturating_sub(bottom as usize) / 4;
    for k in 0..words {
        // SAFETY: between the end of the statics and the stack nothing lives.
        unsafe { bottom.add(k).write_volatile(PAINT) };
    }
}

/// Bytes of stack used since [`paint_stack`].
pub fn stack_used() -> usize {
    let (bottom, top) = (&raw const _bss_end, &raw const _stack_top as usize);
    let mut k = 0;
    // SAFETY: reads memory between the statics and the stack's top.
    while unsafe { bottom.add(k).read_volatile() } == PAINT {
        k += 1;
    }
    top - (bottom as usize + 4 * k)
}

/// A static with one owner.
pub struct Single<T> {
    value: UnsafeCell<T>,
    taken: AtomicBool,
}

// SAFETY: `take` hands the value out once.
unsafe impl<T> Sync for Single<T> {}

impl<T> Single<T> {
    /// A static value.
    pub const fn new(value: T) -> Self {
        Single { value: UnsafeCell::new(value), taken: AtomicBool::new(false) }
    }

    /// The value, the first time.
    pub fn take(&'static self) -> Option<&'static mut T> {
        if self.taken.swap(true, Ordering::AcqRel) {
            return None;
        }
        // SAFETY: the flag lets exactly one caller pass, ever.
        Some(unsafe { &mut *self.value.get() })
    }
}

/// A panic prints its message and ends the run with exit code 101.
#[panic_handler]
fn panic(info: &core::panic::PanicInfo) -> ! {
    super::semihosting::println(format_args!("{info}"));
    super::semihosting::exit(101)
}
