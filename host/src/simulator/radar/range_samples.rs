//! The front end on range samples, without the samples they are sums of.
//!
//! Blocks of a sweep in which the beat hardly turns: a phase tau phi' shifts the beat in time by -phi' / (2 pi S), so a block gets its
//! mean phi' times the slope of the polynomial through the blocks. The limiter takes a block's magnitude. Mean phi' are drawn with
//! the covariance that [`Filters`] gives them.
//!
//! A range gate: its cells are taken as echoes at their middles, of phase noise tau phi' each. Cell r' appears in cell r times the
//! transform of phi' under the gate's window at (r - r') cells: normal numbers, the even and the odd part of the window independent.
//! Real samples have each echo at its negative frequency as well, with phase noise of its own at (r + r') cells and twice the first
//! bin; it is taken as independent. The limiter takes the sum of the cells' powers: a sum of tones is compressed by twice the power of
//! the others. Left out: phase noise of what lies outside the gate, the leakage too, and products of three tones.

use super::impairments::{Impairments, Limiter};
use super::oscillator::{Filters, Oscillator};
use crate::numerics::differentiation;
use crate::scenario::{Format, Radar, SPEED_OF_LIGHT, Scenario};
use crate::simulator::channel::response::Response;
use crate::simulator::channel::{BLOCKS, Blocks, Complex64};
use std::f64::consts::PI;
use std::sync::{Arc, Mutex, PoisonError};

/// Fewest blocks, and most turns of the beat in each, with which its slope is known.
const FEWEST_BLOCKS: usize = 4;
const MOST_TURNS: f64 = 0.25;

type Matrix = [[f64; BLOCKS]; BLOCKS];

/// How a radar's range samples are formed.
#[derive(Debug)]
enum Form {
    /// The polynomial's slope over -2 pi S, in s, `[block][block]`; the factor of the means' covariance.
    Blocks { slope: Matrix, means: Matrix },
    /// Delay of each cell in s; factors of the covariances of the transform's real and imaginary part, `[cells apart][drawn]`; with
    /// real samples the standard deviations of both at the mirrored frequencies, `[r + r'][part]`.
    Gate { delay_s: [f64; BLOCKS], even: Matrix, odd: Matrix, mirrored: Vec<[f64; 2]> },
}

/// What depends on sweep and oscillator alone.
#[derive(Debug)]
struct Shape {
    radar: Radar,
    filters: Option<Filters>,
    kept: usize,
    form: Form,
}

/// The last shapes: a run has one radar, its tests a few.
static SHAPES: Mutex<Vec<Arc<Shape>>> = Mutex::new(Vec::new());
const KEPT: usize = 4;

/// A front end's effects on range samples.
pub struct RangeFrontEnd {
    /// None: the samples are needed.
    shape: Option<Arc<Shape>>,
    leakage: Blocks,
    leakage_w: f64,
    limiter: Option<Limiter>,
    /// Magnitude of each range sample for an echo of 1 sqrt W.
    unit: [f64; BLOCKS],
}

impl RangeFrontEnd {
    /// Of a radar; `None` without leakage, compression and phase noise.
    pub fn of(
        scenario: &Scenario,
        response: &Response,
        impairments: &Impairments,
        filters: Option<Filters>,
    ) -> Option<Self> {
        let radar = &scenario.radar;
        let Impairments { leakage, limiter, .. } = *impairments;
        if leakage.is_none() && limiter.is_none() && filters.is_none() {
            return None;
        }
        let kept = usize::from(radar.range_samples);
        let diagonal = scenario.room.size_m.iter().map(|size| size * size).sum::<f64>().sqrt();
        let turns = radar.bandwidth_hz * 2.0 * diagonal / SPEED_OF_LIGHT / kept as f64;
        let known = radar.bins_per_sample > 0 || (kept >= FEWEST_BLOCKS && turns <= MOST_TURNS);
        let mut leaked = Blocks::default();
        if let Some(one) = leakage {
            response.add(&mut leaked, one.gain, one.delay_s);
        }
        let unit = |range: usize| {
            let mut blocks = Blocks::default();
            let delay_s = if radar.bins_per_sample > 0 { cell_delay(radar, range) } else { 0.0 };
            response.add(&mut blocks, Complex64::new(1.0, 0.0), delay_s);
            blocks[range].norm_sqr().sqrt()
        };
        Some(RangeFrontEnd {
            // leakage alone is a path like any other
            shape: (known || limiter.is_none() && filters.is_none()).then(|| shape(radar, filters)),
            leakage: leaked,
            leakage_w: leakage.map_or(0.0, |one| one.gain.norm_sqr()),
            limiter,
            unit: std::array::from_fn(unit),
        })
    }

