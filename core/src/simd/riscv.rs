//! The multiplications of RV32IM, in an order that 28 registers hold.
//!
//! The module is compiled only for targets that have them: every `unsafe` below relies on it.

use crate::simd::conj_mac::{Chirp, ComplexI16, Sum};
use core::arch::global_asm;
use core::mem::MaybeUninit;

// The products of 125 reference samples with those of four blocks, 250 samples apart. Each is turned back by as many quarters as its block's number times its own,
// so that four samples have all turns. a0: the third block's sample, a1: reference, a2: where sums go, a3: the reference's end. The reference is in a4, a5, a sample
// in a6, a7, its product in t0, t1. Sums live in t3-t6 and s0-s11: low and
// high word of both parts, block by block.
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
    fn sdp3_four_blocks(
        samples: *const ComplexI16,
        reference: *const ComplexI16,
        sums: *mut [[Sum; 2]; 4],
    );
}

/// [`eight_blocks`](crate::simd::conj_mac::eight_blocks) of a reference that repeats itself every 250 samples but for quarter turns, as
/// [`CHIRP`](crate::signal::dechirp::CHIRP) does: `s[n + 250 k] = i^(k n + k mod 2) s[n]`, n from 1. A reference sample is loaded once for four products.
pub fn eight_blocks(samples: &Chirp, reference: &Chirp, sums: &mut [[i64; 2]; 8]) {
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
}
