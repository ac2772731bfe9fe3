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
#[inline]
pub fn level(p: f32) -> i16 {
    let bits = p.to_bits();
    let exponent = (bits >> 23) as i32;
    if !(1..=254).contains(&exponent) {
        return FLOOR; // zero, subnormal, negative, infinite or not a number
    }
    ((exponent - 127) * LEVELS_PER_OCTAVE as i32 + within_octave((bits | 0x0080_0000) << 8)) as i16
}

/// `floor(64 log2 p)` for the leading 32 bits of a positive `p`: exact below 2^32, else up to 2^-31 of p too late.
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
