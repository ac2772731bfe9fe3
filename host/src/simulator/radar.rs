//! From the channel to raw slots: chirp, thermal noise, impairments, converter.
//!
//! r_j = h_j * s + n_j (eq. (rt)) at t = n / f_s, n = 1..=1000, as 16-bit I/Q. Delays are exact: a slot's beat is a
//! polynomial through its Chebyshev nodes, never a shift by whole samples. Full scale is 32767 LSB.

use super::channel::room::mean_power;
use super::channel::{BLOCKS, Blocks, Complex64, NODES, SWEEP_S, Sweep, phasor};
use super::random::Random;
use crate::scenario::{Radar, Scenario};
use sdp3_core::dims::{BLOCK_SAMPLES, Beat, Iq, SLOT_SAMPLES, Slot, ZERO_BEAT};
use sdp3_core::signal::dechirp::BEAT_SHIFT;
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
        let radar = &scenario.radar;
        let front = radar.power_w.sqrt() * libm::pow(10.0, radar.antenna_gain_db / 10.0);
        let full_scale = front * mean_power(scenario).sqrt() * libm::pow(10.0, radar.headroom_db / 20.0);
        let lsb = full_scale / 32767.0;
        let figure = libm::pow(10.0, scenario.radar.noise_figure_db / 10.0);
        let noise = (KT * SAMPLE_RATE * figure / 2.0).sqrt();
        Converter { lsb, noise_lsb: noise / lsb }
    }

    /// What the core's dechirp makes of a slot with these block means: its integers, its noise and that of the converter's
    /// rounding, averaged over a block.
    pub fn beat(&self, blocks: &Blocks, impairments: &mut Impairments, random: &mut Random) -> Beat {
        let scale = BLOCK_SAMPLES as f64 * 32767.0 / f64::from(1_u32 << BEAT_SHIFT);
        let noise = ((self.noise_lsb * self.noise_lsb + 1.0 / 12.0) / BLOCK_SAMPLES as f64).sqrt();
        let turn = impairments.turn();
        let mut beat = ZERO_BEAT;
        for ((out, z), image) in beat.iter_mut().zip(blocks).zip(IMAGE.iter()) {
            let z = z * turn / self.lsb;
            let z = impairments.direct * z + impairments.image * (z.conj() * image);
            out.re = round((z.re + noise * random.gaussian()) * scale);
            out.im = round((z.im + noise * random.gaussian()) * scale);
        }
        beat
    }
}

/// Mean over each block of conj(s)^2: what dechirping leaves of a mirrored signal.
static IMAGE: LazyLock<Blocks> = LazyLock::new(|| {
    let block = |b: usize| CHIRP[b * BLOCK_SAMPLES..(b + 1) * BLOCK_SAMPLES].iter();
    std::array::from_fn::<_, BLOCKS, _>(|b| {
        block(b).map(|s| (s * s).conj()).sum::<Complex64>() / BLOCK_SAMPLES as f64
    })
});

/// Nearest integer, halves to even.
fn round(x: f64) -> i32 {
    const MAGIC: f64 = 6_755_399_441_055_744.0; // 1.5 * 2^52
    (x + MAGIC - MAGIC) as i32
}

/// What real front ends add: the oscillator's phase from slot to slot, and I and Q that are neither equal nor in quadrature.
///
/// Q' = g (Q cos phi + I sin phi) turns x into a x + b conj(x) with a = (1 + g e^(j phi)) / 2 and b = (1 - g e^(-j phi)) / 2.
#[derive(Debug, Clone)]
pub struct Impairments {
    phase_rad: f64,
    direct: Complex64,
    image: Complex64,
    random: Random,
}

impl Impairments {
    /// Of a radar; `random` draws the phases.
    pub fn new(radar: &Radar, random: Random) -> Self {
        let gain = libm::pow(10.0, radar.iq_gain_db / 20.0);
        let phase = radar.iq_phase_deg * PI / 180.0;
        Impairments {
            phase_rad: radar.phase_noise_deg * PI / 180.0,
            direct: (phasor(phase) * gain + 1.0) / 2.0,
            image: (-phasor(-phase) * gain + 1.0) / 2.0,
            random,
        }
    }

