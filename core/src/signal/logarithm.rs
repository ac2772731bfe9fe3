//! The exact logarithm of a power in integers: level = floor(64 log2 p), read off the exponent, the significand's leading bits and
//! one threshold.

use crate::math::exp2_fraction;

/// Level units per octave of power: one unit is 0.047 dB.
pub const LEVELS_PER_OCTAVE: u32 = 64;

/// Level of a cell without power.
pub const FLOOR: i16 = i16::MIN;

/// Levels within an octave from which a significand counts: `floor(2^31 2^(i/64))`, below which level i is not reached.
pub static SIGNIFICAND_THRESHOLDS: [u32; LEVELS_PER_OCTAVE as usize + 1] = thresholds();

const fn thresholds() -> [u32; LEVELS_PER_OCTAVE as usize + 1] {
    let mut table = [u32::MAX; LEVELS_PER_OCTAVE as usize + 1];
    let mut i = 1;
    table[0] = (1 << 31) - 1;
    while i < LEVELS_PER_OCTAVE as usize {
        // never an integer for 0 < i < 64
        table[i] = (exp2_fraction(i as u64, LEVELS_PER_OCTAVE as u64) * 2_147_483_648.0) as u32;
        i += 1;
    }
    table
}

/// Leading bits of a significand, behind the first, by which [`LEVEL_FLOORS`] is indexed.
const INDEX_BITS: u32 = 7;

/// Level within the octave of the smallest significand with these leading bits: the next level is at most one up.
static LEVEL_FLOORS: [u8; 1 << INDEX_BITS] = floors();

const fn floors() -> [u8; 1 << INDEX_BITS] {
    let thresholds = thresholds();
    let mut table = [0; 1 << INDEX_BITS];
    let mut k = 0;
    let mut level = 0;
    while k < table.len() {
        let smallest = (1 << 31) + ((k as u32) << (31 - INDEX_BITS));
        while smallest > thresholds[level + 1] {
            level += 1;
        }
        table[k] = level as u8;
        k += 1;
    }
    table
}

/// Level within the octave of a significand, 2^31..2^32.
#[inline(always)]
fn within_octave(significand: u32) -> i32 {
    let floor = LEVEL_FLOORS[(significand << 1 >> (32 - INDEX_BITS)) as usize];
    // a floor is below 64; the mask lets the compiler see it
    let next = SIGNIFICAND_THRESHOLDS[usize::from(floor & 63) + 1];
    i32::from(floor) + i32::from(significand > next)
}

/// `floor(64 log2 p)` for a normal positive `p`, else [`FLOOR`]. Exact. Cost: a table, a comparison.
pub fn level(p: f32) -> i16 {
    let bits = p.to_bits();
    let exponent = (bits >> 23) as i32;
    if !(1..=254).contains(&exponent) {
        return FLOOR; // zero, subnormal, negative, infinite or not a number
    }
    let significand = (bits | 0x0080_0000) << 8;
    ((exponent - 127) * LEVELS_PER_OCTAVE as i32 + within_octave(significand)) as i16
}

/// `floor(64 log2 p)` for the leading 32 bits of a positive `p`: exact below 2^32, else at most 2^-31 of p too early.
#[inline(always)]
pub fn level_u64(p: u64) -> i16 {
    let (high, low) = ((p >> 32) as u32, p as u32);
    let (exponent, significand) = if high == 0 {
        let zeros = low.leading_zeros() & 31;
        (31 - zeros as i32, low << zeros)
    } else {
        let zeros = high.leading_zeros() & 31;
        (63 - zeros as i32, high << zeros | low >> 1 >> (31 - zeros))
    };
    (exponent * LEVELS_PER_OCTAVE as i32 + within_octave(significand)) as i16
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;

    #[test]
    fn levels_are_the_floor_of_the_exact_logarithm() {
        for exponent in -126..=127_i32 {
            for (i, &threshold) in SIGNIFICAND_THRESHOLDS.iter().enumerate() {
                let threshold = threshold >> 8;
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
        for (i, &threshold) in SIGNIFICAND_THRESHOLDS.iter().enumerate() {
            for significand in (-3..=3).map(|k| u64::from(threshold).wrapping_add_signed(k)) {
                for shift in [0, 1, 13, 31].into_iter().filter(|_| significand < 1 << 32) {
                    let exact = ((significand as f64).log2() * 64.0).floor() as i16 + 64 * shift;
                    let p = significand << shift;
                    assert_eq!(level_u64(p), exact, "{p} near threshold {i}");
                    assert_eq!(level_u64(p | ((1 << shift) - 1)), exact);
                }
            }
        }
        for p in 1..100_000_u64 {
            assert_eq!(level_u64(p), ((p as f64).log2() * 64.0 + 1e-9).floor() as i16);
        }
        for p in [0.0, -1.0, 1e-40, f32::INFINITY, f32::NAN] {
            assert_eq!(level(p), FLOOR);
        }
    }
}
