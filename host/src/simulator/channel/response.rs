//! What a path adds to a slot's range samples, in closed form: the receiver's linear part without its samples.
//!
//! A path of delay tau beats B tau cycles a sweep; its range samples are the transfer functions of the blocks, or of the range gate,
//! at that frequency, and its phase is that of the sweep. Sweeps are short: a path keeps its delay during one. At a speed v this
//! moves an echo by 2 v T / lambda range bins, 0.13 for 5 m/s with the shipped sensors, and leaves its Doppler as it is.

use super::{Blocks, Complex64, add_blocks, phasor};
use crate::scenario::{Dechirp, Format, Radar};
use rustfft::FftPlanner;
use sdp3_core::config::RangeGate;
use std::f64::consts::PI;
use std::sync::{Arc, Mutex, PoisonError};

/// How a radar's range samples are formed.
#[derive(Debug, Clone)]
pub enum Response {
    /// The paper's radar: block means of the beat in closed form, in sqrt W.
    Paper,
    /// Any other, by tables, in LSB of the core's range samples for an LSB of the converter per sqrt W.
    Table(Arc<Table>),
}

/// Steps of the table within a bin. Cubic interpolation is exact to -110 dB then.
const STEPS: usize = 32;

/// Transfer functions of a radar's range samples.
#[derive(Debug)]
pub struct Table {
    radar: Radar,
    /// conj(E(f)) at f = k / [`STEPS`] bins, from the sweep's middle, periodic.
    transfer: Vec<Blocks>,
    /// Lower triangle; its product with white noise has the covariance of the range samples' noise.
    noise: [Blocks; super::BLOCKS],
}

/// The last tables: a run has one radar, its tests a few.
static TABLES: Mutex<Vec<Arc<Table>>> = Mutex::new(Vec::new());
const KEPT: usize = 4;

impl Response {
    /// That of a radar.
    pub fn of(radar: &Radar) -> Self {
        if radar.is_papers() {
            return Response::Paper;
        }
        // what the tables do not depend on is left out of their key
        let key = Radar::default().with_sweep_of(radar);
        let mut tables = TABLES.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(found) = tables.iter().find(|table| table.radar == key) {
            return Response::Table(found.clone());
        }
        let table = Arc::new(Table::new(key));
        tables.insert(0, table.clone());
        tables.truncate(KEPT);
        Response::Table(table)
    }

    /// What a path of amplitude 1 and one of amplitude j add: the response to a path is linear in both parts of its amplitude, and
    /// with real samples no more than that.
    pub fn parts(&self, delay_s: f64) -> [Blocks; 2] {
        [Complex64::new(1.0, 0.0), Complex64::new(0.0, 1.0)].map(|unit| {
            let mut blocks = Blocks::default();
            self.add(&mut blocks, unit, delay_s);
            blocks
        })
    }

    pub fn add(&self, beat: &mut Blocks, amplitude: Complex64, delay_s: f64) {
        match self {
            Response::Paper => add_blocks(beat, amplitude, delay_s),
            Response::Table(table) => table.add(beat, amplitude, delay_s),
        }
    }
}

impl Table {
    fn new(radar: Radar) -> Self {
        let samples = usize::from(radar.samples);
        let weights = weights(&radar);
        let mut transfer = vec![Blocks::default(); STEPS * samples];
        let fft = FftPlanner::new().plan_fft_inverse(transfer.len());
        for (range, weights) in weights.iter().enumerate() {
            let mut line = vec![Complex64::default(); transfer.len()];
            for (n, w) in weights.iter().enumerate() {
                line[(n + transfer.len() - samples / 2) % transfer.len()] = *w;
            }
            fft.process(&mut line);
            transfer.iter_mut().zip(&line).for_each(|(blocks, e)| blocks[range] = e.conj());
        }
        Table { noise: cholesky(&weights), radar, transfer }
    }

