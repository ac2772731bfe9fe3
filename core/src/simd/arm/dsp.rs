//! The DSP extension of Armv7E-M and Armv8-M: two 16-bit products and their sum an instruction.

use crate::simd::NativeDualMac;
use crate::simd::dual_mac::{Constants, I16x8, Sums, Tile, plain_products};
use core::arch::global_asm;

/// [`DualMac::BLOCKS`](crate::simd::dual_mac::DualMac::BLOCKS).
pub const BLOCKS: [usize; 3] = [4, 1, 2];

// Products of `groups` groups of four channels at thirty points, and the output transform of each column. A group is two loads of four words (two tiles' inputs,
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
    // of two rows, the sums of the first at r4: the difference in r5-r8, the sum where the second was
    ".macro sdp3_sum_and_difference",
    "ldm r4, {{r5-r8}}",
    "sub r5, r5, r2",
    "add r2, r5, r2, lsl #1",
    "sub r6, r6, r3",
    "add r3, r6, r3, lsl #1",
    "sub r7, r7, r12",
    "add r12, r7, r12, lsl #1",
    "sub r8, r8, lr",
    "add lr, r8, lr, lsl #1",
    ".endm",
    ".macro sdp3_onto_difference bits",
    "ldm r9, {{r2, r3, r12, lr}}",
    "add r2, r5, r2, lsl #\\bits",
    "add r3, r6, r3, lsl #\\bits",
    "add r12, r7, r12, lsl #\\bits",
    "add lr, r8, lr, lsl #\\bits",
    "stm r9, {{r2, r3, r12, lr}}",
    ".endm",
    ".macro sdp3_products groups",
    ".pushsection .text.sdp3_products_\\groups, \"ax\", %progbits",
    ".global sdp3_products_\\groups",
    ".type sdp3_products_\\groups, %function",
    ".p2align 2",
    ".thumb_func",
    "sdp3_products_\\groups:",
    "push {{r4-r11, lr}}",
    "add r3, r2, #320",
    "push {{r2, r3}}",
    "1:",
    "sdp3_point \\groups, 1", // row 5
    "ldr r4, [sp]",
    "add r5, r4, #48",
    "stm r5, {{r2, r3, r12, lr}}",
    "sdp3_point \\groups, 1", // row 3
    "ldr r4, [sp]",
    "stm r4, {{r2, r3, r12, lr}}",
    "sdp3_point \\groups, 1", // row 4
    "ldr r4, [sp]",
    "sdp3_sum_and_difference",
    "add r9, r4, #16",
    "stm r9!, {{r5-r8}}",
    "stm r9!, {{r2, r3, r12, lr}}",
    "ldm r9, {{r2, r3, r12, lr}}", // the difference of rows 3 and 4 onto row 5
    "add r2, r2, r5",
    "add r3, r3, r6",
    "add r12, r12, r7",
    "add lr, lr, r8",
    "stm r9, {{r2, r3, r12, lr}}",
    "sdp3_point \\groups, 1", // row 1
    "ldr r4, [sp]",
    "stm r4, {{r2, r3, r12, lr}}",
    "sdp3_point \\groups, 1", // row 2
    "ldr r4, [sp]",
    "sdp3_sum_and_difference",
    "stm r4, {{r2, r3, r12, lr}}",
    "add r9, r4, #16",
    "sdp3_onto_difference 1", // output row 1
    "add r9, r4, #48",
    "sdp3_onto_difference 3", // output row 3
    "ldm r4, {{r2, r3, r12, lr}}",
    "add r9, r4, #32",
    "ldm r9, {{r6, r7, r8, r10}}",
    "add r5, r2, r6, lsl #2", // output row 2, and what row 0 is added to
    "add r2, r2, r6",
    "add r6, r3, r7, lsl #2",
    "add r3, r3, r7",
    "add r7, r12, r8, lsl #2",
    "add r12, r12, r8",
    "add r8, lr, r10, lsl #2",
    "add lr, lr, r10",
    "stm r9, {{r5-r8}}",
    "sdp3_point \\groups, 0", // row 0
    "pop {{r4, r5}}",
    "stm r4, {{r2, r3, r12, lr}}",
    "add r4, r4, #64",
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

// The outputs of a block of two tiles: rows of two channels, one after the other. Of a row three sums are made of five, times the
// reciprocal of nine in r8, then requantised by r4-r7. r0: sums, which lie a word further for each tile and channel, r1:
// constants, r2: first pixel, r3: values of a row, r9: of a pixel; on the stack: the end of the constants.
global_asm!(
    ".macro sdp3_output sum, at:vararg",
    "mla \\sum, \\sum, r8, r4",
    "smmla lr, \\sum, r5, r6",
    "asr \\sum, \\sum, #31",
    "add lr, lr, \\sum, lsl #3",
    "asr lr, lr, r7",
    "ssat lr, #8, lr",
    "strb lr, [\\at]",
    ".endm",
    ".pushsection .text.sdp3_outputs, \"ax\", %progbits",
    ".global sdp3_outputs",
    ".type sdp3_outputs, %function",
    ".p2align 2",
    ".thumb_func",
    "sdp3_outputs:",
    "push {{r4-r11, lr}}",
    "ldr r9, [sp, #36]", // behind nine registers
    "add r8, r1, #32",
    "push {{r8}}",
    "movw r8, #0x8e39",
    "movt r8, #0x38e3",
    "1:",
    "ldm r1!, {{r4-r7}}",
    ".rept 2",
    ".rept 4",
    "ldr r11, [r0, #64]",
    "ldr r12, [r0, #128]",
    "ldr lr, [r0, #192]",
    "ldr r10, [r0], #16",
    "add r11, r11, r12",
    "sub r12, r11, r12, lsl #1",
    "add r10, r10, r11",
    "add r10, r10, lr",
    "add r12, r12, lr, lsl #1",
    "add r11, r11, lr, lsl #2",
    "ldr lr, [r0, #240]",
    "add r11, r11, lr",
    "sdp3_output r10, r2",
    "sdp3_output r12, r2, r9",
    "sdp3_output r11, r2, r9, lsl #1",
    "add r2, r2, r3",
    ".endr",
    "sub r0, r0, #60",
    ".endr",
    "sub r2, r2, r3, lsl #3",
    "add r2, r2, #1",
    "ldr r10, [sp]",
    "cmp r1, r10",
    "bne 1b",
    "add sp, sp, #4",
    "pop {{r4-r11, pc}}",
    ".size sdp3_outputs, . - sdp3_outputs",
    ".popsection",
);

unsafe extern "C" {
    fn sdp3_outputs(
        sums: *mut Sums,
        constants: *const [Constants; 2],
        values: *mut i8,
        row: usize,
        pixel: usize,
    );
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
    // SAFETY: each reads 30 GROUPS groups of inputs and of weights, which is what both arrays hold, and writes 320
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

/// The outputs of two channels of a block, of which `values` begins with the first.
///
/// # Safety
///
/// `values` is longer than seven rows, two pixels and one value.
#[inline(always)]
pub unsafe fn outputs(
    sums: &mut Sums,
    constants: &[Constants; 2],
    values: *mut i8,
    row: usize,
    pixel: usize,
) {
    // SAFETY: it reads the sums and both channels' constants, 320 and 32 bytes in words, and writes what the caller has checked.
    unsafe { sdp3_outputs(sums, constants, values, row, pixel) };
}
