//! The transform in integers against the sum itself in f64, and at full scale.

use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;
use sdp3_core::dims::{Complex, FFT_LEN};
use sdp3_core::probe::Probe;
use sdp3_core::signal::stft::{FixedSpectrum, FixedStft, Stft};

const ZERO: FixedSpectrum = [[Complex::new(0, 0); FFT_LEN]; 2];

/// The bins of a spectrum.
struct Bins([Complex<i32>; FFT_LEN]);

impl Probe for Bins {
    fn fixed_frame(&mut self, _k: usize, spectrum: &[Complex<i32>; FFT_LEN]) {
        self.0 = *spectrum;
    }
}

/// The largest error of a part of a kept bin against the sum itself in f64, in LSB of the result.
fn error(signal: &[Complex<i32>], length: u16, bins_per_row: u8) -> f64 {
    let stft = FixedStft::new(length, 10.0, 8);
    let mut spectrum = ZERO;
    stft.frame(signal, 0, bins_per_row, &mut spectrum);
    let mut bins = Bins([Complex::new(0, 0); FFT_LEN]);
    FixedStft::probe(&spectrum, 0, &mut bins);
    let scale = if length > 128 { 0.5 } else { 1.0 };
    let kept = 32 * i32::from(bins_per_row);
    let mut worst = 0.0_f64;
    for bin in -kept..kept {
        let (mut re, mut im) = (0.0, 0.0);
        for (n, (y, w)) in signal.iter().zip(stft.window()).enumerate() {
            let angle = -core::f64::consts::TAU * f64::from(bin) * n as f64 / 256.0;
            let (w, (s, c)) = (f64::from(*w) / 2_147_483_648.0 * scale, angle.sin_cos());
            re += w * (f64::from(y.re) * c - f64::from(y.im) * s);
            im += w * (f64::from(y.re) * s + f64::from(y.im) * c);
        }
        let found = bins.0[(bin & 255) as usize];
        worst = worst.max((f64::from(found.re) - re).abs()).max((f64::from(found.im) - im).abs());
    }
    worst
}

#[test]
fn the_error_is_within_its_bound() {
    let mut random = Xoshiro128PlusPlus::seed_from_u64(11);
    let mut worst = 0.0_f64;
    for round in 0..60 {
        let mut part = || match round {
            0 => 1 << 23,
            1 => [-(1 << 23), 1 << 23][random.next_u32() as usize % 2],
            2 => 0,
            _ => random.next_u32() as i32 >> (8 + round % 20),
        };
        let signal: [Complex<i32>; 256] = core::array::from_fn(|_| Complex::new(part(), part()));
        for (length, bins) in [(128, 1), (100, 2), (128, 4), (129, 1), (256, 4), (2, 1)] {
            worst = worst.max(error(&signal, length, bins));
        }
        // a signal that ends within the window goes on with zeros
        worst = worst.max(error(&signal[..50], 128, 1));
    }
    assert!(worst < 40.0, "{worst}");
}

#[test]
fn full_scale_tones_do_not_overflow() {
    for bin in [0, 1, 31, -32, -7] {
        let tone: [Complex<i32>; 256] = core::array::from_fn(|n| {
            let angle = core::f64::consts::TAU * f64::from(bin) * n as f64 / 256.0;
            let part = |x: f64| (x * f64::from(1 << 23) * core::f64::consts::SQRT_2) as i32;
            let (re, im) = (part(angle.cos()), part(angle.sin()));
            Complex::new(re.clamp(-(1 << 23), 1 << 23), im.clamp(-(1 << 23), 1 << 23))
        });
        for beta in [0.0, 10.0] {
            for length in [128, 256] {
                let stft = FixedStft::new(length, beta, 8);
                let mut spectrum = ZERO;
                stft.frame(&tone, 0, 1, &mut spectrum);
                let at = |k: i32| FixedStft::level(&spectrum, (k & 255) as usize, 1);
                let loudest = (-32..32).max_by_key(|&k| at(k));
                assert_eq!(loudest, Some(bin));
            }
        }
    }
}
