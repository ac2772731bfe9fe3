//! Log-magnitude image: levels in integers, quantised to int8 over a dynamic range below the maximum.
//!
//! Section IV-A of the paper ("the spectrogram of the sensing signal"); levels are exact: see [`logarithm`](crate::signal::logarithm).

use crate::dims::ROWS;
use crate::signal::logarithm::FLOOR;
use crate::signal::stft::Stft;

/// Writes frame `k`'s 64 levels into column `k` of `levels`, `[ROWS, frames]` row-major, and returns their maximum.
///
/// Row r holds the power of bins (r - 32) g .. (r - 32) g + g, g = `bins_per_row`.
pub fn log_magnitudes<T: Stft>(
    spectrum: &T::Spectrum,
    bins_per_row: u8,
    k: usize,
    frames: usize,
    levels: &mut [i16],
) -> i16 {
    let g = usize::from(bins_per_row);
    let (mut largest, mut first) = (FLOOR, (ROWS / 2 * g).wrapping_neg());
    for cell in levels.iter_mut().skip(k).step_by(frames.max(1)).take(ROWS) {
        *cell = T::level(spectrum, first, g);
        largest = largest.max(*cell);
        first = first.wrapping_add(g);
    }
    largest
}

/// Intensity of a cell: 127 at the maximum, -128 at `range` level units below it or weaker.
pub const fn quantize_db(level: i16, largest: i16, range: u16) -> i8 {
    let below = largest as i32 - level as i32;
    let range = range as i32;
    if level == FLOOR || below >= range || range == 0 {
        return -128;
    }
    (255 - below * 255 / range - 128) as i8
}
