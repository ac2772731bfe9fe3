//! Upper words of products in one instruction.

use core::arch::asm;

// not `pure`: kept in the order of the source, they need fewer registers at a time

/// [`crate::simd::mulh::mulh`].
#[inline(always)]
pub fn mulh(a: i32, b: i32) -> i32 {
    let product;
    // SAFETY: registers only; the target has the instruction.
    unsafe {
        asm!("smmul {}, {}, {}", lateout(reg) product, in(reg) a, in(reg) b, options(nomem, nostack, preserves_flags))
    };
    product
}

/// [`crate::simd::mulh::mla_h`].
#[inline(always)]
pub fn mla_h(sum: i32, a: i32, b: i32) -> i32 {
    let total;
    // SAFETY: registers only; the target has the instruction.
    unsafe {
        asm!("smmla {}, {}, {}, {}", lateout(reg) total, in(reg) a, in(reg) b, in(reg) sum, options(nomem, nostack, preserves_flags))
    };
    total
}
