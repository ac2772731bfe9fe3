//! Phase noise of the oscillator that sends and receives, slot by slot.
//!
//! An echo of delay tau meets the oscillator's own phase tau later: its beat has the phase phi(t) - phi(t - tau), of spectral density
//! 4 sin^2(pi f tau) L(f) (range correlation; Budge and Burt, Range correlation effects in radars, 1993). Here that phase is
//! tau phi'(t): 2 pi f tau for 2 sin(pi f tau), 0.5 dB too much at f tau = 0.18 and 0.01 dB at 0.03. One series phi' serves every path.
//!
//! With L = A / (f^2 + f_L^2) + floor ([`Spectrum`]) phi' is white noise behind a high-pass filter of first order at f_L, and the
//! derivative of white phase noise: no transform is needed. The sampling rate bounds the band. Slots are independent: phi is
//! correlated over 1 / (2 pi f_L), a few microseconds. The reference's noise close to the carrier is left out: within 1 kHz the range
//! correlation of 20 ns is -78 dB.

use crate::numerics::random::Random;
use crate::scenario::Spectrum;
use std::f64::consts::PI;

/// Samples on each side in the derivative of white phase noise.
const SIDE: usize = 4;

/// phi' as filters of white noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Filters {
    /// Standard deviation of the white noise that the high-pass filter takes, in rad/s.
    falling: f64,
    /// The filter: `w - l` with `l_n = v_n + beta w_n`, `v_n = alpha v_(n-1) + drive w_(n-1)`.
    alpha: f64,
    beta: f64,
    drive: f64,
    /// Weights of the samples at 1/2, 3/2, .. to the right, and their negatives to the left, in rad/s.
    derivative: [f64; SIDE],
}

impl Filters {
    /// Of a spectrum, for series at a sampling rate in Hz.
    pub fn new(spectrum: &Spectrum, rate_hz: f64) -> Self {
        let t = libm::tan(PI * (spectrum.loop_hz / rate_hz).min(0.4));
        let (alpha, beta) = ((1.0 - t) / (1.0 + t), t / (1.0 + t));
        let white = (spectrum.floor * rate_hz).sqrt() * rate_hz;
        Filters {
            falling: 2.0 * PI * 1e6 * (spectrum.level * rate_hz).sqrt(),
            alpha,
            beta,
            drive: beta * (1.0 + alpha),
            derivative: std::array::from_fn(|m| {
                let sign = if m % 2 == 0 { 1.0 } else { -1.0 };
                // half of the last one: an alternating sum cut there is closest
                let last = if m + 1 == SIDE { 0.5 } else { 1.0 };
                white * sign * last / (PI * (m as f64 + 0.5) * (m as f64 + 0.5))
            }),
        }
    }

    /// Variance of the filter's memory where it has settled, of white noise of variance 1.
    fn settled(&self) -> f64 {
        self.drive * self.drive / (1.0 - self.alpha * self.alpha)
    }

    /// Covariance of two samples of the series in (rad/s)^2, `lag` apart.
    pub fn covariance(&self, lag: usize) -> f64 {
        let direct = 1.0 - self.beta;
        let falling = match lag {
            0 => direct * direct + self.settled(),
            _ => {
                let decay = libm::pow(self.alpha, lag as f64 - 1.0);
                decay * (self.alpha * self.settled() - direct * self.drive)
            }
        };
        let tap = |k: usize| match k {
            k if k < SIDE => -self.derivative[SIDE - 1 - k],
            k if k < 2 * SIDE => self.derivative[k - SIDE],
            _ => 0.0,
        };
        let derivative: f64 = (0..2 * SIDE).map(|k| tap(k) * tap(k + lag)).sum();
        self.falling * self.falling * falling + derivative
    }
}

/// Series of phi', one a slot.
#[derive(Debug, Clone)]
pub struct Oscillator {
    filters: Filters,
    random: Random,
    white: Vec<f64>,
}

impl Oscillator {
    /// Of these filters, drawn from `random`.
    pub fn new(filters: Filters, random: Random) -> Self {
        Oscillator { filters, random, white: Vec::new() }
    }

