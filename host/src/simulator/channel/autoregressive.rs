//! The room's response as an AR(1) process: v_j = rho v_{j-1} + (1 - rho) Upsilon_j.
//!
//! Eq. (vit) in three modes, and as the fluctuation of a room that has a mean besides, once per sensing slot or once per slot. Upsilon is a sum of rays with fixed delays and redrawn
//! phases (802.11ay) or complex Gaussian taps (802.11ax), so the recursion runs on one complex number per ray.

use super::ieee80211ay::Ray;
use super::{BLOCKS, Blocks, Complex64, Path, Sensor, phasor};
use crate::numerics::random::Random;
use crate::numerics::vectors::vectorised;
use crate::scenario::{Advance, ArMode, Channel};
use crate::simulator::body::number::{LANES, Lanes, Real};
use std::f64::consts::FRAC_1_SQRT_2;

/// How a new innovation is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Innovation {
    /// Amplitude 1, uniform phase: a ray.
    Phase,
    /// Complex Gaussian of unit power: a tap.
    Gaussian,
}

/// Range samples of a ray at the amplitudes 1 and j, real and imaginary parts by turns.
type Part = [[f64; 2 * BLOCKS]; 2];

/// Slots of which the innovations are drawn together.
const DRAWN: usize = 32;
/// Slots of which the rays are summed together.
const SIDE_BY_SIDE: usize = 4;

/// The room between two points, slot after slot.
#[derive(Debug, Clone)]
pub struct Ar1Process {
    rays: Vec<Ray>,
    innovation_kind: Innovation,
    state: Vec<Complex64>,
    draw: Vec<Complex64>,
    /// Amplitude of each ray in an innovation.
    levels: Vec<f64>,
    /// Gaussian numbers that were drawn, two a ray and innovation, and how many of them were used.
    numbers: Vec<f64>,
    used: usize,
    /// Of each ray, once they are asked for.
    parts: Vec<Part>,
    rho: f64,
    innovation: f64,
    mode: ArMode,
    stationary: bool,
    steps: u32,
    started: bool,
}

impl Ar1Process {
    /// A room of `rays`; with `spacing_slots` between two sensing slots.
    pub fn new(
        channel: &Channel,
        rays: Vec<Ray>,
        innovation_kind: Innovation,
        rho: f64,
        spacing_slots: u32,
    ) -> Self {
        let innovation = match channel.mode {
            ArMode::Paper | ArMode::Consistent => 1.0 - rho,
            ArMode::VariancePreserving | ArMode::Rician => (1.0 - rho * rho).sqrt(),
        };
        Ar1Process {
            parts: Vec::new(),
            levels: rays.iter().map(|ray| innovation * ray.amplitude).collect(),
            numbers: Vec::new(),
            used: 0,
            state: vec![Complex64::default(); rays.len()],
            draw: vec![Complex64::default(); rays.len()],
            rays,
            innovation_kind,
            rho,
            innovation,
            mode: channel.mode,
            stationary: channel.stationary_start,
            steps: match channel.advance {
                Advance::SensingSlot => 1,
                Advance::Slot => spacing_slots + 1,
            },
            started: false,
        }
    }

    /// Draws what the next `slots` calls of [`Ar1Process::step`] would draw: many numbers are made faster.
    fn draw_ahead(&mut self, random: &mut Random, slots: usize) {
        let steps = if self.rho == 1.0 { 0 } else { self.steps as usize };
        let innovations = if self.started { slots * steps } else { 1 + slots.saturating_sub(1) * steps };
        if self.innovation_kind == Innovation::Gaussian && self.used == self.numbers.len() {
            self.draw_numbers(random, innovations);
        }
    }

    fn draw_numbers(&mut self, random: &mut Random, innovations: usize) {
        self.numbers.resize(innovations * 2 * self.rays.len(), 0.0);
        random.gaussians(&mut self.numbers);
        self.used = 0;
    }

    fn draw(&mut self, random: &mut Random) {
        match self.innovation_kind {
            Innovation::Gaussian => {
                if self.used == self.numbers.len() {
                    self.draw_numbers(random, 1);
                }
                let (pairs, _) = self.numbers[self.used..].as_chunks::<2>();
                self.used += 2 * self.rays.len();
                for (z, [re, im]) in self.draw.iter_mut().zip(pairs) {
                    *z = Complex64::new(re * FRAC_1_SQRT_2, im * FRAC_1_SQRT_2);
                }
            }
            Innovation::Phase => {
                for group in self.draw.chunks_mut(LANES) {
                    let mut turns = [0.0; LANES];
                    turns.iter_mut().take(group.len()).for_each(|t| *t = random.uniform());
                    let (s, c) = Lanes::new(turns).sin_cos_turns();
                    let drawn = c.to_array().into_iter().zip(s.to_array());
                    group.iter_mut().zip(drawn).for_each(|(z, (c, s))| *z = Complex64::new(c, s));
                }
            }
        }
        if self.mode == ArMode::Consistent {
            for (z, ray) in self.draw.iter_mut().zip(&self.rays) {
                if let Some(phase) = ray.fixed {
                    *z = phasor(phase);
                }
            }
        }
    }

