//! Grey levels: log magnitude in integers, 50 dB below the image's maximum is black.
//!
//! Section IV-A of the paper ("the spectrogram of the sensing signal"); the logarithm is exact:
//! level = floor(64 log2 |z|^2), read off the float's exponent and a table of mantissa thresholds.

use crate::frame::{FFT_LEN, ROWS};
use crate::math::exp2_fraction;
use crate::stft::Spectrum;

/// Level units per octave of power: one unit is 0.047 dB.
pub const LEVELS_PER_OCTAVE: u32 = 64;

/// Level of a cell without power.
pub const EMPTY: i16 = i16::MIN;

/// Smallest 24-bit significand whose power is at least 2^(i/64): `ceil(2^23 2^(i/64))`.
pub static SIGNIFICAND_THRESHOLDS: [u32; LEVELS_PER_OCTAVE as usize] = thresholds();

const fn thresholds() -> [u32; LEVELS_PER_OCTAVE as usize] {
    let mut table = [1 << 23; LEVELS_PER_OCTAVE as usize];
    let mut i = 1;
    while i < LEVELS_PER_OCTAVE as usize {
        let exact = exp2_fraction(i as u64, LEVELS_PER_OCTAVE as u64) * 8_388_608.0;
        table[i] = exact as u32 + 1; // never an integer for 0 < i < 64
        i += 1;
    }
    table
}

/// `floor(64 log2 p)` for a normal positive `p`, else [`EMPTY`]. Exact. Cost: six comparisons.
pub fn level(p: f32) -> i16 {
    let bits = p.to_bits();
    let exponent = (bits >> 23) as i32;
    if !(1..=254).contains(&exponent) {
        return EMPTY; // zero, subnormal, negative, infinite or not a number
    }
    let significand = bits & 0x007f_ffff | 0x0080_0000;
    let mut index = 0_usize;
    for step in [32, 16, 8, 4, 2, 1] {
        // index + step stays below 64; the mask lets the compiler see it
        if significand >= SIGNIFICAND_THRESHOLDS[(index + step) & 63] {
            index += step;
        }
    }
    ((exponent - 127) * LEVELS_PER_OCTAVE as i32 + index as i32) as i16
}

/// Writes frame `k`'s 64 levels into column `k` of `levels`, `[ROWS, frames]` row-major, and returns their maximum.
///
/// Row r holds the power of bins (r - 32) g .. (r - 32) g + g, g = `bins_per_row`, summed in ascending order.
pub fn levels(spectrum: &Spectrum, bins_per_row: u8, k: usize, frames: usize, levels: &mut [i16]) -> i16 {
    let g = usize::from(bins_per_row);
    let mut largest = EMPTY;
    for (r, row) in levels.chunks_exact_mut(frames.max(1)).enumerate().take(ROWS) {
        let first = (r * g).wrapping_sub(ROWS / 2 * g);
        let mut power = 0.0_f32;
        for t in 0..g {
            let bin = first.wrapping_add(t) % FFT_LEN;
            if let Some(z) = spectrum.get(bin) {
                power += z.re * z.re + z.im * z.im;
            }
        }
        let value = level(power);
        largest = largest.max(value);
        if let Some(cell) = row.get_mut(k) {
            *cell = value;
        }
    }
    largest
}

/// Grey level of a cell: 255 at the maximum, 0 at `range` level units below it or weaker; minus 128 as int8.
pub const fn pixel(level: i16, largest: i16, range: u16) -> i8 {
    let below = largest as i32 - level as i32;
    let range = range as i32;
    if level == EMPTY || below >= range || range == 0 {
        return -128;
    }
    (255 - below * 255 / range - 128) as i8
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;

    #[test]
    fn levels_are_the_floor_of_the_exact_logarithm() {
        for exponent in -126..=127_i32 {
            for (i, &threshold) in SIGNIFICAND_THRESHOLDS.iter().enumerate() {
                for significand in [threshold - 1, threshold, threshold + 1, threshold + 31] {
                    if !(1 << 23..1 << 24).contains(&significand) {
                        continue;
                    }
                    let p = f32::from_bits(((exponent + 127) as u32) << 23 | significand & 0x7f_ffff);
                    let exact = (f64::from(p).log2() * 64.0).floor() as i16;
                    assert_eq!(level(p), exact, "{p:e} near threshold {i}");
                }
            }
        }
        for p in [0.0, -1.0, 1e-40, f32::INFINITY, f32::NAN] {
            assert_eq!(level(p), EMPTY);
        }
    }

    #[test]
    fn grey_runs_from_the_maximum_to_the_range() {
        assert_eq!(pixel(100, 100, 1063), 127);
        assert_eq!(pixel(100 - 1062, 100, 1063), -127);
        assert_eq!(pixel(100 - 1063, 100, 1063), -128);
        assert_eq!(pixel(EMPTY, EMPTY, 1063), -128);
        assert_eq!(pixel(0, 0, 0), -128);
    }
}
