//! Range gate of a wide-band sensor: the range profile of a dechirped sweep around some bins, in integers.
//!
//! A range sample is the sum of `bins_per_sample` neighbouring bins of the sweep's DFT, Hann-windowed and with the phase taken at
//! the sweep's centre, where neighbours add up to one flat range cell. At most eight range samples are kept, so that each is one
//! inner product with a reference, which costs less than an FFT of which most bins are dropped: 8 L complex multiply-accumulates.
//!
//! With u = (2 n + 1 - L) / (2 L), g bins from k on and their centre q = k + (g - 1) / 2 the reference is
//! `exp(2 pi j q u) (1 + cos 2 pi u) / 2 sin(pi g u) / (g sin(pi u))` in Q1.15. M. Richards, Fundamentals of Radar Signal Processing,
//! section 2.7 (stretch processing) and 4.6.

use super::dechirp::{ComplexI16, to_q15};
use crate::config::{RadarConfig, RangeGate};
use crate::math::sin_cos_turn;

/// Writes the references of all range samples, `[range][fast_time]`.
///
/// Cost: four sines of f64 a sample, once; error below one LSB of Q1.15.
pub(crate) fn write_references(config: &RadarConfig, gate: RangeGate, table: &mut [ComplexI16]) {
    let length = usize::from(config.samples).max(1);
    let (l, g) = (length as u64, u64::from(gate.bins_per_sample));
    for (range, reference) in table.chunks_exact_mut(length).enumerate() {
        let twice_centre = 2 * (u64::from(gate.first_bin) + range as u64 * g) + g - 1;
        for (n, sample) in reference.iter_mut().enumerate() {
            // u in units of 1 / (4 l) of a turn is even: 2 (2 n + 1 - l), here taken modulo a turn
            let u = 2 * n as u64 + 1 + 4 * l - l;
            let (sine, cosine) = sin_cos_turn(twice_centre * u, 4 * l);
            let (_, hann) = sin_cos_turn(2 * u, 4 * l);
            // half turns: the argument of sin(pi g u) is g u / 2, and u is taken from -1/2 to 1/2; in the middle of an odd sweep it is 0
            let (over, under) = (sin_half(g, n as u64, l), sin_half(1, n as u64, l));
            let ratio = if under == 0.0 { g as f64 } else { over / under };
            let amplitude = 0.5 * (1.0 + hann) * ratio / g as f64;
            *sample = [to_q15(amplitude * cosine), to_q15(amplitude * sine)];
        }
    }
}

/// sin(pi g u), u = (2 n + 1 - l) / (2 l).
fn sin_half(g: u64, n: u64, l: u64) -> f64 {
    let (position, centre) = (2 * n + 1, l);
    let (sine, _) = sin_cos_turn(g * position.abs_diff(centre), 4 * l);
    if position < centre { -sine } else { sine }
}
