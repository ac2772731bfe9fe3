//! Slow-time spectra in bands, and the spectrum that an AR(1) process is expected to show.
//!
//! A window of n samples is multiplied by a Kaiser taper (beta = 6, side lobes 44 dB down) and transformed. Its power is averaged over
//! bands of Doppler: single bins up to the 16th, then bands of 8 %.

use crate::numerics::bessel::kaiser;
use crate::numerics::filter::CORNER_HZ;
use crate::simulator::channel::Complex64;
use rustfft::{Fft, FftPlannerScalar};
use std::f64::consts::TAU;
use std::sync::Arc;

/// The taper's beta: with less, a person's lines leak over the room's.
const BETA: f64 = 6.0;
/// Bins that are bands of their own.
const SINGLE: usize = 16;
/// Upper end of a band over its lower end, above them.
const WIDTH: f64 = 1.08;

/// What is done to a window before its spectrum is taken; linear, so that spectra of independent parts add up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Conditioning {
    /// Its mean is taken off.
    MeanRemoved,
    /// A real, AC-coupled signal ([`super::conditioning::ac_couple`]) of this rate in Hz.
    AcCoupled(f64),
}

/// Power in every band.
pub type Bands = Vec<f64>;

/// Spectra of windows of one length.
pub struct Spectrum {
    conditioning: Conditioning,
    taper: Vec<f64>,
    /// The band of each bin, in the transform's order; `None` where the conditioning leaves nothing.
    band: Vec<Option<usize>>,
    /// Bins of each band.
    pub bins: Vec<f64>,
    fft: Arc<dyn Fft<f64>>,
    double: Arc<dyn Fft<f64>>,
    fine: Arc<dyn Fft<f64>>,
}

impl Spectrum {
    /// Of windows of `n` samples.
    pub fn new(n: usize, conditioning: Conditioning) -> Self {
        // real signals show every frequency twice
        let (first, both) = match conditioning {
            Conditioning::MeanRemoved => (1, true),
            Conditioning::AcCoupled(rate) => ((0.5 * CORNER_HZ * n as f64 / rate).ceil() as usize, false),
        };
        let mut edges: Vec<usize> = (first.max(1)..=SINGLE.max(first)).collect();
        while let Some(&last) = edges.last().filter(|&&last| last <= n / 2) {
            edges.push(((last as f64 * WIDTH) as usize).max(last + 1));
        }
        let of = |k: usize| edges.windows(2).position(|pair| (pair[0]..pair[1]).contains(&k));
        let count = edges.len() - 1;
        let band: Vec<Option<usize>> =
            (0..n)
                .map(|bin| {
                    if 2 * bin <= n { of(bin) } else { of(n - bin).filter(|_| both).map(|band| band + count) }
                })
                .collect();
        let mut bins = vec![0.0; if both { 2 * count } else { count }];
        band.iter().flatten().for_each(|&band| bins[band] += 1.0);
        let mut planner = FftPlannerScalar::new();
        let fine = (16 * n).next_power_of_two();
        Spectrum {
            conditioning,
            taper: kaiser(n, BETA),
            band,
            bins,
            fft: planner.plan_fft_forward(n),
            double: planner.plan_fft_forward(2 * n),
            fine: planner.plan_fft_forward(fine),
        }
    }

    fn banded(&self, bins: impl Iterator<Item = f64>) -> Bands {
        let mut sums = vec![0.0; self.bins.len()];
        for (power, band) in bins.zip(&self.band) {
            if let Some(band) = band {
                sums[*band] += power;
            }
        }
        sums.iter().zip(&self.bins).map(|(sum, bins)| sum / bins.max(1.0)).collect()
    }

    /// Of a conditioned window.
    pub fn of(&self, window: &[Complex64]) -> Bands {
        let mut x: Vec<Complex64> = window.iter().zip(&self.taper).map(|(z, taper)| z * taper).collect();
        self.fft.process(&mut x);
        self.banded(x.iter().map(|z| z.norm_sqr()))
    }

    /// Expected of an AR(1) process of unit power; with rho = 0 of white noise. A real signal shows the real part's, half of it.
    pub fn ar1(&self, rho: f64) -> Bands {
        let n = self.taper.len();
        let covariance = match self.conditioning {
            Conditioning::MeanRemoved => {
                let power = |k: usize| if k == 0 { 1.0 } else { libm::pow(rho, k as f64) };
                (0..n).map(power).collect()
            }
            Conditioning::AcCoupled(rate) => self.coupled_covariance(rho, libm::exp(-TAU * CORNER_HZ / rate)),
        };
        // E|X(f)|^2 = sum over lags of the covariance times the taper's autocorrelation
        let spectrum = self.transformed(&self.taper);
        let mut taper_correlation: Vec<Complex64> =
            spectrum.iter().map(|z| Complex64::new(z.norm_sqr() / (2 * n) as f64, 0.0)).collect();
        self.double.process(&mut taper_correlation);
        let mut product = vec![Complex64::default(); 2 * n];
        for lag in 0..n {
            product[lag] = taper_correlation[lag] * covariance[lag];
            if lag > 0 {
                product[2 * n - lag] = product[lag];
            }
        }
        self.double.process(&mut product);
        let mut power: Vec<f64> = product.iter().step_by(2).map(|z| z.re).collect();
        if self.conditioning == Conditioning::MeanRemoved {
            self.remove_mean(&covariance, &mut power);
        } else {
            power.iter_mut().for_each(|power| *power *= 0.5);
        }
        self.banded(power.into_iter())
    }

