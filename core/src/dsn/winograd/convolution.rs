//! 3x3 convolutions with 16 products for four outputs instead of 36, exactly: Winograd's F(2x2, 3x3) in integers.
//!
//! A tile of 4x4 inputs is transformed by B^T . B, the products at 16 points are summed over the channels, and A^T . A
//! makes 2x2 outputs. Inputs are u8 = i8 + 128 and grow to 11 bits, weights are four times G . G^T and fit 12, so sums
//! are four times the convolution; the zero point and the 128 are in the bias. A row of tiles is transformed downwards
//! once, then two tiles at a time along.
//!
//! Source: A. Lavin, S. Gray, Fast Algorithms for Convolutional Neural Networks, CVPR 2016, section 4.1. Cost per tile:
//! 16 products for every pair of channels instead of 36, and 64 sums of pairs for every four inputs.

use super::rescale::{Rescale, WORDS, clamp_all};
use crate::dsn::conv::Conv;
use crate::simd::dual_mac::{DualMac, I16x8, POINTS, Points, Sums, place, unpack};

/// Four channels of a column, transformed downwards: two pairs at each of four points.
type Column = [i32; 8];

/// Columns of a strip: two tiles at a time, and their border.
const fn columns(width: usize) -> usize {
    4 * width.div_ceil(4) + 2
}

/// Words of a transformed row of tiles.
pub const fn strip_words(width: usize, channels: usize) -> usize {
    columns(width) * (channels / 4) * size_of::<Column>() / size_of::<i32>()
}

/// A convolution of stride 1: `[height, width, inputs]` to `[height, width, outputs]`.
pub struct Convolution<'a> {
    pub layer: &'a Conv<'a>,
    pub weights: &'a [I16x8],
    pub constants: &'a [i32],
    pub input: &'a [i8],
    pub width: usize,
    /// A row of the input's zero point.
    pub border: &'a [i8],
    pub strip: &'a mut [i32],
    pub output: &'a mut [i8],
}

/// Four pixels.
type Pixels<const QUADS: usize> = [[[i8; 4]; QUADS]; 4];

/// The outputs of two tiles, upper and lower row.
type Outputs<const QUADS: usize> = [Pixels<QUADS>; 2];

impl Convolution<'_> {
    /// Convolves; false, and nothing is done, for numbers of channels without tiles.
    pub fn run<P: DualMac>(self, pairs: P) -> bool {
        match self.layer.inputs {
            8 => self.rows::<P, 2>(pairs),
            16 => self.rows::<P, 4>(pairs),
            32 => self.rows::<P, 8>(pairs),
            _ => return false,
        }
        true
    }

    fn rows<P: DualMac, const QUADS: usize>(self, pairs: P) {
        let line = self.width * 4 * QUADS;
        let (border, _) = self.border.as_chunks::<4>();
        let lines = |y: usize| match y.checked_sub(1).and_then(|y| self.input.get(y * line..)?.get(..line)) {
            Some(row) => row.as_chunks::<4>().0,
            None => border,
        };
        let (strip, _) = self.strip.as_chunks_mut();
        let edge = border.first().map_or([0; 8], |&pixel| transform(pairs, [pixel; 4]));
        strip.fill(edge);
        let mut inputs = [[I16x8::ZERO; QUADS]; POINTS];
        let mut found: Outputs<QUADS> = [[[[0; 4]; QUADS]; 4]; 2];
        for (tile_row, output) in self.output.chunks_mut((2 * line).max(1)).enumerate() {
            let y = 2 * tile_row;
            let inside = strip.get_mut(QUADS..).unwrap_or_default();
            down(pairs, [lines(y), lines(y + 1), lines(y + 2), lines(y + 3)], inside);
            let (upper, lower) = output.split_at_mut(line.min(output.len()));
            let mut lower = lower.chunks_mut(16 * QUADS);
            let (columns, _) = strip.as_chunks::<QUADS>();
            for (upper, columns) in upper.chunks_mut(16 * QUADS).zip(columns.windows(6).step_by(4)) {
                let Some(six) = columns.first_chunk() else { continue };
                along(pairs, six, &mut inputs);
                outputs(pairs, &inputs, self.weights, self.constants, &mut found);
                put(&found[0], upper);
                put(&found[1], lower.next().unwrap_or_default());
            }
        }
        clamp_all(self.output, (self.layer.quant.act_min, self.layer.quant.act_max));
    }
}

