//! What the room adds to a person's spectrum, by three models on the same windows.
//!
//! - AR room: a E(f) + b A(f; rho) + c, the echo of a person, an AR(1) fluctuation and white noise;
//! - white noise: a E(f) + c, a room that does not change (rho = 1);
//! - static room: a E(f) alone.
//!
//! Whittle's likelihood (1953) of a mean spectrum I under S is the Itakura-Saito divergence, mean of I / S - ln(I / S) - 1 over the
//! frequencies. It is twice the Kullback-Leibler divergence a sample of Gaussian processes with these spectra (Pinsker, 1964). a, b and c
//! follow for each rho by the multiplicative updates of Fevotte, Bertin and Durrieu (2009), which never go up.

use super::spectrum::{Bands, Spectrum};
use crate::numerics::random::Random;
use crate::results::Interval;
use rayon::prelude::*;
use std::collections::HashSet;

/// 1 - rho of the search, ascending by 14 %.
const LEAST: f64 = 0.0002;
const RATIO: f64 = 1.14;
const STEPS: usize = 49;
/// Updates of a, b and c, at most, and the share by which the divergence has to fall for a further one.
const UPDATES: usize = 3000;
const SETTLED: f64 = 1e-9;
/// Where the noise begins, over the other parts, in dB.
const NOISE_DB: [f64; 3] = [0.0, -25.0, -50.0];
/// Drawn sets of windows, the share of them within an interval, the fewest windows for one, and the stream of the draws.
pub const DRAWS: u64 = 200;
const COVERAGE: f64 = 0.95;
pub const FEWEST_WINDOWS: usize = 4;
pub const STREAM: u64 = 206;

/// Powers of a mixture's parts, and its divergence.
#[derive(Debug, Clone, PartialEq)]
struct Mixture {
    parts: Vec<f64>,
    divergence: f64,
}

/// An AR room: its rho, near a place of the search, and its powers.
#[derive(Debug, Clone, PartialEq)]
struct ArRoom {
    place: usize,
    rho: f64,
    mixture: Mixture,
}

/// A model on the windows' spectra.
#[derive(Debug, Clone, PartialEq)]
pub struct SpectralFit {
    /// Power of the white noise over the echo's in dB.
    pub noise_db: Option<f64>,
    /// Itakura-Saito divergence of the measured mean spectrum.
    pub divergence: f64,
    /// 95 % interval of what it is above the AR room's, on windows left out of the fit.
    pub behind: Option<Interval>,
}

/// The three models, and the AR room's parameters with their 95 % intervals.
#[derive(Debug, Clone, PartialEq)]
pub struct RoomFit {
    pub rho: f64,
    pub rho_interval: Option<Interval>,
    pub k_factor_db: f64,
    pub k_factor_interval: Option<Interval>,
    /// Whether rho lies inside the search. At an end of it the windows do not determine it; near 1 they determine the power times 1 - rho.
    pub inside: bool,
    /// AR room, white noise, static room.
    pub models: [SpectralFit; 3],
}

/// The spectra that the models are made of.
struct Parts<'a> {
    spectrum: &'a Spectrum,
    /// A person's.
    echo: Bands,
    noise: &'a Bands,
    /// rho and the AR(1) spectra of the search.
    grid: &'a [(f64, Bands)],
}

