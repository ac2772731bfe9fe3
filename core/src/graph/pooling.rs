//! Poolings of any window and stride: TFLite's MAX_POOL_2D and AVERAGE_POOL_2D in int8.
//!
//! Only pixels of the input count; an average rounds halves away from zero.

use super::node::Node;
use super::window::{place, rows};
use crate::dsn::established;
use crate::fixed::clamp_i8;
use core::ops::Range;

/// Output values `range` of a pooling by the largest value.
pub(super) fn pool_max(node: &Node<'_>, input: &[i8], range: Range<usize>, output: &mut [i8]) {
    pool(node, input, range, output, |values| values.fold(i32::from(i8::MIN), i32::max));
}

/// Output values `range` of a pooling by the average.
pub(super) fn pool_average(node: &Node<'_>, input: &[i8], range: Range<usize>, output: &mut [i8]) {
    pool(node, input, range, output, |values| {
        let (sum, count) = values.fold((0_i32, 0_i32), |(sum, count), x| (sum.wrapping_add(x), count + 1));
        let half = if sum > 0 { count / 2 } else { -(count / 2) };
        sum.wrapping_add(half).checked_div(count).unwrap_or(0)
    });
}

/// Output values `range` by what is made of the values under the window, in the activation's range.
fn pool(
    node: &Node<'_>,
    input: &[i8],
    range: Range<usize>,
    output: &mut [i8],
    of: impl Fn(&mut dyn Iterator<Item = i32>) -> i32,
) {
    let [_, columns, channels] = node.output.shape();
    let [low, high] = node.activation;
    for (index, out) in range.zip(output) {
        let (y, x, c) = place(index, columns, channels);
        let mut values = rows(node, (y, x))
            .flat_map(|(_, pixel, count)| pixel..pixel + count)
            .map(|pixel| i32::from(established::<i8>(input.get(pixel * channels + c).copied())));
        *out = clamp_i8(of(&mut values), low, high);
    }
}
