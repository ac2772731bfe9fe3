//! Dual multiply-accumulates of i16: what the network's Winograd kernels need of a processor.
//!
//! A kernel is written once over [`DualMac`]. [`Plain`] is the portable reference; `arm` has the DSP extension of Cortex-M4,
//! M7, M33 and later, and Helium of M52, M55 and M85, `riscv` the multiplications of RV32IM. All operations are integer and exact:
//! the same bits.

use crate::dsn::winograd::{FACTOR_BITS, NINTH, outputs_of_column, outputs_of_row};
use crate::fixed::Requantizer;
use bytemuck::must_cast_ref;

/// Eight i16 in four words: four successive channels of two tiles or two outputs; in the wide order eight of one, and the same of
/// the other in the next.
pub type I16x8 = [i32; 4];

/// Rows of the points of a tile.
pub const POINT_ROWS: usize = 6;

/// Points of a tile: 6 x 5 products give 4 x 3 outputs.
pub const POINTS: usize = 5 * POINT_ROWS;

/// Two tiles' values or two outputs' weights in the Winograd domain: `GROUPS` groups of four channels at 30 points, column by
/// column, rows in the order 5, 3, 4, 1, 2, 0.
pub(crate) type Tile<const GROUPS: usize> = [[I16x8; GROUPS]; POINTS];

/// Sums of two tiles and two outputs, `[column][row][output, tile]`, already gathered from six points to four rows.
pub(crate) type Sums = [[[i32; 4]; 4]; 5];

/// Rows of outputs of a tile.
pub const TILE_ROWS: usize = 4;

/// Rows of outputs of a block, which is two tiles, one below the other.
pub const BLOCK_ROWS: usize = 2 * TILE_ROWS;

/// Columns of outputs of a tile and of a block.
pub const BLOCK_COLUMNS: usize = 3;

/// Pixels of a row of a block, of `GROUPS` groups of four channels.
pub(crate) type Pixels<const GROUPS: usize> = [[[i8; 4]; GROUPS]; BLOCK_COLUMNS];

/// What an output channel's sums are finished by: what a multiple of the sum starts with, then its [`Requantizer`].
pub(crate) type Constants = [i32; 1 + Requantizer::WORDS];

/// Arithmetic on i16. A value of an implementing type is the proof that the processor has the instructions.
pub trait DualMac: Copy {
    /// Whether a `Tile` of an even number of groups is in the wide order.
    const WIDE: bool = false;
    /// Blocks of two tiles that a step of a convolution of 8 and of 16 channels does, and steps of a block of 32: some 40 000
    /// instructions, here 72 000 on RV32IMAC.
    const BLOCKS: [usize; 3] = [3, 1, 4];

    /// For each column of points the products summed over all channels, and the output transform of the column. Wraps.
    fn products<const GROUPS: usize>(self, inputs: &Tile<GROUPS>, weights: &Tile<GROUPS>, sums: &mut Sums);

    /// The output transform of the rows of the sums, and requantisation: channels `channel`, which is even, and the next of a
    /// block. Its rows are `row` values apart, the first pixel is that of `values`; rows that are not there are left out. The sums
    /// may be overwritten.
    #[inline(always)]
    fn outputs<const GROUPS: usize>(
        self,
        sums: &mut Sums,
        constants: &[Constants; 2],
        values: &mut [i8],
        row: usize,
        channel: usize,
    ) {
        plain_outputs::<GROUPS>(sums, constants, values, row, channel);
    }
}

/// Where group `group` of `GROUPS` of tile or output `part` lies: which [`I16x8`], and its first word.
#[inline(always)]
pub const fn lane<P: DualMac, const GROUPS: usize>(group: usize, part: usize) -> (usize, usize) {
    if P::WIDE && GROUPS.is_multiple_of(2) { (group & !1 | part, 2 * (group & 1)) } else { (group, 2 * part) }
}

/// Up to four int8 values as pairs of u8 = i8 + 128: the first and third, the second and fourth. What is not there is anything.
///
/// A pair (l, h) is the number h 2^16 + l, so that sums and shifts of pairs are those of numbers; [`settle`] ends it.
#[inline(always)]
pub fn widen<const N: usize>(values: &[i8; N]) -> [i32; 2] {
    let byte = |k: usize| if k < N { values[k % N] as u8 } else { 0 };
    if cfg!(target_arch = "riscv32") {
        // without unaligned loads the bytes come one by one
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| i32::from(byte(k)));
        return [a | c << 16, b | d << 16].map(|pair| pair ^ 0x0080_0080);
    }
    let word = u32::from_le_bytes([0, 1, 2, 3].map(byte)) ^ 0x8080_8080;
    [word, word >> 8].map(|pair| (pair & 0x00ff_00ff) as i32)
}

/// The two i16 of a pair, each in its half of a word; each fits i16.
#[inline(always)]
pub fn settle(pair: i32) -> i32 {
    // a negative lower half has taken one from the upper
    pair.wrapping_add((pair & 0x8000) << 1)
}

