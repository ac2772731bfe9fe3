//! Seconds of a single-channel Doppler sensor as images, by the core's own front end.
//!
//! A recording is one number a time (the real part of a complex one), at 2 kHz, AC-coupled, cut into seconds: what `sdp3 classify` makes of
//! it. A carrier above 30 GHz takes proportionally higher rates where the recording has them; a slower recording keeps its own. Simulated
//! seconds are draws of [`crate::simulator::randomised`].

use crate::experiments::RunContext;
use crate::formats::model_file::Preprocessing;
use crate::formats::slots::Slots;
use crate::network::interchange::header;
use crate::network::parameters::Images;
use crate::network::spectrograms::images_of;
use crate::numerics::random::Random;
use crate::recordings::{Samples, Signal, doppler};
use crate::scenario::Scenario;
use crate::scenario::builtin::named;
use crate::simulator::calibration::conditioning::ac_couple;
use crate::simulator::calibration::intensity::{BETA, RANGE_DB};
use crate::simulator::calibration::slots_without_clutter;
use crate::simulator::channel::Complex64;
use crate::simulator::randomised::{Motion, draw};
use rayon::prelude::*;
use sdp3_core::config::{RadarConfig, SampleFormat};
use sdp3_core::dims::ROWS;
use std::path::Path;

/// Rate of comparison in Hz, up to this carrier in Hz.
const RATE_HZ: f64 = 2000.0;
const RATE_CARRIER_HZ: f64 = 30e9;
/// Slowest recording in Hz: slower ones hold no second of spectrogram.
pub const SLOWEST_HZ: f64 = 400.0;
/// Stream of [`Layout::noise`].
const NOISE_STREAM: u64 = 0x6e6f_6973;

/// What images look like at a carrier and a rate: the scenario of such a sensor.
#[derive(Debug, Clone, PartialEq)]
pub struct Layout(Scenario);

impl Layout {
    /// For a recording; `None` if it is too slow.
    pub fn of(signal: &Signal) -> Option<Self> {
        let target_hz = RATE_HZ * (signal.carrier_hz / RATE_CARRIER_HZ).clamp(1.0, 2.0);
        let rate_hz = signal.rate_hz.min(target_hz).round();
        let mut scenario = named(Path::new("doppler-24ghz"))?.scenario();
        scenario.radar.carrier_hz = signal.carrier_hz;
        scenario.frame.slot_s = 1.0 / rate_hz;
        scenario.frame.sensing_slots = vec![rate_hz as u32];
        // windows of 64 ms every 12 ms
        let slots = |seconds: f64| (seconds * rate_hz).round() as u16;
        let spectrogram = &mut scenario.spectrogram;
        (spectrogram.window, spectrogram.hop) = (slots(0.064).clamp(64, 256), slots(0.012).max(4));
        (spectrogram.range_db, spectrogram.beta) = (RANGE_DB, BETA as f32);
        (rate_hz >= SLOWEST_HZ).then_some(Layout(scenario))
    }

    /// Rate in Hz.
    fn rate_hz(&self) -> f64 {
        1.0 / self.0.interval_s()
    }

    /// Samples of a window.
    pub fn second(&self) -> usize {
        self.0.largest_sensing_slots() as usize
    }

    /// STFT frames of a second.
    fn frames(&self) -> usize {
        self.0.spectrogram.preprocessing().frames(self.second())
    }

    /// The image of one second of slots.
    fn image(&self, second: &[i16]) -> Vec<i8> {
        let slots = Slots { values: second.to_vec(), per_slot: 1 };
        images_of(&self.0, &slots).pop().unwrap_or_default()
    }

    /// A recording as the sensor's slots.
    fn slots(&self, signal: &Signal) -> Vec<i16> {
        let real = |x: f64| Complex64::new(x, 0.0);
        let samples = match &signal.samples {
            Samples::Real(x) => x.iter().map(|&x| real(x)).collect(),
            Samples::Complex(z) => z.iter().map(|z| real(z.re)).collect(),
            Samples::Slots(slots) => {
                let slow = slots_without_clutter(slots, RadarConfig::PAPER).unwrap_or_default();
                slow.iter().map(|z| real(z.re)).collect()
            }
        };
        let slow = doppler::coupled(samples, signal.rate_hz, self.rate_hz());
        doppler::slots(&slow, SampleFormat::Real).values
    }

    /// Images of the seconds of a recording that begin `step` samples after each other.
    pub fn seconds(&self, signal: &Signal, step: usize, label: u8) -> Images {
        let slots = self.slots(signal);
        let seconds: Vec<&[i16]> = slots.windows(self.second()).step_by(step).collect();
        let each: Vec<Vec<i8>> = seconds.par_iter().map(|second| self.image(second)).collect();
        self.images(each.concat(), vec![label; seconds.len()])
    }

