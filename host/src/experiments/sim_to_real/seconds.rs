//! Seconds of a single-channel Doppler sensor as images.
//!
//! A recording is one number a time (the real part of a complex one), at 2 kHz, AC-coupled, cut into seconds, each on its own level:
//! spectrograms of 0..rate/2 in 64 rows. A carrier above 30 GHz takes proportionally higher rates where the recording has them; a slower
//! recording keeps its own. Simulated seconds are draws of [`crate::simulator::randomised`].

use crate::experiments::RunContext;
use crate::formats::model_file::Preprocessing;
use crate::network::parameters::Images;
use crate::numerics::random::Random;
use crate::recordings::{Samples, Signal};
use crate::simulator::calibration::conditioning::ac_couple;
use crate::simulator::calibration::intensity::{BETA, Intensity, RANGE_DB};
use crate::simulator::calibration::resample::resample;
use crate::simulator::calibration::slots_without_clutter;
use crate::simulator::channel::Complex64;
use crate::simulator::randomised::{Motion, draw};
use rayon::prelude::*;
use sdp3_core::config::RadarConfig;
use sdp3_core::dims::ROWS;

/// Rate of comparison in Hz, up to this carrier in Hz.
const RATE_HZ: f64 = 2000.0;
const RATE_CARRIER_HZ: f64 = 30e9;
/// Slowest recording in Hz: slower ones hold no second of spectrogram.
pub const SLOWEST_HZ: f64 = 400.0;
/// Stream of [`Layout::noise`].
const NOISE_STREAM: u64 = 0x6e6f_6973;

/// What images look like at a carrier and a rate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Layout {
    /// Carrier in Hz.
    pub carrier_hz: f64,
    /// Rate in Hz.
    pub rate_hz: f64,
    window: usize,
    hop: usize,
}

impl Layout {
    /// For a recording; `None` if it is too slow.
    pub fn of(signal: &Signal) -> Option<Self> {
        let target_hz = RATE_HZ * (signal.carrier_hz / RATE_CARRIER_HZ).clamp(1.0, 2.0);
        let rate_hz = signal.rate_hz.min(target_hz).round();
        // windows of 64 ms every 12 ms; the transform has 256 points
        let samples = |seconds: f64| (seconds * rate_hz).round() as usize;
        let (window, hop) = (samples(0.064).clamp(64, 256), samples(0.012).max(4));
        (rate_hz >= SLOWEST_HZ).then_some(Layout { carrier_hz: signal.carrier_hz, rate_hz, window, hop })
    }

    /// Samples of a window.
    pub fn second(&self) -> usize {
        self.rate_hz as usize
    }

    /// STFT frames of a second.
    fn frames(&self) -> usize {
        (self.second() - self.window) / self.hop + 1
    }

    /// The image of one AC-coupled second, on its own mean level.
    pub fn image(&self, second: &[f64]) -> Vec<i8> {
        let signal: Vec<_> = second.iter().map(|&y| Complex64::new(y, 0.0)).collect();
        let decibels = Intensity::new(self.window, self.hop).decibels(&signal, true);
        let pixel = |frame: &Vec<f64>, row: usize| {
            let power = |bin: usize| libm::pow(10.0, frame[bin] / 10.0);
            let db = 10.0 * libm::log10(0.5 * (power(2 * row) + power(2 * row + 1)));
            ((1.0 + db / RANGE_DB).clamp(0.0, 1.0) * 255.0 - 128.0) as i8
        };
        (0..ROWS).flat_map(|row| decibels.iter().map(move |frame| pixel(frame, row))).collect()
    }

    /// A recording at the layout's rate, AC-coupled.
    fn coupled(&self, signal: &Signal) -> Vec<f64> {
        let real = match &signal.samples {
            Samples::Real(x) => x.clone(),
            Samples::Complex(z) => z.iter().map(|z| z.re).collect(),
            Samples::Slots(slots) => {
                let slow = slots_without_clutter(slots, RadarConfig::PAPER).unwrap_or_default();
                slow.iter().map(|z| z.re).collect()
            }
        };
        let slow =
            if signal.rate_hz > self.rate_hz { resample(&real, signal.rate_hz, self.rate_hz) } else { real };
        let mut coupled: Vec<_> = slow.into_iter().map(|y| Complex64::new(y, 0.0)).collect();
        ac_couple(&mut coupled, self.rate_hz);
        coupled.iter().map(|z| z.re).collect()
    }

    /// Images of the seconds of a recording that begin `step` samples after each other.
    pub fn seconds(&self, signal: &Signal, step: usize, label: u8) -> Images {
        let real = self.coupled(signal);
        let seconds: Vec<&[f64]> = real.windows(self.second()).step_by(step).collect();
        let each: Vec<Vec<i8>> = seconds.par_iter().map(|second| self.image(second)).collect();
        self.images(each.concat(), vec![label; seconds.len()])
    }

    /// Images of seconds of white noise.
    pub fn noise(&self, seed: u64, count: u32) -> Images {
        let second = |n: u32| {
            let mut random = Random::new(seed, NOISE_STREAM, 0, u64::from(n));
            let mut noise: Vec<_> =
                (0..2 * self.second()).map(|_| Complex64::new(random.gaussian(), 0.0)).collect();
            ac_couple(&mut noise, self.rate_hz);
            let settled: Vec<f64> = noise[self.second()..].iter().map(|z| z.re).collect();
            self.image(&settled)
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
        let what = format!("{} GHz at {} Hz, seed {seed}", self.carrier_hz / 1e9, self.rate_hz);
        let stage = context.progress.stage("simulate", &what);
        let motion = |n: u32| Motion::ALL[n as usize % Motion::ALL.len()];
        let each: Vec<Vec<i8>> = (0..all)
            .into_par_iter()
            .map(|n| {
                let index = n / Motion::ALL.len() as u32;
                stage.step(u64::from(all));
                self.image(&draw(self.carrier_hz, self.rate_hz, motion(n), seed, set, index))
            })
            .collect();
        stage.finish(&format!("{all} seconds, {what}"));
        let labels = (0..all).map(|n| motion(n) as u8).collect();
        self.images(each.concat(), labels)
    }

    /// As the model file says it.
    pub fn preprocessing(&self) -> Preprocessing {
        Preprocessing {
            radar: RadarConfig::PAPER,
            sensing_slots: self.second() as u16,
            first_kept: 1,
            last_kept: 8,
            window_len: self.window as u16,
            hop: self.hop as u16,
            bins_per_row: 1,
            range: 1063,
            kaiser_beta: BETA as f32,
            carrier_khz: (self.carrier_hz / 1e3).round() as u32,
            slow_time_us: (1e6 / self.rate_hz).round() as u32,
        }
    }
}

impl std::fmt::Display for Layout {
    /// As part of a file's name.
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "{}-{}", self.carrier_hz / 1e3, self.rate_hz)
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
        assert!(noise.image(1).chunks(79).skip(1).all(|row| row.iter().any(|&p| p > 0)));
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
        assert_eq!(Layout::of(&signal).map(|l| l.rate_hz), Some(4000.0));
    }
}
