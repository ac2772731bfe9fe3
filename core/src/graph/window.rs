//! Which pixels of the input lie under a window.

use super::node::Node;
use core::ops::Range;

/// The pixels of an axis that lie under a window: how many of the window's own come before, and the pixels.
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

/// The part of a window that lies over the input: its first pixel, counted in the window and in the input, and its size.
pub(super) struct Covered {
    pub tap: usize,
    pub pixel: usize,
    pub rows: usize,
    pub columns: usize,
}

/// The part of the window of output pixel `(y, x)` that lies over the input.
pub(super) fn covered(node: &Node<'_>, (y, x): (usize, usize)) -> Covered {
    let [height, width, _] = node.input.shape();
    let ([h, w], [sh, sw], [top, left]) =
        (node.window_size(), node.window.stride.map(usize::from), node.window.padding.map(usize::from));
    let (skipped_rows, rows) = under(h, sh, top, height, y);
    let (skipped, columns) = under(w, sw, left, width, x);
    Covered {
        tap: skipped_rows * w + skipped,
        pixel: rows.start * width + columns.start,
        rows: rows.len(),
        columns: columns.len(),
    }
}

/// For every row of [`covered`]: number of its first pixel in the window and in the input, and how many pixels lie side by side.
pub(super) fn rows(
    node: &Node<'_>,
    at: (usize, usize),
) -> impl Iterator<Item = (usize, usize, usize)> + use<> {
    let Covered { tap, pixel, rows, columns } = covered(node, at);
    let ([_, w], width) = (node.window_size(), usize::from(node.input.width));
    (0..rows).map(move |row| (tap + row * w, pixel + row * width, columns))
}

/// Number of the first pixel under the window of output pixel `(y, x)`, if all of the window lies over the input.
pub(super) fn first_inside(node: &Node<'_>, (y, x): (usize, usize)) -> Option<usize> {
    let ([height, width, _], [h, w]) = (node.input.shape(), node.window_size());
    let ([sh, sw], [top, left]) = (node.window.stride.map(usize::from), node.window.padding.map(usize::from));
    let [y, x] = [(y * sh).checked_sub(top)?, (x * sw).checked_sub(left)?];
    (y + h <= height && x + w <= width).then_some(y * width + x)
}

/// The place of value `index` of a tensor of so many columns and channels: row, column, channel.
pub(super) fn place(index: usize, columns: usize, channels: usize) -> (usize, usize, usize) {
    let (pixel, channel) = (index / channels.max(1), index % channels.max(1));
    (pixel / columns.max(1), pixel % columns.max(1), channel)
}