    /// Images of seconds of white noise.
    pub fn noise(&self, seed: u64, count: u32) -> Images {
        let second = |n: u32| {
            let mut random = Random::new(seed, NOISE_STREAM, 0, u64::from(n));
            let mut noise: Vec<_> =
                (0..2 * self.second()).map(|_| Complex64::new(random.gaussian(), 0.0)).collect();
            ac_couple(&mut noise, self.rate_hz());
            self.image(&doppler::slots(&noise[self.second()..], SampleFormat::Real).values)
        };
        let each: Vec<Vec<i8>> = (0..count).into_par_iter().map(second).collect();
        self.images(each.concat(), vec![0; count as usize])
    }

    fn images(&self, pixels: Vec<i8>, labels: Vec<u8>) -> Images {
        Images { rows: ROWS, frames: self.frames(), pixels, labels }
    }

    /// Simulated images, `count` of each motion, alternating.
    pub fn simulated(&self, seed: u64, set: u64, count: u32, context: RunContext) -> Images {
        let all = count * Motion::ALL.len() as u32;
        let (carrier_hz, rate_hz) = (self.0.radar.carrier_hz, self.rate_hz());
        let what = format!("{} GHz at {} Hz, seed {seed}", carrier_hz / 1e9, rate_hz.round());
        let stage = context.progress.stage("simulate", &what);
        let motion = |n: u32| Motion::ALL[n as usize % Motion::ALL.len()];
        let each: Vec<Vec<i8>> = (0..all)
            .into_par_iter()
            .map(|n| {
                let index = n / Motion::ALL.len() as u32;
                stage.step(u64::from(all));
                let drawn = draw(carrier_hz, rate_hz, motion(n), seed, set, index);
                let drawn: Vec<_> = drawn.into_iter().map(|y| Complex64::new(y, 0.0)).collect();
                self.image(&doppler::slots(&drawn, SampleFormat::Real).values)
            })
            .collect();
        stage.finish(&format!("{all} seconds, {what}"));
        let labels = (0..all).map(|n| motion(n) as u8).collect();
        self.images(each.concat(), labels)
    }

    /// As the model file says it.
    pub fn preprocessing(&self) -> Preprocessing {
        header(&self.0, self.second() as u32)
    }
}

impl std::fmt::Display for Layout {
    /// As part of a file's name.
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "{}-{}", self.0.radar.carrier_hz / 1e3, self.rate_hz().round())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tone(hz: f64, seconds: f64) -> Signal {
        let sample = |n: usize| libm::sin(std::f64::consts::TAU * hz * n as f64 / 44_100.0);
        let samples = Samples::Real((0..(44_100.0 * seconds) as usize).map(sample).collect());
        Signal {
            samples,
            rate_hz: 44_100.0,
            carrier_hz: 24.125e9,
            title: "tone".into(),
            power_db: 0.0,
            about: Default::default(),
        }
    }

    #[test]
    fn seconds_follow_one_another_with_the_label_of_the_file() {
        let signal = tone(300.0, 3.2);
        let layout = Layout::of(&signal).unwrap();
        let images = layout.seconds(&signal, layout.second(), Motion::Running as u8);
        // 79 frames of 64 rows
        assert_eq!((images.len(), images.frames), (3, 79));
        assert_eq!(layout.seconds(&signal, layout.second() / 2, 1).len(), 5);
        assert!(images.labels.iter().all(|&label| label == 1));
        // 300 Hz of 0..1 kHz in 64 rows: row 19; what lies far from it is black
        let row = |r: usize| images.image(2)[r * 79..(r + 1) * 79].to_vec();
        assert!(row(19).iter().all(|&p| p > 100), "{:?}", row(19));
        assert!(row(40).iter().all(|&p| p == -128), "{:?}", row(40));
        // noise fills every row
        let noise = layout.noise(1, 2);
        assert_eq!(noise.len(), 2);
        assert!(noise.image(1).chunks(79).all(|row| row.iter().any(|&p| p > 0)));
    }

    #[test]
    fn level_does_not_matter_and_slow_recordings_have_no_layout() {
        let mut signal = tone(300.0, 2.0);
        let layout = Layout::of(&signal).unwrap();
        let first = layout.seconds(&signal, layout.second(), 0);
        if let Samples::Real(x) = &mut signal.samples {
            x.iter_mut().for_each(|x| *x *= 1e-3);
        }
        let second = layout.seconds(&signal, layout.second(), 0);
        // but for the rounding of a level at its border
        assert!(second.pixels.iter().zip(&first.pixels).all(|(a, b)| a.abs_diff(*b) <= 1));
        signal.rate_hz = 20.0;
        assert_eq!(Layout::of(&signal), None);
        (signal.rate_hz, signal.carrier_hz) = (48e3, 60e9);
        assert_eq!(Layout::of(&signal).map(|l| l.second()), Some(4000));
    }
}
