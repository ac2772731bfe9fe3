//! Helium, the vector extension of Armv8.1-M: eight 16-bit products and their sum an instruction.

use crate::simd::NativeDualMac;
use crate::simd::dual_mac::{I16x8, Sums, Tile, plain_products};
use core::arch::global_asm;

/// Blocks of two tiles that a step of a convolution of 8, 16 and 32 channels does.
pub const BLOCKS: [usize; 3] = [16, 7, 2];

// As the DSP extension's products, with eight channels a group: two tiles' inputs in q0 and q1, two outputs' weights in q2 and q3.
// Sums live in r4, r6, r8, r10, as the instruction wants even registers. r0: inputs, r1: weights, r2: where sums go, r3: their end.
global_asm!(
    concat!(".cpu ", env!("SDP3_ARM_CPU")),
    ".macro sdp3_wide_group first",
    "vldrw.u32 q0, [r0], #16",
    "vldrw.u32 q1, [r0], #16",
    "vldrw.u32 q2, [r1], #16",
    "vldrw.u32 q3, [r1], #16",
    ".if \\first",
    "vmladav.s16 r4, q0, q2",
    "vmladav.s16 r6, q1, q2",
    "vmladav.s16 r8, q0, q3",
    "vmladav.s16 r10, q1, q3",
    ".else",
    "vmladava.s16 r4, q0, q2",
    "vmladava.s16 r6, q1, q2",
    "vmladava.s16 r8, q0, q3",
    "vmladava.s16 r10, q1, q3",
    ".endif",
    ".endm",
    ".macro sdp3_wide_point groups, first",
    "sdp3_wide_group \\first",
    ".rept \\groups - 1",
    "sdp3_wide_group 0",
    ".endr",
    ".endm",
    ".macro sdp3_wide_products groups",
    ".pushsection .text.sdp3_wide_products_\\groups, \"ax\", %progbits",
    ".global sdp3_wide_products_\\groups",
    ".type sdp3_wide_products_\\groups, %function",
    ".p2align 2",
    ".thumb_func",
    "sdp3_wide_products_\\groups:",
    "push {{r4-r11, lr}}",
    "add r3, r2, #128",
    "1:",
    "sdp3_wide_point \\groups, 1", // row 1
    "stm r2, {{r4, r6, r8, r10}}",
    "sdp3_wide_point \\groups, 1", // row 2
    "ldm r2, {{r5, r7, r9, r11}}",
    "sub r5, r5, r4", // the difference, and from it the sum
    "add r4, r5, r4, lsl #1",
    "sub r7, r7, r6",
    "add r6, r7, r6, lsl #1",
    "sub r9, r9, r8",
    "add r8, r9, r8, lsl #1",
    "sub r11, r11, r10",
    "add r10, r11, r10, lsl #1",
    "add r12, r2, #16",
    "stm r12, {{r5, r7, r9, r11}}",
    "sdp3_wide_point \\groups, 0", // row 0
    "stmia r2!, {{r4, r6, r8, r10}}",
    "ldm r2, {{r4, r6, r8, r10}}",
    "sdp3_wide_point \\groups, 0", // row 3
    "stmia r2!, {{r4, r6, r8, r10}}",
    "cmp r2, r3",
    "bne 1b",
    "pop {{r4-r11, pc}}",
    ".size sdp3_wide_products_\\groups, . - sdp3_wide_products_\\groups",
    ".popsection",
    ".endm",
    "sdp3_wide_products 1",
    "sdp3_wide_products 2",
    "sdp3_wide_products 4",
    "sdp3_wide_products 8",
);

unsafe extern "C" {
    fn sdp3_wide_products_1(inputs: *const I16x8, weights: *const I16x8, sums: *mut Sums);
    fn sdp3_wide_products_2(inputs: *const I16x8, weights: *const I16x8, sums: *mut Sums);
    fn sdp3_wide_products_4(inputs: *const I16x8, weights: *const I16x8, sums: *mut Sums);
    #[cfg(feature = "graph")]
    fn sdp3_wide_products_8(inputs: *const I16x8, weights: *const I16x8, sums: *mut Sums);
}

/// [`DualMac::products`](crate::simd::dual_mac::DualMac::products).
#[inline]
pub fn products<const GROUPS: usize>(inputs: &Tile<GROUPS>, weights: &Tile<GROUPS>, sums: &mut Sums) {
    let (x, w) = (inputs.as_ptr().cast(), weights.as_ptr().cast());
    // SAFETY: each reads 16 GROUPS eights of inputs and of weights, which is what both arrays hold, and writes 128
    // bytes, which is what the sums are; all are aligned to words. It saves the registers it must.
    match GROUPS {
        2 => unsafe { sdp3_wide_products_1(x, w, sums) },
        4 => unsafe { sdp3_wide_products_2(x, w, sums) },
        8 => unsafe { sdp3_wide_products_4(x, w, sums) },
        #[cfg(feature = "graph")]
        16 => unsafe { sdp3_wide_products_8(x, w, sums) },
        _ => plain_products::<NativeDualMac, GROUPS>(inputs, weights, sums),
    }
}
