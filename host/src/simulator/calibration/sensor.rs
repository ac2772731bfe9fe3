//! Simulated people as a sensor shows them, conditioned as the measured signal is.

use super::conditioning::{ac_couple, remove_mean};
use super::divergence::{Counts, EVALUATIONS, search};
use super::intensity::{Intensity, LEVELS, histogram};
use super::{PEOPLE, Progress, without_clutter};
use crate::numerics::random::Random;
use crate::results::{KlPoint, Spectrogram};
use crate::scenario::{Class, Scenario};
use crate::simulator::channel::{BLOCKS, Blocks, Complex64};
use crate::simulator::dataset::{Set, Simulation};
use rayon::prelude::*;
use std::f64::consts::FRAC_1_SQRT_2;
use std::sync::atomic::{AtomicU64, Ordering};

/// Slots simulated before a window: the room's first response fades and the AC coupling settles. Measured rooms have no
/// beginning.
pub const SETTLE_SLOTS: u32 = 300;
/// Stream number of white noise.
const NOISE_STREAM: u64 = 207;

/// Simulates people as the sensor of a measured signal shows them.
pub struct SensorSimulation<'a> {
    pub scenario: &'a Scenario,
    pub seed: u64,
    pub class: Class,
    /// A real, AC-coupled signal instead of a complex one.
    pub real: bool,
    /// One range cell, its mean removed, instead of the beat matrix.
    pub single_cell: bool,
    pub slots: u32,
    pub intensity: Intensity,
}

impl<'a> SensorSimulation<'a> {
    /// Complex recordings of `slots` sensing slots as the scenario's front end shows them; real ones if asked.
    pub fn new(scenario: &'a Scenario, seed: u64, class: Class, real: bool, slots: u32) -> Self {
        let settings = &scenario.spectrogram;
        let intensity = Intensity::new(usize::from(settings.window), usize::from(settings.hop));
        SensorSimulation { scenario, seed, class, real, single_cell: false, slots, intensity }
    }

    /// Slots of a simulation, with those that settle before the window.
    fn simulated(&self) -> u32 {
        SETTLE_SLOTS + self.slots
    }

    fn simulation<'s>(&self, scenario: &'s Scenario, rho: f64, set: Set, index: u32) -> Simulation<'s> {
        Simulation::new(scenario, rho, self.seed, set, self.class, index)
    }

    /// The slow-time signal before conditioning: one range sample of a sensor that has one number a time, else their mean.
    fn unconditioned(&self, beats: &[Blocks]) -> Vec<Complex64> {
        let one = self.real || self.single_cell;
        let sample =
            |b: &Blocks| if one { b[BLOCKS / 2] } else { b.iter().sum::<Complex64>() / BLOCKS as f64 };
        beats.iter().map(sample).collect()
    }

    /// As the sensor shows it: real and AC-coupled, or without its mean.
    fn conditioned(&self, mut y: Vec<Complex64>) -> Vec<Complex64> {
        if self.real {
            y.iter_mut().for_each(|z| z.im = 0.0);
            ac_couple(&mut y, 1.0 / self.scenario.interval_s());
        }
        let mut y = y.split_off(SETTLE_SLOTS as usize);
        if !self.real {
            remove_mean(&mut y);
        }
        y
    }

    /// One person's slow-time signal for spectra, in a scenario of its own.
    pub fn slow_time(&self, scenario: &Scenario, rho: f64, set: Set, index: u32) -> Vec<Complex64> {
        let beats = self.simulation(scenario, rho, set, index).advance_blocks(self.simulated());
        self.conditioned(self.unconditioned(&beats))
    }

    /// Mean power that the second scenario's signals have in addition to the first's, before conditioning.
    pub fn added_power(&self, scenarios: [&Scenario; 2], rho: f64, people: u32) -> f64 {
        let of = |index| {
            let [without, with] = scenarios.map(|scenario| {
                let mut simulation = self.simulation(scenario, rho, Set::Calibration, index);
                self.unconditioned(&simulation.advance_blocks(self.simulated()))
            });
            with.iter().zip(&without).map(|(a, b)| (a - b).norm_sqr()).sum::<f64>() / with.len() as f64
        };
        (0..people).into_par_iter().map(of).collect::<Vec<_>>().iter().sum::<f64>() / f64::from(people)
    }

    /// White noise of unit power as the sensor shows it.
    pub fn noise(&self, index: u32) -> Vec<Complex64> {
        let mut random = Random::new(self.seed, NOISE_STREAM, self.class as u64, u64::from(index));
        let draw = |_| Complex64::new(random.gaussian(), random.gaussian()) * FRAC_1_SQRT_2;
        self.conditioned((0..self.simulated()).map(draw).collect())
    }

    /// One person's slow-time signal for intensities: clutter removed, as the measured one has it.
    pub fn signal(&self, rho: f64, set: Set, index: u32) -> Vec<Complex64> {
        self.shown(self.simulation(self.scenario, rho, set, index).advance_blocks(self.simulated()))
    }

    /// Range samples as they are shown for intensities.
    fn shown(&self, mut beats: Vec<Blocks>) -> Vec<Complex64> {
        if self.real || self.single_cell {
            return self.conditioned(self.unconditioned(&beats));
        }
        without_clutter(&beats.split_off(SETTLE_SLOTS as usize), self.scenario.radar.range_samples)
    }

    /// Intensities of signals, together.
    pub fn counted(&self, signals: impl IndexedParallelIterator<Item = Vec<Complex64>>) -> Counts {
        let each: Vec<Counts> = signals.map(|y| histogram(&self.intensity.decibels(&y, self.real))).collect();
        let mut counts = [0_u64; LEVELS];
        each.iter().for_each(|one| counts.iter_mut().zip(one).for_each(|(sum, n)| *sum += n));
        counts
    }

    /// Intensities of `people` recordings of a set, together.
    pub fn counts(&self, rho: f64, set: Set, people: u32) -> Counts {
        self.counted((0..people).into_par_iter().map(|index| self.signal(rho, set, index)))
    }

    /// The KL curve over rho, what was simulated at each of its points, and the place of its minimum.
    pub fn search(&self, measured: &Counts, progress: Progress) -> (Vec<KlPoint>, Vec<Counts>, usize) {
        let done = AtomicU64::new(0);
        let of = |rho, index| self.simulation(self.scenario, rho, Set::Calibration, index);
        let steady: Vec<Vec<Blocks>> =
            (0..PEOPLE).into_par_iter().map(|index| of(1.0, index).steady_blocks(self.simulated())).collect();
        let found = search(measured, |rho| {
            let person = |index: u32| self.shown(of(rho, index).with_fluctuation(&steady[index as usize]));
            let counts = self.counted((0..PEOPLE).into_par_iter().map(person));
            progress(done.fetch_add(1, Ordering::Relaxed) + 1, EVALUATIONS);
            counts
        });
        progress(EVALUATIONS, EVALUATIONS);
        found
    }
}

/// The spectrogram of a signal.
pub fn picture(sensor: &SensorSimulation, title: &str, signal: &[Complex64]) -> Spectrogram {
    let scenario = &sensor.scenario;
    let rate_hz = 1.0 / scenario.interval_s();
    let decibels = sensor.intensity.decibels(signal, sensor.real);
    sensor.intensity.picture(title, &decibels, sensor.real, rate_hz, scenario.radar.carrier_hz)
}
