//! Log-magnitude image: levels in integers, quantised to int8 over a dynamic range below the maximum.
//!
//! Section IV-A of the paper ("the spectrogram of the sensing signal"); levels are exact: see [`logarithm`](crate::signal::logarithm).

use crate::dims::ROWS;
use crate::signal::logarithm::FLOOR;
use crate::signal::stft::Stft;
use bytemuck::must_cast_slice_mut;
use core::ops::Range;

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

/// Intensity of a cell: 127 at the maximum or above, -128 at `range` level units, up to 4095, below it or weaker.
pub const fn quantize_db(level: i16, largest: i16, range: u16) -> i8 {
    intensity(if level > largest { largest } else { level }, largest, range, reciprocal(range))
}

/// 2^32 over a range, rounded up: x / range, rounded down, is x times this over 2^32 for x < 255 range and ranges up to 4095.
const fn reciprocal(range: u16) -> u32 {
    if range == 0 { 0 } else { (u32::MAX / range as u32).wrapping_add(1) }
}

/// [`quantize_db`] of a level that is not above the largest.
#[inline(always)]
const fn intensity(level: i16, largest: i16, range: u16, reciprocal: u32) -> i8 {
    let below = (largest as i32 - level as i32) as u32;
    if level == FLOOR || below >= range as u32 {
        return -128;
    }
    (127 - (((below * 255) as u64 * reciprocal as u64) >> 32) as i32) as i8
}

/// Cells that are quantised at once before the others.
const LAST: usize = 16;

/// [`quantize_db`] of these cells in the memory of all levels, of which the image's bytes are the second half: the last cells first, for a
/// cell's place lies behind the levels of the cells before. `None` if they are not in it.
pub(crate) fn quantize(memory: &mut [i16], cells: Range<usize>, largest: i16, range: u16) -> Option<()> {
    let (all, mut end, reciprocal) = (memory.len(), cells.end, reciprocal(range));
    if end == all {
        // the last ones' places are their own levels
        let levels = *memory.last_chunk::<LAST>()?;
        let pixels = must_cast_slice_mut(memory).last_chunk_mut::<LAST>()?;
        for (pixel, level) in pixels.iter_mut().zip(levels) {
            *pixel = intensity(level, largest, range, reciprocal);
        }
        end -= LAST;
    }
    while end > cells.start {
        // from here on the places lie behind all levels
        let start = (2 * end).saturating_sub(all).max(cells.start);
        let (levels, rest) = memory.split_at_mut_checked(end)?;
        let pixels: &mut [i8] = must_cast_slice_mut(rest).get_mut((all + start).checked_sub(2 * end)?..)?;
        for (pixel, &level) in pixels.iter_mut().zip(levels.get(start..)?) {
            *pixel = intensity(level, largest, range, reciprocal);
        }
        end = start;
    }
    Some(())
}
