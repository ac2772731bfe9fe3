//! Products with the windows of four pixels by dual multiply-accumulates: sixteen of them take 13 instructions.

use crate::simd::patch_products::{Fours, PIXELS};
use core::arch::{asm, global_asm};

// r0: patch, r1: weights, r2: fours of values, r3: sums. Sums live in r8-r11, values in r4-r7, weights in r12 and lr. One and two fours that are
// over come first, then four at a time.
global_asm!(
    concat!(".cpu ", env!("SDP3_ARM_CPU")),
    ".macro sdp3_fours",
    "ldr lr, [r1], #4",
    "ldmia r0!, {{r4-r7}}",
    "sxtb16 r12, lr",
    "smlad r8, r4, r12, r8",
    "smlad r9, r5, r12, r9",
    "smlad r10, r6, r12, r10",
    "smlad r11, r7, r12, r11",
    "ldmia r0!, {{r4-r7}}",
    "sxtb16 lr, lr, ror #8",
    "smlad r8, r4, lr, r8",
    "smlad r9, r5, lr, r9",
    "smlad r10, r6, lr, r10",
    "smlad r11, r7, lr, r11",
    ".endm",
    ".pushsection .text.sdp3_patch_products, \"ax\", %progbits",
    ".global sdp3_patch_products",
    ".type sdp3_patch_products, %function",
    ".p2align 2",
    ".thumb_func",
    "sdp3_patch_products:",
    "push {{r4-r11, lr}}",
    "ldm r3, {{r8-r11}}",
    "lsrs r2, r2, #1",
    "bcc 1f",
    "sdp3_fours",
    "1:",
    "lsrs r2, r2, #1",
    "bcc 2f",
    ".rept 2",
    "sdp3_fours",
    ".endr",
    "2:",
    "beq 4f", // of the shift: the products leave the flags
    "3:",
    ".rept 4",
    "sdp3_fours",
    ".endr",
    "subs r2, r2, #1",
    "bne 3b",
    "4:",
    "stm r3, {{r8-r11}}",
    "pop {{r4-r11, pc}}",
    ".size sdp3_patch_products, . - sdp3_patch_products",
    ".popsection",
);

unsafe extern "C" {
    fn sdp3_patch_products(
        patch: *const Fours,
        weights: *const [u8; 4],
        fours: usize,
        sums: *mut [i32; PIXELS],
    );
}

/// [`crate::simd::patch_products::portable`] by dual multiply-accumulates.
#[inline(always)]
pub fn patch_products(patch: &[Fours], weights: &[[u8; 4]], sums: &mut [i32; PIXELS]) {
    let fours = patch.len().min(weights.len());
    // SAFETY: it reads `fours` items of the patch, in words, and as many of the weights, at any alignment, and reads and writes the sums.
    unsafe { sdp3_patch_products(patch.as_ptr(), weights.as_ptr(), fours, sums) };
}

/// [`crate::simd::patch_products::widen`] two values an instruction.
#[inline(always)]
pub fn widen(values: &[[i8; 4]], zero: i8, fours: &mut [Fours], pixel: usize) {
    let zeros = i32::from(zero) & 0xffff | i32::from(zero) << 16;
    for (four, Fours([even, odd])) in values.iter().zip(fours) {
        let word = i32::from_le_bytes(four.map(|value| value as u8));
        let (first, second): (i32, i32);
        // SAFETY: registers and APSR.GE only; the target has the instructions.
        unsafe {
            asm!(
                "sxtb16 {first}, {second}",
                "sxtb16 {second}, {second}, ror #8",
                "ssub16 {first}, {first}, {zeros}",
                "ssub16 {second}, {second}, {zeros}",
                zeros = in(reg) zeros, first = out(reg) first, second = inout(reg) word => second,
                options(pure, nomem, nostack)
            );
        }
        let [first, second] = [first, second].map(|pair| [pair as i16, (pair >> 16) as i16]);
        (even[pixel % PIXELS], odd[pixel % PIXELS]) = (first, second);
    }
}
