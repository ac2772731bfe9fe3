//! Spectrogram intensities in f64 for calibration, where signals may be real and rates arbitrary.
//!
//! Section III-C of the paper: Kaiser window, 256-point FFT, a range of 50 dB quantised into F levels.

use crate::numerics::bessel::kaiser;
use crate::results::Spectrogram;
use rustfft::num_complex::Complex;
use rustfft::{Fft, FftPlannerScalar};
use std::sync::Arc;

/// Levels F of the probability mass function.
pub const LEVELS: usize = 64;
/// Brightest level in dB above the spectrogram's mean power, where its maximum lies on average. The maximum itself is one cell of
/// 28160: levels below it shift by decibels from recording to recording, and rho recovered from 30 recordings scatters
/// twice as much.
pub const REFERENCE_DB: f64 = 16.0;
/// Dynamic range in dB.
pub const RANGE_DB: f64 = 50.0;
/// The Kaiser window's beta, the paper's: side lobes lie below the range.
pub const BETA: f64 = 10.0;
/// Length of the transform.
const FFT: usize = 256;

/// Window, transform and hop.
pub struct Intensity {
    window: Vec<f64>,
    hop: usize,
    fft: Arc<dyn Fft<f64>>,
}

impl Intensity {
    /// A Kaiser window of `length` samples, moved by `hop`.
    pub fn new(length: usize, hop: usize) -> Self {
        let mut window = kaiser(length, BETA);
        window.truncate(FFT);
        let fft = FftPlannerScalar::new().plan_fft_forward(FFT);
        Intensity { window, hop: hop.max(1), fft }
    }

    /// Decibels below the reference, `[frame][bin]`, negative frequencies first; `half` keeps 0 to 128 only.
    pub fn decibels(&self, signal: &[Complex<f64>], half: bool) -> Vec<Vec<f64>> {
        self.mean_decibels(std::iter::once(signal), half)
    }

    /// Decibels of the mean power over signals of one length: range cells that are added without their phases.
    pub fn mean_decibels<'s>(
        &self,
        signals: impl Iterator<Item = &'s [Complex<f64>]>,
        half: bool,
    ) -> Vec<Vec<f64>> {
        let mut frames: Vec<Vec<f64>> = Vec::new();
        for (n, signal) in signals.enumerate() {
            for (k, powers) in self.powers(signal, half).enumerate() {
                if n == 0 {
                    frames.push(powers);
                } else if let Some(sums) = frames.get_mut(k) {
                    sums.iter_mut().zip(powers).for_each(|(sum, power)| *sum += power);
                }
            }
        }
        let cells = frames.iter().map(Vec::len).sum::<usize>().max(1) as f64;
        let mean = frames.iter().flatten().sum::<f64>() / cells;
        let decibels = |power: f64| 10.0 * libm::log10(power.max(1e-300));
        let most = REFERENCE_DB + decibels(mean);
        frames.iter_mut().flatten().for_each(|cell| *cell = decibels(*cell) - most);
        frames
    }

    /// Powers of a signal's frames.
    fn powers<'s>(
        &'s self,
        signal: &'s [Complex<f64>],
        half: bool,
    ) -> impl Iterator<Item = Vec<f64>> + use<'s> {
        let last = (signal.len() + 1).saturating_sub(self.window.len());
        (0..last).step_by(self.hop).map(move |start| {
            let mut x = vec![Complex::default(); FFT];
            for ((x, y), w) in x.iter_mut().zip(&signal[start..]).zip(&self.window) {
                *x = y * w;
            }
            self.fft.process(&mut x);
            x.rotate_right(FFT / 2);
            let kept = if half { &x[FFT / 2..] } else { &x[..] };
            kept.iter().map(Complex::norm_sqr).collect()
        })
    }

    /// The spectrogram of decibels that were found at this rate; `half` where the rows are those of positive frequencies only.
    pub fn picture(
        &self,
        title: &str,
        decibels: &[Vec<f64>],
        half: bool,
        rate_hz: f64,
        carrier_hz: f64,
    ) -> Spectrogram {
        let rows = decibels.first().map_or(0, Vec::len);
        let row_hz = rate_hz / FFT as f64;
        let pixel = |row: usize| {
            decibels.iter().map(move |f| ((1.0 + f[row] / RANGE_DB).clamp(0.0, 1.0) * 255.0) as u8)
        };
        Spectrogram {
            title: title.to_owned(),
            rows: rows as u32,
            frames: decibels.len() as u32,
            first_row_hz: if half { 0.0 } else { -128.0 * row_hz },
            row_hz,
            frame_s: self.hop as f64 / rate_hz,
            carrier_hz,
            range_db: RANGE_DB,
            intensities: (0..rows).flat_map(pixel).collect(),
        }
    }
}

/// Intensity 0..LEVELS of a value in dB below the reference; 0 is black, what is brighter than it is brightest.
pub fn level(db: f64) -> usize {
    let share = 1.0 + db / RANGE_DB;
    ((share * LEVELS as f64) as isize).clamp(0, LEVELS as isize - 1) as usize
}

/// Counts of each level.
pub fn histogram(decibels: &[Vec<f64>]) -> [u64; LEVELS] {
    let mut counts = [0; LEVELS];
    decibels.iter().flatten().for_each(|&db| counts[level(db)] += 1);
    counts
}
