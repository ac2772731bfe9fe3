//! Calibration: the rho whose simulated grey levels are nearest to the measured ones.
//!
//! Eq. (fitting) of the paper: Kullback-Leibler divergence of the measured probability mass function from the simulated
//! one, over F = 64 grey levels, searched over 0 <= rho <= 1. The same random draws serve every rho, so the curve is smooth.

use super::channel::Complex64;
use super::dataset::{Channel, Set};
use super::grey::{Grey, LEVELS, RANGE_DB, histogram};
use super::resample::resample;
use crate::results::{Calibration, KlPoint, Spectrogram};
use crate::scenario::{Class, Scenario};
use rayon::prelude::*;
use serde::Deserialize;
use std::sync::atomic::{AtomicU64, Ordering};

/// Rate the measured signal is brought to, in Hz.
pub const MEASURED_PRF_HZ: f64 = 2000.0;
/// Corner of the AC coupling that is applied to the measured and to the simulated signal alike, in Hz. CW sensors block what
/// does not move; their own corners are rarely published.
pub const AC_COUPLING_HZ: f64 = 20.0;
/// Least energy of a window with motion, as a share of the median window's.
const MOTION_SHARE: f64 = 0.5;
/// Slots simulated before the window, for the filter to settle.
const SETTLE_SLOTS: usize = 200;
/// Simulated people behind every point of the curve.
const PEOPLE: u32 = 20;
/// Recordings that stand for a measurement when none is given.
const STAND_INS: u32 = 20;
/// First pass of the search.
const GRID: [f64; 14] =
    [0.95, 0.96, 0.97, 0.975, 0.98, 0.984, 0.988, 0.99, 0.992, 0.994, 0.996, 0.998, 0.999, 1.0];
/// Points of the refinement between the neighbours of the grid's minimum.
const REFINEMENT: usize = 7;

/// Progress callback: steps done, steps in all.
pub type Progress<'a> = &'a (dyn Fn(u64, u64) + Sync);

/// A row of the stored table.
#[derive(Debug, Clone, Deserialize)]
struct Stored {
    carrier_hz: f64,
    interferer: bool,
    motion: String,
    rho: f64,
    source: String,
}

#[derive(Debug, Deserialize)]
struct Table {
    entry: Vec<Stored>,
}

/// The stored rho of the nearest carrier with the same number of people, and where it comes from.
pub fn stored_rho(scenario: &Scenario) -> (f64, String) {
    let table: Table =
        toml::from_str(include_str!("rho_table.toml")).expect("the table is part of the program");
    let distance = |s: &Stored| libm::log(s.carrier_hz / scenario.radar.carrier_hz).abs();
    let matching = table.entry.iter().filter(|s| s.interferer == scenario.channel.interferer);
    let nearest = matching.min_by(|a, b| distance(a).total_cmp(&distance(b))).or(table.entry.first());
    nearest.map_or((0.997, String::new()), |s| {
        (s.rho, format!("stored table, {} at {:.3} GHz: {}", s.motion, s.carrier_hz / 1e9, s.source))
    })
}

/// How simulated signals are made to look like the measured one.
struct Bench<'a> {
    scenario: &'a Scenario,
    seed: u64,
    real: bool,
    slots: u32,
    grey: Grey,
}

