//! 3x3 convolutions with 16 products for four outputs instead of 36, exactly: Winograd's F(2x2, 3x3) in integers.
//!
//! Source: A. Lavin, S. Gray, Fast Algorithms for Convolutional Neural Networks, CVPR 2016, section 4.1. Cost per tile:
//! 16 products for every pair of channels instead of 36, and 64 sums of pairs for every four inputs.
//!
//! A tile of 4x4 inputs is transformed by B^T . B, the products at 16 points are summed over the channels, and A^T . A
//! makes 2x2 outputs. Inputs are u8 = i8 + 128 and grow to 11 bits, weights are four times G . G^T and fit 12, so sums
//! are four times the convolution; the zero point and the 128 are in the bias. A row of tiles is transformed by columns
//! once, into a strip, then two tiles at a time by rows: a block.

use super::packing::{WORDS, packed_outputs};
use super::{clamp_all, transform::input_transform};
use crate::dsn::conv::Conv;
use crate::dsn::established;
use crate::fixed::Requantizer;
use crate::simd::dual_mac::{DualMac, I16x8, POINTS, Sums, Tile, lane, widen};

/// Four channels of a column, transformed: two pairs at each of four points.
type Column = [i32; 8];

/// Words of the sums.
const SUMS: usize = size_of::<Sums>() / size_of::<i32>();

/// Columns of a strip: two tiles at a time, and their border.
const fn columns(width: usize) -> usize {
    4 * width.div_ceil(4) + 2
}

/// Words of the sums, then of a strip.
pub const fn words(width: usize, inputs: usize) -> usize {
    SUMS + columns(width) * inputs.div_ceil(4) * size_of::<Column>() / size_of::<i32>()
}

/// Blocks of two tiles that a step of a convolution with so many outputs does.
const fn blocks<P: DualMac>(outputs: usize) -> usize {
    let [of_8, of_16, of_32] = P::BLOCKS;
    match outputs {
        8 => of_8,
        16 => of_16,
        _ => of_32,
    }
}

/// Steps of a convolution with so many outputs, `(height, width)`.
pub const fn steps<P: DualMac>(outputs: usize, (height, width): (usize, usize)) -> usize {
    let steps = width.div_ceil(4 * blocks::<P>(outputs));
    if steps > 1 { height / 2 * steps } else { height / 2 }
}

/// A convolution of stride 1: `[height, width, inputs]` to `[height, width, outputs]`.
pub(super) struct Convolution<'a> {
    pub layer: &'a Conv<'a>,
    /// First of the output channels that are packed.
    pub first: usize,
    pub weights: &'a [I16x8],
    pub constants: &'a [i32],
    pub input: &'a [i8],
    pub width: usize,
    /// A row of the input's zero point, which the first step writes.
    pub border: &'a mut [i8],
    /// Sums, and the strip of the row of tiles that is computed, which stays between two steps.
    pub words: &'a mut [i32],
    /// The inputs of two tiles.
    pub tile: &'a mut [I16x8],
    pub output: &'a mut [i8],
}

/// Four pixels of a row: the outputs of two tiles.
type Pixels<const GROUPS: usize> = [[[i8; 4]; GROUPS]; 4];

/// A row as blocks, and the pixels that are left.
fn pixels<const GROUPS: usize>(row: &mut [i8]) -> (&mut [Pixels<GROUPS>], &mut [[[i8; 4]; GROUPS]]) {
    row.as_chunks_mut::<4>().0.as_chunks_mut::<GROUPS>().0.as_chunks_mut::<4>()
}

