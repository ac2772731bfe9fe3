//! A slot's beat, sample by sample.

use super::interpolation::interpolate;
use crate::scenario::{Dechirp, Radar};
use crate::simulator::channel::{Complex64, Sweep, phasor};
use std::f64::consts::PI;

/// A slot's beat at the samples.
pub struct Samples {
    /// Its real part.
    pub re: Vec<f64>,
    /// Its imaginary part.
    pub im: Vec<f64>,
    /// The same with every path weighted by its delay; empty without phase noise.
    moment_re: Vec<f64>,
    moment_im: Vec<f64>,
    /// Derivative of the oscillator's phase in rad/s; empty without phase noise.
    pub frequency: Vec<f64>,
}

const LANES: usize = 8;

impl Samples {
    /// Zeros, with or without phase noise.
    pub fn new(samples: usize, noisy: bool) -> Self {
        let zeros = |used: bool| vec![0.0; if used { samples } else { 0 }];
        Samples {
            re: zeros(true),
            im: zeros(true),
            moment_re: zeros(noisy),
            moment_im: zeros(noisy),
            frequency: zeros(noisy),
        }
    }

    /// The beat of the paper's radar from its values at the nodes; `moment` has the same with every path weighted by its delay.
    pub fn interpolate(&mut self, beat: &Sweep, moment: impl FnOnce() -> Sweep) {
        let Samples { re, im, moment_re, moment_im, frequency } = self;
        interpolate(beat, re, im);
        if frequency.is_empty() {
            return;
        }
        interpolate(&moment(), moment_re, moment_im);
        let moments = moment_re.iter().zip(moment_im.iter()).zip(frequency.iter());
        for ((re, im), ((moment_re, moment_im), frequency)) in re.iter_mut().zip(im).zip(moments) {
            *re += moment_re * frequency;
            *im += moment_im * frequency;
        }
    }

    /// The beat of received times conjugate sent sweep at the samples, path by path, every path a phasor that turns:
    /// `gain exp(j pi S tau^2 - 2 pi j S tau t)`; with the phase tau phi' of the oscillator where there is one.
    pub fn fill(&mut self, tones: impl Iterator<Item = (Complex64, f64)>, radar: &Radar) {
        let Samples { re, im, moment_re, moment_im, frequency } = self;
        [&mut *re, im, moment_re, moment_im].into_iter().for_each(|sums| sums.fill(0.0));
        let first = if radar.dechirp == Dechirp::Digital { 1.0 } else { 0.0 };
        for (gain, delay_s) in tones {
            // turns of a sample
            let step = radar.bandwidth_hz * delay_s / f64::from(radar.samples);
            let start = gain * phasor(PI * radar.sweep_rate() * delay_s * delay_s);
            let lanes: [_; LANES] =
                std::array::from_fn(|k| start * phasor(-2.0 * PI * step * (k as f64 + first)));
            let turn = phasor(-2.0 * PI * step * LANES as f64);
            if frequency.is_empty() {
                turning(lanes, turn, [re, im]);
            } else {
                turning_with_moment(lanes, turn, delay_s, [re, im, moment_re, moment_im]);
            }
        }
        for ((((re, im), moment_re), moment_im), frequency) in
            re.iter_mut().zip(im).zip(moment_re).zip(moment_im).zip(frequency)
        {
            *re -= *frequency * *moment_im;
            *im += *frequency * *moment_re;
        }
    }
}

/// Adds a phasor that goes on by `turn` every [`LANES`] samples.
fn turning(lanes: [Complex64; LANES], turn: Complex64, [re, im]: [&mut Vec<f64>; 2]) {
    let (mut a, mut b) = (lanes.map(|z| z.re), lanes.map(|z| z.im));
    for (re, im) in re.chunks_mut(LANES).zip(im.chunks_mut(LANES)) {
        re.iter_mut().zip(&a).for_each(|(sum, a)| *sum += a);
        im.iter_mut().zip(&b).for_each(|(sum, b)| *sum += b);
        for (a, b) in a.iter_mut().zip(&mut b) {
            (*a, *b) = (*a * turn.re - *b * turn.im, *a * turn.im + *b * turn.re);
        }
    }
}

/// The same, and the phasor times a delay to two further sums.
fn turning_with_moment(
    lanes: [Complex64; LANES],
    turn: Complex64,
    delay_s: f64,
    [re, im, moment_re, moment_im]: [&mut Vec<f64>; 4],
) {
    let (mut a, mut b) = (lanes.map(|z| z.re), lanes.map(|z| z.im));
    let sums = re.chunks_mut(LANES).zip(im.chunks_mut(LANES));
    let moments = moment_re.chunks_mut(LANES).zip(moment_im.chunks_mut(LANES));
    for ((re, im), (moment_re, moment_im)) in sums.zip(moments) {
        re.iter_mut().zip(&a).for_each(|(sum, a)| *sum += a);
        im.iter_mut().zip(&b).for_each(|(sum, b)| *sum += b);
        moment_re.iter_mut().zip(&a).for_each(|(sum, a)| *sum += delay_s * a);
        moment_im.iter_mut().zip(&b).for_each(|(sum, b)| *sum += delay_s * b);
        for (a, b) in a.iter_mut().zip(&mut b) {
            (*a, *b) = (*a * turn.re - *b * turn.im, *a * turn.im + *b * turn.re);
        }
    }
}
