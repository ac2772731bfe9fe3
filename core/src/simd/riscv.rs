//! The multiplications of RV32IM, in an order that 28 registers hold.
//!
//! The module is compiled only for targets that have them: every `unsafe` below relies on it.

use crate::simd::conj_mac::{Chirp, ComplexI16, Sum};
use crate::simd::dual_mac::{DualMac, I16x8, Sums, Tile, plain_products};
use core::arch::global_asm;
use core::mem::MaybeUninit;

// The products of 125 reference samples with those of four blocks, 250 samples apart. Sample n of block k is turned back by k n
// quarters, so that four samples have all turns. a0: the third block's sample, a1: reference, a2: where sums go, a3: the last of
// the reference, which has no turn. The reference is in a4, a5, a sample in a6, a7, its product in t0, t1. Sums live in t3-t6 and
// s0-s11: low and high word of both parts, block by block.
global_asm!(
    ".option push",
    ".option arch, +m",
    #[cfg(target_feature = "c")]
    ".option arch, +c",
    ".macro sdp3_add op, low, high, value",
    "\\op \\low, \\low, \\value",
    "srai t2, \\value, 16",
    "\\op \\high, \\high, t2",
    ".endm",
    ".macro sdp3_product at, turns, low, high, low2, high2",
    "lh a6, \\at(a0)",
    "lh a7, \\at+2(a0)",
    "mul t0, a6, a4",
    "mul t2, a7, a5",
    "add t0, t0, t2",
    "mul t1, a7, a4",
    "mul t2, a6, a5",
    "sub t1, t1, t2",
    ".if \\turns == 0",
    "sdp3_add add, \\low, \\high, t0",
    "sdp3_add add, \\low2, \\high2, t1",
    ".elseif \\turns == 1",
    "sdp3_add add, \\low, \\high, t1",
    "sdp3_add sub, \\low2, \\high2, t0",
    ".elseif \\turns == 2",
    "sdp3_add sub, \\low, \\high, t0",
    "sdp3_add sub, \\low2, \\high2, t1",
    ".else",
    "sdp3_add sub, \\low, \\high, t1",
    "sdp3_add add, \\low2, \\high2, t0",
    ".endif",
    ".endm",
    ".macro sdp3_sample number",
    "lh a4, 4*\\number(a1)",
    "lh a5, 4*\\number+2(a1)",
    "sdp3_product 4*\\number-2000, 0, t3, t4, t5, t6",
    "sdp3_product 4*\\number-1000, \\number, s0, s1, s2, s3",
    "sdp3_product 4*\\number, (2*\\number)%4, s4, s5, s6, s7",
    "sdp3_product 4*\\number+1000, (3*\\number)%4, s8, s9, s10, s11",
    ".endm",
    ".pushsection .text.sdp3_four_blocks, \"ax\", @progbits",
    ".global sdp3_four_blocks",
    ".type sdp3_four_blocks, @function",
    ".p2align 2",
    "sdp3_four_blocks:",
    "addi sp, sp, -48",
    ".irp number, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11",
    "sw s\\number, 4*\\number(sp)",
    ".endr",
    ".irp sum, t3, t4, t5, t6, s0, s1, s2, s3, s4, s5, s6, s7, s8, s9, s10, s11",
    "li \\sum, 0",
    ".endr",
    "addi a0, a0, 2000",
    "addi a3, a1, 496",
    "1:",
    "sdp3_sample 0",
    "beq a1, a3, 2f",
    "sdp3_sample 1",
    "sdp3_sample 2",
    "sdp3_sample 3",
    "addi a0, a0, 16",
    "addi a1, a1, 16",
    "j 1b",
    "2:",
    ".irp sum, t3, t4, t5, t6, s0, s1, s2, s3, s4, s5, s6, s7, s8, s9, s10, s11",
    "sw \\sum, 0(a2)",
    "addi a2, a2, 4",
    ".endr",
    ".irp number, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11",
    "lw s\\number, 4*\\number(sp)",
    ".endr",
    "addi sp, sp, 48",
    "ret",
    ".size sdp3_four_blocks, . - sdp3_four_blocks",
    ".popsection",
    ".option pop",
);

