//! 3x3 convolutions with a quarter of the products, exactly: Winograd's F(4x4, 3x3) in integers.
//!
//! For inputs of 16 bits in pairs, where products cost most. A tile of 6x6 inputs is transformed by B^T . B, weights are
//! stored as G . G^T with the fractions of G cleared, 36 products a pair of channels give 4x4 outputs by A^T . A. All is
//! integer: inputs grow from 8 to 14 bits, weights to 13, and the sum comes out as 9 2^a times the convolution modulo
//! 2^32, which a product with 9^-1 modulo 2^32 and a shift by a turn into the convolution itself: below 2^24 in
//! magnitude, it loses nothing.
//!
//! Source: S. Winograd, Arithmetic Complexity of Computations, 1980; A. Lavin, S. Gray, Fast Algorithms for
//! Convolutional Neural Networks, CVPR 2016 (points 0, 1, -1, 2, -2). Cost per 16 outputs of 16 pixels: 36 inputs / 2
//! vector products instead of 144 inputs / 2, and 11 one-dimensional transforms.

use super::layer::{Convolution, Group, finish, put};
use crate::simd::{LANES, Lanes};

/// Outputs of a tile along an axis.
pub const TILE: usize = 4;
/// Inputs of a tile along an axis.
const SPAN: usize = 6;
/// Products of a tile.
pub const POINTS: usize = SPAN * SPAN;
/// Tiles worked on together.
const TILES: usize = 4;
/// Pixels of a row that are worked on together.
pub const BLOCK: usize = TILE * TILES;
/// Most words of a pixel: 32 channels.
const MAX_STEP: usize = 16;
/// Words of half a vector.
const HALF: usize = LANES / 2;

/// G with its fractions cleared: 24, -6, -6, 24, 24 and 6 times its rows.
const G: [[i32; 3]; SPAN] = [[6, 0, 0], [1, 1, 1], [1, -1, 1], [1, 2, 4], [1, -2, 4], [0, 0, 6]];
/// Powers of two in the four outputs of a transform: 24, 12, 6 and 6 times the convolution are 3 times these.
const POWERS: [u32; TILE] = [3, 2, 1, 1];
/// The inverse of 9 modulo 2^32.
const NINTH: i32 = 0x38e3_8e39;

/// Rows of memory beyond the map, for one row of tiles transformed downwards.
pub const ROWS: usize = SPAN;

/// A weight at one of the 36 points: |w| below 49 x 128.
pub fn point(kernel: &[[i32; 3]; 3], point: usize) -> i32 {
    let [Some(row), Some(column)] = [G.get(point / SPAN), G.get(point % SPAN)] else { return 0 };
    kernel.iter().zip(row).map(|(k, r)| r * k.iter().zip(column).map(|(w, c)| w * c).sum::<i32>()).sum()
}

/// B^T on six half vectors of i16.
#[inline(always)]
fn forward<L: Lanes>(l: L, d: [L::H; SPAN]) -> [L::H; SPAN] {
    let [d0, d1, d2, d3, d4, d5] = d;
    let even = l.sub16(d4, l.shift_left16::<2>(d2));
    let odd = l.sub16(d3, l.shift_left16::<2>(d1));
    let a = l.sub16(d4, d2);
    let b = l.shift_left16::<1>(l.sub16(d3, d1));
    [
        l.add16(l.shift_left16::<2>(l.sub16(d0, d2)), a),
        l.add16(even, odd),
        l.sub16(even, odd),
        l.add16(a, b),
        l.sub16(a, b),
        l.sub16(l.sub16(d5, d3), l.shift_left16::<1>(b)),
    ]
}

/// A^T on six vectors, its rows times 24, 12, 6 and 6.
#[inline(always)]
fn backward<L: Lanes>(l: L, p: [L::V; SPAN]) -> [L::V; TILE] {
    let [p0, p1, p2, p3, p4, p5] = p;
    let (q, r) = (l.add(p1, p2), l.sub(p1, p2));
    let (s, t) = (l.add(p3, p4), l.sub(p3, p4));
    [
        l.add(l.sub(p0, l.shift_left::<2>(q)), s),
        l.sub(l.sub(t, r), r),
        l.sub(s, q),
        l.add(l.sub(l.add(t, t), r), p5),
    ]
}

/// B^T down six rows of the map, word by word.
#[inline(always)]
fn down<L: Lanes>(lanes: L, map: &[i32], row: usize, out: &mut [i32]) -> Option<()> {
    for at in (0..row).step_by(HALF) {
        let mut d = [lanes.load16(&[0; HALF]); SPAN];
        for (i, d) in d.iter_mut().enumerate() {
            *d = lanes.load16(map.get(i * row + at..)?.first_chunk()?);
        }
        let t = forward(lanes, d);
        for i in 0..SPAN {
            *out.get_mut(i * row + at..)?.first_chunk_mut()? = lanes.store16(t[i]);
        }
    }
    Some(())
}

/// The products' inputs of [`TILES`] tiles, `[point][tile][step]`.
type Inputs = [[i32; TILES * MAX_STEP]; POINTS];

