//! Recursive filters of slow-time signals.

use rustfft::num_complex::Complex64;
use std::ops::{Add, Mul, Sub};

/// Corner of the AC coupling in Hz: 0.12 m/s at 24 GHz, far below a walker's torso. CW sensors block what does not move; their
/// own corners are rarely published.
pub const CORNER_HZ: f64 = 20.0;

/// Two single-pole high-pass filters, one after the other, at rest before the first sample.
pub fn ac_couple(y: &mut [Complex64], rate_hz: f64) {
    for _ in 0..2 {
        high_pass(y, pole(CORNER_HZ, rate_hz));
    }
}

/// Pole of a section with a corner at `corner_hz`, at this rate in Hz.
pub fn pole(corner_hz: f64, rate_hz: f64) -> f64 {
    libm::exp(-std::f64::consts::TAU * corner_hz / rate_hz)
}

/// A single-pole high-pass of pole `keep`, in place, at rest before the first sample.
pub fn high_pass<T: Linear>(samples: &mut [T], keep: f64) {
    let mut filter = HighPass::new(keep);
    samples.iter_mut().for_each(|sample| *sample = filter.pass(*sample));
}

/// Numbers that can be filtered.
pub trait Linear: Copy + Default + Add<Output = Self> + Sub<Output = Self> + Mul<f64, Output = Self> {}

impl<T> Linear for T where T: Copy + Default + Add<Output = T> + Sub<Output = T> + Mul<f64, Output = T> {}

/// A single-pole high-pass, sample by sample.
#[derive(Debug, Clone)]
pub struct HighPass<T> {
    keep: f64,
    /// Last input; none before the first sample, which it has settled to.
    before: Option<T>,
    output: T,
}

impl<T: Linear> HighPass<T> {
    /// Of this pole.
    pub fn new(keep: f64) -> Self {
        HighPass { keep, before: None, output: T::default() }
    }

    /// The next sample.
    pub fn pass(&mut self, input: T) -> T {
        let before = self.before.replace(input).unwrap_or(input);
        self.output = (self.output + input - before) * self.keep;
        self.output
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_vanishes_and_a_step_decays_by_the_pole() {
        let mut samples = [3.0, 3.0, 4.0, 4.0, 4.0];
        high_pass(&mut samples, 0.5);
        assert_eq!(samples, [0.0, 0.0, 0.5, 0.25, 0.125]);
        // 3 dB at the corner
        let mut tone: Vec<f64> =
            (0..4000).map(|n| libm::cos(0.002 * std::f64::consts::TAU * f64::from(n))).collect();
        high_pass(&mut tone, pole(2.0, 1000.0));
        let power = tone[1000..].iter().map(|y| y * y).sum::<f64>() / 1500.0;
        assert!((power - 0.5).abs() < 0.05, "{power}");
    }
}