    /// Goes on to the next sensing slot.
    pub fn step(&mut self, random: &mut Random) {
        if !self.started {
            self.started = true;
            self.draw(random);
            // what the recursion loses of Upsilon's power in the long run
            let settled = self.innovation / (1.0 - self.rho * self.rho).max(f64::MIN_POSITIVE).sqrt();
            for ((state, draw), ray) in self.state.iter_mut().zip(&self.draw).zip(&self.rays) {
                let kept = self.mode == ArMode::Consistent && ray.fixed.is_some();
                let start = if self.stationary && self.rho < 1.0 && !kept { settled } else { 1.0 };
                *state = draw * (start * ray.amplitude);
            }
            return;
        }
        if self.rho == 1.0 {
            return;
        }
        for _ in 0..self.steps {
            self.draw(random);
            let (state, draw, levels, rho) = (&mut self.state, &self.draw, &self.levels, self.rho);
            for ((state, draw), level) in state.iter_mut().zip(draw).zip(levels) {
                *state = *state * rho + draw * level;
            }
        }
    }

    /// Appends the room's paths as they are now.
    pub fn paths(&self, paths: &mut Vec<Path>) {
        let path = |(state, ray): (&Complex64, &Ray)| Path {
            gain: *state,
            delay_s: ray.delay_s,
            departure: ray.departure,
            arrival: ray.arrival,
        };
        paths.extend(self.state.iter().zip(&self.rays).map(path));
    }

    /// Goes on slot by slot and adds the room's range samples, by the same sensor every time.
    pub fn beats(&mut self, random: &mut Random, sensor: &Sensor, beats: &mut [Blocks]) {
        if self.parts.is_empty() {
            let parts = |ray: &Ray| {
                let weight = sensor.antenna.amplitude(ray.departure) * sensor.antenna.amplitude(ray.arrival);
                sensor.response.parts(ray.delay_s).map(|part| {
                    let part = part.map(|z| z * weight);
                    std::array::from_fn(|k| if k % 2 == 0 { part[k / 2].re } else { part[k / 2].im })
                })
            };
            self.parts = self.rays.iter().map(parts).collect();
        }
        let mut states = vec![[Complex64::default(); SIDE_BY_SIDE]; self.rays.len()];
        for beats in beats.chunks_mut(DRAWN) {
            self.draw_ahead(random, beats.len());
            for beats in beats.chunks_mut(SIDE_BY_SIDE) {
                for slot in 0..beats.len() {
                    self.step(random);
                    states.iter_mut().zip(&self.state).for_each(|(states, state)| states[slot] = *state);
                }
                add_rays(&states, &self.parts, beats);
            }
        }
    }
}

/// Adds rays' range samples to those of up to [`SIDE_BY_SIDE`] slots, of which `states` has the rays' amplitudes: every slot's sum waits for
/// its last term, not for the other slots'.
fn add_rays(states: &[[Complex64; SIDE_BY_SIDE]], parts: &[Part], beats: &mut [Blocks]) {
    let mut begin = [[0.0; 2 * BLOCKS]; SIDE_BY_SIDE];
    for (begin, beat) in begin.iter_mut().zip(&*beats) {
        begin.as_chunks_mut().0.iter_mut().zip(beat).for_each(|(to, z)| *to = [z.re, z.im]);
    }
    let sums = vectorised(
        #[inline(always)]
        || {
            let [mut a, mut b, mut c, mut d] = begin;
            for ([of_a, of_b, of_c, of_d], part) in states.iter().zip(parts) {
                (a, b) = (added(a, of_a, part), added(b, of_b, part));
                (c, d) = (added(c, of_c, part), added(d, of_d, part));
            }
            [a, b, c, d]
        },
    );
    for (beat, sums) in beats.iter_mut().zip(&sums) {
        beat.iter_mut().zip(sums.as_chunks().0).for_each(|(z, &[re, im])| *z = Complex64::new(re, im));
    }
}

