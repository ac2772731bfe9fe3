//! A convolution's numbers in the order in which the kernels read them.
//!
//! Weights: for each pair of outputs the filter transform at 16 points, column by column, rows in the order 1, 2, 0, 3, row 3
//! negated (see [`Tile`]); channels of a group in the order 0, 2, 1, 3, as masks take them out of a word. Constants: four words
//! of every output channel. Cost: some 90 instructions for each pair of channels.

use super::transform::filter_transform;
use crate::dsn::conv::Conv;
use crate::dsn::per_channel::PerChannelQuant;
use crate::fixed::Requantizer;
use crate::simd::dual_mac::{DualMac, I16x8, POINTS, Tile, lane};

/// The channel that comes `k`-th in a group of four.
const ORDER: [usize; 4] = [0, 2, 1, 3];

/// Output channels that a step packs, at most some 44 000 instructions on Cortex-M4F.
const OUTPUTS: usize = 16;

/// Words of an output channel: what four times its sum starts with, then its [`Requantizer`].
pub const WORDS: usize = 1 + Requantizer::WORDS;

/// The words of output channel `o` with `taps` weights of this `sum`, for inputs as u8 = i8 + 128; `None` if an
/// accumulator or the scale is not within a [`Requantizer`]'s range.
pub fn channel(quant: &PerChannelQuant<'_>, o: usize, sum: i32, taps: usize) -> Option<[i32; WORDS]> {
    let bias = i64::from(quant.bias(o));
    let start = bias - i64::from(i32::from(quant.in_zp) + 128) * i64::from(sum);
    if (bias.abs() + 255 * 128 * taps as i64).max(start.abs()) >= Requantizer::MAX_ACCUMULATOR {
        return None;
    }
    let (multiplier, shift) = quant.scale(o);
    let [multiplier, offset, shift] = Requantizer::new(multiplier, shift, quant.out_zp)?.to_words();
    Some([(start << 2) as i32, multiplier, offset, shift])
}

/// Whether there are kernels for so many channels: 8, 16 and 32, each a program of its own.
pub const fn covered(channels: usize) -> bool {
    matches!(channels, 8 | 16 | 32)
}

/// Transformed weights of a convolution with as many outputs as inputs.
pub const fn conv_vectors(channels: usize) -> usize {
    if covered(channels) { channels / 2 * POINTS * (channels / 4) } else { 0 }
}

/// The input tiles of a convolution that runs.
pub const fn tile_vectors(channels: usize) -> usize {
    if covered(channels) { POINTS * (channels / 4) } else { 0 }
}

/// Words of its constants.
pub const fn conv_words(channels: usize) -> usize {
    if covered(channels) { channels * WORDS } else { 0 }
}

/// Steps that packing takes.
pub const fn steps(channels: usize) -> usize {
    channels.div_ceil(OUTPUTS)
}

/// Does step `step` of packing a convolution in the order of `P`; `None` if the kernels cannot compute it.
pub fn pack<P: DualMac>(
    conv: &Conv<'_>,
    step: usize,
    vectors: &mut [I16x8],
    constants: &mut [i32],
) -> Option<()> {
    match conv.inputs {
        8 => outputs::<P, 2>(conv, step, vectors, constants),
        16 => outputs::<P, 4>(conv, step, vectors, constants),
        32 => outputs::<P, 8>(conv, step, vectors, constants),
        _ => None,
    }
}

/// A 3x3 kernel of four channels at a time.
type Taps<const GROUPS: usize> = [[[u8; 4]; GROUPS]; 9];

fn outputs<P: DualMac, const GROUPS: usize>(
    conv: &Conv<'_>,
    step: usize,
    vectors: &mut [I16x8],
    constants: &mut [i32],
) -> Option<()> {
    let (taps, _) = conv.quant.weights.as_chunks::<4>();
    let (taps, _) = taps.as_chunks::<GROUPS>();
    let (taps, _): (&[Taps<GROUPS>], _) = taps.as_chunks::<9>();
    let (vectors, _) = vectors.as_chunks_mut::<GROUPS>();
    let (tiles, _) = vectors.as_chunks_mut::<POINTS>();
    let (constants, _) = constants.as_chunks_mut::<WORDS>();
    let all = taps.iter().zip(constants).enumerate().skip(step * OUTPUTS).take(OUTPUTS);
    for (o, (taps, words)) in all {
        let sum = output::<P, GROUPS>(taps, o % 2, tiles.get_mut(o / 2)?);
        *words = channel(&conv.quant, o, sum, 9 * conv.inputs)?;
    }
    Some(())
}

/// Packs one output, the first or the second of a pair; returns the sum of its weights.
#[inline(never)]
fn output<P: DualMac, const GROUPS: usize>(taps: &Taps<GROUPS>, part: usize, tile: &mut Tile<GROUPS>) -> i32 {
    let mut sum = 0;
    for group in 0..GROUPS {
        let (vector, first) = lane::<P>(group, part);
        for (k, channel) in ORDER.into_iter().enumerate() {
            let columns = filter_transform(|tap| i32::from(taps[tap % 9][group][channel % 4] as i8));
            sum += columns[1][1]; // both rows of G there are 1, 1, 1
            for (column, [a, b, c, d]) in columns.into_iter().enumerate() {
                for (row, value) in [b, c, a, -d].into_iter().enumerate() {
                    tile[4 * column + row][vector % GROUPS].0[(first + k) % 8] = value as i16;
                }
            }
        }
    }
    sum
}