/// B^T on a column of four values.
#[inline(always)]
fn forward<P: DualMac>(pairs: P, [a, b, c, d]: [i32; 4]) -> [i32; 4] {
    [pairs.sub(a, c), pairs.add(b, c), pairs.sub(c, b), pairs.sub(b, d)]
}

/// Four channels of a column of four pixels, transformed downwards.
#[inline(always)]
fn transform<P: DualMac>(pairs: P, column: [[i8; 4]; 4]) -> Column {
    let [a, b, c, d] = column.map(unpack);
    let even = forward(pairs, [a[0], b[0], c[0], d[0]]);
    let odd = forward(pairs, [a[1], b[1], c[1], d[1]]);
    [even[0], odd[0], even[1], odd[1], even[2], odd[2], even[3], odd[3]]
}

/// Four lines of pixels, transformed downwards.
#[inline(never)]
fn down<P: DualMac>(pairs: P, [a, b, c, d]: [&[[i8; 4]]; 4], strip: &mut [Column]) {
    for ((((a, b), c), d), out) in a.iter().zip(b).zip(c).zip(d).zip(strip) {
        *out = transform(pairs, [*a, *b, *c, *d]);
    }
}

/// Two tiles' columns, transformed along.
#[inline(never)]
fn along<P: DualMac, const QUADS: usize>(pairs: P, six: &[[Column; QUADS]; 6], inputs: &mut Points<QUADS>) {
    for quad in 0..QUADS {
        for (order, row) in [1, 2, 0, 3].into_iter().enumerate() {
            for tile in 0..2 {
                for pair in 0..2 {
                    let value = |column: usize| six[2 * tile + column][quad][(2 * row + pair) % 8];
                    let points = forward(pairs, [value(0), value(1), value(2), value(3)]);
                    let (eight, first) = place::<P>(quad, tile);
                    for column in 0..4 {
                        let [low, high] = pairs.settle(points[column]);
                        let I16x8(values) = &mut inputs[4 * column + order][eight % QUADS];
                        let at = (first + 2 * pair) % 8;
                        (values[at], values[at + 1]) = (low, high);
                    }
                }
            }
        }
    }
}

/// All channels of two tiles.
#[inline(always)]
fn outputs<P: DualMac, const QUADS: usize>(
    pairs: P,
    inputs: &Points<QUADS>,
    weights: &[I16x8],
    constants: &[i32],
    found: &mut Outputs<QUADS>,
) {
    let (weights, _) = weights.as_chunks::<QUADS>();
    let (weights, _) = weights.as_chunks::<POINTS>();
    let (weights, _) = weights.as_chunks::<2>();
    let (constants, _) = constants.as_chunks::<WORDS>();
    let (constants, _) = constants.as_chunks::<4>();
    let mut sums = [[[0; 4]; 2]; 4];
    for (quad, (weights, constants)) in weights.iter().zip(constants).enumerate().take(QUADS) {
        for (pair, weights) in weights.iter().enumerate() {
            pairs.products(inputs, weights, &mut sums);
            finish::<QUADS, 0>(&sums, &constants[2 * pair], found, quad, 2 * pair);
            finish::<QUADS, 1>(&sums, &constants[2 * pair + 1], found, quad, 2 * pair + 1);
        }
    }
}

/// A^T along the rows of two tiles, and requantisation: the `OUTPUT`-th channel of the sums.
#[inline(never)]
fn finish<const QUADS: usize, const OUTPUT: usize>(
    sums: &Sums,
    constants: &[i32; WORDS],
    found: &mut Outputs<QUADS>,
    quad: usize,
    channel: usize,
) {
    let rescale = Rescale::from_words(*constants);
    let (quad, channel) = (quad % QUADS, channel % 4);
    for row in 0..2 {
        for tile in 0..2 {
            let m = [0, 1, 2, 3].map(|column| sums[column][row][2 * OUTPUT + tile]);
            let middle = m[1].wrapping_add(rescale.start);
            let left = m[0].wrapping_add(middle).wrapping_add(m[2]);
            let right = middle.wrapping_sub(m[2]).wrapping_sub(m[3]);
            found[row][2 * tile][quad][channel] = rescale.apply(left);
            found[row][2 * tile + 1][quad][channel] = rescale.apply(right);
        }
    }
}

/// Writes up to four pixels.
#[inline(always)]
fn put<const QUADS: usize>(pixels: &Pixels<QUADS>, line: &mut [i8]) {
    let (line, _) = line.as_chunks_mut::<4>();
    for (to, from) in line.iter_mut().zip(pixels.as_flattened()) {
        *to = *from;
    }
}
