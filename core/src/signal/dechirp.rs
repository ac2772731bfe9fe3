//! Dechirp and decimate: the received chirp times the conjugate of the sent one, summed in blocks.
//!
//! Eq. (X) of the paper, conj(s~ . conj(x_j)) = conj(s~) . x_j, then a boxcar over [`BLOCK_SAMPLES`](crate::dims::BLOCK_SAMPLES) samples.

use crate::dims::{BEATS, Beat, Complex, Iq, SLOT_SAMPLES, Slot, ZERO_BEAT};
use crate::math::sin_cos_turn;
use crate::simd::conj_mac::conj_mac;

/// The sent chirp `s[n] = exp(j pi n^2 / 1000)`, n = 1..=1000, in Q1.15 (scaled by 32767), `[fast_time]`.
///
/// B t^2 / T_sw with t = n / f_s gives pi n^2 / 1000 = 2 pi n^2 / 2000, in whole parts of a turn: the phase is exact.
pub static CHIRP: [Iq; SLOT_SAMPLES] = chirp();

const fn chirp() -> [Iq; SLOT_SAMPLES] {
    let mut table = [Iq { i: 0, q: 0 }; SLOT_SAMPLES];
    let mut n = 0;
    while n < SLOT_SAMPLES {
        let (sine, cosine) = sin_cos_turn((n as u64 + 1) * (n as u64 + 1), 2000);
        table[n] = Iq { i: to_q15(cosine), q: to_q15(sine) };
        n += 1;
    }
    table
}

/// Rounds 32767 x to the nearest integer, halves away from zero.
const fn to_q15(x: f64) -> i16 {
    let scaled = 32767.0 * x;
    if scaled < 0.0 { (scaled - 0.5) as i16 } else { (scaled + 0.5) as i16 }
}

/// Bits dropped from a block's sum: 125 samples of 31-bit products leave 25.5 bits, so that the Gram matrix of
/// 4000 slots still fits 64 bits.
pub const BEAT_SHIFT: u32 = 12;

/// Dechirps one slot.
///
/// In: `[fast_time]` ADC samples. Out: [`Beat`], `round(sum / 2^12)`, halves up. Exact integers throughout:
/// the products fit i32 (|x| |s| <= 1.52e9), the sums i64. Cost: 4000 multiply-accumulates.
pub fn dechirp(slot: &Slot) -> Beat {
    let mut beat = ZERO_BEAT;
    for (value, [re, im]) in beat.iter_mut().zip(conj_mac(slot, &CHIRP)) {
        *value = Complex::new(round_beat(re), round_beat(im));
    }
    beat
}

/// `round(sum / 2^BEAT_SHIFT)`, halves up.
const fn round_beat(sum: i64) -> i32 {
    ((sum + (1 << (BEAT_SHIFT - 1))) >> BEAT_SHIFT) as i32
}

const _: () = assert!(BEATS == 8, "the weights and the model format assume eight beat samples");

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_chirp_against_itself_is_a_constant() {
        let slot: Slot = CHIRP;
        let full = (32767_i64 * 32767 * 125) >> BEAT_SHIFT;
        for value in dechirp(&slot) {
            // rounding of the table: each sample is off by at most 0.71 of 32767
            assert!((i64::from(value.re) - full).abs() < full / 30_000, "{}", value.re);
            assert!(i64::from(value.im).abs() < full / 30_000);
        }
    }

    #[test]
    fn a_full_scale_slot_stays_within_the_stated_magnitude() {
        let mut slot = [Iq { i: i16::MIN, q: i16::MIN }; SLOT_SAMPLES];
        // align every sample with the chirp's quadrant: the worst case of the sum
        for (x, s) in slot.iter_mut().zip(&CHIRP) {
            x.i = if s.i < 0 { i16::MIN } else { i16::MAX };
            x.q = if s.q < 0 { i16::MIN } else { i16::MAX };
        }
        for value in dechirp(&slot) {
            let power = i64::from(value.re).pow(2) + i64::from(value.im).pow(2);
            assert!(power < 1 << 51, "{value}");
        }
    }
}