    /// conj(E) at a beat of `cycles` a sweep.
    fn at(&self, cycles: f64) -> Blocks {
        let place = cycles * STEPS as f64;
        let (whole, t) = (place.floor(), place - place.floor());
        // Lagrange's cubic through the neighbours at -1, 0, 1 and 2
        let cubic = [
            -t * (t - 1.0) * (t - 2.0) / 6.0,
            (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0,
            -(t + 1.0) * t * (t - 2.0) / 2.0,
            (t + 1.0) * t * (t - 1.0) / 6.0,
        ];
        let mut value = Blocks::default();
        for (k, weight) in (-1..).zip(cubic) {
            let at = (whole as i64 + k).rem_euclid(self.transfer.len() as i64) as usize;
            value.iter_mut().zip(&self.transfer[at]).for_each(|(sum, e)| *sum += e * weight);
        }
        // the table's origin is sample `samples / 2`, the beat's the first
        let turns = cycles * f64::from(self.radar.samples / 2) / f64::from(self.radar.samples);
        let phase = phasor(-2.0 * PI * (turns - turns.floor()));
        value.map(|e| e * phase)
    }

    fn add(&self, beat: &mut Blocks, amplitude: Complex64, delay_s: f64) {
        let radar = &self.radar;
        let cycles = radar.bandwidth_hz * delay_s;
        // residual video phase; a digital chirp's first sample is taken at t = 1 / f_s
        let late = match radar.dechirp {
            Dechirp::Digital => 2.0 * cycles / f64::from(radar.samples),
            Dechirp::Analog => 0.0,
        };
        let value = amplitude * phasor(PI * (radar.sweep_rate() * delay_s * delay_s - late));
        match radar.format {
            Format::Complex => {
                beat.iter_mut().zip(self.at(cycles)).for_each(|(beat, e)| *beat += value * e);
            }
            Format::Real => {
                // half of the signal has the mirrored frequency
                let mirrored = value.conj() * 0.5;
                let (direct, image) = (self.at(cycles), self.at(-cycles));
                for ((beat, direct), image) in beat.iter_mut().zip(direct).zip(image) {
                    *beat += value * 0.5 * direct + mirrored * image;
                }
            }
        }
    }

    /// Noise of the range samples where each value of the converter has noise of standard deviation 1, from Gaussian draws.
    pub fn noise(&self, mut gaussian: impl FnMut() -> f64) -> Blocks {
        // sums of real samples are real
        let (scale, imaginary) = match (self.radar.format, self.radar.bins_per_sample) {
            (Format::Complex, _) => (1.0, 1.0),
            (Format::Real, 0) => (1.0, 0.0),
            (Format::Real, _) => (std::f64::consts::FRAC_1_SQRT_2, 1.0),
        };
        let white: Blocks =
            std::array::from_fn(|_| Complex64::new(gaussian(), imaginary * gaussian()) * scale);
        self.noise.map(|row| row.iter().zip(&white).map(|(l, w)| l * w).sum())
    }
}

/// Weights of the samples in each range sample, `[range][fast_time]`: what the core multiplies dechirped samples by.
///
/// Without a gate blocks are summed. A gate sums bins of the DFT under a Hann window, phases taken at the sweep's middle.
fn weights(radar: &Radar) -> Vec<Vec<Complex64>> {
    let config = radar.config();
    let samples = usize::from(config.samples);
    let kept = usize::from(config.range_samples);
    let reference = if config.gate.is_some() || radar.dechirp == Dechirp::Digital { 32767.0 } else { 1.0 };
    let justified = if radar.left_justified { 16 - i32::from(radar.converter_bits) } else { 0 };
    let scale = reference * libm::exp2(f64::from(justified - config.shift() as i32));
    let weight = |range: usize, n: usize| match config.gate {
        None => Complex64::new(if n * kept / samples == range { scale } else { 0.0 }, 0.0),
        Some(RangeGate { first_bin, bins_per_sample }) => {
            let u = (2.0 * n as f64 + 1.0) / (2.0 * samples as f64) - 0.5;
            let bins = usize::from(bins_per_sample);
            let first = usize::from(first_bin) + range * bins;
            let sum: Complex64 = (first..first + bins).map(|bin| phasor(-2.0 * PI * bin as f64 * u)).sum();
            sum * (scale * 0.5 * (1.0 + libm::cos(2.0 * PI * u)) / bins as f64)
        }
    };
    (0..kept).map(|range| (0..samples).map(|n| weight(range, n)).collect()).collect()
}

/// L with L L^H = W W^H for the rows W of weights, conjugated as range samples are.
fn cholesky(weights: &[Vec<Complex64>]) -> [Blocks; super::BLOCKS] {
    let mut l = [Blocks::default(); super::BLOCKS];
    for i in 0..weights.len() {
        for j in 0..=i {
            let gram: Complex64 = weights[i].iter().zip(&weights[j]).map(|(a, b)| a.conj() * b).sum();
            let rest: Complex64 = (0..j).map(|k| l[i][k] * l[j][k].conj()).sum();
            let left = gram - rest;
            l[i][j] = if i == j { Complex64::new(left.re.max(0.0).sqrt(), 0.0) } else { left / l[j][j].re };
        }
    }
    l
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::builtin::named;
    use std::path::Path;

    /// Radars of every kind: sensors with a gate, blocks of a beat, a chirp of another length.
    pub(crate) fn radars() -> Vec<Radar> {
        let named = |name: &str| named(Path::new(name)).map(|one| one.scenario().radar).unwrap();
        let (bgt60, iwr) = (named("bgt60"), named("iwr"));
        let blocks = Radar { bins_per_sample: 0, first_bin: 0, range_samples: 4, ..iwr.clone() };
        let odd =
            Radar { samples: 75, sample_rate_hz: 75.0 / blocks.sweep_s, range_samples: 5, ..blocks.clone() };
        let chirp = Radar {
            bandwidth_hz: 40e6,
            sample_rate_hz: 40e6,
            sweep_s: 40e-6,
            samples: 1600,
            ..Radar::default()
        };
        let left = Radar { left_justified: true, ..bgt60.clone() };
        let one = named("doppler-24ghz");
        let sums = Radar { bins_per_sample: 0, first_bin: 0, range_samples: 4, ..bgt60.clone() };
        vec![bgt60, iwr, blocks, odd, chirp, left, one, sums]
    }

    #[test]
    fn tables_are_the_weighted_sums_of_the_beat_to_100_decibels() {
        for radar in radars() {
            let response = Response::of(&radar);
            let weights = weights(&radar);
            let samples = usize::from(radar.samples);
            let late = f64::from(u8::from(radar.dechirp == Dechirp::Digital));
            let mut loudest = 0.0_f64;
            for delay in [6.71e-9, 13.4e-9, 21.3e-9, 30.017e-9] {
                let amplitude = Complex64::new(0.8, -0.3);
                let mut found = Blocks::default();
                response.add(&mut found, amplitude, delay);
                let beat = |n: usize| {
                    let t = (n as f64 + late) / radar.sample_rate_hz;
                    let z = amplitude * phasor(PI * radar.sweep_rate() * delay * (delay - 2.0 * t));
                    if radar.format == Format::Real { Complex64::new(z.re, 0.0) } else { z }
                };
                for (range, row) in weights.iter().enumerate() {
                    let exact: Complex64 = (0..samples).map(|n| row[n].conj() * beat(n)).sum();
                    let total: f64 = row.iter().map(|w| w.norm()).sum();
                    assert!((found[range] - exact).norm() < 1e-5 * total, "{radar:?} {range}: {exact}");
                    loudest = loudest.max(exact.norm() / total);
                }
            }
            assert!(loudest > 0.01, "{radar:?}: {loudest}");
        }
    }

    #[test]
    fn noise_has_the_covariance_of_weighted_white_noise() {
        for radar in radars() {
            let Response::Table(table) = Response::of(&radar) else { panic!("{radar:?}") };
            let weights = weights(&radar);
            for (i, a) in weights.iter().enumerate() {
                for (j, b) in weights.iter().enumerate() {
                    let exact: Complex64 = a.iter().zip(b).map(|(a, b)| a.conj() * b).sum();
                    let found: Complex64 =
                        table.noise[i].iter().zip(&table.noise[j]).map(|(x, y)| x * y.conj()).sum();
                    let scale = table.noise[0][0].re * table.noise[0][0].re;
                    assert!((found - exact).norm() < 1e-9 * scale, "{i} {j}: {found} {exact}");
                }
            }
        }
    }
}
