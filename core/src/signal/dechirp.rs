//! Dechirp and decimate: the received chirp times the conjugate of the sent one, summed in blocks.
//!
//! Eq. (X) of the paper, conj(s~ . conj(x_j)) = conj(s~) . x_j, then a boxcar over the blocks.

use crate::config::RadarConfig;
use crate::math::sin_cos_turn;
pub(crate) use crate::simd::conj_mac::ComplexI16;

/// Complex samples that begin at a word: what the multiply-accumulate instructions of Arm load in fours.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(4))]
pub(crate) struct WordAligned<const N: usize>(pub [ComplexI16; N]);

const L: usize = RadarConfig::PAPER.samples as usize;

/// The paper's chirp `s[n] = exp(j pi n^2 / 1000)`, n = 1 to 1000, in Q1.15 (scaled by 32767), `[fast_time]`.
///
/// B t^2 / T_sw with t = n / f_s gives pi n^2 / 1000 = 2 pi n^2 / 2000, in whole parts of a turn: the phase is exact.
pub static CHIRP: [ComplexI16; L] = CHIRP_WORDS.0;

pub(crate) static CHIRP_WORDS: WordAligned<L> = {
    let mut table = WordAligned([[0; 2]; L]);
    let mut n = 0;
    while n < L {
        table.0[n] = chirp_sample(n, L);
        n += 1;
    }
    table
};

/// Sample n = 0..L - 1 of a chirp of L samples. Its bandwidth is the sampling rate.
const fn chirp_sample(n: usize, length: usize) -> ComplexI16 {
    let (sine, cosine) = sin_cos_turn((n as u64 + 1) * (n as u64 + 1), 2 * length as u64);
    [to_q15(cosine), to_q15(sine)]
}

/// Writes the chirp of `table.len()` samples.
pub(crate) fn write_chirp(table: &mut [ComplexI16]) {
    let length = table.len();
    table.iter_mut().enumerate().for_each(|(n, sample)| *sample = chirp_sample(n, length));
}

/// Rounds 32767 x to the nearest integer, halves away from zero.
pub(crate) const fn to_q15(x: f64) -> i16 {
    let scaled = 32767.0 * x;
    if scaled < 0.0 { (scaled - 0.5) as i16 } else { (scaled + 0.5) as i16 }
}