    /// Whether the effects are not known without the samples.
    pub fn needs_samples(&self) -> bool {
        self.shape.is_none()
    }

    /// Range samples behind the front end, before I and Q.
    pub fn apply(&self, blocks: &Blocks, oscillator: Option<&mut Oscillator>) -> Blocks {
        let mut found = *blocks;
        found.iter_mut().zip(&self.leakage).for_each(|(sum, leaked)| *sum += leaked);
        let Some(shape) = &self.shape else { return found };
        if let Some(oscillator) = oscillator {
            shape.phase_noise(&mut found, blocks, || oscillator.gaussian());
        }
        if let Some(limiter) = self.limiter {
            let mut power_w = [0.0; BLOCKS];
            for ((power_w, z), unit) in power_w.iter_mut().zip(&found).zip(self.unit).take(shape.kept) {
                *power_w = z.norm_sqr() / (unit * unit);
            }
            if let Form::Gate { .. } = shape.form {
                // of the leakage only its power matters, which the gate does not pass
                let total = power_w.iter().sum::<f64>() + self.leakage_w;
                power_w.iter_mut().for_each(|power_w| *power_w = 2.0 * total - *power_w);
            }
            found.iter_mut().zip(power_w).for_each(|(z, power_w)| *z *= limiter.gain(power_w));
        }
        found
    }
}

/// Delay of an echo in the middle of a cell of the gate, in s.
fn cell_delay(radar: &Radar, range: usize) -> f64 {
    let bins = f64::from(radar.bins_per_sample);
    (f64::from(radar.first_bin) + bins * range as f64 + 0.5 * (bins - 1.0)) / radar.bandwidth_hz
}

/// The shape of a radar and its oscillator.
fn shape(radar: &Radar, filters: Option<Filters>) -> Arc<Shape> {
    let key = Radar::default().with_sweep_of(radar);
    let mut shapes = SHAPES.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(found) = shapes.iter().find(|one| one.radar == key && one.filters == filters) {
        return found.clone();
    }
    let shape = Arc::new(Shape::new(key, filters));
    shapes.insert(0, shape.clone());
    shapes.truncate(KEPT);
    shape
}

impl Shape {
    fn new(radar: Radar, filters: Option<Filters>) -> Self {
        let (kept, samples) = (usize::from(radar.range_samples), usize::from(radar.samples));
        let lags: Vec<f64> = match filters {
            Some(filters) => (0..samples).map(|lag| filters.covariance(lag)).collect(),
            None => vec![0.0; samples],
        };
        let form = if radar.bins_per_sample > 0 {
            let windows = |wave: fn(f64) -> f64| -> Vec<_> {
                let bins = |apart: usize| f64::from(radar.bins_per_sample) * apart as f64;
                (0..kept).map(|apart| gate_window(&radar, bins(apart), wave)).collect()
            };
            // a cell's middle and that of another cell's negative frequency, in bins
            let between = |sum: usize| {
                let (first, bins) = (f64::from(radar.first_bin), f64::from(radar.bins_per_sample));
                2.0 * first + bins * sum as f64 + bins - 1.0
            };
            let deviation = |sum: usize, wave: fn(f64) -> f64| {
                factor(&[gate_window(&radar, between(sum), wave)], &lags)[0][0]
            };
            let sums = if radar.format == Format::Real { 2 * kept - 1 } else { 0 };
            Form::Gate {
                delay_s: std::array::from_fn(|range| cell_delay(&radar, range)),
                even: factor(&windows(libm::cos), &lags),
                odd: factor(&windows(libm::sin), &lags),
                mirrored: (0..sums).map(|sum| [libm::cos, libm::sin].map(|f| deviation(sum, f))).collect(),
            }
        } else {
            let block = samples / kept;
            let mean = |b: usize| -> Vec<f64> {
                let inside = |n: usize| if n / block == b { 1.0 / block as f64 } else { 0.0 };
                (0..samples).map(inside).collect()
            };
            let means: Vec<_> = (0..kept).map(mean).collect();
            let times: Vec<_> = (0..kept).map(|b| radar.sweep_s * b as f64 / kept as f64).collect();
            let mut slope = Matrix::default();
            for (row, weights) in slope.iter_mut().zip(differentiation::matrix(&times)) {
                let scaled = weights.iter().map(|w| w / (-2.0 * PI * radar.sweep_rate()));
                row.iter_mut().zip(scaled).for_each(|(to, w)| *to = w);
            }
            Form::Blocks { slope, means: factor(&means, &lags) }
        };
        Shape { radar, filters, kept, form }
    }