impl Parts<'_> {
    /// Itakura-Saito divergence of `measured` from `model`, a mean over bins.
    fn divergence(&self, measured: &[f64], model: &[f64]) -> f64 {
        let (mut sum, mut bins) = (0.0, 0.0);
        for ((i, s), n) in measured.iter().zip(model).zip(&self.spectrum.bins) {
            let ratio = (i / s).max(f64::MIN_POSITIVE);
            sum += n * (ratio - libm::log(ratio) - 1.0);
            bins += n;
        }
        sum / bins
    }

    fn model(bases: &[&Bands], parts: &[f64]) -> Bands {
        let at = |band: usize| bases.iter().zip(parts).map(|(basis, part)| basis[band] * part).sum();
        (0..bases[0].len()).map(at).collect()
    }

    /// The powers of `bases` that bring their sum nearest to `measured`, the last of them white noise: the best of several beginnings, since
    /// there may be more than one minimum.
    fn mixture<const N: usize>(&self, measured: &[f64], bases: [&Bands; N]) -> Mixture {
        let from = |noise_db: &f64| self.updated(measured, bases, libm::pow(10.0, noise_db / 10.0));
        let beginnings = if N > 1 { &NOISE_DB[..] } else { &NOISE_DB[..1] };
        let found = beginnings.iter().map(from).min_by(|a, b| a.divergence.total_cmp(&b.divergence));
        found.expect("there is a beginning")
    }

    /// The updates from equal powers of all parts but the noise, which begins `noise` times as strong.
    fn updated<const N: usize>(&self, measured: &[f64], bases: [&Bands; N], noise: f64) -> Mixture {
        let sum = |x: &[f64]| x.iter().zip(&self.spectrum.bins).map(|(x, bins)| x * bins).sum::<f64>();
        let mut parts = bases.map(|basis| sum(measured) / (sum(basis) * N as f64));
        if let [.., _, last] = &mut parts[..] {
            *last *= noise;
        }
        let divergence_at = |parts: &[f64]| self.divergence(measured, &Self::model(&bases, parts));
        let mut divergence = f64::INFINITY;
        for update in 0..UPDATES {
            if update % 20 == 0 {
                let now = divergence_at(&parts);
                if divergence - now < SETTLED * now {
                    break;
                }
                divergence = now;
            }
            let (mut up, mut down) = ([0.0; N], [0.0; N]);
            for (band, (i, bins)) in measured.iter().zip(&self.spectrum.bins).enumerate() {
                let at = bases.map(|basis| basis[band]);
                let model: f64 = at.iter().zip(&parts).map(|(basis, part)| basis * part).sum();
                let weight = bins / model;
                let excess = weight * i / model;
                for k in 0..N {
                    up[k] += at[k] * excess;
                    down[k] += at[k] * weight;
                }
            }
            for k in 0..N {
                parts[k] *= (up[k] / down[k]).sqrt();
            }
        }
        Mixture { divergence: divergence_at(&parts), parts: parts.into() }
    }

    /// The AR room: of the whole search, or downhill from a place of it.
    fn ar_room(&self, measured: &[f64], from: Option<usize>) -> ArRoom {
        let at = |k: usize| self.mixture(measured, [&self.echo, &self.grid[k].1, self.noise]);
        let mut found: Vec<Option<Mixture>> = vec![None; STEPS];
        let mut best = from.unwrap_or_else(|| {
            found = (0..STEPS).into_par_iter().map(|k| Some(at(k))).collect();
            let d = |k: usize| found[k].as_ref().map_or(f64::INFINITY, |mixture| mixture.divergence);
            (0..STEPS).min_by(|&a, &b| d(a).total_cmp(&d(b))).unwrap_or(0)
        });
        let mut d = |k: usize| found[k].get_or_insert_with(|| at(k)).divergence;
        while best > 0 && d(best - 1) < d(best) {
            best -= 1;
        }
        while best + 1 < STEPS && d(best + 1) < d(best) {
            best += 1;
        }
        if best == 0 || best + 1 == STEPS {
            return ArRoom { place: best, rho: self.grid[best].0, mixture: at(best) };
        }
        // the vertex of the parabola through the best point and its neighbours, over ln(1 - rho)
        let (left, right) = (d(best - 1) - d(best), d(best + 1) - d(best));
        let shift = 0.5 * (left - right) / (left + right).max(f64::MIN_POSITIVE);
        let rho = 1.0 - (1.0 - self.grid[best].0) * libm::pow(RATIO, shift);
        let mixture = self.mixture(measured, [&self.echo, &self.spectrum.ar1(rho), self.noise]);
        ArRoom { place: best, rho, mixture }
    }

    fn white_noise(&self, measured: &[f64]) -> Mixture {
        self.mixture(measured, [&self.echo, self.noise])
    }

    fn static_room(&self, measured: &[f64]) -> Mixture {
        self.mixture(measured, [&self.echo])
    }

    /// Power of the noise over that of the echo in dB.
    fn noise_db(&self, mixture: &Mixture) -> f64 {
        let power = |x: &Bands| x.iter().zip(&self.spectrum.bins).map(|(x, bins)| x * bins).sum::<f64>();
        let noise = mixture.parts.last().copied().unwrap_or(0.0) * power(self.noise);
        10.0 * libm::log10((noise / (mixture.parts[0] * power(&self.echo))).max(1e-12))
    }

    /// Mean of measured over model.
    fn ratio(&self, measured: &[f64], model: &[f64]) -> f64 {
        let bins = &self.spectrum.bins;
        let sum: f64 = measured.iter().zip(model).zip(bins).map(|((i, s), n)| n * i / s).sum();
        sum / bins.iter().sum::<f64>()
    }
}

