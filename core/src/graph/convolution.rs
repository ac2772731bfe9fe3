//! Convolutions of any window, stride and number of channels: TFLite's CONV_2D and DEPTHWISE_CONV_2D in int8.
//!
//! TFLite 8-bit specification: acc = bias + sum (x - z_x) w, y = requantize(acc) + z_y, clamped; padding contributes nothing.

use super::node::Node;
use crate::dsn::established;
use crate::dsn::per_channel::PerChannelQuant;
use core::ops::Range;

/// The pixels of an axis that lie under a window: the first of the window's own, and the pixels.
fn under(
    window: usize,
    stride: usize,
    padding: usize,
    length: usize,
    output: usize,
) -> (usize, Range<usize>) {
    let first = output * stride;
    let (skipped, start) = (padding.saturating_sub(first), first.saturating_sub(padding));
    let end = (first + window).saturating_sub(padding).min(length);
    (skipped, start..end.max(start))
}

/// For every pixel of the input under the window of output pixel `(y, x)`: its number in the window, and in the input.
pub(super) fn pixels(
    node: &Node<'_>,
    (y, x): (usize, usize),
) -> impl Iterator<Item = (usize, usize)> + use<> {
    let [height, width, _] = node.input.shape();
    let ([h, w], [sh, sw], [top, left]) =
        (node.window_size(), node.window.stride.map(usize::from), node.window.padding.map(usize::from));
    let (skipped_rows, rows) = under(h, sh, top, height, y);
    let (skipped, columns) = under(w, sw, left, width, x);
    rows.enumerate().flat_map(move |(row, y)| {
        let first = (skipped_rows + row) * w + skipped;
        columns.clone().enumerate().map(move |(k, x)| (first + k, y * width + x))
    })
}

/// The place of value `index` of a tensor of so many columns and channels: row, column, channel.
pub(super) fn place(index: usize, columns: usize, channels: usize) -> (usize, usize, usize) {
    let (pixel, channel) = (index / channels.max(1), index % channels.max(1));
    (pixel / columns.max(1), pixel % columns.max(1), channel)
}

/// Output values `range` of a convolution. Cost: [`Node::taps`] multiply-accumulates a value.
pub(super) fn convolve(
    node: &Node<'_>,
    quant: &PerChannelQuant<'_>,
    input: &[i8],
    range: Range<usize>,
    output: &mut [i8],
) {
    let [_, columns, outputs] = node.output.shape();
    let (channels, zero, taps) =
        (usize::from(node.input.channels).max(1), i32::from(quant.in_zp), node.taps());
    for (index, out) in range.zip(output) {
        let (y, x, o) = place(index, columns, outputs);
        let weights = established(quant.weights.get(o * taps..(o + 1) * taps));
        let mut sum = quant.bias(o);
        for (tap, pixel) in pixels(node, (y, x)) {
            let values = established(input.get(pixel * channels..(pixel + 1) * channels));
            let weights = established(weights.get(tap * channels..(tap + 1) * channels));
            for (&x, &w) in values.iter().zip(weights) {
                sum = sum.wrapping_add((i32::from(x) - zero) * i32::from(w as i8));
            }
        }
        *out = quant.output(o, sum);
    }
}

/// Output values `range` of a depthwise convolution; output channel `o` reads channel `o / multiplier`.
pub(super) fn convolve_depthwise(
    node: &Node<'_>,
    quant: &PerChannelQuant<'_>,
    input: &[i8],
    range: Range<usize>,
    output: &mut [i8],
) {
    let [_, columns, outputs] = node.output.shape();
    let (channels, zero) = (usize::from(node.input.channels).max(1), i32::from(quant.in_zp));
    let multiplier = (outputs / channels).max(1);
    for (index, out) in range.zip(output) {
        let (y, x, o) = place(index, columns, outputs);
        let mut sum = quant.bias(o);
        for (tap, pixel) in pixels(node, (y, x)) {
            let x: i8 = established(input.get(pixel * channels + o / multiplier).copied());
            let w: u8 = established(quant.weights.get(tap * outputs + o).copied());
            sum = sum.wrapping_add((i32::from(x) - zero) * i32::from(w as i8));
        }
        *out = quant.output(o, sum);
    }
}