/// The i16 of words, in pairs that lie alike in inputs and weights.
#[inline(always)]
fn halves(words: &I16x8) -> &[i16; 8] {
    must_cast_ref(words)
}

/// `[output, tile]`: the sums over channels, of one point.
#[inline(always)]
fn sums_of_point<P: DualMac, const GROUPS: usize>(
    inputs: &[I16x8; GROUPS],
    weights: &[I16x8; GROUPS],
) -> [i32; 4] {
    let mut sums = [0; 4];
    if P::WIDE && GROUPS.is_multiple_of(2) {
        let (inputs, weights) = (inputs.as_chunks().0, weights.as_chunks().0);
        for ([x0, x1], [w0, w1]) in inputs.iter().zip(weights) {
            add_products([x0, x1].map(halves), [w0, w1].map(halves), &mut sums);
        }
    } else {
        for (x, w) in inputs.iter().zip(weights) {
            if let ([x0, x1], [w0, w1]) = (halves(x).as_chunks::<4>().0, halves(w).as_chunks::<4>().0) {
                add_products([x0, x1], [w0, w1], &mut sums);
            }
        }
    }
    sums
}

/// Adds the products of as many channels of two tiles and two outputs.
#[inline(always)]
fn add_products<const N: usize>([x0, x1]: [&[i16; N]; 2], [w0, w1]: [&[i16; N]; 2], sums: &mut [i32; 4]) {
    let [mut s00, mut s01, mut s10, mut s11] = *sums;
    for k in 0..N {
        let [x0, x1, w0, w1] = [x0[k], x1[k], w0[k], w1[k]].map(i32::from);
        s00 = s00.wrapping_add(x0 * w0);
        s01 = s01.wrapping_add(x1 * w0);
        s10 = s10.wrapping_add(x0 * w1);
        s11 = s11.wrapping_add(x1 * w1);
    }
    *sums = [s00, s01, s10, s11];
}

/// [`DualMac::products`] in plain Rust, in the order of `P`.
#[inline(always)]
pub fn plain_products<P: DualMac, const GROUPS: usize>(
    inputs: &Tile<GROUPS>,
    weights: &Tile<GROUPS>,
    sums: &mut Sums,
) {
    let ((inputs, _), (weights, _)) = (inputs.as_chunks::<POINT_ROWS>(), weights.as_chunks::<POINT_ROWS>());
    let mut points = [[0; 4]; POINT_ROWS];
    for ((inputs, weights), sums) in inputs.iter().zip(weights).zip(sums) {
        for ((inputs, weights), point) in inputs.iter().zip(weights).zip(&mut points) {
            *point = sums_of_point::<P, GROUPS>(inputs, weights);
        }
        for k in 0..4 {
            let outputs = outputs_of_column(points.map(|point| point[k]));
            sums.iter_mut().zip(outputs).for_each(|(sums, output)| sums[k] = output);
        }
    }
}

/// [`DualMac::outputs`] in plain Rust.
#[inline(never)]
pub fn plain_outputs<const GROUPS: usize>(
    sums: &Sums,
    constants: &[Constants; 2],
    values: &mut [i8],
    row: usize,
    channel: usize,
) {
    /// Words of a column of sums: of each row two outputs and two tiles.
    const COLUMN: usize = 4 * TILE_ROWS;
    let sums = sums.as_flattened().as_flattened();
    for (output, &[start, ref scale @ ..]) in constants.iter().enumerate() {
        let (requantizer, channel) = (Requantizer::from_words(*scale), (channel + output) % (4 * GROUPS));
        let mut lines = values.chunks_mut(row.max(1));
        for tile in 0..2 {
            // the sums of a row lie a column apart
            let windows = sums.windows(4 * COLUMN + 1).skip(2 * output + tile).step_by(4);
            for (line, window) in lines.by_ref().take(TILE_ROWS).zip(windows) {
                let pixels: Option<&mut Pixels<GROUPS>> =
                    line.as_chunks_mut::<4>().0.as_chunks_mut::<GROUPS>().0.first_chunk_mut();
                let (Some(pixels), Some(window)) = (pixels, window.first_chunk::<{ 4 * COLUMN + 1 }>())
                else {
                    continue;
                };
                let outputs = outputs_of_row([0, 1, 2, 3, 4].map(|column| window[COLUMN * column]));
                for (pixel, sum) in pixels.iter_mut().zip(outputs) {
                    let sixteen = sum.wrapping_mul(NINTH).wrapping_add(start);
                    pixel.as_flattened_mut()[channel] = requantizer.apply::<FACTOR_BITS>(sixteen);
                }
            }
        }
    }
}

/// In plain Rust; `WIDE` as [`DualMac::WIDE`] of the processor that is compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Plain<const WIDE: bool = false>;

impl<const WIDE: bool> DualMac for Plain<WIDE> {
    const WIDE: bool = WIDE;

    #[inline]
    fn products<const GROUPS: usize>(self, inputs: &Tile<GROUPS>, weights: &Tile<GROUPS>, sums: &mut Sums) {
        plain_products::<Self, GROUPS>(inputs, weights, sums);
    }
}