impl Bench<'_> {
    /// One person's slow-time signal: clutter removed, as the measured one has it.
    fn signal(&self, rho: f64, set: Set, index: u32) -> Vec<Complex64> {
        let mut channel = Channel::new(self.scenario, rho, self.seed, set, Class::AdultWalking, index);
        if self.real {
            // a CW sensor sees one number a time, AC-coupled; its filter settles before the window begins
            let settle = SETTLE_SLOTS as u32;
            let mut y: Vec<_> =
                (0..settle + self.slots).map(|_| Complex64::new(channel.advance()[0].re, 0.0)).collect();
            ac_couple(&mut y, 1.0 / self.scenario.interval_s());
            return y.split_off(SETTLE_SLOTS);
        }
        let sweeps: Vec<_> = (0..self.slots).map(|_| channel.advance()).collect();
        clutter_free(&sweeps)
    }

    fn levels(&self, rho: f64, set: Set, index: u32) -> [u64; LEVELS] {
        histogram(&self.grey.decibels(&self.signal(rho, set, index), self.real))
    }

    fn pmf(&self, rho: f64, set: Set, people: u32) -> Vec<f64> {
        let each: Vec<_> = (0..people).into_par_iter().map(|index| self.levels(rho, set, index)).collect();
        let mut counts = [0_u64; LEVELS];
        each.iter().for_each(|one| counts.iter_mut().zip(one).for_each(|(sum, n)| *sum += n));
        shares(&counts)
    }
}

/// w = (I - u u^H) 1 with the leading left singular vector of the node matrix, found by power iteration on its Gram
/// matrix; the sum over the nodes of what is left.
fn clutter_free(sweeps: &[super::channel::Sweep]) -> Vec<Complex64> {
    const N: usize = super::channel::NODES;
    let mut gram = [[Complex64::default(); N]; N];
    for sweep in sweeps {
        for (row, a) in gram.iter_mut().zip(sweep) {
            row.iter_mut().zip(sweep).for_each(|(g, b)| *g += a * b.conj());
        }
    }
    let mut u = [Complex64::new(1.0, 0.0); N];
    for _ in 0..100 {
        let mut next = gram.map(|row| row.iter().zip(&u).map(|(g, u)| g * u).sum::<Complex64>());
        let length = next.iter().map(|z| z.norm_sqr()).sum::<f64>().sqrt();
        if length > 0.0 {
            next.iter_mut().for_each(|z| *z /= length);
            u = next;
        }
    }
    let inner: Complex64 = u.iter().map(|u| u.conj()).sum();
    let w = u.map(|u| Complex64::new(1.0, 0.0) - u * inner);
    sweeps.iter().map(|s| s.iter().zip(&w).map(|(b, w)| w.conj() * b).sum()).collect()
}

/// Two single-pole high-pass filters, one after the other: what AC coupling leaves of a signal at `rate_hz`.
fn ac_couple(y: &mut [Complex64], rate_hz: f64) {
    let keep = libm::exp(-std::f64::consts::TAU * AC_COUPLING_HZ / rate_hz);
    for _ in 0..2 {
        let Some(&first) = y.first() else { return };
        let (mut before, mut state) = (first, Complex64::default());
        for z in y.iter_mut() {
            state = (state + *z - before) * keep;
            before = *z;
            *z = state;
        }
    }
}

fn shares(counts: &[u64; LEVELS]) -> Vec<f64> {
    let total: u64 = counts.iter().sum();
    counts.iter().map(|&n| n as f64 / total.max(1) as f64).collect()
}

/// KL(measured || simulated) in nats; a 10^-6 share, about one count, is added to every simulated level.
fn divergence(measured: &[f64], simulated: &[f64], skip: usize) -> f64 {
    let norm = |p: &[f64]| -> f64 { p.iter().skip(skip).sum::<f64>().max(1e-300) };
    let floor = 1e-6;
    let (m, s) = (norm(measured), norm(simulated) + floor * (LEVELS - skip) as f64);
    measured
        .iter()
        .zip(simulated)
        .skip(skip)
        .filter(|(p, _)| **p > 0.0)
        .map(|(p, q)| p / m * libm::log(p / m / ((q + floor) / s)))
        .sum()
}

