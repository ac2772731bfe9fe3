//! Convolutions of any window, stride and number of channels: TFLite's CONV_2D and DEPTHWISE_CONV_2D in int8.
//!
//! TFLite 8-bit specification: acc = bias + sum (x - z_x) w, y = requantize(acc) + z_y, clamped; padding contributes nothing.

use super::node::Node;
use super::window::{covered, first_inside, place, rows};
use crate::dsn::established;
use crate::dsn::per_channel::PerChannelQuant;
use crate::dsn::winograd::clamp_all;
use crate::fixed::{Requantizer, TIMES_FOUR};
use crate::simd::depthwise_products::DepthwiseWindow;
use crate::simd::patch_products::{Fours, PIXELS, portable};
use crate::simd::{native_depthwise_products, native_patch_products, native_widen};
use core::ops::Range;

/// Channels of a depthwise convolution at a time.
pub(super) const BLOCK: usize = 16;

/// Output channels of a step of a convolution at most.
const CHANNELS: usize = 64;

/// Values of a window that are gathered at a time, in fours.
const FOURS: usize = 72;

/// Writes the values `taps` of the window of output pixel `at`, less the zero point; outside of the input they are zero.
#[inline(never)]
fn gather(
    node: &Node<'_>,
    input: &[i8],
    at: (usize, usize),
    taps: &Range<usize>,
    patch: &mut [Fours],
    pixel: usize,
) {
    let (channels, zero) = (usize::from(node.input.channels).max(1), node.zero_points[0]);
    match first_inside(node, at) {
        // the whole window at once
        Some(first) if taps.len() == node.taps() => {
            let (row, [h, w]) = (usize::from(node.input.width) * channels, node.window_size());
            let mut values = input.get(first * channels..).unwrap_or_default();
            for tap in (0..h).map(|y| y * w * channels) {
                write(values.get(..w * channels).unwrap_or_default(), zero, patch, pixel, tap);
                values = values.get(row..).unwrap_or_default();
            }
        }
        inside => {
            if inside.is_none() {
                patch.iter_mut().for_each(|Fours([even, odd])| {
                    (even[pixel % PIXELS], odd[pixel % PIXELS]) = ([0; 2], [0; 2]);
                });
            }
            for (tap, place, count) in rows(node, at) {
                let [first, end] = [tap * channels, (tap + count) * channels];
                let (from, to) = (first.max(taps.start), end.min(taps.end));
                if from < to {
                    let values = established(input.get(place * channels..(place + count) * channels));
                    let values = established(values.get(from - first..to - first));
                    write(values, zero, patch, pixel, from - taps.start);
                }
            }
        }
    }
}

/// Writes values of window `pixel`, less `zero`, from value `at` of the patch on.
#[inline(always)]
fn write(values: &[i8], zero: i8, patch: &mut [Fours], pixel: usize, at: usize) {
    let (mut fours, mut values) = (patch.get_mut(at / 4..).unwrap_or_default(), values);
    let before = at % 4;
    if before != 0
        && let Some((first, rest)) = core::mem::take(&mut fours).split_first_mut()
    {
        let single;
        (single, values) = values.split_at_checked(4 - before).unwrap_or((values, &[]));
        (before..).zip(single).for_each(|(at, &value)| first.set(pixel, at, value, zero));
        fours = rest;
    }
    let (whole, single) = values.as_chunks::<4>();
    native_widen(whole, zero, fours, pixel);
    if let Some(last) = fours.get_mut(whole.len()) {
        single.iter().enumerate().for_each(|(at, &value)| last.set(pixel, at, value, zero));
    }
}

/// Four output pixels of a convolution.
struct FourPixels<'a> {
    node: &'a Node<'a>,
    quant: &'a PerChannelQuant<'a>,
    input: &'a [i8],
    patch: [Fours; FOURS],
    sums: [[i32; PIXELS]; CHANNELS],
}