/// A sum and a ray's range samples at an amplitude.
#[inline(always)]
fn added(mut sum: [f64; 2 * BLOCKS], amplitude: &Complex64, [one, j]: &Part) -> [f64; 2 * BLOCKS] {
    for k in 0..2 * BLOCKS {
        sum[k] += amplitude.re * one[k] + amplitude.im * j[k];
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ray(fixed: Option<f64>) -> Ray {
        Ray { amplitude: 1.0, delay_s: 20e-9, departure: [1.0, 0.0, 0.0], arrival: [1.0, 0.0, 0.0], fixed }
    }

    fn process(mode: ArMode, rho: f64, stationary_start: bool, fixed: Option<f64>) -> Ar1Process {
        let channel = Channel { mode, stationary_start, ..Default::default() };
        Ar1Process::new(&channel, vec![ray(fixed)], Innovation::Phase, rho, 3)
    }

    /// Mean powers of one ray over `runs` runs of `slots` slots.
    fn powers(mode: ArMode, rho: f64, stationary: bool, slots: usize, runs: u32) -> Vec<f64> {
        let mut sums = vec![0.0; slots];
        for index in 0..runs {
            let mut random = Random::new(3, 0, 0, u64::from(index));
            let mut process = process(mode, rho, stationary, None);
            for sum in &mut sums {
                process.step(&mut random);
                *sum += process.state[0].norm_sqr() / f64::from(runs);
            }
        }
        sums
    }

    #[test]
    fn variance_follows_each_mode() {
        let start = powers(ArMode::Paper, 0.9, false, 120, 4000);
        assert!((start[0] - 1.0).abs() < 1e-9);
        // paper: the first response fades as rho^2j, its innovations rise to (1 - rho) / (1 + rho)
        for j in [1, 5, 10, 40] {
            let fade = libm::pow(0.9, 2.0 * j as f64);
            let exact = fade + (1.0 - fade) * 0.1 / 1.9;
            assert!((start[j] / exact - 1.0).abs() < 0.06, "{j}: {} {exact}", start[j]);
        }
        for (mode, exact) in [(ArMode::Paper, 0.1 / 1.9), (ArMode::VariancePreserving, 1.0)] {
            let settled = powers(mode, 0.9, true, 60, 4000);
            let mean = settled.iter().sum::<f64>() / 60.0;
            assert!((mean / exact - 1.0).abs() < 0.03, "{mode:?} {mean}");
        }
    }

    #[test]
    fn the_spectrum_is_lorentzian() {
        // at 0.997 and 1 kHz: half width 0.48 Hz, -20 dB at 5 Hz, -40 dB at 50 Hz
        let (rho, n) = (0.997, 1 << 15);
        let mut planner = rustfft::FftPlanner::new();
        let fft = planner.plan_fft_forward(n);
        let mut spectrum = vec![0.0; n];
        for run in 0..40 {
            let mut random = Random::new(5, 0, 0, run);
            let mut process = process(ArMode::Paper, rho, true, None);
            let mut signal: Vec<Complex64> = (0..n)
                .map(|k| {
                    process.step(&mut random);
                    // Hann window: the tails are its, not the rectangle's
                    process.state[0] * (0.5 - 0.5 * libm::cos(std::f64::consts::TAU * k as f64 / n as f64))
                })
                .collect();
            fft.process(&mut signal);
            spectrum.iter_mut().zip(&signal).for_each(|(s, z)| *s += z.norm_sqr());
        }
        let density = |hz: f64, width: f64| -> f64 {
            let bin = |f: f64| (f / 1000.0 * n as f64) as usize;
            let band = &spectrum[bin(hz - width).max(1)..bin(hz + width)];
            band.iter().sum::<f64>() / band.len() as f64
        };
        let top = density(0.1, 0.1);
        for (hz, width, db) in [(0.48, 0.05, -3.2), (5.0, 0.3, -20.4), (50.0, 2.0, -40.1)] {
            let found = 10.0 * libm::log10(density(hz, width) / top);
            assert!((found - db).abs() < 1.2, "{hz} Hz: {found} dB");
        }
    }

    #[test]
    fn full_memory_and_geometry_never_change() {
        for (mode, rho, fixed) in [(ArMode::Paper, 1.0, None), (ArMode::Consistent, 0.9, Some(1.0))] {
            let mut random = Random::new(3, 0, 0, 0);
            let mut process = process(mode, rho, false, fixed);
            process.step(&mut random);
            let first = process.state[0];
            for _ in 0..50 {
                process.step(&mut random);
                assert!((process.state[0] - first).norm() < 1e-12);
            }
        }
    }
}
