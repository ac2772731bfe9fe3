//! The AC coupling behind the mixer of a Doppler sensor: what stands still is no signal to its amplifier.
//!
//! Two sections of first order, one after the other, over slow time: a Doppler sensor has one sample a slot.

use crate::simulator::channel::Complex64;
use std::f64::consts::TAU;

/// The sections and what they hold.
#[derive(Debug, Clone)]
pub struct AcCoupling {
    keep: f64,
    /// Last input and last output of each section; `None` before the first sample, which they have settled to.
    sections: Option<[[Complex64; 2]; 2]>,
}

impl AcCoupling {
    /// With a corner in Hz; `None` for 0.
    pub fn new(corner_hz: f64, interval_s: f64) -> Option<Self> {
        (corner_hz > 0.0)
            .then(|| AcCoupling { keep: libm::exp(-TAU * corner_hz * interval_s), sections: None })
    }

    /// The next sample.
    pub fn pass(&mut self, sample: Complex64) -> Complex64 {
        let zero = Complex64::default();
        let sections = self.sections.get_or_insert([[sample, zero], [zero, zero]]);
        sections.iter_mut().fold(sample, |input, [before, output]| {
            *output = (*output + input - *before) * self.keep;
            *before = input;
            *output
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::filter::high_pass;

    #[test]
    fn samples_one_by_one_pass_as_a_whole_signal_does() {
        let signal: Vec<Complex64> = (0..500)
            .map(|n| Complex64::new(7.0, -3.0) + Complex64::from_polar(1.0, 0.2 * f64::from(n)))
            .collect();
        let mut coupling = AcCoupling::new(20.0, 0.5e-3).unwrap();
        let found: Vec<Complex64> = signal.iter().map(|&z| coupling.pass(z)).collect();
        let mut expected = signal;
        let keep = libm::exp(-TAU * 20.0 * 0.5e-3);
        (0..2).for_each(|_| high_pass(&mut expected, keep));
        assert_eq!(found, expected);
        assert!(AcCoupling::new(0.0, 0.5e-3).is_none());
    }
}
