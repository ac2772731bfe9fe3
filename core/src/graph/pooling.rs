//! Poolings of any window and stride: TFLite's MAX_POOL_2D and AVERAGE_POOL_2D in int8.
//!
//! Only pixels of the input count; an average rounds halves away from zero.

use super::node::Node;
use super::window::{place, rows};
use crate::dsn::established;
use crate::fixed::clamp_i8;
use core::ops::Range;

/// Channels at a time, so that a window's pixels are found once for all of them.
pub(super) const BLOCK: usize = 8;

/// Output values `range` of a pooling by the largest value.
pub(super) fn pool_max(node: &Node<'_>, input: &[i8], range: Range<usize>, output: &mut [i8]) {
    pool(node, input, range, output, i32::from(i8::MIN), i32::max, |most, _| most);
}

/// Output values `range` of a pooling by the average.
pub(super) fn pool_average(node: &Node<'_>, input: &[i8], range: Range<usize>, output: &mut [i8]) {
    pool(node, input, range, output, 0, i32::wrapping_add, |sum, count| {
        let half = if sum > 0 { count / 2 } else { -(count / 2) };
        sum.wrapping_add(half).checked_div(count).unwrap_or(0)
    });
}

/// Output values `range`: the values under the window, taken together from `first` on, and what `of` makes of that and their number, in the
/// activation's range.
#[inline(always)]
fn pool(
    node: &Node<'_>,
    input: &[i8],
    range: Range<usize>,
    output: &mut [i8],
    first: i32,
    together: impl Fn(i32, i32) -> i32,
    of: impl Fn(i32, i32) -> i32,
) {
    let [_, columns, channels] = node.output.shape();
    let [low, high] = node.activation;
    let (mut at, mut rest) = (range.start, output);
    while !rest.is_empty() {
        let (y, x, channel) = place(at, columns, channels);
        let length = rest.len().min(channels - channel).min(BLOCK);
        let Some((values, behind)) = core::mem::take(&mut rest).split_at_mut_checked(length) else { return };
        let (mut found, mut count) = ([first; BLOCK], 0);
        for (_, pixel, pixels) in rows(node, (y, x)) {
            for pixel in pixel..pixel + pixels {
                let under =
                    established(input.get(pixel * channels + channel..).and_then(|from| from.get(..length)));
                found.iter_mut().zip(under).for_each(|(found, &x)| *found = together(*found, i32::from(x)));
                count += 1;
            }
        }
        values
            .iter_mut()
            .zip(found)
            .for_each(|(value, found)| *value = clamp_i8(of(found, count), low, high));
        (at, rest) = (at + length, behind);
    }
}