/// The three models on the windows' spectra, with those of simulated people as the echo. `mean_power` is the power of the room's mean in
/// the echo's unit. Intervals are over redrawn windows and redrawn people.
pub fn fit(spectrum: &Spectrum, windows: &[Bands], people: &[Bands], mean_power: f64, seed: u64) -> RoomFit {
    let rhos: Vec<f64> = (0..STEPS).map(|k| 1.0 - LEAST * libm::pow(RATIO, k as f64)).collect();
    let grid: Vec<(f64, Bands)> = rhos.into_par_iter().map(|rho| (rho, spectrum.ar1(rho))).collect();
    let noise = spectrum.ar1(0.0);
    let parts = |echo: Bands| Parts { spectrum, echo, noise: &noise, grid: &grid };
    let all = |spectra: &[Bands]| mean(spectra, &(0..spectra.len()).collect::<Vec<_>>());
    let whole = parts(all(people));
    let measured = all(windows);
    let room = whole.ar_room(&measured, None);
    // every draw: rho, K, and what the other models lose on the windows that were not drawn
    let draw = |draw: u64| -> Option<[f64; 4]> {
        let mut random = Random::new(seed, STREAM, 0, draw);
        let mut redraw =
            |n: usize| -> Vec<usize> { (0..n).map(|_| (random.uniform() * n as f64) as usize).collect() };
        let (chosen, people) = (redraw(windows.len()), mean(people, &redraw(people.len())));
        let drawn: HashSet<usize> = chosen.iter().copied().collect();
        let left: Vec<usize> = (0..windows.len()).filter(|k| !drawn.contains(k)).collect();
        if left.is_empty() {
            return None;
        }
        let (learned, left) = (mean(windows, &chosen), mean(windows, &left));
        let parts = parts(people);
        let redrawn = parts.ar_room(&learned, Some(room.place));
        let fluctuation = spectrum.ar1(redrawn.rho);
        let of = |bases: &[&Bands], mixture: &Mixture| {
            let model = Parts::model(bases, &mixture.parts);
            // the echo's power differs from window to window: the scale is that of the windows left
            let scale = parts.ratio(&left, &model);
            parts.divergence(&left, &model.iter().map(|s| s * scale).collect::<Vec<_>>())
        };
        let ar = of(&[&parts.echo, &fluctuation, &noise], &redrawn.mixture);
        let white = of(&[&parts.echo, &noise], &parts.white_noise(&learned));
        let static_room = of(&[&parts.echo], &parts.static_room(&learned));
        Some([redrawn.rho, k_factor_db(&redrawn, mean_power), white - ar, static_room - ar])
    };
    let draws = if windows.len() >= FEWEST_WINDOWS { DRAWS } else { 0 };
    let drawn: Vec<[f64; 4]> = (0..draws).into_par_iter().filter_map(draw).collect();
    let interval = |k: usize| interval(drawn.iter().map(|draw| draw[k]).collect());
    let fitted = |noise_db, divergence, behind| SpectralFit { noise_db, divergence, behind };
    let [white, static_room] = [whole.white_noise(&measured), whole.static_room(&measured)];
    RoomFit {
        rho: room.rho,
        rho_interval: interval(0),
        k_factor_db: k_factor_db(&room, mean_power),
        k_factor_interval: interval(1),
        inside: (1..STEPS - 1).contains(&room.place),
        models: [
            fitted(Some(whole.noise_db(&room.mixture)), room.mixture.divergence, None),
            fitted(Some(whole.noise_db(&white)), white.divergence, interval(2)),
            fitted(None, static_room.divergence, interval(3)),
        ],
    }
}

/// K factor in dB: power of the room's mean, in the echo's unit, over the fluctuation's.
fn k_factor_db(room: &ArRoom, mean_power: f64) -> f64 {
    10.0 * libm::log10(mean_power * room.mixture.parts[0] / room.mixture.parts[1].max(f64::MIN_POSITIVE))
}

/// The ends of the middle [`COVERAGE`] of the values; `None` of too few.
pub fn interval(mut values: Vec<f64>) -> Option<Interval> {
    if values.len() < 20 {
        return None;
    }
    values.sort_by(f64::total_cmp);
    let outside = (0.5 * (1.0 - COVERAGE) * values.len() as f64) as usize;
    Some(Interval { low: values[outside], high: values[values.len() - 1 - outside] })
}

/// Mean of chosen spectra.
fn mean(spectra: &[Bands], chosen: &[usize]) -> Bands {
    let mut sum = vec![0.0; spectra.first().map_or(0, Vec::len)];
    for &k in chosen {
        sum.iter_mut().zip(&spectra[k]).for_each(|(sum, x)| *sum += x / chosen.len() as f64);
    }
    sum
}
