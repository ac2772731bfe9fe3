//! The counters of RISC-V, and marks by which a trace of addresses is divided into stages.

/// Marks there are.
pub const MARKS: usize = 64;

// an entry is four bytes long and returns at once
#[cfg(target_arch = "riscv32")]
core::arch::global_asm!(
    ".section .text.marks, \"ax\"",
    ".balign 4",
    ".global firmware_marks",
    "firmware_marks:",
    ".rept 64",
    "ret",
    ".balign 4",
    ".endr",
);
#[cfg(target_arch = "arm")]
core::arch::global_asm!(
    ".section .text.marks, \"ax\"",
    ".balign 4",
    ".global firmware_marks",
    ".thumb_func",
    "firmware_marks:",
    ".rept 64",
    "bx lr",
    "nop",
    ".endr",
);
#[cfg(target_arch = "aarch64")]
core::arch::global_asm!(
    ".section .text.marks, \"ax\"",
    ".global firmware_marks",
    "firmware_marks:",
    ".rept 64",
    "ret",
    ".endr",
);

unsafe extern "C" {
    safe fn firmware_marks();
}

/// Executes entry `number`, modulo [`MARKS`], of the table `firmware_marks`, which does nothing else.
#[inline(never)]
pub fn mark(number: usize) {
    let entry = firmware_marks as *const () as usize + 4 * (number % MARKS);
    // SAFETY: every entry of the table is a function without arguments that returns; Thumb's low bit is the table's own.
    let entry = unsafe { core::mem::transmute::<usize, extern "C" fn()>(entry) };
    entry();
}

/// Low words of the retired instructions and of the cycles; zeros on processors without these two counters.
#[inline(always)]
pub fn counters() -> [u32; 2] {
    #[cfg(target_arch = "riscv32")]
    {
        let (instructions, cycles);
        // SAFETY: reads two counters; no `nomem`, so that no access moves past.
        unsafe {
            core::arch::asm!("csrr {}, minstret", "csrr {}, mcycle", out(reg) instructions, out(reg) cycles)
        };
        [instructions, cycles]
    }
    #[cfg(not(target_arch = "riscv32"))]
    {
        core::sync::atomic::compiler_fence(core::sync::atomic::Ordering::SeqCst);
        [0; 2]
    }
}
