//! 3x3 convolutions with a quarter of the products, exactly: Winograd's F(4x4, 3x3) in integers.
//!
//! S. Winograd, Arithmetic Complexity of Computations, 1980; A. Lavin, S. Gray, Fast Algorithms for Convolutional Neural
//! Networks, CVPR 2016 (points 0, 1, -1, 2, -2).
//!
//! It serves inputs of 16 bits in pairs, where products cost most. A tile of 6x6 inputs is transformed by B^T . B, weights
//! are stored as G . G^T with the fractions of G cleared, and 36 products a pair of channels give 4x4 outputs by A^T . A.
//! Inputs grow from 8 to 14 bits, weights to 13. The sum is 9 2^a times the convolution modulo 2^32: a product with
//! 9^-1 modulo 2^32 and a shift by a leave the convolution. That is exact, as the convolution is below 2^24 in magnitude.
//!
//! Cost per 16 outputs of 16 pixels: 36 inputs / 2 vector products instead of 144 inputs / 2, and 11 one-dimensional
//! transforms.

use super::layer::{Convolution, OutputGroup, finish, reserve};
use super::simd::{LANES, SimdI32};
use std::array::from_fn;

/// Outputs of a tile along an axis.
const TILE: usize = 4;
/// Inputs of a tile along an axis.
const SPAN: usize = 6;
/// Products of a tile.
pub const POINTS: usize = SPAN * SPAN;
/// Tiles worked on together.
const TILES: usize = 4;
/// Pixels of a row that are worked on together.
const BLOCK: usize = TILE * TILES;
/// Words of half a vector.
const HALF: usize = LANES / 2;

/// G with its fractions cleared: 24, -6, -6, 24, 24 and 6 times its rows.
const G: [[i32; 3]; SPAN] = [[6, 0, 0], [1, 1, 1], [1, -1, 1], [1, 2, 4], [1, -2, 4], [0, 0, 6]];
/// Powers of two in the four outputs of a transform: 24, 12, 6 and 6 times the convolution are 3 times these.
const POWERS: [u32; TILE] = [3, 2, 1, 1];
/// The inverse of 9 modulo 2^32.
const NINTH: i32 = 0x38e3_8e39;

/// A weight at one of the 36 points: |w| below 49 x 128.
pub fn transform_weights(kernel: &[[i32; 3]; 3], point: usize) -> i32 {
    let (row, column) = (G[point / SPAN], G[point % SPAN]);
    kernel.iter().zip(row).map(|(k, r)| r * k.iter().zip(column).map(|(w, c)| w * c).sum::<i32>()).sum()
}

/// B^T on six half vectors of i16.
#[inline(always)]
fn input_transform<S: SimdI32>(simd: S, d: [S::I16; SPAN]) -> [S::I16; SPAN] {
    let [d0, d1, d2, d3, d4, d5] = d;
    let even = simd.sub16(d4, simd.shift_left16::<2>(d2));
    let odd = simd.sub16(d3, simd.shift_left16::<2>(d1));
    let a = simd.sub16(d4, d2);
    let b = simd.shift_left16::<1>(simd.sub16(d3, d1));
    [
        simd.add16(simd.shift_left16::<2>(simd.sub16(d0, d2)), a),
        simd.add16(even, odd),
        simd.sub16(even, odd),
        simd.add16(a, b),
        simd.sub16(a, b),
        simd.sub16(simd.sub16(d5, d3), simd.shift_left16::<1>(b)),
    ]
}

/// A^T on six vectors, its rows times 24, 12, 6 and 6.
#[inline(always)]
fn output_transform<S: SimdI32>(simd: S, p: [S::I32; SPAN]) -> [S::I32; TILE] {
    let [p0, p1, p2, p3, p4, p5] = p;
    let (q, r) = (simd.add(p1, p2), simd.sub(p1, p2));
    let (s, t) = (simd.add(p3, p4), simd.sub(p3, p4));
    [
        simd.add(simd.sub(p0, simd.shift_left::<2>(q)), s),
        simd.sub(simd.sub(t, r), r),
        simd.sub(s, q),
        simd.add(simd.sub(simd.add(t, t), r), p5),
    ]
}

/// B^T down six rows of the map, word by word.
#[inline(always)]
fn transform_columns<S: SimdI32>(simd: S, map: &[i32], row: usize, out: &mut [i32]) {
    let from: [_; SPAN] = from_fn(|i| map[i * row..][..row].as_chunks().0);
    let mut rows = out.chunks_exact_mut(row);
    let to: [_; SPAN] = from_fn(|_| rows.next().unwrap_or_default().as_chunks_mut().0);
    for at in 0..row / HALF {
        let mut d = [simd.load16(&[0; HALF]); SPAN];
        for i in 0..SPAN {
            d[i] = simd.load16(&from[i][at]);
        }
        let t = input_transform(simd, d);
        for i in 0..SPAN {
            to[i][at] = simd.store16(t[i]);
        }
    }
}

/// The words of [`TILES`] tiles at one point.
type Point<const STEP: usize> = [[i32; STEP]; TILES];

