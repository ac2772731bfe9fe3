//! The DSP extension of Armv7E-M and Armv8-M, two 16-bit products an instruction, and Helium, eight: behind [`DualMac`].
//!
//! The module is compiled only for targets that have the extension: every `unsafe` below relies on it.

#[cfg(feature = "graph")]
mod depthwise_products;
mod patch_pairs;
#[cfg(feature = "graph")]
mod patch_products;
#[cfg(feature = "graph")]
pub use depthwise_products::depthwise_products;
#[cfg_attr(arm_mve, path = "helium.rs")]
#[cfg_attr(not(arm_mve), path = "dsp.rs")]
mod products;
pub mod upper_words;
pub use patch_pairs::largest_of_pairs;
#[cfg(feature = "graph")]
pub use patch_products::{patch_products, widen};

use crate::simd::conj_mac::{self, Chirp, ComplexI16, portable};
use crate::simd::dual_mac::{BLOCK_ROWS, Constants, DualMac, Pixels, Sums, Tile, plain_outputs};
use core::arch::global_asm;
use core::mem::MaybeUninit;

/// The DSP extension, with Helium's products where there is Helium.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct NativeDualMac;

impl DualMac for NativeDualMac {
    const WIDE: bool = cfg!(arm_mve);
    const BLOCKS: [usize; 3] = products::BLOCKS;

    #[inline]
    fn products<const GROUPS: usize>(self, inputs: &Tile<GROUPS>, weights: &Tile<GROUPS>, sums: &mut Sums) {
        products::products(inputs, weights, sums);
    }

    #[inline(always)]
    fn outputs<const GROUPS: usize>(
        self,
        sums: &mut Sums,
        constants: &[Constants; 2],
        values: &mut [i8],
        row: usize,
        channel: usize,
    ) {
        let (pixel, first) = (4 * GROUPS, channel % (4 * GROUPS) & !1);
        let whole = row < 1 << 24 && values.len() >= (BLOCK_ROWS - 1) * row + size_of::<Pixels<GROUPS>>();
        if !whole {
            return plain_outputs::<GROUPS>(sums, constants, values, row, channel);
        }
        // SAFETY: from the first of two channels of a pixel on there are seven rows and the rest of three pixels.
        unsafe { products::outputs(sums, constants, values.as_mut_ptr().wrapping_add(first), row, pixel) };
    }
}

