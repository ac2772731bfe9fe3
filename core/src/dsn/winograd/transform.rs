//! The transforms of Winograd's F(4x3, 3x3) in integers: F(4, 3) along columns, F(3, 3) along rows.
//!
//! Source: A. Lavin, S. Gray, Fast Algorithms for Convolutional Neural Networks, CVPR 2016, section 4.1. The points are 0, 1, -1, 2, -2
//! and infinity along columns, without -2 along rows.
//!
//! Ranges: of u8 the input transform makes magnitudes up to 255 * 30 = 7650, and the filter transform of i8 up to
//! 128 * 12 * 9 = 13 824; both fit i16. Sums wrap; what they are [`FACTOR`] times is below 2^27 and comes out exactly.

/// The outputs are so many times the convolution: 24 along columns, 6 along rows.
pub const FACTOR: i32 = 144;

/// Reciprocal of the odd part of [`FACTOR`], modulo 2^32: a multiple of it becomes the quotient.
pub const NINTH: i32 = 954_437_177;

/// The even part of [`FACTOR`], as its binary logarithm.
pub const FACTOR_BITS: u32 = 4;

const _: () = assert!(FACTOR >> FACTOR_BITS == 9 && NINTH.wrapping_mul(9) == 1);

/// The input transform of a column of six numbers, B^T of F(4, 3), rows in the order 5, 3, 4, 1, 2, 0: few sums of products are kept
/// at a time.
#[inline(always)]
pub fn transform_column([a, b, c, d, e, f]: [i32; 6]) -> [i32; 6] {
    let (even, odd) = (e.wrapping_sub(c << 2), d.wrapping_sub(b << 2));
    let (far, near) = (e.wrapping_sub(c), d.wrapping_sub(b));
    [
        f.wrapping_sub(d).wrapping_sub(near << 2),
        far.wrapping_add(near << 1),
        far.wrapping_sub(near << 1),
        even.wrapping_add(odd),
        even.wrapping_sub(odd),
        far.wrapping_add(a.wrapping_sub(c) << 2),
    ]
}

/// The input transform of a row of five numbers, B^T of F(3, 3).
#[inline(always)]
pub fn transform_row([a, b, c, d, e]: [i32; 5]) -> [i32; 5] {
    let (near, next) = (d.wrapping_sub(b), b.wrapping_sub(c));
    [
        near.wrapping_add(a.wrapping_sub(c) << 1),
        near.wrapping_sub(b).wrapping_sub(c),
        near.wrapping_add(next).wrapping_add(next << 1),
        near,
        e.wrapping_sub(c).wrapping_sub(near << 1),
    ]
}

/// The output transform of the sums of a column, A^T of F(4, 3), in the same order.
#[inline(always)]
pub fn outputs_of_column([f, d, e, b, c, a]: [i32; 6]) -> [i32; 4] {
    let (sum, difference) = (b.wrapping_add(c), b.wrapping_sub(c));
    let (sum2, difference2) = (d.wrapping_add(e), d.wrapping_sub(e));
    [
        a.wrapping_add(sum).wrapping_add(sum2),
        difference.wrapping_add(difference2 << 1),
        sum.wrapping_add(sum2 << 2),
        difference.wrapping_add(difference2.wrapping_add(f) << 3),
    ]
}

/// The output transform of the sums of a row, A^T of F(3, 3).
#[inline(always)]
pub fn outputs_of_row([a, b, c, d, e]: [i32; 5]) -> [i32; 3] {
    let (sum, difference) = (b.wrapping_add(c), b.wrapping_sub(c));
    [
        a.wrapping_add(sum).wrapping_add(d),
        difference.wrapping_add(d << 1),
        sum.wrapping_add(d << 2).wrapping_add(e),
    ]
}

/// The filter transform of the columns of 3x3 kernels, G of F(4, 3), scaled to integers, rows in the same order.
#[inline(always)]
pub fn filter_columns(taps: &[i32; 9]) -> [[i32; 6]; 3] {
    [0, 1, 2].map(|column| {
        let [a, b, c] = [0, 3, 6].map(|row| taps[row + column % 3]);
        let (ends, far, twice) = (a + c, a + (c << 2), b << 1);
        [c + (c << 1), far + twice, far - twice, -((ends + b) << 2), (b - ends) << 2, (a + (a << 1)) << 1]
    })
}

/// The filter transform of a row of three, G of F(3, 3), scaled to integers.
#[inline(always)]
pub fn filter_row([a, b, c]: [i32; 3]) -> [i32; 5] {
    let (ends, thrice) = (a + c, c + (c << 1));
    let all = ends + b;
    [a + (a << 1), -(all + (all << 1)), b - ends, all + b + thrice, thrice << 1]
}