unsafe extern "C" {
    fn sdp3_four_blocks(samples: *const ComplexI16, reference: *const ComplexI16, sums: *mut [[Sum; 2]; 4]);
}

/// [`eight_blocks`](crate::simd::conj_mac::eight_blocks) of a reference that repeats itself every 250 samples but for quarter turns, as
/// [`CHIRP`](crate::signal::dechirp::CHIRP) does: `s[n + 250 k] = i^(k n + k mod 2) s[n]`, n from 1. A reference sample is loaded once for four products.
#[inline]
pub fn eight_blocks(samples: &Chirp, reference: &Chirp) -> [[i64; 2]; 8] {
    let mut sums = [[0; 2]; 8];
    for half in 0..2 {
        let mut found = MaybeUninit::<[[Sum; 2]; 4]>::uninit();
        let [samples, reference] = [samples, reference].map(|from| from.as_ptr().wrapping_add(125 * half));
        // SAFETY: it reads 125 samples of the reference and of each of four blocks 250 samples apart, 875 samples in all, from the first or
        // the 126th of a thousand on, and writes 64 bytes, which is what is found.
        let found = unsafe {
            sdp3_four_blocks(samples, reference, found.as_mut_ptr());
            found.assume_init_ref()
        };
        // every second block belongs to this half; all of a block is turned back by what its first sample is
        for (k, (sum, [re, im])) in sums.iter_mut().skip(half).step_by(2).zip(found).enumerate() {
            let (re, im) = (re.short_value(), im.short_value());
            *sum = match (k * (125 * half + 1) + k % 2) % 4 {
                0 => [re, im],
                1 => [im, -re],
                2 => [-re, -im],
                _ => [-im, re],
            };
        }
    }
    sums
}

/// Products in scalar registers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct NativeDualMac;

impl DualMac for NativeDualMac {
    #[inline]
    fn products<const GROUPS: usize>(self, inputs: &Tile<GROUPS>, weights: &Tile<GROUPS>, sums: &mut Sums) {
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
            _ => plain_products::<Self, GROUPS>(inputs, weights, sums),
        }
    }
}