// Sums of products with the conjugate reference: eight blocks of 125 samples, unrolled, or one block of any length, four
// samples at a time: four instructions with Helium, ten without. r0: samples, r1: reference. Sums live in r2, r3 (real) and
// r4, r5 (imaginary part).
// sdp3_conj_mac_8x125: r2: where sums go. sdp3_conj_mac_block: r2: fours of samples, r3: single ones, on the stack: where sums go.
global_asm!(
    concat!(".cpu ", env!("SDP3_ARM_CPU")),
    ".macro sdp3_conj_mac x, s",
    "smlald r2, r3, \\x, \\s",
    "smlsldx r4, r5, \\s, \\x",
    ".endm",
    ".macro sdp3_conj_mac_four",
    #[cfg(arm_mve)]
    "vldrw.u32 q0, [r0], #16
    vldrw.u32 q1, [r1], #16
    vmlaldava.s16 r2, r3, q0, q1
    vmlsldavax.s16 r4, r5, q0, q1",
    #[cfg(not(arm_mve))]
    "ldmia r0!, {{r6-r9}}
    ldmia r1!, {{r10-r12, lr}}
    sdp3_conj_mac r6, r10
    sdp3_conj_mac r7, r11
    sdp3_conj_mac r8, r12
    sdp3_conj_mac r9, lr",
    ".endm",
    ".macro sdp3_conj_mac_one",
    "ldr r6, [r0], #4",
    "ldr r10, [r1], #4",
    "sdp3_conj_mac r6, r10",
    ".endm",
    ".macro sdp3_zero_sums",
    "movs r2, #0",
    "movs r3, #0",
    "movs r4, #0",
    "movs r5, #0",
    ".endm",
    ".pushsection .text.sdp3_conj_mac_8x125, \"ax\", %progbits",
    ".global sdp3_conj_mac_8x125",
    ".type sdp3_conj_mac_8x125, %function",
    ".p2align 2",
    ".thumb_func",
    "sdp3_conj_mac_8x125:",
    "push {{r4-r11, lr}}",
    "add r3, r2, #128",
    "push {{r2, r3}}",
    "1:",
    "sdp3_zero_sums",
    ".rept 31",
    "sdp3_conj_mac_four",
    ".endr",
    "sdp3_conj_mac_one",
    "pop {{r6, r7}}",
    "stmia r6!, {{r2-r5}}",
    "push {{r6, r7}}",
    "cmp r6, r7",
    "bne 1b",
    "add sp, sp, #8",
    "pop {{r4-r11, pc}}",
    ".size sdp3_conj_mac_8x125, . - sdp3_conj_mac_8x125",
    ".popsection",
    ".pushsection .text.sdp3_conj_mac_block, \"ax\", %progbits",
    ".global sdp3_conj_mac_block",
    ".type sdp3_conj_mac_block, %function",
    ".p2align 2",
    ".thumb_func",
    "sdp3_conj_mac_block:",
    "push {{r4-r11, lr}}",
    "push {{r2, r3}}", // fours, ones
    "sdp3_zero_sums",
    "1:",
    "ldr r6, [sp]",
    "subs r6, r6, #1",
    "bmi 2f",
    "str r6, [sp]",
    "sdp3_conj_mac_four",
    "b 1b",
    "2:",
    "ldr r6, [sp, #4]",
    "subs r6, r6, #1",
    "bmi 3f",
    "str r6, [sp, #4]",
    "sdp3_conj_mac_one",
    "b 2b",
    "3:",
    "ldr r6, [sp, #44]", // behind two words and nine registers
    "stmia r6!, {{r2-r5}}",
    "add sp, sp, #8",
    "pop {{r4-r11, pc}}",
    ".size sdp3_conj_mac_block, . - sdp3_conj_mac_block",
    ".popsection",
);

unsafe extern "C" {
    fn sdp3_conj_mac_8x125(
        samples: *const ComplexI16,
        reference: *const ComplexI16,
        sums: *mut [[i64; 2]; 8],
    );
    fn sdp3_conj_mac_block(
        samples: *const ComplexI16,
        reference: *const ComplexI16,
        fours: usize,
        ones: usize,
        sums: *mut [i64; 2],
    );
}

/// [`crate::simd::conj_mac::portable`] by dual multiply-accumulates with 64-bit sums, for samples that begin at a word.
#[inline]
pub fn conj_mac(samples: &[ComplexI16], reference: &[ComplexI16], block: usize, sums: &mut [[i64; 2]]) {
    if !(samples.as_ptr() as usize | reference.as_ptr() as usize).is_multiple_of(4) {
        return portable(samples, reference, block, sums);
    }
    let blocks = samples.chunks_exact(block.max(1)).zip(reference.chunks_exact(block.max(1)));
    for (sum, (samples, reference)) in sums.iter_mut().zip(blocks) {
        // SAFETY: it reads `block` samples of each and writes 16 bytes; samples are words and the first begins at a word.
        unsafe { sdp3_conj_mac_block(samples.as_ptr(), reference.as_ptr(), block / 4, block % 4, sum) };
    }
}

/// [`crate::simd::conj_mac::eight_blocks`] in the same way.
#[inline]
pub fn eight_blocks(samples: &Chirp, reference: &Chirp) -> [[i64; 2]; 8] {
    if !(samples.as_ptr() as usize | reference.as_ptr() as usize).is_multiple_of(4) {
        return conj_mac::eight_blocks(samples, reference);
    }
    let mut sums = MaybeUninit::uninit();
    // SAFETY: it reads 1000 samples of each and writes 128 bytes, which is what the sums are; all begin at a word.
    unsafe {
        sdp3_conj_mac_8x125(samples.as_ptr(), reference.as_ptr(), sums.as_mut_ptr());
        sums.assume_init()
    }
}
