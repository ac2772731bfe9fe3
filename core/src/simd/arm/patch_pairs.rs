//! The stem's inner loop by dual multiply-accumulates: 52 instructions a value.

use crate::simd::patch_pairs::{PatchPairs, WORDS};
use core::arch::global_asm;

// r0: pairs of four outputs, r1: words of a channel, r2: value; on the stack: the last value's end. Weights live in r3-r7, the
// start in r8, the largest sum in r9, a sum in r10, pairs in r11, r12, lr.
global_asm!(
    concat!(".cpu ", env!("SDP3_ARM_CPU")),
    ".macro sdp3_sum_of_pairs sum",
    "ldm r0!, {{r11, r12, lr}}",
    "smlad \\sum, r11, r3, r8",
    "smlad \\sum, r12, r4, \\sum",
    "smlad \\sum, lr, r5, \\sum",
    "ldrd r11, r12, [r0], #8",
    "smlad \\sum, r11, r6, \\sum",
    "smlad \\sum, r12, r7, \\sum",
    ".endm",
    ".pushsection .text.sdp3_largest_of_pairs, \"ax\", %progbits",
    ".global sdp3_largest_of_pairs",
    ".type sdp3_largest_of_pairs, %function",
    ".p2align 2",
    ".thumb_func",
    "sdp3_largest_of_pairs:",
    "push {{r4-r11, lr}}",
    "add r3, r3, r2",
    "push {{r3}}",
    "1:",
    "ldm r1, {{r3-r7}}",
    "ldr r8, [r1, #64]",
    "sdp3_sum_of_pairs r9",
    ".rept 3",
    "sdp3_sum_of_pairs r10",
    "cmp r9, r10",
    "it lt",
    "movlt r9, r10",
    ".endr",
    "ldrd r11, r12, [r1, #68]",
    "ldr lr, [r1, #76]",
    "smmla r10, r9, r11, r12",
    "asr r9, r9, #31",
    "add r10, r10, r9, lsl #1",
    "asr r10, r10, lr",
    "ssat r10, #8, r10",
    "strb r10, [r2], #1",
    "sub r0, r0, #80",
    "add r1, r1, #80",
    "ldr r3, [sp]",
    "cmp r2, r3",
    "bne 1b",
    "add sp, sp, #4",
    "pop {{r4-r11, pc}}",
    ".size sdp3_largest_of_pairs, . - sdp3_largest_of_pairs",
    ".popsection",
);

unsafe extern "C" {
    fn sdp3_largest_of_pairs(
        pairs: *const PatchPairs,
        channels: *const [i32; WORDS],
        values: *mut i8,
        count: usize,
    );
}

/// [`crate::simd::patch_pairs::portable`] by dual multiply-accumulates.
#[inline(always)]
pub fn largest_of_pairs(pairs: &PatchPairs, channels: &[[i32; WORDS]], values: &mut [i8]) {
    let count = channels.len().min(values.len());
    if count > 0 {
        // SAFETY: it reads the pairs and the words of `count` channels, 80 bytes each in words, and writes as many values, at least one.
        unsafe { sdp3_largest_of_pairs(pairs, channels.as_ptr(), values.as_mut_ptr(), count) };
    }
}