// Products of `groups` groups of four channels at thirty points, and the output transform of each column. a0: inputs, a1:
// weights, a2: where sums go, a3: their end. Two tiles' inputs are in t0, t1, two outputs' weights in t2, t3; four points' sums
// live in a4-a7, s0-s3, s4-s7 and s8-s11. Of many groups four are done at a time, until a0 is t6.
global_asm!(
    ".option push",
    ".option arch, +m",
    #[cfg(target_feature = "c")]
    ".option arch, +c",
    ".macro sdp3_accumulate sum, input, weight",
    "mul t4, \\input, \\weight",
    "add \\sum, \\sum, t4",
    ".endm",
    ".macro sdp3_channel at, s0, s1, s2, s3",
    "lh t0, \\at(a0)",
    "lh t1, \\at+8(a0)",
    "lh t2, \\at(a1)",
    "lh t3, \\at+8(a1)",
    "sdp3_accumulate \\s0, t0, t2",
    "sdp3_accumulate \\s1, t1, t2",
    "sdp3_accumulate \\s2, t0, t3",
    "sdp3_accumulate \\s3, t1, t3",
    ".endm",
    ".macro sdp3_group at, s0, s1, s2, s3",
    "sdp3_channel \\at, \\s0, \\s1, \\s2, \\s3",
    "sdp3_channel \\at+2, \\s0, \\s1, \\s2, \\s3",
    "sdp3_channel \\at+4, \\s0, \\s1, \\s2, \\s3",
    "sdp3_channel \\at+6, \\s0, \\s1, \\s2, \\s3",
    ".endm",
    ".macro sdp3_onto groups, s0, s1, s2, s3",
    ".if \\groups > 4",
    "addi t6, a0, 16*\\groups",
    "2:",
    ".endif",
    "sdp3_group 0, \\s0, \\s1, \\s2, \\s3",
    ".if \\groups > 1",
    "sdp3_group 16, \\s0, \\s1, \\s2, \\s3",
    ".endif",
    ".if \\groups > 2",
    "sdp3_group 32, \\s0, \\s1, \\s2, \\s3",
    "sdp3_group 48, \\s0, \\s1, \\s2, \\s3",
    ".endif",
    ".if \\groups > 4",
    "addi a0, a0, 64",
    "addi a1, a1, 64",
    "bne a0, t6, 2b",
    ".else",
    "addi a0, a0, 16*\\groups",
    "addi a1, a1, 16*\\groups",
    ".endif",
    ".endm",
    ".macro sdp3_point groups, s0, s1, s2, s3",
    ".irp sum, \\s0, \\s1, \\s2, \\s3",
    "li \\sum, 0",
    ".endr",
    "sdp3_onto \\groups, \\s0, \\s1, \\s2, \\s3",
    ".endm",
    // of two points' sums the difference where the first was, the sum where the second was
    ".macro sdp3_difference_and_sum first, second",
    "sub \\first, \\first, \\second",
    "slli t0, \\second, 1",
    "add \\second, \\first, t0",
    ".endm",
    // one of four sums of rows 3 and 4: onto that of row 5
    ".macro sdp3_far at, five, three, four",
    "sdp3_difference_and_sum \\three, \\four",
    "add \\five, \\five, \\three",
    "sw \\five, 48+\\at(a2)",
    ".endm",
    // one of four sums of all rows but 0, which it is added to
    ".macro sdp3_near at, one, two, difference, sum",
    "sdp3_difference_and_sum \\one, \\two",
    "slli t0, \\difference, 1",
    "add t0, t0, \\one",
    "sw t0, 16+\\at(a2)",
    "lw t0, 48+\\at(a2)",
    "slli t0, t0, 3",
    "add t0, t0, \\one",
    "sw t0, 48+\\at(a2)",
    "slli t0, \\sum, 2",
    "add t0, t0, \\two",
    "sw t0, 32+\\at(a2)",
    "add \\two, \\two, \\sum",
    ".endm",
    ".macro sdp3_products groups",
    ".pushsection .text.sdp3_products_\\groups, \"ax\", @progbits",
    ".global sdp3_products_\\groups",
    ".type sdp3_products_\\groups, @function",
    ".p2align 2",
    "sdp3_products_\\groups:",
    "addi sp, sp, -48",
    ".irp number, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11",
    "sw s\\number, 4*\\number(sp)",
    ".endr",
    "addi a3, a2, 320",
    "1:",
    "sdp3_point \\groups, a4, a5, a6, a7", // row 5
    "sdp3_point \\groups, s0, s1, s2, s3", // row 3
    "sdp3_point \\groups, s4, s5, s6, s7", // row 4
    "sdp3_far 0, a4, s0, s4",
    "sdp3_far 4, a5, s1, s5",
    "sdp3_far 8, a6, s2, s6",
    "sdp3_far 12, a7, s3, s7",
    "sdp3_point \\groups, a4, a5, a6, a7",   // row 1
    "sdp3_point \\groups, s8, s9, s10, s11", // row 2
    "sdp3_near 0, a4, s8, s0, s4",
    "sdp3_near 4, a5, s9, s1, s5",
    "sdp3_near 8, a6, s10, s2, s6",
    "sdp3_near 12, a7, s11, s3, s7",
    "sdp3_onto \\groups, s8, s9, s10, s11", // row 0
    "sw s8, 0(a2)",
    "sw s9, 4(a2)",
    "sw s10, 8(a2)",
    "sw s11, 12(a2)",
    "addi a2, a2, 64",
    "bne a2, a3, 1b",
    ".irp number, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11",
    "lw s\\number, 4*\\number(sp)",
    ".endr",
    "addi sp, sp, 48",
    "ret",
    ".size sdp3_products_\\groups, . - sdp3_products_\\groups",
    ".popsection",
    ".endm",
    "sdp3_products 1",
    "sdp3_products 2",
    "sdp3_products 4",
    "sdp3_products 8",
    "sdp3_products 16",
    ".option pop",
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
