//! Short-time Fourier transform of the slow-time signal: Kaiser window, zero padding, 256-point FFT.
//!
//! Eq. (z) of the paper, with N_fft in the exponent's denominator.

mod fixed;

use crate::dims::{Complex, FFT_LEN, Spectrum};
use crate::math::{bessel_i0f, sqrtf};
use crate::probe::Probe;
use crate::signal::logarithm::level;
pub(crate) use fixed::{BUTTERFLY_BITS, FULL_SHIFT, HALF_SHIFT, HIGH_PRODUCT_BITS, STAGES};
pub use fixed::{FixedSpectrum, FixedStft};

/// A short-time Fourier transform in one arithmetic, and the logarithm of its powers.
pub trait Stft {
    /// Spectrum of one frame, `[doppler]`.
    type Spectrum;
    /// One in this memory, with what it holds.
    fn spectrum(memory: &mut FixedSpectrum) -> &mut Self::Spectrum;

    /// A Kaiser window of `length` (2 to 256) samples with parameter `beta` (0 to 40), moved by `hop` (1 to `length`) samples.
    ///
    /// Out-of-range arguments are taken to the nearest legal value, a `beta` that is no number to 0. The window's error against exact
    /// arithmetic is below 1e-5 of its peak. Cost: at most `length` Bessel series of 64 terms, once.
    fn new(length: u16, beta: f32, hop: u16) -> Self;
    /// Frames in `slots` slow-time samples: floor((N_s - N_w) / hop) + 1, or 0.
    fn frames(&self, slots: usize) -> usize;
    /// Frame `k` of the slow-time signal into `spectrum`: at least the central 64 `per_row` bins. A frame beyond the
    /// end of the signal is transformed as if the signal went on with zeros.
    fn frame(&self, slow_time: &[Complex<i32>], k: usize, per_row: u8, spectrum: &mut Self::Spectrum);
    /// `floor(64 log2 p)` of the power p of `count` bins from `first` on, modulo 256.
    fn level(spectrum: &Self::Spectrum, first: usize, count: usize) -> i16;
    /// Shows a spectrum to an observer.
    fn probe(spectrum: &Self::Spectrum, k: usize, probe: &mut impl Probe);
}

/// The faster transform of the target: in integers on microcontrollers, in f32 elsewhere.
#[cfg(not(any(target_arch = "arm", target_arch = "riscv32")))]
pub type NativeStft = FloatStft;
/// The faster transform of the target: in integers on microcontrollers, in f32 elsewhere.
#[cfg(any(target_arch = "arm", target_arch = "riscv32"))]
pub type NativeStft = FixedStft;

/// A spectrum of zeros.
pub const ZERO_SPECTRUM: Spectrum = [Complex::new(0.0, 0.0); FFT_LEN];

/// Window and hop of the transform. In f32: microfft's radix 2.
#[derive(Debug, Clone)]
pub struct FloatStft {
    window: [f32; FFT_LEN],
    length: usize,
    hop: usize,
}

impl FloatStft {
    /// The window, `[slow_time]`.
    pub fn window(&self) -> &[f32] {
        self.window.get(..self.length).unwrap_or(&self.window)
    }
}

impl Stft for FloatStft {
    type Spectrum = Spectrum;

    fn spectrum([bins, _]: &mut FixedSpectrum) -> &mut Spectrum {
        bytemuck::must_cast_mut(bins)
    }

    fn new(length: u16, beta: f32, hop: u16) -> Self {
        let mut stft = FloatStft { window: [0.0; FFT_LEN], length: 0, hop: 0 };
        let window = &mut stft.window;
        (stft.length, stft.hop) = kaiser(length, beta, hop, |n, value| window[n % FFT_LEN] = value);
        stft
    }

    fn frames(&self, slots: usize) -> usize {
        frames(slots, self.length, self.hop)
    }

    /// All bins. Error below 2^-20 of the sum of the windowed magnitudes. Cost: one 256-point complex FFT.
    fn frame(&self, slow_time: &[Complex<i32>], k: usize, _per_row: u8, spectrum: &mut Spectrum) {
        let signal = slow_time.get(k.saturating_mul(self.hop)..).unwrap_or(&[]);
        *spectrum = ZERO_SPECTRUM;
        for ((out, y), w) in spectrum.iter_mut().zip(signal).zip(self.window()) {
            *out = Complex::new(y.re as f32 * w, y.im as f32 * w);
        }
        let _: &mut Spectrum = microfft::complex::cfft_256(spectrum); // in place
    }

    /// Powers are summed in ascending order of the bins.
    #[inline(always)]
    fn level(spectrum: &Spectrum, first: usize, count: usize) -> i16 {
        let mut power = 0.0_f32;
        for k in 0..count {
            let z = spectrum[first.wrapping_add(k) % FFT_LEN];
            power += z.re * z.re + z.im * z.im;
        }
        level(power)
    }

    fn probe(spectrum: &Spectrum, k: usize, probe: &mut impl Probe) {
        probe.frame(k, spectrum);
    }
}

/// Gives every value of a Kaiser window; its length and hop.
fn kaiser(length: u16, beta: f32, hop: u16, mut give: impl FnMut(usize, f32)) -> (usize, usize) {
    let length = usize::from(length).clamp(2, FFT_LEN);
    let beta = if beta > 0.0 { if beta < 40.0 { beta } else { 40.0 } } else { 0.0 };
    let centre = (length - 1) as f32 / 2.0;
    let peak = bessel_i0f(beta);
    for n in 0..length {
        let x = (n as f32 - centre) / centre;
        let inside = 1.0 - x * x;
        give(n, bessel_i0f(beta * sqrtf(if inside > 0.0 { inside } else { 0.0 })) / peak);
    }
    (length, usize::from(hop).max(1).min(length))
}

/// floor((slots - window) / hop) + 1, or 0 if no window fits.
pub const fn frames(slots: usize, window: usize, hop: usize) -> usize {
    if slots < window || hop == 0 { 0 } else { (slots - window) / hop + 1 }
}
