//! A convolution's numbers in the order in which tiles read them.
//!
//! Weights: for each pair of outputs those at 16 points, U = G g G^T times four, column by column, rows in the order 1, 2,
//! 0, 3, row 3 negated (see [`Points`]); channels of a group in the order 0, 2, 1, 3, as masks take them out of a word.
//! Constants: a [`Rescale`] of every output channel. Cost: some 90 instructions for each pair of channels.

use super::rescale::{Rescale, WORDS};
use crate::dsn::conv::Conv;
use crate::simd::dual_mac::{DualMac, I16x8, POINTS, Points, place};

/// The channel that comes `k`-th in a group of four.
const ORDER: [usize; 4] = [0, 2, 1, 3];

/// Whether there are tiles of so many channels: 8, 16 and 32, each a program of its own.
pub const fn covered(channels: usize) -> bool {
    matches!(channels, 8 | 16 | 32)
}

/// Eights of a convolution with as many outputs as inputs.
pub const fn conv_eights(channels: usize) -> usize {
    if covered(channels) { channels / 2 * POINTS * (channels / 4) } else { 0 }
}

/// Words of its constants.
pub const fn conv_words(channels: usize) -> usize {
    if covered(channels) { channels * WORDS } else { 0 }
}

/// Packs a convolution in the order of `P`; `None` if tiles cannot compute it.
pub fn pack<P: DualMac>(conv: &Conv<'_>, eights: &mut [I16x8], constants: &mut [i32]) -> Option<()> {
    match conv.inputs {
        8 => outputs::<P, 2>(conv, eights, constants),
        16 => outputs::<P, 4>(conv, eights, constants),
        32 => outputs::<P, 8>(conv, eights, constants),
        _ => None,
    }
}

/// A 3x3 kernel of four channels at a time.
type Taps<const QUADS: usize> = [[[u8; 4]; QUADS]; 9];

fn outputs<P: DualMac, const QUADS: usize>(
    conv: &Conv<'_>,
    eights: &mut [I16x8],
    constants: &mut [i32],
) -> Option<()> {
    let (taps, _) = conv.quant.weights.as_chunks::<4>();
    let (taps, _) = taps.as_chunks::<QUADS>();
    let (taps, _): (&[Taps<QUADS>], _) = taps.as_chunks::<9>();
    let (eights, _) = eights.as_chunks_mut::<QUADS>();
    let (points, _) = eights.as_chunks_mut::<POINTS>();
    let (constants, _) = constants.as_chunks_mut::<WORDS>();
    for (pair, ((taps, constants), points)) in
        taps.chunks_exact(2).zip(constants.chunks_exact_mut(2)).zip(points).enumerate()
    {
        for (part, (taps, words)) in taps.iter().zip(constants).enumerate() {
            let sum = output::<P, QUADS>(taps, part, points);
            *words = Rescale::of(&conv.quant, 2 * pair + part, sum, 9 * conv.inputs)?.to_words();
        }
    }
    Some(())
}

/// Packs one output, the first or the second of a pair; returns the sum of its weights.
#[inline(never)]
fn output<P: DualMac, const QUADS: usize>(
    taps: &Taps<QUADS>,
    part: usize,
    points: &mut Points<QUADS>,
) -> i32 {
    let mut sum = 0;
    for quad in 0..QUADS {
        let (eight, first) = place::<P>(quad, part);
        for (k, lane) in ORDER.into_iter().enumerate() {
            let columns = at_points(|tap| i32::from(taps[tap][quad][lane % 4] as i8));
            sum += columns[1][1]; // both rows of G there are 1, 1, 1
            for (column, [a, b, c, d]) in columns.into_iter().enumerate() {
                for (row, value) in [b, c, a, -d].into_iter().enumerate() {
                    points[4 * column + row][eight % QUADS].0[(first + k) % 8] = value as i16;
                }
            }
        }
    }
    sum
}

/// The kernel's weights at the points, times four: `[column][row]`.
#[inline(always)]
pub fn at_points(tap: impl Fn(usize) -> i32) -> [[i32; 4]; 4] {
    let [a, b, c] = [0, 1, 2].map(|row| spread([tap(3 * row), tap(3 * row + 1), tap(3 * row + 2)]));
    [0, 1, 2, 3].map(|column| spread([a[column], b[column], c[column]]))
}

/// G on three weights, times two.
#[inline(always)]
fn spread([a, b, c]: [i32; 3]) -> [i32; 4] {
    [2 * a, a + b + c, a - b + c, 2 * c]
}
