//! Recursive filters of slow-time signals.

use rustfft::num_complex::Complex64;
use std::ops::{Add, Mul, Sub};

/// Corner of the AC coupling in Hz: 0.12 m/s at 24 GHz, far below a walker's torso. CW sensors block what does not move; their
/// own corners are rarely published.
pub const CORNER_HZ: f64 = 20.0;

/// Two single-pole high-pass filters, one after the other, at rest before the first sample.
pub fn ac_couple(y: &mut [Complex64], rate_hz: f64) {
    let keep = libm::exp(-std::f64::consts::TAU * CORNER_HZ / rate_hz);
    for _ in 0..2 {
        high_pass(y, keep);
    }
}

/// A single-pole high-pass of pole `keep`, in place, at rest before the first sample.
pub fn high_pass<T>(samples: &mut [T], keep: f64)
where
    T: Copy + Default + Add<Output = T> + Sub<Output = T> + Mul<f64, Output = T>,
{
    let Some(&first) = samples.first() else { return };
    let (mut before, mut state) = (first, T::default());
    for sample in samples {
        state = (state + *sample - before) * keep;
        before = *sample;
        *sample = state;
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
    }
}