    /// The transform of a real sequence of n samples at 2 n frequencies.
    fn transformed(&self, x: &[f64]) -> Vec<Complex64> {
        let mut z: Vec<Complex64> = x.iter().map(|&x| Complex64::new(x, 0.0)).collect();
        z.resize(2 * self.taper.len(), Complex64::default());
        self.double.process(&mut z);
        z
    }

    /// What the mean m of a window takes off: |X - m W|^2 with E[x_t m*] and E|m|^2 from the covariance.
    fn remove_mean(&self, covariance: &[f64], power: &mut [f64]) {
        let n = self.taper.len();
        let mut sums = vec![0.0; n + 1];
        covariance.iter().enumerate().for_each(|(lag, r)| sums[lag + 1] = sums[lag] + r);
        let with_mean: Vec<f64> =
            (0..n).map(|t| (sums[t + 1] + sums[n - t] - covariance[0]) / n as f64).collect();
        let of_mean = with_mean.iter().sum::<f64>() / n as f64;
        let tapered: Vec<f64> = with_mean.iter().zip(&self.taper).map(|(q, taper)| q * taper).collect();
        let (cross, taper) = (self.transformed(&tapered), self.transformed(&self.taper));
        for ((power, cross), taper) in
            power.iter_mut().zip(cross.iter().step_by(2)).zip(taper.iter().step_by(2))
        {
            *power += of_mean * taper.norm_sqr() - 2.0 * (taper.conj() * cross).re;
        }
    }

    /// Autocovariance of AR(1) behind the two high-pass filters of pole `keep`, from its spectrum on a fine grid.
    fn coupled_covariance(&self, rho: f64, keep: f64) -> Vec<f64> {
        let fine = self.fine.len();
        let mut spectrum: Vec<Complex64> = (0..fine)
            .map(|k| {
                let cosine = libm::cos(TAU * k as f64 / fine as f64);
                let ar = (1.0 - rho * rho) / (1.0 - 2.0 * rho * cosine + rho * rho).max(f64::MIN_POSITIVE);
                let section = keep * keep * 2.0 * (1.0 - cosine) / (1.0 - 2.0 * keep * cosine + keep * keep);
                Complex64::new(ar * section * section / fine as f64, 0.0)
            })
            .collect();
        self.fine.process(&mut spectrum);
        spectrum.iter().take(self.taper.len()).map(|z| z.re).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::conditioning::{ac_couple, remove_mean};
    use super::*;
    use crate::numerics::random::Random;

    /// Mean spectrum of simulated AR(1) processes.
    fn simulated(spectrum: &Spectrum, n: usize, rho: f64, draws: u64) -> Bands {
        let mut sum = vec![0.0; spectrum.bins.len()];
        for index in 0..draws {
            let mut random = Random::new(5, 0, 0, index);
            let mut draw =
                || Complex64::new(random.gaussian(), random.gaussian()) * std::f64::consts::FRAC_1_SQRT_2;
            let mut state = draw();
            let mut x: Vec<Complex64> = (0..300 + n)
                .map(|_| {
                    state = state * rho + draw() * (1.0 - rho * rho).sqrt();
                    state
                })
                .collect();
            if let Conditioning::AcCoupled(rate) = spectrum.conditioning {
                x.iter_mut().for_each(|z| z.im = 0.0);
                ac_couple(&mut x, rate);
            }
            let mut x = x.split_off(300);
            if spectrum.conditioning == Conditioning::MeanRemoved {
                remove_mean(&mut x);
            }
            sum.iter_mut().zip(spectrum.of(&x)).for_each(|(sum, power)| *sum += power / draws as f64);
        }
        sum
    }

    #[test]
    fn the_expected_spectrum_is_that_of_simulated_processes() {
        for conditioning in [Conditioning::MeanRemoved, Conditioning::AcCoupled(2000.0)] {
            let n = 500;
            let spectrum = Spectrum::new(n, conditioning);
            for rho in [0.0, 0.9, 0.99, 0.999] {
                let (expected, found) = (spectrum.ar1(rho), simulated(&spectrum, n, rho, 1500));
                // a band of one bin has an error of 1 / sqrt(1500), 2.6 %
                for (band, (e, f)) in expected.iter().zip(&found).enumerate() {
                    assert!((f / e - 1.0).abs() < 0.13, "{conditioning:?}, {rho}, band {band}: {e} {f}");
                }
                let ratio = found.iter().zip(&expected).map(|(f, e)| f / e).sum::<f64>() / found.len() as f64;
                assert!((ratio - 1.0).abs() < 0.02, "{conditioning:?}, {rho}: {ratio}");
            }
        }
    }

    #[test]
    fn every_bin_but_those_that_conditioning_removes_is_in_one_band() {
        let spectrum = Spectrum::new(1000, Conditioning::MeanRemoved);
        assert_eq!(spectrum.bins.iter().sum::<f64>(), 999.0);
        let spectrum = Spectrum::new(2000, Conditioning::AcCoupled(2000.0));
        assert_eq!(spectrum.bins.iter().sum::<f64>(), 991.0);
        assert!(spectrum.bins.iter().all(|bins| *bins > 0.0));
    }
}