impl FourPixels<'_> {
    /// Channels `channels`, at most [`CHANNELS`], of at most four pixels, from `first` on, into their values: the windows are gathered,
    /// then each channel's weights are read once for all pixels.
    fn compute(&mut self, first: usize, channels: Range<usize>, output: &mut [i8]) {
        let (node, taps) = (self.node, self.node.taps());
        let [_, columns, outputs] = node.output.shape();
        let pixels = (output.len() / outputs.max(1)).min(PIXELS);
        let sums = established(self.sums.get_mut(..channels.len()));
        channels.clone().zip(sums.iter_mut()).for_each(|(o, sums)| *sums = [self.quant.bias(o); PIXELS]);
        for start in (0..taps).step_by(4 * FOURS) {
            let window = start..taps.min(start + 4 * FOURS);
            let patch = established(self.patch.get_mut(..window.len().div_ceil(4)));
            if let (true, Some(last)) = (window.len() % 4 != 0, patch.last_mut()) {
                *last = Fours::ZERO;
            }
            for pixel in 0..pixels {
                let (y, x, _) = place(first + pixel, columns, 1);
                gather(node, self.input, (y, x), &window, patch, pixel);
            }
            let weights = established(self.quant.weights.get(channels.start * taps + start..));
            accumulate(patch, weights, taps, sums);
        }
        finish(self.quant, channels.start, sums, outputs, output);
    }
}

/// Adds the products of the windows with each channel's weights, `taps` behind those of the channel before.
#[inline(never)]
fn accumulate(patch: &[Fours], weights: &[u8], taps: usize, sums: &mut [[i32; PIXELS]]) {
    let mut weights = weights;
    for sums in sums {
        // a window that fills no four meets the next channel's weights with zeros
        let (fours, rest) = weights.as_chunks();
        native_patch_products(patch, fours, sums);
        if let Some(behind) = patch.get(fours.len()..).filter(|behind| !behind.is_empty()) {
            let mut four = [0; 4];
            four.iter_mut().zip(rest).for_each(|(to, from)| *to = *from);
            portable(behind, &[four], sums);
        }
        weights = weights.get(taps..).unwrap_or_default();
    }
}

/// Writes the outputs of the sums: successive channels of pixels with `outputs` channels.
#[inline(never)]
fn finish(
    quant: &PerChannelQuant<'_>,
    channel: usize,
    sums: &[[i32; PIXELS]],
    outputs: usize,
    output: &mut [i8],
) {
    let end = channel + sums.len();
    let multipliers = established(quant.multipliers.get(channel..end));
    let shifts = established(quant.shifts.get(channel..end));
    for (k, ((&multiplier, &shift), sums)) in multipliers.iter().zip(shifts).zip(sums).enumerate() {
        let o = channel + k;
        let places = [0, 1, 2, 3].map(|pixel| pixel * outputs + o).into_iter().zip(sums);
        let mut write = |at: usize, value: i8| {
            if let Some(to) = output.get_mut(at) {
                *to = value;
            }
        };
        match Requantizer::new::<TIMES_FOUR>(i32::from_le_bytes(multiplier), shift as i8, quant.out_zp) {
            Some(by) if by.takes(sums) => {
                places.for_each(|(at, sum)| write(at, by.apply::<TIMES_FOUR>(sum << 2)))
            }
            _ => places.for_each(|(at, &sum)| write(at, quant.output(o, sum))),
        }
    }
    for pixel in output.chunks_mut(outputs.max(1)) {
        let values = established(pixel.get_mut(channel..channel + sums.len()));
        clamp_all(values, (quant.act_min, quant.act_max));
    }
}

/// Does step `step` of a convolution, some `most` instructions of Cortex-M4F or those of one channel of four pixels; true after its last.
/// Cost: [`Node::taps`] multiply-accumulates a value.
pub(super) fn convolve(
    node: &Node<'_>,
    quant: &PerChannelQuant<'_>,
    input: &[i8],
    (step, most): (usize, usize),
    output: &mut [i8],
) -> bool {
    let [_, _, outputs] = node.output.shape();
    // a product is about an instruction, a value takes some more, and gathering two for each value under the window
    let (value, windows) = (PIXELS * (node.taps() + 32), PIXELS * (2 * node.taps() + 250));
    let most_channels = most.saturating_sub(windows) / value.max(1);
    let channels = most_channels.clamp(1, CHANNELS).min(outputs.max(1));
    let fours = (most / (windows + channels * value).max(1)).max(1);
    let parts = outputs.div_ceil(channels).max(1);
    let first = step / parts * fours * PIXELS;
    let channel = step % parts * channels;
    let pixels = established(output.get_mut(first * outputs..));
    let mut four =
        FourPixels { node, quant, input, patch: [Fours::ZERO; FOURS], sums: [[0; PIXELS]; CHANNELS] };
    let last = pixels.len() <= fours * PIXELS * outputs && channel + channels >= outputs;
    for (k, output) in pixels.chunks_mut((PIXELS * outputs).max(1)).take(fours).enumerate() {
        four.compute(first + k * PIXELS, channel..outputs.min(channel + channels), output);
    }
    last
}

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

