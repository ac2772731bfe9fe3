//! Samples of a Doppler sensor as the slots of the radar module: at its slot rate, AC-coupled, in 16 bits.
//!
//! A recording's level says nothing of the converter that the radar module would have, so every recording gets the same: 30 dB of head
//! room above its mean power. The spectrogram is on its own level anyway.

use crate::formats::slots::Slots;
use crate::numerics::filter::ac_couple;
use crate::numerics::resample::resample;
use rustfft::num_complex::Complex64;
use sdp3_core::config::SampleFormat;

/// Root of the mean power of a recording, in LSB.
const RMS_LSB: f64 = 1024.0;

/// At another rate in Hz if that is lower, AC-coupled.
pub fn coupled(samples: Vec<Complex64>, rate_hz: f64, slot_rate_hz: f64) -> Vec<Complex64> {
    let mut slow = samples;
    if rate_hz > slot_rate_hz {
        let part = |of: fn(&Complex64) -> f64| {
            resample(&slow.iter().map(of).collect::<Vec<_>>(), rate_hz, slot_rate_hz)
        };
        slow =
            part(|z| z.re).into_iter().zip(part(|z| z.im)).map(|(re, im)| Complex64::new(re, im)).collect();
    }
    ac_couple(&mut slow, slot_rate_hz);
    slow
}

/// One sample a slot, saturated. A positive frequency is an approaching target; of I and Q, the slots have the conjugate, as the beat of a
/// sweep does.
pub fn slots(slow: &[Complex64], format: SampleFormat) -> Slots {
    let power = slow.iter().map(|z| z.norm_sqr()).sum::<f64>() / slow.len().max(1) as f64;
    let scale = if power > 0.0 { RMS_LSB / power.sqrt() } else { 0.0 };
    let lsb = |x: f64| (scale * x).round() as i16;
    let values: Vec<i16> = match format {
        SampleFormat::Real => slow.iter().map(|z| lsb(z.re)).collect(),
        SampleFormat::Complex => slow.iter().flat_map(|z| [lsb(z.re), lsb(-z.im)]).collect(),
    };
    Slots { values, per_slot: if format == SampleFormat::Real { 1 } else { 2 } }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sdp3_core::config::RadarConfig;
    use std::f64::consts::TAU;

    /// A tone of 8 kHz rate on a constant, at 2 kHz.
    fn tone(hz: f64) -> Vec<Complex64> {
        let sample = |n: usize| Complex64::from_polar(0.3, TAU * hz * n as f64 / 8000.0) + 5.0;
        coupled((0..16_000).map(sample).collect(), 8000.0, 2000.0)
    }

    #[test]
    fn a_recording_fills_the_converter_to_30_decibels_and_loses_its_constant() {
        for (format, config) in
            [(SampleFormat::Real, RadarConfig::DOPPLER), (SampleFormat::Complex, RadarConfig::DOPPLER_IQ)]
        {
            let slots = slots(&tone(300.0), format);
            assert_eq!((slots.per_slot, slots.len()), (config.values_per_slot(), 4000));
            let beats = slots.beats(config).unwrap();
            // settled: the constant is gone, and an approaching target has a positive frequency
            let sum = |hz: f64| {
                let turn = |n: usize| Complex64::from_polar(1.0, -TAU * hz * n as f64 / 2000.0);
                let settled = beats.iter().enumerate().skip(2000);
                let sum: Complex64 = settled
                    .map(|(n, b)| Complex64::new(f64::from(b[0].re), f64::from(b[0].im)) * turn(n))
                    .sum();
                sum.norm() / 2000.0
            };
            let negative = if format == SampleFormat::Real { sum(300.0) } else { 0.0 };
            assert!(sum(0.0) < 2.0 && sum(300.0) > 400.0, "{}", sum(0.0));
            assert!((sum(-300.0) - negative).abs() < 2.0, "{}", sum(-300.0));
        }
    }

    #[test]
    fn silence_is_silent_and_a_click_saturates() {
        assert!(slots(&[Complex64::default(); 10], SampleFormat::Real).values.iter().all(|&x| x == 0));
        let mut click = vec![Complex64::new(1.0, 0.0); 10_000];
        click[7].re = 1000.0;
        assert_eq!(slots(&click, SampleFormat::Real).values[7], i16::MAX);
    }
}
