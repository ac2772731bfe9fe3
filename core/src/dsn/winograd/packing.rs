//! A convolution's numbers in the order in which the kernels read them.
//!
//! Weights: for each pair of outputs the filter transform at 30 points, column by column (see [`Tile`]); channels of a group in
//! the order 0, 2, 1, 3, as masks take them out of a word. Constants: four words of every output channel. Cost: some 110
//! instructions for each pair of channels.

use super::transform::{FACTOR_BITS, filter_columns, filter_row};
use crate::dsn::conv::{Conv, MAX_CHANNELS, WIDEST};
use crate::dsn::per_channel::PerChannelQuant;
use crate::fixed::Requantizer;
use crate::simd::dual_mac::{Constants, DualMac, I16x8, POINT_ROWS, POINTS, Tile, lane, settle};

/// Output channels of a convolution with 64 inputs that are packed at a time: their memory is that of 32 channels.
const OUTPUTS: usize = 16;

/// Output channels that a step packs, at most some 44 000 instructions on Cortex-M4F.
const fn outputs_of_step(inputs: usize) -> usize {
    if inputs > MAX_CHANNELS { 8 } else { 16 }
}

/// Words of an output channel: what a multiple of its sum starts with, then its [`Requantizer`].
pub const WORDS: usize = size_of::<Constants>() / size_of::<i32>();

/// The words of output channel `o` with `taps` weights of this `sum`, for inputs as u8 = i8 + 128 and sums times 2^`BITS`; `None`
/// if an accumulator or the scale is not within a [`Requantizer`]'s range.
pub fn channel<const BITS: u32>(
    quant: &PerChannelQuant<'_>,
    o: usize,
    sum: i32,
    taps: usize,
) -> Option<Constants> {
    let bias = i64::from(quant.bias(o));
    let start = bias - i64::from(i32::from(quant.in_zp) + 128) * i64::from(sum);
    if (bias.abs() + 255 * 128 * taps as i64).max(start.abs()) >= 1 << (31 - BITS) {
        return None;
    }
    let (multiplier, shift) = quant.scale(o);
    let [multiplier, offset, shift] = Requantizer::new::<BITS>(multiplier, shift, quant.out_zp)?.to_words();
    Some([(start << BITS) as i32, multiplier, offset, shift])
}

/// Whether there are kernels for so many inputs and outputs: 8, 16 and 32 of both, each a program of its own; of graphs 64 too, and the three
/// of a colour image.
pub const fn covered(inputs: usize, outputs: usize) -> bool {
    let of_graphs =
        (inputs == 3 && matches!(outputs, 8 | 16 | 32)) || (inputs == WIDEST && outputs == WIDEST);
    (inputs == outputs && matches!(inputs, 8 | 16 | 32)) || (cfg!(feature = "graph") && of_graphs)
}

/// Output channels of a convolution that are packed at a time: all, or [`OUTPUTS`] of 64.
pub const fn packed_outputs(outputs: usize) -> usize {
    if outputs > MAX_CHANNELS { OUTPUTS } else { outputs }
}

/// Transformed weights of a convolution.
pub const fn conv_vectors(inputs: usize, outputs: usize) -> usize {
    if covered(inputs, outputs) { packed_outputs(outputs) / 2 * POINTS * inputs.div_ceil(4) } else { 0 }
}

/// Words of its constants.
pub const fn conv_words(inputs: usize, outputs: usize) -> usize {
    if covered(inputs, outputs) { packed_outputs(outputs) * WORDS } else { 0 }
}

/// Steps that packing what is packed at a time takes.
pub const fn steps(inputs: usize, outputs: usize) -> usize {
    packed_outputs(outputs).div_ceil(outputs_of_step(inputs))
}

/// Does step `step` of packing output channels of a convolution, from `first` on, in the order of `P`; `None` if the kernels cannot compute
/// them.
pub fn pack<P: DualMac>(
    conv: &Conv<'_>,
    first: usize,
    step: usize,
    vectors: &mut [I16x8],
    constants: &mut [i32],
) -> Option<()> {
    match conv.inputs {
        8 => outputs::<P, 4, 2>(conv, first, step, vectors, constants),
        16 => outputs::<P, 4, 4>(conv, first, step, vectors, constants),
        32 => outputs::<P, 4, 8>(conv, first, step, vectors, constants),
        #[cfg(feature = "graph")]
        3 => outputs::<P, 3, 1>(conv, first, step, vectors, constants),
        #[cfg(feature = "graph")]
        64 => outputs::<P, 4, 16>(conv, first, step, vectors, constants),
        _ => None,
    }
}

/// A 3x3 kernel of `C` channels at a time, three or four.
type Taps<const C: usize, const GROUPS: usize> = [[[u8; C]; GROUPS]; 9];

fn outputs<P: DualMac, const C: usize, const GROUPS: usize>(
    conv: &Conv<'_>,
    first: usize,
    step: usize,
    vectors: &mut [I16x8],
    constants: &mut [i32],
) -> Option<()> {
    let (taps, _) = conv.quant.weights.as_chunks::<C>();
    let (taps, _) = taps.as_chunks::<GROUPS>();
    let (taps, _): (&[Taps<C, GROUPS>], _) = taps.as_chunks::<9>();
    let (vectors, _) = vectors.as_chunks_mut::<GROUPS>();
    let (tiles, _) = vectors.as_chunks_mut::<POINTS>();
    let (constants, _) = constants.as_chunks_mut::<WORDS>();
    let count = outputs_of_step(conv.inputs);
    let all = taps.get(first..)?.iter().zip(constants).enumerate().skip(step * count).take(count);
    for (o, (taps, words)) in all {
        let sum = output::<P, C, GROUPS>(taps, o % 2, tiles.get_mut(o / 2)?);
        *words = channel::<FACTOR_BITS>(&conv.quant, first + o, sum, 9 * conv.inputs)?;
    }
    Some(())
}

/// Packs one output, the first or the second of a pair; returns the sum of its weights.
#[inline(never)]
fn output<P: DualMac, const C: usize, const GROUPS: usize>(
    taps: &Taps<C, GROUPS>,
    part: usize,
    tile: &mut Tile<GROUPS>,
) -> i32 {
    let mut sum = 0;
    for group in 0..GROUPS {
        let (vector, first) = lane::<P, GROUPS>(group, part);
        for k in 0..2 {
            let taps = taps.each_ref().map(|groups| {
                let weight = |channel: usize| {
                    if channel < C { i32::from(groups[group][channel % C] as i8) } else { 0 }
                };
                weight(k) + (weight(k + 2) << 16)
            });
            let all = settle(taps.iter().sum());
            sum += i32::from(all as i16) + (all >> 16);
            let rows = filter_columns(&taps);
            let at = (first + k) % 4;
            for row in 0..POINT_ROWS {
                for (column, value) in filter_row(rows.map(|values| values[row])).into_iter().enumerate() {
                    tile[POINT_ROWS * column + row][vector % GROUPS][at] = settle(value);
                }
            }
        }
    }
    sum
}
