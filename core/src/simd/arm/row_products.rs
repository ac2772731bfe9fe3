//! Products with four rows of weights by dual multiply-accumulates: sixteen of them take 28 instructions.

use crate::simd::row_products::portable;
use core::arch::global_asm;

// r0: values, r1: where the addresses of four rows are, r2: fours of values, at least one, r3: the zero point twice, on the stack: sums.
// Rows live in r4-r7, sums in r8-r11; of four values the first and third are in r12, the others in r1.
global_asm!(
    concat!(".cpu ", env!("SDP3_ARM_CPU")),
    ".pushsection .text.sdp3_row_products, \"ax\", %progbits",
    ".global sdp3_row_products",
    ".type sdp3_row_products, %function",
    ".p2align 2",
    ".thumb_func",
    "sdp3_row_products:",
    "push {{r4-r11, lr}}",
    "push {{r3}}",
    "ldr r12, [sp, #40]", // behind a word and nine registers
    "ldm r12, {{r8-r11}}",
    "ldm r1, {{r4-r7}}",
    "1:",
    "ldr r3, [r0], #4",
    "ldr lr, [sp]",
    "sxtb16 r12, r3",
    "sxtb16 r3, r3, ror #8",
    "ssub16 r12, r12, lr",
    "ssub16 r1, r3, lr",
    ".macro sdp3_row row, sum",
    "ldr lr, [\\row], #4",
    "sxtb16 r3, lr",
    "smlad \\sum, r12, r3, \\sum",
    "sxtb16 lr, lr, ror #8",
    "smlad \\sum, r1, lr, \\sum",
    ".endm",
    "sdp3_row r4, r8",
    "sdp3_row r5, r9",
    "sdp3_row r6, r10",
    "sdp3_row r7, r11",
    "subs r2, r2, #1",
    "bne 1b",
    "ldr r12, [sp, #40]",
    "stm r12, {{r8-r11}}",
    "add sp, sp, #4",
    "pop {{r4-r11, pc}}",
    ".size sdp3_row_products, . - sdp3_row_products",
    ".popsection",
);

unsafe extern "C" {
    fn sdp3_row_products(
        values: *const i8,
        rows: *const [*const u8; 4],
        fours: usize,
        zeros: i32,
        sums: *mut [i32; 4],
    );
}

/// [`crate::simd::row_products::portable`] by dual multiply-accumulates.
#[inline]
pub fn row_products(values: &[i8], rows: [&[u8]; 4], zero: i8, sums: &mut [i32; 4]) {
    let length = rows.iter().fold(values.len(), |least, row| least.min(row.len()));
    let fours = length / 4;
    if fours > 0 {
        let zeros = i32::from(zero) & 0xffff | i32::from(zero) << 16;
        // SAFETY: it reads 4 `fours` bytes of the values and of each row, which are at least as long, at any alignment, and the 16 bytes of
        // their addresses, and reads and writes the 16 bytes of the sums; addresses and sums are words.
        unsafe { sdp3_row_products(values.as_ptr(), &rows.map(<[u8]>::as_ptr), fours, zeros, sums) };
    }
    let rest = rows.map(|row| row.get(4 * fours..).unwrap_or(&[]));
    portable(values.get(4 * fours..).unwrap_or(&[]), rest, zero, sums);
}