    /// Adds the oscillator's phase noise of the echoes; `found` has the leakage, `echoes` has not.
    fn phase_noise(&self, found: &mut Blocks, echoes: &Blocks, mut gaussian: impl FnMut() -> f64) {
        match &self.form {
            Form::Blocks { slope, means } => {
                let z = *found;
                let mean = drawn(means, self.kept, &mut gaussian);
                for ((found, row), mean) in found.iter_mut().zip(slope).zip(mean).take(self.kept) {
                    let shift: Complex64 = row.iter().zip(&z).map(|(w, z)| z * w).sum();
                    *found += shift * mean;
                }
            }
            Form::Gate { delay_s, even, odd, mirrored } => {
                let even = drawn(even, self.kept, &mut gaussian);
                let odd = drawn(odd, self.kept, &mut gaussian);
                for (to, found) in found.iter_mut().enumerate().take(self.kept) {
                    for from in 0..self.kept {
                        let apart = to.abs_diff(from);
                        let sign = if to < from { -1.0 } else { 1.0 };
                        let transform = Complex64::new(even[apart], sign * odd[apart]);
                        *found += Complex64::i() * transform * echoes[from] * delay_s[from];
                    }
                }
                let mut transforms = [Complex64::default(); 2 * BLOCKS];
                for (transform, [even, odd]) in transforms.iter_mut().zip(mirrored) {
                    *transform = Complex64::new(even * gaussian(), odd * gaussian());
                }
                if mirrored.is_empty() {
                    return;
                }
                for (to, found) in found.iter_mut().enumerate().take(self.kept) {
                    for from in 0..self.kept {
                        let echo = echoes[from].conj() * delay_s[from];
                        *found -= Complex64::i() * transforms[to + from] * echo;
                    }
                }
            }
        }
    }
}

/// Window of a gate's cell over the sweep, of sum 1, times a wave of some turns.
fn gate_window(radar: &Radar, turns: f64, wave: fn(f64) -> f64) -> Vec<f64> {
    let (samples, bins) = (usize::from(radar.samples), f64::from(radar.bins_per_sample));
    let time = |n: usize| (2.0 * n as f64 + 1.0) / (2.0 * samples as f64) - 0.5;
    let flat = |u: f64| {
        let sum: f64 = (0..radar.bins_per_sample)
            .map(|k| libm::cos(2.0 * PI * (f64::from(k) - 0.5 * (bins - 1.0)) * u))
            .sum();
        sum * 0.5 * (1.0 + libm::cos(2.0 * PI * u))
    };
    let total: f64 = (0..samples).map(|n| flat(time(n))).sum();
    let at = |n: usize| flat(time(n)) / total * wave(2.0 * PI * turns * time(n));
    (0..samples).map(at).collect()
}

/// L with L L^T the covariance of weighted sums of a stationary series.
fn factor(weights: &[Vec<f64>], lags: &[f64]) -> Matrix {
    let filtered = |row: &Vec<f64>| -> Vec<f64> {
        (0..row.len()).map(|n| row.iter().enumerate().map(|(k, w)| w * lags[n.abs_diff(k)]).sum()).collect()
    };
    let filtered: Vec<_> = weights.iter().map(filtered).collect();
    let mut l = Matrix::default();
    for i in 0..weights.len() {
        for j in 0..=i {
            let covariance: f64 = weights[i].iter().zip(&filtered[j]).map(|(a, b)| a * b).sum();
            let rest: f64 = (0..j).map(|k| l[i][k] * l[j][k]).sum();
            let left = covariance - rest;
            l[i][j] = match i == j {
                true => left.max(0.0).sqrt(),
                false if l[j][j] > 0.0 => left / l[j][j],
                false => 0.0,
            };
        }
    }
    l
}

/// Normal numbers with a covariance.
fn drawn(factor: &Matrix, count: usize, gaussian: &mut impl FnMut() -> f64) -> [f64; BLOCKS] {
    let mut white = [0.0; BLOCKS];
    white.iter_mut().take(count).for_each(|w| *w = gaussian());
    factor.map(|row| row.iter().zip(&white).map(|(l, w)| l * w).sum())
}
