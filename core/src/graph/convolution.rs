//! Convolutions of any window, stride and number of channels: TFLite's CONV_2D and DEPTHWISE_CONV_2D in int8.
//!
//! TFLite 8-bit specification: acc = bias + sum (x - z_x) w, y = requantize(acc) + z_y, clamped; padding contributes nothing. Four
//! output channels are computed at a time, so that an input is loaded once for four products.

use super::node::Node;
use super::window::{place, rows};
use crate::dsn::established;
use crate::dsn::per_channel::PerChannelQuant;
use crate::fixed::Requantizer;
use crate::simd::native_row_products;
use core::ops::Range;

/// Output channels at a time.
pub(super) const BLOCK: usize = 4;

/// The parts of `range` that belong to one output pixel: its row and column, its first channel, its values.
fn pixels<'o>(
    node: &Node<'_>,
    range: Range<usize>,
    output: &'o mut [i8],
) -> impl Iterator<Item = ((usize, usize), usize, &'o mut [i8])> + use<'o> {
    let [_, columns, outputs] = node.output.shape();
    let (mut at, mut rest) = (range.start, output);
    core::iter::from_fn(move || {
        let (y, x, channel) = place(at, columns, outputs);
        let count = (outputs - channel).min(rest.len());
        let (values, behind) =
            core::mem::take(&mut rest).split_at_mut_checked(count).filter(|_| count > 0)?;
        (at, rest) = (at + count, behind);
        Some(((y, x), channel, values))
    })
}

/// Values of a window that are gathered, so that all output channels take them from one place.
const PATCH: usize = 1152;

/// Gathers the values under the window of output pixel `at`; outside of the input they are the zero point, which contributes nothing. `None`
/// if the window has more than [`PATCH`].
fn gather<'p>(
    node: &Node<'_>,
    input: &[i8],
    at: (usize, usize),
    patch: &'p mut [i8; PATCH],
) -> Option<&'p [i8]> {
    let channels = usize::from(node.input.channels).max(1);
    let patch = patch.get_mut(..node.taps())?;
    let mut covered = 0;
    for (tap, pixel, count) in rows(node, at) {
        let values = established(input.get(pixel * channels..(pixel + count) * channels));
        let outside = established(patch.get_mut(covered..tap * channels));
        outside.fill(node.zero_points[0]);
        let to = established(patch.get_mut(tap * channels..(tap + count) * channels));
        to.iter_mut().zip(values).for_each(|(to, from)| *to = *from);
        covered = (tap + count) * channels;
    }
    established(patch.get_mut(covered..)).fill(node.zero_points[0]);
    Some(patch)
}

/// Output values `range` of a convolution. Cost: [`Node::taps`] multiply-accumulates a value.
pub(super) fn convolve(
    node: &Node<'_>,
    quant: &PerChannelQuant<'_>,
    input: &[i8],
    range: Range<usize>,
    output: &mut [i8],
) {
    let (channels, taps) = (usize::from(node.input.channels).max(1), node.taps());
    let weights = |o: usize| established(quant.weights.get(o * taps..(o + 1) * taps));
    let mut patch = [0; PATCH];
    for (at, first, values) in pixels(node, range, output) {
        let gathered = gather(node, input, at, &mut patch);
        let add = |weights: [&[u8]; BLOCK], sums: &mut [i32; BLOCK]| match gathered {
            Some(values) => native_row_products(values, weights, quant.in_zp, sums),
            // a window too large to be gathered, row by row
            None => rows(node, at).for_each(|(tap, pixel, count)| {
                let values = established(input.get(pixel * channels..(pixel + count) * channels));
                let row = weights.map(|all| established(all.get(tap * channels..(tap + count) * channels)));
                native_row_products(values, row, quant.in_zp, sums);
            }),
        };
        let (blocks, rest) = values.as_chunks_mut::<BLOCK>();
        for (k, block) in blocks.iter_mut().enumerate() {
            let channel = [0, 1, 2, 3].map(|part| first + BLOCK * k + part);
            let mut sums = channel.map(|o| quant.bias(o));
            add(channel.map(weights), &mut sums);
            *block = scaled_block(quant, first + BLOCK * k, sums);
        }
        // channels that fill no block, each four times
        let first = first + BLOCK * blocks.len();
        for (o, out) in (first..).zip(rest) {
            let mut sums = [quant.bias(o); BLOCK];
            add([weights(o); BLOCK], &mut sums);
            *out = scaled(quant, o, sums[0]);
        }
    }
}

