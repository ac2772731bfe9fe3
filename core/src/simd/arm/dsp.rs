//! The DSP extension of Armv7E-M and Armv8-M: two 16-bit products and their sum an instruction.

use crate::simd::NativeDualMac;
use crate::simd::dual_mac::{I16x8, Sums, Tile, plain_products};
use core::arch::global_asm;

/// Blocks of two tiles that a step of a convolution of 8, 16 and 32 channels does.
pub const BLOCKS: [usize; 3] = [8, 4, 1];

// Products of `groups` groups of four channels at sixteen points. A group is two loads of four words (two tiles' inputs,
// two outputs' weights) and eight dual multiply-accumulates; sums live in r2, r3, r12, lr. r0: inputs, r1: weights;
// on the stack: where sums go, and their end.
global_asm!(
    concat!(".cpu ", env!("SDP3_ARM_CPU")),
    ".macro sdp3_group first",
    "ldmia r0!, {{r4-r7}}",
    "ldmia r1!, {{r8-r11}}",
    ".if \\first",
    "smuad r2, r4, r8",
    "smuad r3, r6, r8",
    "smuad r12, r4, r10",
    "smuad lr, r6, r10",
    ".else",
    "smlad r2, r4, r8, r2",
    "smlad r3, r6, r8, r3",
    "smlad r12, r4, r10, r12",
    "smlad lr, r6, r10, lr",
    ".endif",
    "smlad r2, r5, r9, r2",
    "smlad r3, r7, r9, r3",
    "smlad r12, r5, r11, r12",
    "smlad lr, r7, r11, lr",
    ".endm",
    ".macro sdp3_point groups, first",
    "sdp3_group \\first",
    ".rept \\groups - 1",
    "sdp3_group 0",
    ".endr",
    ".endm",
    ".macro sdp3_products groups",
    ".pushsection .text.sdp3_products_\\groups, \"ax\", %progbits",
    ".global sdp3_products_\\groups",
    ".type sdp3_products_\\groups, %function",
    ".p2align 2",
    ".thumb_func",
    "sdp3_products_\\groups:",
    "push {{r4-r11, lr}}",
    "add r3, r2, #128",
    "push {{r2, r3}}",
    "1:",
    "sdp3_point \\groups, 1", // row 1
    "ldr r4, [sp]",
    "stm r4, {{r2, r3, r12, lr}}",
    "sdp3_point \\groups, 1", // row 2
    "ldr r4, [sp]",
    "ldmia r4!, {{r5-r8}}",
    "sub r5, r5, r2", // the difference, and from it the sum
    "add r2, r5, r2, lsl #1",
    "sub r6, r6, r3",
    "add r3, r6, r3, lsl #1",
    "sub r7, r7, r12",
    "add r12, r7, r12, lsl #1",
    "sub r8, r8, lr",
    "add lr, r8, lr, lsl #1",
    "stm r4, {{r5-r8}}",
    "sdp3_point \\groups, 0", // row 0
    "ldr r4, [sp]",
    "stmia r4!, {{r2, r3, r12, lr}}",
    "ldm r4, {{r2, r3, r12, lr}}",
    "sdp3_point \\groups, 0", // row 3
    "pop {{r4, r5}}",
    "add r4, r4, #16",
    "stmia r4!, {{r2, r3, r12, lr}}",
    "push {{r4, r5}}",
    "cmp r4, r5",
    "bne 1b",
    "add sp, sp, #8",
    "pop {{r4-r11, pc}}",
    ".size sdp3_products_\\groups, . - sdp3_products_\\groups",
    ".popsection",
    ".endm",
    "sdp3_products 1",
    "sdp3_products 2",
    "sdp3_products 4",
    "sdp3_products 8",
    "sdp3_products 16",
);

unsafe extern "C" {
    #[cfg(feature = "graph")]
    fn sdp3_products_1(inputs: *const I16x8, weights: *const I16x8, sums: *mut Sums);
    fn sdp3_products_2(inputs: *const I16x8, weights: *const I16x8, sums: *mut Sums);
    fn sdp3_products_4(inputs: *const I16x8, weights: *const I16x8, sums: *mut Sums);
    fn sdp3_products_8(inputs: *const I16x8, weights: *const I16x8, sums: *mut Sums);
    #[cfg(feature = "graph")]
    fn sdp3_products_16(inputs: *const I16x8, weights: *const I16x8, sums: *mut Sums);
}

/// [`DualMac::products`](crate::simd::dual_mac::DualMac::products).
#[inline]
pub fn products<const GROUPS: usize>(inputs: &Tile<GROUPS>, weights: &Tile<GROUPS>, sums: &mut Sums) {
    let (x, w) = (inputs.as_ptr().cast(), weights.as_ptr().cast());
    // SAFETY: each reads 16 GROUPS groups of inputs and of weights, which is what both arrays hold, and writes 128
    // bytes, which is what the sums are; all are aligned to words.
    match GROUPS {
        #[cfg(feature = "graph")]
        1 => unsafe { sdp3_products_1(x, w, sums) },
        2 => unsafe { sdp3_products_2(x, w, sums) },
        4 => unsafe { sdp3_products_4(x, w, sums) },
        8 => unsafe { sdp3_products_8(x, w, sums) },
        #[cfg(feature = "graph")]
        16 => unsafe { sdp3_products_16(x, w, sums) },
        _ => plain_products::<NativeDualMac, GROUPS>(inputs, weights, sums),
    }
}