/// Output values `range` of a depthwise convolution; output channel `o` reads channel `o / multiplier`.
pub(super) fn convolve_depthwise(
    node: &Node<'_>,
    quant: &PerChannelQuant<'_>,
    input: &[i8],
    range: Range<usize>,
    output: &mut [i8],
) {
    let ([_, width, channels], [_, w]) = (node.input.shape(), node.window_size());
    let outputs = usize::from(node.output.channels);
    for (at, first, values) in pixels(node, range, output) {
        let covered = covered(node, at);
        let window = DepthwiseWindow {
            rows: covered.rows,
            columns: covered.columns,
            channels,
            input_row: width * channels,
            weight_row: w * outputs,
        };
        let input = input.get(covered.pixel * channels..).unwrap_or_default();
        let weights = quant.weights.get(covered.tap * outputs..).unwrap_or_default();
        for (o, values) in (first..).step_by(BLOCK).zip(values.chunks_mut(BLOCK)) {
            let mut sums = [0; BLOCK];
            let sums = established(sums.get_mut(..values.len()));
            sums.iter_mut().zip(o..).for_each(|(sum, o)| *sum = quant.bias(o));
            // with a depth multiplier the inputs of four channels do not lie together
            let together = if channels == outputs { sums.len() / 4 * 4 } else { 0 };
            let (fours, rest) = established(sums.split_at_mut_checked(together));
            let (fours, _) = fours.as_chunks_mut();
            for (o, sums) in (o..).step_by(4).zip(fours) {
                let (input, weights) = (established(input.get(o..)), established(weights.get(o..)));
                native_depthwise_products(input, weights, &window, quant.in_zp, sums);
            }
            for (o, sum) in (o + together..).zip(rest) {
                *sum = sum.wrapping_add(one_channel(input, weights, &window, outputs, quant.in_zp, o));
            }
            scale(quant, o, sums, values);
        }
    }
}

/// The products of a depthwise window for output channel `o` of `outputs`.
#[inline(never)]
fn one_channel(
    input: &[i8],
    weights: &[u8],
    window: &DepthwiseWindow,
    outputs: usize,
    zero: i8,
    o: usize,
) -> i32 {
    let channels = window.channels.max(1);
    let channel = o / (outputs / channels).max(1);
    let mut sum = 0_i32;
    for row in 0..window.rows {
        for column in 0..window.columns {
            let x: i8 = established(input.get(row * window.input_row + column * channels + channel).copied());
            let w: u8 = established(weights.get(row * window.weight_row + column * outputs + o).copied());
            sum = sum.wrapping_add((i32::from(x) - i32::from(zero)) * i32::from(w as i8));
        }
    }
    sum
}

/// [`PerChannelQuant::output`] of successive channels from `o` on, the same bits, by one high product and one shift where they are enough.
#[inline(never)]
fn scale(quant: &PerChannelQuant<'_>, o: usize, sums: &[i32], values: &mut [i8]) {
    let end = o + values.len();
    let multipliers = established(quant.multipliers.get(o..end));
    let shifts = established(quant.shifts.get(o..end));
    let channels = multipliers.iter().zip(shifts).zip(sums).zip(values.iter_mut()).enumerate();
    for (k, (((&multiplier, &shift), &sum), value)) in channels {
        *value =
            match Requantizer::new::<TIMES_FOUR>(i32::from_le_bytes(multiplier), shift as i8, quant.out_zp) {
                Some(by) if by.takes(&[sum]) => by.apply::<TIMES_FOUR>(sum << 2),
                _ => quant.output(o + k, sum),
            };
    }
    clamp_all(values, (quant.act_min, quant.act_max));
}
