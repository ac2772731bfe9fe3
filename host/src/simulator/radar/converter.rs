//! Analog to digital conversion: full scale, thermal noise in its units, and rounding.

use super::SAMPLES;
use crate::numerics::vectors::vectorised;
use crate::scenario::{Effects, Radar, Scenario};
use crate::simulator::channel::room::expected_power;

/// Boltzmann's constant times 290 K in W/Hz.
pub const KT: f64 = 1.380_649e-23 * 290.0;

/// Amplitude of the leakage in sqrt W; 0 without.
pub(super) fn leakage(radar: &Radar, effects: &Effects) -> f64 {
    effects.isolation_db.map_or(0.0, |db| radar.power_w.sqrt() * libm::pow(10.0, -db / 20.0))
}

/// Real and imaginary parts of a slot of the paper's radar, by turns.
pub(super) type Pairs<T> = [[T; 2]; SAMPLES];

/// Analog to digital conversion: LSB per sqrt W and noise in LSB.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Converter {
    /// Amplitude of one LSB in sqrt W.
    pub lsb: f64,
    /// Standard deviation of the thermal noise of each value in LSB.
    pub noise_lsb: f64,
    /// Largest value in LSB; the smallest is one below its negative.
    pub(super) largest: f64,
    /// Places by which values are shifted up in their 16 bits.
    shift: u32,
}

impl Converter {
    /// Full scale is `headroom_db` above the loudest that is expected, with the leakage.
    ///
    /// Noise of power k T f_s F is that of both sidebands; I and Q, or the only real value, have half of it each.
    pub fn of(scenario: &Scenario) -> Self {
        let radar = &scenario.radar;
        let front = radar.power_w.sqrt() * libm::pow(10.0, radar.antenna_gain_db / 10.0);
        let mut received = front * expected_power(scenario).sqrt();
        let leakage = leakage(radar, &radar.effects());
        if leakage > 0.0 {
            received = (received * received + leakage * leakage).sqrt();
        }
        let full_scale = received * libm::pow(10.0, radar.headroom_db / 20.0);
        let bits = u32::from(radar.converter_bits);
        let largest = f64::from((1_u32 << (bits - 1)) - 1);
        let lsb = full_scale / largest;
        let figure = libm::pow(10.0, scenario.radar.noise_figure_db / 10.0);
        let noise = (KT * radar.sample_rate_hz * figure / 2.0).sqrt();
        let shift = if radar.left_justified { 16 - bits } else { 0 };
        Converter { lsb, noise_lsb: noise / lsb, largest, shift }
    }

    /// Nearest integer (halves to even), saturated to the converter's range.
    #[inline(always)]
    fn nearest(&self, x: f64) -> i16 {
        let smallest = -1.0 - self.largest;
        let x = if x < smallest { smallest } else { x };
        let x = if x > self.largest { self.largest } else { x };
        (x + ROUNDING).to_bits() as i16
    }

    /// The same, justified.
    pub(super) fn convert(&self, x: f64) -> i16 {
        self.nearest(x) << self.shift
    }

    /// Real and imaginary parts of the samples of a slot of the paper's radar, each with its noise.
    #[inline(always)]
    pub(super) fn convert_all(
        &self,
        sample: impl Fn(usize) -> [f64; 2] + Copy,
        noise: &Pairs<f64>,
        values: &mut Pairs<i16>,
    ) {
        vectorised(
            #[inline(always)]
            || {
                // local copies, which the stores to `values` cannot change: else the compiler makes no vectors
                let (converter, sample) = (*self, sample);
                for n in 0..SAMPLES {
                    let ([re, im], [re_noise, im_noise]) = (sample(n), noise[n]);
                    let noisy = [re + converter.noise_lsb * re_noise, im + converter.noise_lsb * im_noise];
                    values[n] = noisy.map(
                        #[inline(always)]
                        |x| converter.nearest(x),
                    );
                }
            },
        );
        if self.shift > 0 {
            values.as_flattened_mut().iter_mut().for_each(|value| *value <<= self.shift);
        }
    }
}

/// Adding 1.5 * 2^52 rounds to an integer, halves to even, which the sum's mantissa ends with.
const ROUNDING: f64 = 6_755_399_441_055_744.0;

/// Nearest integer, halves to even; saturates.
#[inline(always)]
pub(super) fn round(x: f64) -> i32 {
    let [smallest, largest] = [i32::MIN, i32::MAX].map(f64::from);
    let x = if x < smallest { smallest } else { x };
    let x = if x > largest { largest } else { x };
    (x + ROUNDING).to_bits() as i32
}
