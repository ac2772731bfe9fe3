//! Products of a window with the weights of four channels, each alone: the inner loop of depthwise convolutions.

/// A window over `[height, width, channels]`, and its weights `[height, width, channels]`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub struct DepthwiseWindow {
    /// Rows of the window, at least one.
    pub rows: usize,
    /// Columns, at least one.
    pub columns: usize,
    /// Channels: from a pixel to the next, of the input and of the weights.
    pub channels: usize,
    /// From a row to the next, of the input.
    pub input_row: usize,
    /// The same of the weights.
    pub weight_row: usize,
}

impl DepthwiseWindow {
    /// Values from the first to the last that is read, of the input and of the weights.
    #[inline(always)]
    pub fn reach(&self) -> [usize; 2] {
        let last = |row: usize| {
            let columns = self.columns.saturating_sub(1).saturating_mul(self.channels);
            self.rows.saturating_sub(1).saturating_mul(row).saturating_add(columns).saturating_add(4)
        };
        [last(self.input_row), last(self.weight_row)]
    }
}

/// Adds `(x - zero) w` of four successive channels, the first of `input` and of `weights` (i8), to their sums. Wraps. Nothing is added if either
/// is shorter than [`DepthwiseWindow::reach`].
#[inline(always)]
pub fn portable(input: &[i8], weights: &[u8], window: &DepthwiseWindow, zero: i8, sums: &mut [i32; 4]) {
    let [input_reach, weight_reach] = window.reach();
    if input.len() < input_reach || weights.len() < weight_reach {
        return;
    }
    let mut found = *sums;
    for row in 0..window.rows {
        for column in 0..window.columns {
            let at = |of_row: usize| row * of_row + column * window.channels;
            let four = input.get(at(window.input_row)..).and_then(|from| from.first_chunk::<4>());
            let weights = weights.get(at(window.weight_row)..).and_then(|from| from.first_chunk::<4>());
            if let (Some(four), Some(weights)) = (four, weights) {
                for ((sum, &x), &w) in found.iter_mut().zip(four).zip(weights) {
                    *sum = sum.wrapping_add((i32::from(x) - i32::from(zero)) * i32::from(w as i8));
                }
            }
        }
    }
    *sums = found;
}