/// Searches the curve: the grid, then between the neighbours of its minimum.
fn search(bench: &Bench, measured: &[f64], progress: Progress) -> (Vec<KlPoint>, Vec<f64>, usize) {
    let total = (GRID.len() + REFINEMENT) as u64;
    let done = AtomicU64::new(0);
    let evaluate = |rho: f64| {
        let simulated = bench.pmf(rho, Set::Calibration, PEOPLE);
        progress(done.fetch_add(1, Ordering::Relaxed) + 1, total);
        let point = KlPoint {
            rho,
            kl: divergence(measured, &simulated, 0),
            kl_without_black: divergence(measured, &simulated, 1),
        };
        (point, simulated)
    };
    let mut found: Vec<(KlPoint, Vec<f64>)> = GRID.iter().map(|&rho| evaluate(rho)).collect();
    let lowest = |found: &[(KlPoint, Vec<f64>)]| {
        let order = |a: &usize, b: &usize| found[*a].0.kl.total_cmp(&found[*b].0.kl);
        (0..found.len()).min_by(order).unwrap_or(0)
    };
    let best = lowest(&found);
    let (low, high) = (GRID[best.saturating_sub(1)], GRID[(best + 1).min(GRID.len() - 1)]);
    for step in 1..=REFINEMENT {
        let rho = low + (high - low) * step as f64 / (REFINEMENT + 1) as f64;
        // to the fourth digit, so that tables and pages show what was used
        let rho = (rho * 1e4).round() / 1e4;
        if found.iter().all(|(p, _)| (p.rho - rho).abs() > 1e-9) {
            found.push(evaluate(rho));
        }
    }
    found.sort_by(|a, b| a.0.rho.total_cmp(&b.0.rho));
    let best = lowest(&found);
    let pmf = found[best].1.clone();
    (found.into_iter().map(|(point, _)| point).collect(), pmf, best)
}

/// Calibrates on a measured CW Doppler signal: real, one number per time.
pub fn calibrate_measured(
    scenario: &Scenario,
    samples: &[f64],
    rate_hz: f64,
    carrier_hz: f64,
    title: &str,
    seed: u64,
    progress: Progress,
) -> Calibration {
    let mut at_carrier = scenario.clone();
    at_carrier.radar.carrier_hz = carrier_hz;
    at_carrier.frame.slot_s = 1.0 / MEASURED_PRF_HZ;
    at_carrier.frame.spacing_slots = 0;
    let slots = MEASURED_PRF_HZ as usize;
    let grey = Grey::new(128, 10.0, 8);
    let bench = Bench { scenario: &at_carrier, seed, real: true, slots: slots as u32, grey };

    let mut signal: Vec<Complex64> =
        resample(samples, rate_hz, MEASURED_PRF_HZ).into_iter().map(|x| Complex64::new(x, 0.0)).collect();
    ac_couple(&mut signal, MEASURED_PRF_HZ);
    let energy = |w: &[Complex64]| w.iter().map(|z| z.norm_sqr()).sum::<f64>();
    let all: Vec<&[Complex64]> = signal.chunks_exact(slots).collect();
    let mut energies: Vec<f64> = all.iter().map(|w| energy(w)).collect();
    energies.sort_by(f64::total_cmp);
    let median = energies.get(energies.len() / 2).copied().unwrap_or(0.0);
    // pauses and turns show the room, not the walker
    let windows: Vec<&[Complex64]> = all.into_iter().filter(|w| energy(w) >= MOTION_SHARE * median).collect();
    let mut counts = [0; LEVELS];
    for window in &windows {
        let one = histogram(&bench.grey.decibels(window, true));
        counts.iter_mut().zip(one).for_each(|(sum, n)| *sum += n);
    }
    let measured_pmf = shares(&counts);
    let (curve, simulated_pmf, best) = search(&bench, &measured_pmf, progress);
    let shown = windows.iter().max_by(|a, b| energy(a).total_cmp(&energy(b))).map_or(&signal[..0], |w| w);
    let simulated = bench.signal(curve[best].rho, Set::Demo, 0);
    Calibration {
        source: format!(
            "measured: {title}, {:.4} GHz, {} windows of 1 s with motion",
            carrier_hz / 1e9,
            windows.len()
        ),
        carrier_hz,
        rho: curve[best].rho,
        kl: Some(curve[best].kl),
        kl_without_uncertainty: curve.last().map(|p| p.kl),
        curve_of: format!("grey levels of {title} against {PEOPLE} simulated walkers at the same carrier"),
        curve,
        measured_pmf,
        simulated_pmf,
        measured: Some(picture(&bench, title, shown)),
        simulated: Some(picture(&bench, "simulated walker", &simulated)),
    }
}

