//! What real front ends add: leakage, compression, phases from slot to slot, unequal I and Q, an offset.

use super::LEAKAGE_DELAY_S;
use super::converter::{Converter, leakage};
use crate::numerics::random::Random;
use crate::scenario::{Effects, Format, Radar};
use crate::simulator::channel::{Complex64, phasor};
use std::f64::consts::{PI, TAU};

/// Full scale over the attenuator's compression point in dB, where an attenuator keeps it there.
const ATTENUATOR_DB: f64 = 3.0;

/// The transmitter's signal in the receiver: one path that does not change during a recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Leakage {
    /// Amplitude in sqrt W.
    pub gain: Complex64,
    /// Delay in s.
    pub delay_s: f64,
}

/// A soft limiter without memory: y = x / sqrt(1 + |x|^2 / A^2), Rapp's law of smoothness 1. At small signals it is of third order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limiter {
    /// 1 / A^2 in 1/W.
    pub steepness: f64,
}

impl Limiter {
    /// With 1 dB of compression at an input power.
    pub fn new(compression_dbm: f64) -> Self {
        let power_w = libm::pow(10.0, compression_dbm / 10.0 - 3.0);
        Limiter { steepness: (libm::pow(10.0, 0.1) - 1.0) / power_w }
    }

    /// Gain at an instantaneous input power in W.
    pub fn gain(&self, power_w: f64) -> f64 {
        1.0 / (1.0 + self.steepness * power_w).sqrt()
    }
}

/// Q' = g (Q cos phi + I sin phi) turns x into a x + b conj(x) with a = (1 + g e^(j phi)) / 2 and b = (1 - g e^(-j phi)) / 2.
#[derive(Debug, Clone)]
pub struct Impairments {
    /// Standard deviation of the phase from slot to slot in rad.
    phase_rad: f64,
    /// a.
    pub direct: Complex64,
    /// b.
    pub image: Complex64,
    /// What is added to every value, in LSB.
    pub offset: Complex64,
    /// The path from the transmitter.
    pub leakage: Option<Leakage>,
    /// The amplifier.
    pub limiter: Option<Limiter>,
    phases: Random,
}

impl Impairments {
    /// Of a radar; `phases` draws the phases from slot to slot, `module` what one recording has throughout.
    pub fn new(
        radar: &Radar,
        effects: &Effects,
        converter: &Converter,
        phases: Random,
        mut module: Random,
    ) -> Self {
        let gain = libm::pow(10.0, effects.iq_gain_db / 20.0);
        let phase = effects.iq_phase_deg * PI / 180.0;
        // both are drawn in any case: one does not depend on whether there is the other
        let [leaked, offset] = [(); 2].map(|()| phasor(TAU * module.uniform()));
        let offset = match radar.format {
            Format::Complex => offset,
            Format::Real => Complex64::new(if offset.re < 0.0 { -1.0 } else { 1.0 }, 0.0),
        };
        let full_scale = converter.largest * converter.lsb;
        let above_dbm = 20.0 * libm::log10(full_scale) + 30.0 + ATTENUATOR_DB;
        Impairments {
            phase_rad: radar.phase_noise_deg * PI / 180.0,
            direct: (phasor(phase) * gain + 1.0) / 2.0,
            image: (-phasor(-phase) * gain + 1.0) / 2.0,
            offset: offset * (effects.dc_offset * converter.largest),
            leakage: effects
                .isolation_db
                .map(|_| Leakage { gain: leaked * leakage(radar, effects), delay_s: LEAKAGE_DELAY_S }),
            limiter: effects
                .compression_dbm
                .map(|dbm| Limiter::new(if effects.attenuator { dbm.max(above_dbm) } else { dbm })),
            phases,
        }
    }

    /// Whether a value passes as it is, but for the phase from slot to slot and the leakage.
    pub fn is_ideal(&self) -> bool {
        let zero = Complex64::default();
        self.limiter.is_none() && [self.direct - 1.0, self.image, self.offset] == [zero; 3]
    }

    /// Whether the phase changes from slot to slot.
    pub fn turns(&self) -> bool {
        self.phase_rad != 0.0
    }

    /// The oscillator's phase in the next slot.
    pub fn turn(&mut self) -> Complex64 {
        if self.turns() { phasor(self.phase_rad * self.phases.gaussian()) } else { Complex64::new(1.0, 0.0) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::{FrontEnd, Scenario};

    #[test]
    fn gain_is_one_decibel_less_at_the_compression_point() {
        for dbm in [-20.0, -7.0, 13.0] {
            let limiter = Limiter::new(dbm);
            let db = |dbm: f64| 20.0 * libm::log10(limiter.gain(libm::pow(10.0, dbm / 10.0 - 3.0)));
            assert!((db(dbm) + 1.0).abs() < 1e-9);
            assert!(db(dbm - 40.0) > -1e-3 && db(dbm + 10.0) < -5.0);
            // third order: ten times less compression 10 dB below
            assert!((db(dbm - 20.0) / db(dbm - 30.0) - 10.0).abs() < 0.05);
        }
    }

    #[test]
    fn an_attenuator_keeps_compression_above_full_scale_and_a_stated_value_is_kept() {
        let mut scenario = Scenario::default();
        scenario.radar.front_end = FrontEnd::Typical;
        let gain = |scenario: &Scenario| {
            let (converter, effects) = (Converter::of(scenario), scenario.radar.effects());
            let random = Random::new(0, 0, 0, 0);
            let found = Impairments::new(&scenario.radar, &effects, &converter, random.clone(), random);
            let full_scale = converter.largest * converter.lsb;
            20.0 * libm::log10(found.limiter.unwrap().gain(full_scale * full_scale))
        };
        assert!(gain(&scenario) > -0.6, "{}", gain(&scenario));
        scenario.radar.compression_dbm = Some(-10.0);
        assert!(gain(&scenario) < -20.0, "{}", gain(&scenario));
    }

    #[test]
    fn image_rejection_is_the_formulas() {
        let mut scenario = Scenario::default();
        (scenario.radar.iq_gain_db, scenario.radar.iq_phase_deg) = (Some(0.2), Some(1.0));
        let random = Random::new(0, 0, 0, 0);
        let converter = Converter::of(&scenario);
        let found =
            Impairments::new(&scenario.radar, &scenario.radar.effects(), &converter, random.clone(), random);
        let (g, phi) = (libm::pow(10.0, 0.01), PI / 180.0);
        let cosine = 2.0 * g * libm::cos(phi);
        let exact = 10.0 * libm::log10((g * g + cosine + 1.0) / (g * g - cosine + 1.0));
        let ratio = 10.0 * libm::log10(found.direct.norm_sqr() / found.image.norm_sqr());
        assert!((ratio - exact).abs() < 1e-9 && (ratio - 36.8).abs() < 0.1, "{ratio} {exact}");
        // a tone in quadrature: I = cos, Q' = g sin(x + phi)
        for x in [0.3, 1.9, 4.0] {
            let z = phasor(x);
            let y = found.direct * z + found.image * z.conj();
            assert!((y.re - z.re).abs() < 1e-12 && (y.im - g * libm::sin(x + phi)).abs() < 1e-12);
        }
    }
}