/// B^T along the rows of [`TILES`] tiles with the first row at `columns`.
#[inline(always)]
fn transform_rows<S: SimdI32, const STEP: usize>(
    simd: S,
    columns: &[i32],
    row: usize,
    out: &mut [Point<STEP>; POINTS],
) {
    let (out, _) = out.as_chunks_mut::<SPAN>();
    for (i, out) in out.iter_mut().enumerate() {
        let (pixels, _) = columns[i * row..][..(BLOCK + 2) * STEP].as_chunks::<STEP>();
        for tile in 0..TILES {
            for half in 0..STEP / HALF {
                let mut d = [simd.load16(&[0; HALF]); SPAN];
                for j in 0..SPAN {
                    d[j] = simd.load16(&pixels[TILE * tile + j].as_chunks().0[half]);
                }
                let t = input_transform(simd, d);
                for j in 0..SPAN {
                    out[j][tile].as_chunks_mut().0[half] = simd.store16(t[j]);
                }
            }
        }
    }
}

/// The 36 sums of [`TILES`] tiles.
#[inline(always)]
fn products<S: SimdI32, const STEP: usize>(
    simd: S,
    group: &OutputGroup,
    inputs: &[Point<STEP>; POINTS],
    sums: &mut [[S::I32; POINTS]; TILES],
) {
    let (weights, _) = group.weights.as_chunks::<STEP>();
    for (point, (inputs, weights)) in inputs.iter().zip(weights).enumerate() {
        let mut found = [simd.splat(0); TILES];
        for k in 0..STEP {
            let weights = simd.load(&weights[k]);
            for tile in 0..TILES {
                found[tile] = simd.dot(found[tile], inputs[tile][k], weights);
            }
        }
        for tile in 0..TILES {
            sums[tile][point] = found[tile];
        }
    }
}

/// A^T . A of one tile's sums and what is left of the division: four rows of four accumulators.
#[inline(always)]
fn output_tile<S: SimdI32>(simd: S, start: S::I32, sums: &[S::I32; POINTS]) -> [[S::I32; TILE]; TILE] {
    let zero = simd.splat(0);
    let mut columns = [[zero; SPAN]; TILE];
    for j in 0..SPAN {
        let mut p = [zero; SPAN];
        for i in 0..SPAN {
            p[i] = sums[SPAN * i + j];
        }
        let y = output_transform(simd, p);
        for i in 0..TILE {
            columns[i][j] = y[i];
        }
    }
    let ninth = simd.splat(NINTH);
    let mut out = [[zero; TILE]; TILE];
    for i in 0..TILE {
        let y = output_transform(simd, columns[i]);
        for j in 0..TILE {
            let power = POWERS[i] + POWERS[j];
            let whole = simd.shift_right(simd.multiply_low(y[j], ninth), power);
            out[i][j] = simd.add(whole, start);
        }
    }
    out
}

impl Convolution<'_> {
    /// The convolution, for pixels of `STEP` words of two inputs: inputs in sixteens.
    #[inline(always)]
    pub fn winograd<S: SimdI32, const STEP: usize>(mut self, simd: S) {
        let (height, width) = self.size;
        let columns = width.next_multiple_of(BLOCK) + 2;
        let row = columns * STEP;
        let rows = height.next_multiple_of(TILE) + 2;
        reserve(self.words, (rows + SPAN) * row);
        self.pad_input(simd, STEP, (rows, columns));
        let (map, transformed) = self.words.split_at_mut(rows * row);
        let quant = &self.layer.quant;
        let channels = quant.channels;
        let mut inputs = [[[0; STEP]; TILES]; POINTS];
        let mut sums = [[simd.splat(0); POINTS]; TILES];
        for y in (0..height).step_by(TILE) {
            transform_columns(simd, &map[y * row..], row, transformed);
            for x in (0..width).step_by(BLOCK) {
                transform_rows(simd, &transformed[x * STEP..], row, &mut inputs);
                for group in self.groups {
                    let start = simd.load(&group.start);
                    products(simd, group, &inputs, &mut sums);
                    for (tile, sums) in sums.iter().enumerate() {
                        let at = x + TILE * tile;
                        if at >= width {
                            break;
                        }
                        let lines = self.output[y * width * channels..].chunks_exact_mut(width * channels);
                        for (line, &four) in lines.zip(&output_tile(simd, start, sums)) {
                            finish(simd, quant, group, four, line, at);
                        }
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nine_and_its_inverse_are_one() {
        assert_eq!(9_i32.wrapping_mul(NINTH), 1);
    }

    #[test]
    fn transformed_weights_fit_in_16_bits() {
        let largest = (0..POINTS).map(|k| transform_weights(&[[-128; 3]; 3], k).abs()).max();
        assert_eq!(largest, Some(49 * 128));
        assert_eq!(transform_weights(&[[1, 2, 3], [4, 5, 6], [7, 8, 9]], 0), 36);
        assert_eq!(transform_weights(&[[1, 2, 3], [4, 5, 6], [7, 8, 9]], 7), 45);
    }
}