impl Convolution<'_> {
    /// Does a step: some blocks of a row of tiles, below 45 000 instructions on Cortex-M4F; true after the last.
    pub fn run<P: DualMac>(self, mac: P, step: usize) -> bool {
        match (self.layer.inputs, self.layer.quant.channels) {
            (8, _) => self.blocks::<P, 4, 2, 2>(mac, step),
            (16, _) => self.blocks::<P, 4, 4, 4>(mac, step),
            (32, _) => self.blocks::<P, 4, 8, 8>(mac, step),
            #[cfg(feature = "graph")]
            (64, _) => self.blocks::<P, 4, 16, 16>(mac, step),
            #[cfg(feature = "graph")]
            (3, 8) => self.blocks::<P, 3, 1, 2>(mac, step),
            #[cfg(feature = "graph")]
            (3, 16) => self.blocks::<P, 3, 1, 4>(mac, step),
            #[cfg(feature = "graph")]
            (3, 32) => self.blocks::<P, 3, 1, 8>(mac, step),
            _ => true,
        }
    }

    /// Does some blocks of a row of tiles, of inputs in `IN` groups of `C` channels and outputs in `OUT` groups of four.
    fn blocks<P: DualMac, const C: usize, const IN: usize, const OUT: usize>(
        self,
        mac: P,
        step: usize,
    ) -> bool {
        let (most, line) = (blocks::<P>(4 * OUT), self.width * 4 * OUT);
        let (all, steps) = (self.width.div_ceil(4), self.width.div_ceil(4 * most).max(1));
        let (y, first) = (2 * (step / steps), step % steps * most);
        let last = (first + most).min(all);

        let (sums, strip) = established(self.words.split_at_mut_checked(SUMS));
        let (strip, _) = strip.as_chunks_mut();
        if step == 0 {
            self.border.fill(self.layer.quant.in_zp);
            let pixel = [self.layer.quant.in_zp; 4];
            let edge = transform_column(mac, [pixel; 4]);
            established(strip.get_mut(..IN)).fill(edge);
            established(strip.get_mut((self.width + 1) * IN..)).fill(edge);
        }
        let (border, _) = self.border.as_chunks::<C>();
        // the columns that these blocks read and those before them have not
        let from = if first == 0 { 0 } else { 4 * first + 1 };
        let lines = [0, 1, 2, 3].map(|k| {
            let line = self.width * C * IN;
            let line = (y + k).checked_sub(1).and_then(|y| self.input.get(y * line..)?.get(..line));
            let line = line.map_or(border, |line| line.as_chunks().0);
            established(line.get(from * IN..(4 * last + 1).min(self.width) * IN))
        });
        transform_columns(mac, lines, established(strip.get_mut((from + 1) * IN..)));

        let ([inputs], [sums]) = (
            self.tile.as_chunks_mut::<IN>().0.as_chunks_mut::<POINTS>().0,
            sums.as_chunks_mut().0.as_chunks_mut().0.as_chunks_mut().0,
        ) else {
            established::<()>(None);
            return true;
        };
        let rows = established(self.output.get_mut(y * line..));
        let end = rows.len() <= 2 * line && last == all;
        let (upper, lower) = established(rows.split_at_mut_checked(line));
        let range = 16 * OUT * first..(16 * OUT * last).min(line);
        let upper = established(upper.get_mut(range.clone()));
        let lower = established(lower.get_mut(range));
        let (columns, _) = strip.as_chunks::<IN>();
        let columns = established(columns.get(4 * first..)).windows(6).step_by(4);
        let ((upper_blocks, upper_rest), (lower_blocks, lower_rest)) = (pixels(upper), pixels(lower));
        // the last block of a row may have fewer pixels than are computed
        let mut found = (!upper_rest.is_empty()).then_some([[[[0; 4]; OUT]; 4]; 2]);
        let blocks = upper_blocks.iter_mut().zip(lower_blocks).map(|(upper, lower)| [upper, lower]);
        for (rows, columns) in blocks.chain(found.as_mut().map(|found| found.each_mut())).zip(columns) {
            let Some(six) = columns.first_chunk() else { continue };
            transform_rows(mac, six, inputs);
            outputs(mac, inputs, (self.weights, self.constants), sums, rows, self.first);
        }
        let channels = self.first / 4..(self.first + packed_outputs(4 * OUT)) / 4;
        for (rest, found) in [upper_rest, lower_rest].into_iter().zip(found.iter().flatten()) {
            for (to, from) in rest.iter_mut().zip(found) {
                let to = established(to.get_mut(channels.clone()));
                to.iter_mut().zip(established(from.get(channels.clone()))).for_each(|(to, from)| *to = *from);
            }
        }
        let range = (self.layer.quant.act_min, self.layer.quant.act_max);
        clamp_all(upper, range);
        clamp_all(lower, range);
        end
    }
}

