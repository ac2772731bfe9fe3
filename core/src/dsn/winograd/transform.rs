//! The transforms of Winograd's F(2x2, 3x3) in integers.
//!
//! Source: A. Lavin, S. Gray, Fast Algorithms for Convolutional Neural Networks, CVPR 2016, section 4.1.

use crate::simd::dual_mac::DualMac;

/// The input transform, B^T, of four values or pairs.
#[inline(always)]
pub fn input_transform<P: DualMac>(mac: P, [a, b, c, d]: [i32; 4]) -> [i32; 4] {
    [mac.sub(a, c), mac.add(b, c), mac.sub(c, b), mac.sub(b, d)]
}

/// The filter transform of a 3x3 kernel, G g G^T, times four: `[column][row]`.
#[inline(always)]
pub fn filter_transform(tap: impl Fn(usize) -> i32) -> [[i32; 4]; 4] {
    // G on three weights, times two
    let g = |[a, b, c]: [i32; 3]| [2 * a, a + b + c, a - b + c, 2 * c];
    let [a, b, c] = [0, 3, 6].map(|row| g([tap(row), tap(row + 1), tap(row + 2)]));
    [0, 1, 2, 3].map(|column| g([a[column], b[column], c[column]]))
}