/// No measurement: the stored rho, and the curve that recovers it from recordings simulated with it.
pub fn recover(scenario: &Scenario, rho: f64, source: &str, seed: u64, progress: Progress) -> Calibration {
    let settings = &scenario.spectrogram;
    let grey = Grey::new(usize::from(settings.window), f64::from(settings.beta), usize::from(settings.hop));
    let bench = Bench { scenario, seed, real: false, slots: scenario.largest_sensing_slots(), grey };
    let measured_pmf = bench.pmf(rho, Set::Stand, STAND_INS);
    let (curve, simulated_pmf, best) = search(&bench, &measured_pmf, progress);
    let simulated = bench.signal(rho, Set::Demo, 0);
    Calibration {
        source: source.to_owned(),
        carrier_hz: scenario.radar.carrier_hz,
        rho,
        kl: Some(curve[best].kl),
        kl_without_uncertainty: curve.last().map(|p| p.kl),
        curve_of: format!(
            "self-check, nothing measured: {STAND_INS} walkers simulated at rho = {rho} stand for the measurement; the \
             curve's minimum is at {}",
            curve[best].rho
        ),
        curve,
        measured_pmf,
        simulated_pmf,
        measured: None,
        simulated: Some(picture(&bench, "simulated walker", &simulated)),
    }
}

fn picture(bench: &Bench, title: &str, signal: &[Complex64]) -> Spectrogram {
    let decibels = bench.grey.decibels(signal, bench.real);
    let rows = decibels.first().map_or(0, Vec::len);
    let row_hz = 1.0 / (256.0 * bench.scenario.interval_s());
    let grey = |row: usize| decibels.iter().map(move |f| ((1.0 + f[row] / RANGE_DB).max(0.0) * 255.0) as u8);
    let hop = if bench.real { 8.0 } else { f64::from(bench.scenario.spectrogram.hop) };
    Spectrogram {
        title: title.to_owned(),
        rows: rows as u32,
        frames: decibels.len() as u32,
        first_row_hz: if bench.real { 0.0 } else { -128.0 * row_hz },
        row_hz,
        frame_s: hop * bench.scenario.interval_s(),
        grey: (0..rows).flat_map(grey).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_knows_the_papers_rooms() {
        let mut scenario = Scenario::default();
        assert_eq!(stored_rho(&scenario).0, 0.997);
        scenario.radar.carrier_hz = 60e9;
        scenario.channel.interferer = true;
        assert_eq!(stored_rho(&scenario).0, 0.996);
    }

    #[test]
    fn divergence_is_zero_for_equals_and_positive_else() {
        let p = vec![1.0 / LEVELS as f64; LEVELS];
        let mut q = p.clone();
        q[3] *= 2.0;
        q[4] = 0.0;
        assert!(divergence(&p, &p, 0).abs() < 1e-9);
        assert!(divergence(&p, &q, 0) > 0.01);
    }

    #[test]
    fn a_known_memory_is_recovered() {
        let scenario = Scenario::default();
        let found = recover(&scenario, 0.99, "test", 3, &|_, _| ());
        let best = found.curve.iter().min_by(|a, b| a.kl.total_cmp(&b.kl)).unwrap();
        assert!((best.rho - 0.99).abs() < 0.0045, "{}", best.rho);
        assert!(found.kl_without_uncertainty > found.kl.map(|kl| 5.0 * kl));
    }
}