/// [`PerChannelQuant::output`], the same bits, by one high product and one shift where they are enough.
#[inline(always)]
fn scaled(quant: &PerChannelQuant<'_>, o: usize, sum: i32) -> i8 {
    let (multiplier, shift) = quant.scale(o);
    match Requantizer::new(multiplier, shift, quant.out_zp) {
        Some(requantizer) if i64::from(sum.unsigned_abs()) < Requantizer::MAX_ACCUMULATOR => {
            requantizer.apply(sum << 2).max(quant.act_min).min(quant.act_max)
        }
        _ => quant.output(o, sum),
    }
}

/// [`scaled`] of four channels, from `o` on.
#[inline(always)]
fn scaled_block(quant: &PerChannelQuant<'_>, o: usize, [a, b, c, d]: [i32; BLOCK]) -> [i8; BLOCK] {
    [scaled(quant, o, a), scaled(quant, o + 1, b), scaled(quant, o + 2, c), scaled(quant, o + 3, d)]
}

/// Output values `range` of a depthwise convolution; output channel `o` reads channel `o / multiplier`.
pub(super) fn convolve_depthwise(
    node: &Node<'_>,
    quant: &PerChannelQuant<'_>,
    input: &[i8],
    range: Range<usize>,
    output: &mut [i8],
) {
    let outputs = usize::from(node.output.channels);
    let (channels, zero) = (usize::from(node.input.channels).max(1), i32::from(quant.in_zp));
    let multiplier = (outputs / channels).max(1);
    for (at, first, values) in pixels(node, range, output) {
        let (blocks, rest) = values.as_chunks_mut::<BLOCK>();
        // a block reads four channels that lie together; with a depth multiplier they do not
        let whole = if multiplier == 1 { blocks.len() } else { 0 };
        for (k, block) in blocks.iter_mut().enumerate().take(whole) {
            let o = first + BLOCK * k;
            let mut sums = [0, 1, 2, 3].map(|part| quant.bias(o + part));
            for (tap, pixel, count) in rows(node, at) {
                for step in 0..count {
                    let x: [i8; BLOCK] = four(input, (pixel + step) * channels + o);
                    let w: [u8; BLOCK] = four(quant.weights, (tap + step) * outputs + o);
                    for part in 0..BLOCK {
                        let product = (i32::from(x[part]) - zero) * i32::from(w[part] as i8);
                        sums[part] = sums[part].wrapping_add(product);
                    }
                }
            }
            *block = scaled_block(quant, o, sums);
        }
        let singles = blocks.iter_mut().skip(whole).flatten().chain(rest);
        for (o, out) in (first + BLOCK * whole..).zip(singles) {
            let mut sum = quant.bias(o);
            for (tap, pixel, count) in rows(node, at) {
                for step in 0..count {
                    let x: i8 = established(input.get((pixel + step) * channels + o / multiplier).copied());
                    let w: u8 = established(quant.weights.get((tap + step) * outputs + o).copied());
                    sum = sum.wrapping_add((i32::from(x) - zero) * i32::from(w as i8));
                }
            }
            *out = scaled(quant, o, sum);
        }
    }
}

/// Four values that lie together.
#[inline(always)]
fn four<T: Copy>(values: &[T], at: usize) -> [T; BLOCK]
where
    [T; BLOCK]: Default,
{
    established(values.get(at..).and_then(|rest| rest.first_chunk()).copied())
}
