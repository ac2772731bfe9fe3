//! Dual multiply-accumulates of i16: what the network's Winograd kernels need of a processor.
//!
//! A kernel is written once over [`DualMac`]. [`Plain`] is the portable reference; `arm` has the DSP extension of Cortex-M4,
//! M7, M33 and later, and Helium of M52, M55 and M85. All operations are integer and exact: the same bits.

use core::hint::black_box;

/// Eight i16: four successive channels of two tiles or two outputs; in the wide order eight of one, and the same of the
/// other in the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C, align(16))]
pub struct I16x8(pub [i16; 8]);

impl I16x8 {
    /// Zeros.
    pub const ZERO: Self = I16x8([0; 8]);
}

/// Points of a tile: 4 x 4 products give 2 x 2 outputs.
pub const POINTS: usize = 16;

/// Two tiles' values or two outputs' weights in the Winograd domain: `GROUPS` groups of four channels at 16 points, column by
/// column, rows in the order 1, 2, 0, 3.
pub(crate) type Tile<const GROUPS: usize> = [[I16x8; GROUPS]; POINTS];

/// Sums of two tiles and two outputs, `[column][row][output, tile]`, already gathered from four points to two rows.
pub(crate) type Sums = [[[i32; 4]; 2]; 4];

/// Arithmetic on pairs of i16. A value of an implementing type is the proof that the processor has the instructions.
pub trait DualMac: Copy {
    /// Whether a `Tile` of an even number of groups is in the wide order.
    const WIDE: bool = false;
    /// Blocks of two tiles that a step of a convolution of 8, 16 and 32 channels does: some 40 000 instructions, here 120 000 on RV32IMAC.
    const BLOCKS: [usize; 3] = [4, 2, 1];

    /// Sum of pairs, in a form of the implementation's own; no part leaves i16.
    fn add(self, a: i32, b: i32) -> i32;
    /// Difference of pairs, likewise.
    fn sub(self, a: i32, b: i32) -> i32;
    /// The two i16 of a result, the lower half first.
    fn unpack(self, pair: i32) -> [i16; 2];

    /// For each column of points the products summed over all channels, and the rows gathered: with p the sums of rows 1,
    /// 2, 0 and 3, `p1 + p2 + p0` and `p1 - p2 + p3`. Wraps.
    fn products<const GROUPS: usize>(self, inputs: &Tile<GROUPS>, weights: &Tile<GROUPS>, sums: &mut Sums);
}

/// Where group `group` of `GROUPS` of tile or output `part` lies: which [`I16x8`], and its first value.
#[inline(always)]
pub const fn lane<P: DualMac, const GROUPS: usize>(group: usize, part: usize) -> (usize, usize) {
    if P::WIDE && GROUPS.is_multiple_of(2) { (group & !1 | part, 4 * (group & 1)) } else { (group, 4 * part) }
}

/// Four int8 values as pairs of u8 = i8 + 128: the first and third, the second and fourth.
#[inline(always)]
pub fn widen(four: [i8; 4]) -> [i32; 2] {
    if cfg!(target_arch = "riscv32") {
        // without unaligned loads the bytes come one by one
        let [a, b, c, d] = four.map(|v| i32::from(v as u8));
        return [a | c << 16, b | d << 16].map(|pair| pair ^ 0x0080_0080);
    }
    let word = u32::from_le_bytes(four.map(|v| v as u8)) ^ 0x8080_8080;
    [word, word >> 8].map(|pair| (pair & 0x00ff_00ff) as i32)
}

/// `sums[output, tile] += sum over channels`, of one point.
#[inline(always)]
fn accumulate<P: DualMac, const GROUPS: usize>(
    inputs: &[I16x8; GROUPS],
    weights: &[I16x8; GROUPS],
    sums: &mut [i32; 4],
) {
    if P::WIDE && GROUPS.is_multiple_of(2) {
        let (inputs, weights) = (inputs.as_chunks().0, weights.as_chunks().0);
        for ([x0, x1], [w0, w1]) in inputs.iter().zip(weights) {
            add_products([&x0.0, &x1.0], [&w0.0, &w1.0], sums);
        }
    } else {
        // of a short loop of known length the compiler makes more products at once than RISC-V has registers
        let groups = if cfg!(target_arch = "riscv32") && GROUPS < 8 { black_box(GROUPS) } else { GROUPS };
        for (I16x8(x), I16x8(w)) in inputs.iter().zip(weights).take(groups) {
            if let ([x0, x1], [w0, w1]) = (x.as_chunks::<4>().0, w.as_chunks::<4>().0) {
                add_products([x0, x1], [w0, w1], sums);
            }
        }
    }
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
    let ((inputs, _), (weights, _)) = (inputs.as_chunks::<4>(), weights.as_chunks::<4>());
    for (([x1, x2, x0, x3], [w1, w2, w0, w3]), [upper, lower]) in inputs.iter().zip(weights).zip(sums) {
        let (mut p1, mut p2) = ([0; 4], [0; 4]);
        accumulate::<P, GROUPS>(x1, w1, &mut p1);
        accumulate::<P, GROUPS>(x2, w2, &mut p2);
        for k in 0..4 {
            (upper[k], lower[k]) = (p1[k].wrapping_add(p2[k]), p1[k].wrapping_sub(p2[k]));
        }
        accumulate::<P, GROUPS>(x0, w0, upper);
        accumulate::<P, GROUPS>(x3, w3, lower);
    }
}

/// Pairs in plain Rust: a pair (l, h) is the number h 2^16 + l, so that sums of pairs are sums of numbers.
///
/// `WIDE` as [`DualMac::WIDE`] of the processor that is compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Plain<const WIDE: bool = false>;

impl<const WIDE: bool> DualMac for Plain<WIDE> {
    const WIDE: bool = WIDE;

    #[inline(always)]
    fn add(self, a: i32, b: i32) -> i32 {
        a.wrapping_add(b)
    }

    #[inline(always)]
    fn sub(self, a: i32, b: i32) -> i32 {
        a.wrapping_sub(b)
    }

    #[inline(always)]
    fn unpack(self, pair: i32) -> [i16; 2] {
        let low = pair as i16;
        [low, (pair.wrapping_sub(i32::from(low)) >> 16) as i16]
    }

    #[inline]
    fn products<const GROUPS: usize>(self, inputs: &Tile<GROUPS>, weights: &Tile<GROUPS>, sums: &mut Sums) {
        plain_products::<Self, GROUPS>(inputs, weights, sums);
    }
}
