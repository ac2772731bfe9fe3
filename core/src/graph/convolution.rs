//! Convolutions of any window, stride and number of channels: TFLite's CONV_2D and DEPTHWISE_CONV_2D in int8.
//!
//! TFLite 8-bit specification: acc = bias + sum (x - z_x) w, y = requantize(acc) + z_y, clamped; padding contributes nothing. Four
//! output channels are computed at a time, so that an input is loaded once for four products.

use super::node::Node;
use super::window::{place, rows};
use crate::dsn::established;
use crate::dsn::per_channel::PerChannelQuant;
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
    for (at, first, values) in pixels(node, range, output) {
        let (blocks, rest) = values.as_chunks_mut::<BLOCK>();
        for (k, block) in blocks.iter_mut().enumerate() {
            let channel = [0, 1, 2, 3].map(|part| first + BLOCK * k + part);
            let mut sums = channel.map(|o| quant.bias(o));
            let weights = channel.map(weights);
            for (tap, pixel, count) in rows(node, at) {
                let (first, length) = (tap * channels, count * channels);
                let values = established(input.get(pixel * channels..pixel * channels + length));
                let row = weights.map(|all| established(all.get(first..first + length)));
                block_of_products(values, row, quant.in_zp, &mut sums);
            }
            *block = [0, 1, 2, 3].map(|part| quant.output(channel[part], sums[part]));
        }
        let first = first + BLOCK * blocks.len();
        for (o, out) in (first..).zip(rest) {
            let (mut sum, weights) = (quant.bias(o), weights(o));
            for (tap, pixel, count) in rows(node, at) {
                let (first, length) = (tap * channels, count * channels);
                let values = established(input.get(pixel * channels..pixel * channels + length));
                let row = established(weights.get(first..first + length));
                for (&x, &w) in values.iter().zip(row) {
                    sum = sum.wrapping_add((i32::from(x) - i32::from(quant.in_zp)) * i32::from(w as i8));
                }
            }
            *out = quant.output(o, sum);
        }
    }
}

/// Adds the products of values with four rows of weights.
#[inline(never)]
fn block_of_products(values: &[i8], [a, b, c, d]: [&[u8]; BLOCK], zero: i8, sums: &mut [i32; BLOCK]) {
    let [mut s0, mut s1, mut s2, mut s3] = *sums;
    for ((((&x, &a), &b), &c), &d) in values.iter().zip(a).zip(b).zip(c).zip(d) {
        let x = i32::from(x) - i32::from(zero);
        s0 = s0.wrapping_add(x * i32::from(a as i8));
        s1 = s1.wrapping_add(x * i32::from(b as i8));
        s2 = s2.wrapping_add(x * i32::from(c as i8));
        s3 = s3.wrapping_add(x * i32::from(d as i8));
    }
    *sums = [s0, s1, s2, s3];
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
        // a block reads four channels that lie together, or one channel that is computed four times too often
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
            *block = [0, 1, 2, 3].map(|part| quant.output(o + part, sums[part]));
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
            *out = quant.output(o, sum);
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
