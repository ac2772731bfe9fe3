//! Kernels of 3x3 convolutions as Winograd's transform needs them, and their gradients back: `U = G g G'` (Lavin and Gray,
//! 2016).

use super::winograd::{PATCH, POINTS};
use std::array::from_fn;

/// From three taps to six points.
const G: [[f64; 3]; PATCH] = [
    [1.0 / 4.0, 0.0, 0.0],
    [-1.0 / 6.0, -1.0 / 6.0, -1.0 / 6.0],
    [-1.0 / 6.0, 1.0 / 6.0, -1.0 / 6.0],
    [1.0 / 24.0, 1.0 / 12.0, 1.0 / 6.0],
    [1.0 / 24.0, -1.0 / 12.0, 1.0 / 6.0],
    [0.0, 0.0, 1.0],
];

/// Values of a transformed set of `channels` by `channels` kernels.
pub fn transformed(channels: usize) -> usize {
    POINTS * channels * channels
}

/// Kernels `[o][i][9]` as `[point][i][o]`.
pub fn forward_kernels(kernels: &[f32], channels: usize) -> Vec<f32> {
    kernel_points(channels, |i, o, tap| kernels[(o * channels + i) * 9 + tap])
}

/// Kernels `[o][i][9]` as those of the input's gradient, mirrored, `[point][o][i]`.
pub fn backward_kernels(kernels: &[f32], channels: usize) -> Vec<f32> {
    kernel_points(channels, |o, i, tap| kernels[(o * channels + i) * 9 + 8 - tap])
}

fn kernel_points(channels: usize, kernel: impl Fn(usize, usize, usize) -> f32) -> Vec<f32> {
    let mut points = vec![0.0; transformed(channels)];
    for (from, to) in (0..channels).flat_map(|from| (0..channels).map(move |to| (from, to))) {
        let rows: [[f64; PATCH]; 3] = from_fn(|r| {
            let taps: [f64; 3] = from_fn(|c| f64::from(kernel(from, to, 3 * r + c)));
            G.map(|g| g[0] * taps[0] + g[1] * taps[1] + g[2] * taps[2])
        });
        for (point, g) in (0..POINTS).map(|point| (point, G[point / PATCH])) {
            let value: f64 = (0..3).map(|r| g[r] * rows[r][point % PATCH]).sum();
            points[(point * channels + from) * channels + to] = value as f32;
        }
    }
    points
}

/// Gradients of kernels `[o][i][9]` from the sum of parts `[point][i][o]`.
pub fn kernel_gradients<'a>(parts: impl Iterator<Item = &'a [f32]>, channels: usize) -> Vec<f32> {
    let mut sums = vec![0.0f64; transformed(channels)];
    for part in parts {
        sums.iter_mut().zip(part).for_each(|(sum, &part)| *sum += f64::from(part));
    }
    let mut gradients = Vec::with_capacity(9 * channels * channels);
    for (o, i) in (0..channels).flat_map(|o| (0..channels).map(move |i| (o, i))) {
        let at = |row: usize, column: usize| sums[((row * PATCH + column) * channels + i) * channels + o];
        let rows: [[f64; PATCH]; 3] =
            from_fn(|tap| from_fn(|column| (0..PATCH).map(|row| G[row][tap] * at(row, column)).sum()));
        let taps = (0..9).map(|tap| (0..PATCH).map(|c| G[c][tap % 3] * rows[tap / 3][c]).sum::<f64>() as f32);
        gradients.extend(taps);
    }
    gradients
}
