//! Helium, the vector extension of Armv8.1-M: eight 16-bit products and their sum an instruction.

use crate::simd::NativeDualMac;
use crate::simd::dual_mac::{Constants, I16x8, Sums, Tile, plain_products};
use core::arch::global_asm;

/// [`DualMac::BLOCKS`](crate::simd::dual_mac::DualMac::BLOCKS).
pub const BLOCKS: [usize; 3] = [6, 2, 1];

// As the DSP extension's products, with eight channels a group: two tiles' inputs in q0 and q1, two outputs' weights in q2 and q3.
// Sums of a point live in r4, r6, r8, r10, as the instruction wants even registers, then in a vector. r0: inputs, r1: weights, r2: where sums go, r3: their end.
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
    ".macro sdp3_wide_point groups, sums",
    "sdp3_wide_group 1",
    ".rept \\groups - 1",
    "sdp3_wide_group 0",
    ".endr",
    "vmov \\sums[2], \\sums[0], r4, r8",
    "vmov \\sums[3], \\sums[1], r6, r10",
    ".endm",
    ".macro sdp3_wide_products groups",
    ".pushsection .text.sdp3_wide_products_\\groups, \"ax\", %progbits",
    ".global sdp3_wide_products_\\groups",
    ".type sdp3_wide_products_\\groups, %function",
    ".p2align 2",
    ".thumb_func",
    "sdp3_wide_products_\\groups:",
    "push {{r4-r11, lr}}",
    "vpush {{d8-d15}}",
    "add r3, r2, #320",
    "1:",
    "sdp3_wide_point \\groups, q4", // row 5
    "sdp3_wide_point \\groups, q5", // row 3
    "sdp3_wide_point \\groups, q0", // row 4
    "vadd.i32 q6, q5, q0",
    "vsub.i32 q5, q5, q0",
    "vadd.i32 q4, q4, q5",
    "sdp3_wide_point \\groups, q7", // row 1
    "sdp3_wide_point \\groups, q0", // row 2
    "vsub.i32 q1, q7, q0",
    "vadd.i32 q7, q7, q0",
    "vshl.i32 q5, q5, #1",
    "vadd.i32 q5, q5, q1",
    "vstrw.32 q5, [r2, #16]", // output row 1
    "vshl.i32 q4, q4, #3",
    "vadd.i32 q4, q4, q1",
    "vstrw.32 q4, [r2, #48]", // output row 3
    "vshl.i32 q5, q6, #2",
    "vadd.i32 q5, q5, q7",
    "vstrw.32 q5, [r2, #32]", // output row 2
    "vadd.i32 q7, q7, q6",
    "sdp3_wide_point \\groups, q0", // row 0
    "vadd.i32 q7, q7, q0",
    "vstrw.32 q7, [r2], #64",
    "cmp r2, r3",
    "bne 1b",
    "vpop {{d8-d15}}",
    "pop {{r4-r11, pc}}",
    ".size sdp3_wide_products_\\groups, . - sdp3_wide_products_\\groups",
    ".popsection",
    ".endm",
    "sdp3_wide_products 1",
    "sdp3_wide_products 2",
    "sdp3_wide_products 4",
    "sdp3_wide_products 8",
);

// The outputs of a block of two tiles, for two channels and both tiles at once. Of a row three sums are made of five, times the
// reciprocal of nine in r8, then requantised: what they start with is in q4, multipliers in q5, offsets in q6, shifts in q7, where
// the four bytes lie in q3. r0: sums, the second of the three goes back there; r1: constants, r2, r6, r9: pixels, r3: values of a
// row; on the stack: values of a pixel.
global_asm!(
    ".macro sdp3_wide_output sum, rest, at",
    "vmul.i32 \\sum, \\sum, r8",
    "vadd.i32 \\sum, \\sum, q4",
    "vmulh.s32 \\rest, \\sum, q5",
    "vadd.i32 \\rest, \\rest, q6",
    "vshr.s32 \\sum, \\sum, #31",
    "vshl.i32 \\sum, \\sum, #3",
    "vadd.i32 \\rest, \\rest, \\sum",
    "vshl.s32 \\rest, \\rest, q7",
    "vqmovnb.s32 \\rest, \\rest",
    "vqmovnb.s16 \\rest, \\rest",
    "vstrb.32 \\rest, [\\at, q3]",
    ".endm",
    ".macro sdp3_of_channels vector, first, second",
    "vmov \\vector[2], \\vector[0], \\first, \\second",
    "vmov \\vector[3], \\vector[1], \\first, \\second",
    ".endm",
    ".pushsection .text.sdp3_wide_outputs, \"ax\", %progbits",
    ".global sdp3_wide_outputs",
    ".type sdp3_wide_outputs, %function",
    ".p2align 2",
    ".thumb_func",
    "sdp3_wide_outputs:",
    "push {{r4-r11, lr}}",
    "vpush {{d8-d15}}",
    "ldm r1, {{r4-r11}}",
    "rsb r7, r7, #0",
    "rsb r11, r11, #0",
    "sdp3_of_channels q4, r4, r8",
    "sdp3_of_channels q5, r5, r9",
    "sdp3_of_channels q6, r6, r10",
    "sdp3_of_channels q7, r7, r11",
    "movs r4, #0",
    "movs r5, #1",
    "vmov q3[2], q3[0], r4, r5",
    "lsls r4, r3, #2",
    "adds r5, r4, #1",
    "vmov q3[3], q3[1], r4, r5",
    "ldr r6, [sp, #100]", // behind nine registers and eight of twice the length
    "add r9, r2, r6, lsl #1",
    "add r6, r6, r2",
    "movw r8, #0x8e39",
    "movt r8, #0x38e3",
    ".rept 4",
    "vldrw.u32 q0, [r0, #64]",
    "vldrw.u32 q1, [r0, #128]",
    "vadd.i32 q2, q0, q1",
    "vsub.i32 q0, q0, q1",
    "vldrw.u32 q1, [r0, #192]",
    "vadd.i32 q0, q0, q1",
    "vadd.i32 q0, q0, q1",
    "vstrw.32 q0, [r0, #64]",
    "vldrw.u32 q0, [r0]",
    "vadd.i32 q0, q0, q2",
    "vadd.i32 q0, q0, q1",
    "vshl.i32 q1, q1, #2",
    "vadd.i32 q2, q2, q1",
    "vldrw.u32 q1, [r0, #256]",
    "vadd.i32 q2, q2, q1",
    "sdp3_wide_output q0, q1, r2",
    "sdp3_wide_output q2, q1, r9",
    "vldrw.u32 q0, [r0, #64]",
    "sdp3_wide_output q0, q1, r6",
    "vadd.i32 q3, q3, r3",
    "adds r0, r0, #16",
    ".endr",
    "vpop {{d8-d15}}",
    "pop {{r4-r11, pc}}",
    ".size sdp3_wide_outputs, . - sdp3_wide_outputs",
    ".popsection",
);

unsafe extern "C" {
    fn sdp3_wide_outputs(
        sums: *mut Sums,
        constants: *const [Constants; 2],
        values: *mut i8,
        row: usize,
        pixel: usize,
    );
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
    // SAFETY: each reads 30 GROUPS eights of inputs and of weights, which is what both arrays hold, and writes 320
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
    // SAFETY: it reads both channels' constants, 32 bytes in words, reads and writes the sums, 320 bytes in words, and writes what the caller has
    // checked. It saves the registers it must.
    unsafe { sdp3_wide_outputs(sums, constants, values, row, pixel) };
}
