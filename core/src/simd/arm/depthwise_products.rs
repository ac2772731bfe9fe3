//! Products of depthwise windows, two channels in a register: a tap of four channels takes 12 instructions.

use crate::simd::depthwise_products::DepthwiseWindow;
use core::arch::global_asm;

// r0: input, r1: weights, r2: where the window's sizes are, r3: the zero point twice, on the stack: sums. Sums live in r8-r11, values in r4 and r5,
// weights in r6 and r7; rows that are left in r12, columns that are left in lr. What comes after a row is on the stack.
global_asm!(
    concat!(".cpu ", env!("SDP3_ARM_CPU")),
    ".macro sdp3_depthwise_tap",
    "sxtb16 r4, r5",
    "sxtb16 r5, r5, ror #8",
    "sxtb16 r6, r7",
    "sxtb16 r7, r7, ror #8",
    "ssub16 r4, r4, r3",
    "ssub16 r5, r5, r3",
    "smlabb r8, r4, r6, r8",
    "smlabb r9, r5, r7, r9",
    "smlatt r10, r4, r6, r10",
    "smlatt r11, r5, r7, r11",
    ".endm",
    ".pushsection .text.sdp3_depthwise_products, \"ax\", %progbits",
    ".global sdp3_depthwise_products",
    ".type sdp3_depthwise_products, %function",
    ".p2align 2",
    ".thumb_func",
    "sdp3_depthwise_products:",
    "push {{r4-r11, lr}}",
    "ldm r2, {{r4-r8}}", // rows, columns, channels, from a row to the next of both
    "mov r12, r4",
    "cmp r5, #3",
    "mov r2, r6",
    "beq 3f",
    "mul lr, r5, r6",
    "sub r7, r7, lr", // behind the last column to the next row
    "sub r8, r8, lr",
    "push {{r5, r7, r8}}",
    "ldr r4, [sp, #48]", // behind three words and nine registers
    "ldm r4, {{r8-r11}}",
    "1:",
    "ldr lr, [sp]",
    "2:",
    "ldr r5, [r0]",
    "ldr r7, [r1]",
    "add r0, r0, r2",
    "add r1, r1, r2",
    "sdp3_depthwise_tap",
    "subs lr, lr, #1",
    "bne 2b",
    "ldrd r4, r5, [sp, #4]",
    "add r0, r0, r4",
    "add r1, r1, r5",
    "subs r12, r12, #1",
    "bne 1b",
    "b 5f",
    "3:", // three columns, without a loop
    "push {{r5, r7, r8}}",
    "ldr r4, [sp, #48]",
    "ldm r4, {{r8-r11}}",
    "4:",
    "ldr r5, [r0]",
    "ldr r7, [r1]",
    "sdp3_depthwise_tap",
    "ldr r5, [r0, r2]",
    "ldr r7, [r1, r2]",
    "sdp3_depthwise_tap",
    "ldr r5, [r0, r2, lsl #1]",
    "ldr r7, [r1, r2, lsl #1]",
    "sdp3_depthwise_tap",
    "ldrd r4, r5, [sp, #4]",
    "add r0, r0, r4",
    "add r1, r1, r5",
    "subs r12, r12, #1",
    "bne 4b",
    "5:",
    "ldr r4, [sp, #48]",
    "stm r4, {{r8-r11}}",
    "add sp, sp, #12",
    "pop {{r4-r11, pc}}",
    ".size sdp3_depthwise_products, . - sdp3_depthwise_products",
    ".popsection",
);

unsafe extern "C" {
    fn sdp3_depthwise_products(
        input: *const i8,
        weights: *const u8,
        window: *const DepthwiseWindow,
        zeros: i32,
        sums: *mut [i32; 4],
    );
}

/// [`crate::simd::depthwise_products::portable`] two values a register.
#[inline(always)]
pub fn depthwise_products(
    input: &[i8],
    weights: &[u8],
    window: &DepthwiseWindow,
    zero: i8,
    sums: &mut [i32; 4],
) {
    let [input_reach, weight_reach] = window.reach();
    let none = window.rows == 0 || window.columns == 0;
    if none || input.len() < input_reach || weights.len() < weight_reach {
        return;
    }
    let zeros = i32::from(zero) & 0xffff | i32::from(zero) << 16;
    // SAFETY: rows and columns are at least one, and of both it reads four bytes of every column of every row, the last of which end at
    // their reach, at any alignment; it reads and writes the sums.
    unsafe { sdp3_depthwise_products(input.as_ptr(), weights.as_ptr(), window, zeros, sums) };
}