/// B^T along the rows of [`TILES`] tiles that begin at `columns`.
#[inline(always)]
fn along<L: Lanes>(lanes: L, columns: &[i32], row: usize, step: usize, out: &mut Inputs) -> Option<()> {
    for (i, out) in out.chunks_exact_mut(SPAN).enumerate() {
        for tile in 0..TILES {
            for half in (0..step).step_by(HALF) {
                let mut d = [lanes.load16(&[0; HALF]); SPAN];
                for (j, d) in d.iter_mut().enumerate() {
                    let at = i * row + (TILE * tile + j) * step + half;
                    *d = lanes.load16(columns.get(at..)?.first_chunk()?);
                }
                let t = forward(lanes, d);
                for j in 0..SPAN {
                    *out[j].get_mut(tile * step + half..)?.first_chunk_mut()? = lanes.store16(t[j]);
                }
            }
        }
    }
    Some(())
}

/// The 36 sums of [`TILES`] tiles.
#[inline(always)]
fn products<L: Lanes>(
    lanes: L,
    group: &Group<'_>,
    inputs: &Inputs,
    step: usize,
    sums: &mut [[L::V; POINTS]; TILES],
) {
    for (point, (inputs, weights)) in inputs.iter().zip(group.words.chunks_exact(step)).enumerate() {
        let mut found = [lanes.splat(0); TILES];
        for (k, weights) in weights.iter().enumerate() {
            let weights = lanes.load(weights);
            for tile in 0..TILES {
                found[tile] = lanes.dot(found[tile], inputs[(tile * step + k) % inputs.len()], weights);
            }
        }
        for tile in 0..TILES {
            sums[tile][point] = found[tile];
        }
    }
}

/// A^T . A of one tile's sums and what is left of the division: four rows of four accumulators.
#[inline(always)]
fn accumulators<L: Lanes>(lanes: L, bias: L::V, sums: &[L::V; POINTS]) -> [[L::V; TILE]; TILE] {
    let zero = lanes.splat(0);
    let mut columns = [[zero; SPAN]; TILE];
    for j in 0..SPAN {
        let mut p = [zero; SPAN];
        for i in 0..SPAN {
            p[i] = sums[SPAN * i + j];
        }
        let y = backward(lanes, p);
        for i in 0..TILE {
            columns[i][j] = y[i];
        }
    }
    let ninth = lanes.splat(NINTH);
    let mut out = [[zero; TILE]; TILE];
    for i in 0..TILE {
        let y = backward(lanes, columns[i]);
        for j in 0..TILE {
            let power = POWERS[i] + POWERS[j];
            let whole = lanes.shift_right(lanes.multiply_low(y[j], ninth), power);
            out[i][j] = lanes.add(whole, bias);
        }
    }
    out
}

impl Convolution<'_> {
    /// The convolution, for words of two inputs and inputs in sixteens; `None` if the memory is too small.
    #[inline(always)]
    pub fn winograd<L: Lanes, const STEP: usize>(mut self, lanes: L) -> Option<()> {
        let (height, width) = self.size;
        let columns = width.next_multiple_of(BLOCK) + 2;
        let row = columns * STEP;
        let rows = height.next_multiple_of(TILE) + 2;
        self.spread(lanes, STEP, (rows, columns));
        let (map, rest) = self.words.split_at_mut_checked(rows * row)?;
        let transformed = rest.get_mut(..ROWS * row)?;
        let layer = &self.layer.layer;
        let channels = layer.channels;
        let mut inputs: Inputs = [[0; TILES * MAX_STEP]; POINTS];
        let mut sums = [[lanes.splat(0); POINTS]; TILES];
        for y in (0..height).step_by(TILE) {
            down(lanes, map.get(y * row..)?, row, transformed)?;
            for x in (0..width).step_by(BLOCK) {
                along(lanes, transformed.get(x * STEP..)?, row, STEP, &mut inputs)?;
                let mut lines = self.lines;
                for first in (0..channels).step_by(LANES) {
                    let group = Group::take(&mut lines, POINTS * STEP)?;
                    let bias = lanes.load(group.biases);
                    products(lanes, &group, &inputs, STEP, &mut sums);
                    for (tile, sums) in sums.iter().enumerate() {
                        let at = x + TILE * tile;
                        if at >= width {
                            break;
                        }
                        let below = self.output.get_mut(y * width * channels..)?;
                        let lines = below.chunks_exact_mut(width * channels);
                        let rows = accumulators(lanes, bias, sums);
                        for (line, four) in lines.zip(&rows) {
                            let values = finish(lanes, layer, group.rescale, *four);
                            put(&values, first, channels, line, at);
                        }
                    }
                }
            }
        }
        Some(())
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
        let largest = (0..POINTS).map(|k| point(&[[-128; 3]; 3], k).abs()).max();
        assert_eq!(largest, Some(49 * 128));
        assert_eq!(point(&[[1, 2, 3], [4, 5, 6], [7, 8, 9]], 0), 36);
        assert_eq!(point(&[[1, 2, 3], [4, 5, 6], [7, 8, 9]], 7), 45);
    }
}