    /// The oscillator's phase in the next slot.
    fn turn(&mut self) -> Complex64 {
        if self.phase_rad == 0.0 {
            Complex64::new(1.0, 0.0)
        } else {
            phasor(self.phase_rad * self.random.gaussian())
        }
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
pub fn slot(
    sweep: &Sweep,
    converter: &Converter,
    impairments: &mut Impairments,
    random: &mut Random,
) -> Slot {
    let turn = impairments.turn();
    let scaled: Sweep = sweep.map(|z| z * turn / converter.lsb);
    let (direct, image) = (impairments.direct, impairments.image);
    let mut samples = [Iq::default(); SLOT_SAMPLES];
    for ((sample, row), chirp) in samples.iter_mut().zip(INTERPOLATION.iter()).zip(CHIRP.iter()) {
        let (mut re, mut im) = (0.0, 0.0);
        for (w, z) in row.iter().zip(&scaled) {
            re += w * z.re;
            im += w * z.im;
        }
        let received = Complex64::new(re, im) * chirp;
        let received = direct * received + image * received.conj();
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

    /// Largest error of the interpolation against the exact sum, relative to the echo, over the samples.
    fn error(delay: f64) -> f64 {
        let found = beat(&tone(Complex64::new(1.0, 0.0), delay));
        let errors = found.iter().enumerate().map(|(n, z)| {
            let t = (n + 1) as f64 / SAMPLE_RATE;
            let phase = PI * 1e11 * delay * delay - 2.0 * PI * 1e11 * delay * t;
            (z - phasor(phase)).norm_sqr().sqrt()
        });
        errors.fold(0.0, f64::max)
    }

    #[test]
    fn interpolation_holds_delays_to_160_db() {
        for delay in [0.0, 0.3e-9, 13.4e-9, 60e-9, 110e-9] {
            assert!(error(delay) < 1e-8, "{delay}: {:e}", error(delay));
        }
        // 190 ns: a corner path of the largest room, 20 m
        assert!(error(190e-9) < 1e-5, "{:e}", error(190e-9));
    }

    #[test]
    fn a_slot_is_the_delayed_chirp_itself() {
        // two echoes far above the noise, summed sample by sample at t - tau, against the slot through the nodes
        let converter = Converter { lsb: 1e-4, noise_lsb: 0.0 };
        let echoes = [(0.9, 21.37e-9), (1.3, 6.671e-9)];
        let mut sweep = Sweep::default();
        for (amplitude, delay) in echoes {
            super::super::channel::accumulate(&mut sweep, &tone(Complex64::new(amplitude, 0.0), delay));
        }
        let random = Random::new(0, 0, 0, 0);
        let mut clean = Impairments::new(&Scenario::default().radar, random.clone());
        let slot = slot(&sweep, &converter, &mut clean, &mut random.clone());
        for (n, sample) in slot.iter().enumerate() {
            let t = (n + 1) as f64 / SAMPLE_RATE;
            let exact: Complex64 =
                echoes.iter().map(|&(a, tau)| phasor(PI * 1e11 * (t - tau) * (t - tau)) * (a / 1e-4)).sum();
            assert!((f64::from(sample.i) - exact.re).abs() < 0.501, "{n}");
            assert!((f64::from(sample.q) - exact.im).abs() < 0.501, "{n}");
        }
    }

    #[test]
    fn thermal_noise_is_minus_94_dbm_at_10_db_noise_figure() {
        let scenario = Scenario::default();
        let converter = Converter::of(&scenario);
        let power = 2.0 * (converter.noise_lsb * converter.lsb) * (converter.noise_lsb * converter.lsb);
        // k T B F = -174 dBm/Hz + 70 dB + 10 dB
        let dbm = 10.0 * libm::log10(power * 1e3);
        assert!((dbm + 93.98).abs() < 0.02, "{dbm}");
    }

    #[test]
    fn the_converter_rounds_and_saturates() {
        assert_eq!([0.4, 0.6, -0.6, 1e9, -1e9].map(convert), [0, 1, -1, 32767, -32768]);
    }
}