/// Four channels of a column of four pixels, transformed.
#[inline(always)]
fn transform_column<P: DualMac>(mac: P, column: [[i8; 4]; 4]) -> Column {
    let [a, b, c, d] = column.map(widen);
    let even = input_transform(mac, [a[0], b[0], c[0], d[0]]);
    let odd = input_transform(mac, [a[1], b[1], c[1], d[1]]);
    [even[0], odd[0], even[1], odd[1], even[2], odd[2], even[3], odd[3]]
}

/// Four lines of pixels, transformed column by column.
#[inline(never)]
fn transform_columns<P: DualMac, const C: usize>(
    mac: P,
    [a, b, c, d]: [&[[i8; C]]; 4],
    strip: &mut [Column],
) {
    // the weights of a fourth channel that is not there are zero
    let four = |channels: &[i8; C]| {
        let mut four = [0; 4];
        four.iter_mut().zip(channels).for_each(|(to, from)| *to = *from);
        four
    };
    for ((((a, b), c), d), out) in a.iter().zip(b).zip(c).zip(d).zip(strip) {
        *out = transform_column(mac, [a, b, c, d].map(four));
    }
}

/// Two tiles' columns, transformed row by row.
#[inline(never)]
fn transform_rows<P: DualMac, const GROUPS: usize>(
    mac: P,
    six: &[[Column; GROUPS]; 6],
    inputs: &mut Tile<GROUPS>,
) {
    for group in 0..GROUPS {
        for (order, row) in [1, 2, 0, 3].into_iter().enumerate() {
            for tile in 0..2 {
                for pair in 0..2 {
                    let value = |column: usize| six[2 * tile + column][group][(2 * row + pair) % 8];
                    let points = input_transform(mac, [value(0), value(1), value(2), value(3)]);
                    let (vector, first) = lane::<P, GROUPS>(group, tile);
                    for column in 0..4 {
                        let [low, high] = mac.unpack(points[column]);
                        let I16x8(values) = &mut inputs[4 * column + order][vector % GROUPS];
                        let at = (first + 2 * pair) % 8;
                        (values[at], values[at + 1]) = (low, high);
                    }
                }
            }
        }
    }
}

/// The packed channels of two tiles.
#[inline(always)]
fn outputs<P: DualMac, const IN: usize, const OUT: usize>(
    mac: P,
    inputs: &Tile<IN>,
    (weights, constants): (&[I16x8], &[i32]),
    sums: &mut Sums,
    mut rows: [&mut Pixels<OUT>; 2],
    first: usize,
) {
    let (weights, _) = weights.as_chunks::<IN>();
    let (weights, _) = weights.as_chunks::<POINTS>();
    let (constants, _) = constants.as_chunks::<WORDS>();
    let (constants, _) = constants.as_chunks::<2>();
    for (pair, (weights, constants)) in weights.iter().zip(constants).enumerate() {
        mac.products(inputs, weights, sums);
        finish::<OUT, 0>(sums, &constants[0], &mut rows, first + 2 * pair);
        finish::<OUT, 1>(sums, &constants[1], &mut rows, first + 2 * pair + 1);
    }
}

/// A^T along the rows of two tiles, and requantisation: the `OUTPUT`-th channel of the sums.
#[inline(never)]
fn finish<const OUT: usize, const OUTPUT: usize>(
    sums: &Sums,
    constants: &[i32; WORDS],
    rows: &mut [&mut Pixels<OUT>; 2],
    channel: usize,
) {
    let [start, scale @ ..] = *constants;
    let requantizer = Requantizer::from_words(scale);
    let channel = channel % (4 * OUT);
    for (row, pixels) in rows.iter_mut().enumerate() {
        for tile in 0..2 {
            let m = [0, 1, 2, 3].map(|column| sums[column][row][2 * OUTPUT + tile]);
            let middle = m[1].wrapping_add(start);
            let left = m[0].wrapping_add(middle).wrapping_add(m[2]);
            let right = middle.wrapping_sub(m[2]).wrapping_sub(m[3]);
            pixels[2 * tile].as_flattened_mut()[channel] = requantizer.apply(left);
            pixels[2 * tile + 1].as_flattened_mut()[channel] = requantizer.apply(right);
        }
    }
}
