//! From the channel to raw slots: chirp, thermal noise, converter.
//!
//! r_j = h_j * s + n_j (eq. (rt)) at t = n / f_s, n = 1..=1000, as 16-bit I/Q. Delays are exact: a slot's beat is a
//! polynomial through its Chebyshev nodes, never a shift by whole samples.

use super::channel::autoregressive::mean_power_w;
use super::channel::{Complex64, NODES, SWEEP_S, Sweep, phasor};
use super::random::Random;
use crate::scenario::Scenario;
use sdp3_core::frame::{Iq, SLOT_SAMPLES, Slot};
use std::f64::consts::PI;
use std::sync::LazyLock;

/// Sampling rate and noise bandwidth in Hz.
pub const SAMPLE_RATE: f64 = 10e6;
/// Boltzmann's constant times 290 K in W/Hz.
pub const KT: f64 = 1.380_649e-23 * 290.0;

/// The sent chirp of amplitude 1, `[fast_time]`.
static CHIRP: LazyLock<Vec<Complex64>> = LazyLock::new(|| {
    (1..=SLOT_SAMPLES as u64).map(|n| phasor(PI * ((n * n) % 2000) as f64 / 1000.0)).collect()
});

/// Values of the Lagrange polynomials of the nodes at the samples, `[fast_time][node]`.
static INTERPOLATION: LazyLock<Vec<[f64; NODES]>> = LazyLock::new(|| {
    let node = |k: usize| (PI * (k as f64 + 0.5) / NODES as f64, k);
    (1..=SLOT_SAMPLES)
        .map(|n| {
            let x = 1.0 - 2.0 * (n as f64 / SAMPLE_RATE) / SWEEP_S;
            let x = libm::acos(x.clamp(-1.0, 1.0));
            // discrete cosine synthesis: sum over degrees of T_d(x) T_d(x_k)
            std::array::from_fn(|k| {
                let (angle, _) = node(k);
                let sum: f64 =
                    (1..NODES).map(|d| libm::cos(d as f64 * x) * libm::cos(d as f64 * angle)).sum();
                (1.0 + 2.0 * sum) / NODES as f64
            })
        })
        .collect()
});

/// Analog to digital conversion: LSB per sqrt W and noise in LSB.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Converter {
    /// Amplitude of one LSB in sqrt W.
    pub lsb: f64,
    /// Standard deviation of the thermal noise of each of I and Q in LSB.
    pub noise_lsb: f64,
}

impl Converter {
    /// Full scale (32767 LSB) is `headroom_db` above the room's mean received amplitude.
    pub fn of(scenario: &Scenario) -> Self {
        let full_scale = mean_power_w(scenario).sqrt() * libm::pow(10.0, scenario.radar.headroom_db / 20.0);
        let lsb = full_scale / 32767.0;
        let figure = libm::pow(10.0, scenario.radar.noise_figure_db / 10.0);
        let noise = (KT * SAMPLE_RATE * figure / 2.0).sqrt();
        Converter { lsb, noise_lsb: noise / lsb }
    }
}

/// The beat at the samples, `[fast_time]`, without the chirp.
#[cfg(test)]
fn beat(sweep: &Sweep) -> Vec<Complex64> {
    INTERPOLATION
        .iter()
        .map(|row| row.iter().zip(sweep).fold(Complex64::default(), |sum, (w, z)| sum + z * w))
        .collect()
}

/// Nearest integer (halves to even), saturated to the converter's range.
fn convert(x: f64) -> i16 {
    const MAGIC: f64 = 6_755_399_441_055_744.0; // 1.5 * 2^52
    (x.clamp(-32768.0, 32767.0) + MAGIC - MAGIC) as i16
}

/// One raw slot.
pub fn slot(sweep: &Sweep, converter: &Converter, random: &mut Random) -> Slot {
    let scaled: Sweep = sweep.map(|z| z / converter.lsb);
    let mut samples = [Iq::default(); SLOT_SAMPLES];
    for ((sample, row), chirp) in samples.iter_mut().zip(INTERPOLATION.iter()).zip(CHIRP.iter()) {
        let (mut re, mut im) = (0.0, 0.0);
        for (w, z) in row.iter().zip(&scaled) {
            re += w * z.re;
            im += w * z.im;
        }
        let received = Complex64::new(re, im) * chirp;
        *sample = Iq {
            i: convert(received.re + converter.noise_lsb * random.gaussian()),
            q: convert(received.im + converter.noise_lsb * random.gaussian()),
        };
    }
    samples
}

#[cfg(test)]
mod tests {
    use super::super::channel::tone;
    use super::*;

    #[test]
    fn interpolation_holds_delays_to_140_db() {
        for delay in [0.3e-9, 13.4e-9, 60e-9, 110e-9] {
            let found = beat(&tone(Complex64::new(1.0, 0.0), delay));
            for (n, z) in found.iter().enumerate() {
                let t = (n + 1) as f64 / SAMPLE_RATE;
                let phase = PI * 1e11 * delay * delay - 2.0 * PI * 1e11 * delay * t;
                assert!((z - phasor(phase)).norm_sqr().sqrt() < 1e-7, "{delay} {n}");
            }
        }
    }

    #[test]
    fn the_converter_rounds_and_saturates() {
        assert_eq!([0.4, 0.6, -0.6, 1e9, -1e9].map(convert), [0, 1, -1, 32767, -32768]);
    }
}