    /// Draws phi' in rad/s at the samples of the next slot.
    pub fn draw(&mut self, series: &mut [f64]) {
        let Oscillator { filters, random, white } = self;
        white.clear();
        white.extend((0..series.len() + 2 * SIDE - 1).map(|_| random.gaussian()));
        let mut memory = filters.settled().sqrt() * random.gaussian();
        for (n, value) in series.iter_mut().enumerate() {
            let w = random.gaussian();
            let falling = w - (memory + filters.beta * w);
            memory = filters.alpha * memory + filters.drive * w;
            let near = &white[n..n + 2 * SIDE];
            let floor: f64 = filters
                .derivative
                .iter()
                .enumerate()
                .map(|(m, weight)| weight * (near[SIDE + m] - near[SIDE - 1 - m]))
                .sum();
            *value = filters.falling * falling + floor;
        }
    }

    /// Standard normal numbers of its stream, for what is drawn without the series.
    pub fn gaussian(&mut self) -> f64 {
        self.random.gaussian()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::builtin::named;
    use crate::scenario::{FrontEnd, Radar};
    use crate::simulator::channel::{Complex64, phasor};

    fn typical(name: &str) -> Radar {
        let mut radar = named(name.as_ref()).unwrap().scenario().radar;
        radar.front_end = FrontEnd::Typical;
        radar
    }

    /// Power density of many series at `cycles` a series, by a Hann window.
    fn density(series: &[Vec<f64>], rate_hz: f64, cycles: f64) -> f64 {
        let samples = series[0].len() as f64;
        let window: Vec<_> = (0..series[0].len())
            .map(|n| {
                let u = (n as f64 + 0.5) / samples;
                phasor(-2.0 * PI * cycles * u) * (0.5 - 0.5 * libm::cos(2.0 * PI * u))
            })
            .collect();
        let norm: f64 = window.iter().map(|w| w.norm_sqr()).sum::<f64>() * rate_hz;
        let power =
            |one: &Vec<f64>| one.iter().zip(&window).map(|(x, w)| w * x).sum::<Complex64>().norm_sqr();
        series.iter().map(power).sum::<f64>() / norm / series.len() as f64
    }

    #[test]
    fn series_have_the_spectrum_of_the_law_to_one_decibel() {
        for name in ["conference-room", "bgt60", "iwr"] {
            let radar = typical(name);
            let spectrum = radar.effects().spectrum.unwrap();
            let rate_hz = radar.sample_rate_hz;
            let random = Random::new(1, 2, 3, 4);
            let mut oscillator = Oscillator::new(Filters::new(&spectrum, rate_hz), random);
            let series: Vec<_> = (0..4000)
                .map(|_| {
                    let mut one = vec![0.0; 512];
                    oscillator.draw(&mut one);
                    one
                })
                .collect();
            for share in [0.01, 0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.48] {
                let offset_hz = (share * 512.0_f64).round() / 512.0 * rate_hz;
                let found = density(&series, rate_hz, (share * 512.0_f64).round());
                let turns = 2.0 * PI * offset_hz;
                let db = 10.0 * libm::log10(found / (turns * turns * spectrum.at(offset_hz)));
                // 4000 series: 0.07 dB of standard deviation
                let within = if share < 0.45 { 0.5 } else { 1.0 };
                assert!(db.abs() < within, "{name} at {offset_hz} Hz: {db} dB");
            }
        }
    }

    #[test]
    fn covariances_are_those_of_the_series() {
        let radar = typical("conference-room");
        let filters = Filters::new(&radar.effects().spectrum.unwrap(), radar.sample_rate_hz);
        let mut oscillator = Oscillator::new(filters, Random::new(1, 2, 3, 5));
        let mut sums = [0.0; 12];
        let slots = 100_000;
        let mut one = vec![0.0; 12];
        for _ in 0..slots {
            oscillator.draw(&mut one);
            sums.iter_mut().zip(&one).for_each(|(sum, x)| *sum += one[0] * x);
        }
        let variance = filters.covariance(0);
        for (lag, sum) in sums.iter().enumerate() {
            let found = sum / f64::from(slots);
            assert!((found - filters.covariance(lag)).abs() < 0.015 * variance, "{lag}: {found}");
        }
    }
}
