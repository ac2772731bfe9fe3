//! The transform in integers, for microcontrollers: the same bits everywhere, by construction.
//!
//! X[k] = sum over r of W^(rk) F_r[k mod 64], W = exp(-2 pi j / 256): four transforms of 64 samples, every fourth one
//! each, by radix 4, of which a window of up to 128 samples leaves half of the inputs zero; and only the bins that
//! become rows are put together. Products with Q1.31 are cut to their upper word, which halves: three times on every
//! path, made good by the eight-fold input (four-fold for a window beyond 128).

mod twiddles;

use super::{Stft, kaiser};
use crate::dims::{Complex, FFT_LEN, FixedBins, ROWS};
use crate::probe::Probe;
use crate::signal::logarithm::{FLOOR, level_u64};
use crate::simd::mulh::{mla_h, mulh};
use twiddles::{RADIX4_TWIDDLES, TWIDDLES_16, TWIDDLES_64, to_q31};

/// Parts of the transform.
const PARTS: usize = 4;
/// Length of a part.
const PART: usize = FFT_LEN / PARTS;

/// Stages of radix 4 in a part.
pub const STAGES: u32 = PART.ilog2() / 2;
/// Bits by which a butterfly of radix 4 grows.
pub const BUTTERFLY_BITS: u32 = 2;
/// Bits that the upper word of a product with Q1.31 loses.
pub const HIGH_PRODUCT_BITS: u32 = 1;
/// Bits by which samples are taken larger where half of the transform's inputs are zero.
pub const HALF_SHIFT: u32 = 3;
/// The same where none is.
pub const FULL_SHIFT: u32 = 2;

/// Where bin k of a part lies after three stages of radix 4: its digits of two bits in reverse.
static DIGIT_REVERSAL: [u8; PART] = places();

const fn places() -> [u8; PART] {
    let mut table = [0; PART];
    let mut k = 0;
    while k < PART {
        table[k] = (k >> 4 | k & 0x0c | (k & 3) << 4) as u8;
        k += 1;
    }
    table
}

/// A spectrum, and the parts it is made of.
pub type FixedSpectrum = [FixedBins; 2];

/// [`FloatStft`](super::FloatStft) in integers.
///
/// Error against exact arithmetic: below 40 LSB a part, of up to 2^30, for a slow-time signal of at most 23 bits, which
/// also keeps every sum within 31 bits.
#[derive(Debug, Clone)]
pub struct FixedStft {
    window: [i32; FFT_LEN],
    length: usize,
    hop: usize,
}

type Part = [Complex<i32>; PART];

/// Half the product of a number and a twiddle.
#[inline(always)]
fn twiddle_mul(a: Complex<i32>, w: Complex<i32>) -> Complex<i32> {
    let re = mulh(a.re, w.re).wrapping_sub(mulh(a.im, w.im));
    Complex::new(re, mla_h(mulh(a.re, w.im), a.im, w.re))
}

#[inline(always)]
fn half(a: Complex<i32>) -> Complex<i32> {
    Complex::new(a.re >> 1, a.im >> 1)
}

#[inline(always)]
fn add(a: Complex<i32>, b: Complex<i32>) -> Complex<i32> {
    Complex::new(a.re.wrapping_add(b.re), a.im.wrapping_add(b.im))
}

#[inline(always)]
fn sub(a: Complex<i32>, b: Complex<i32>) -> Complex<i32> {
    Complex::new(a.re.wrapping_sub(b.re), a.im.wrapping_sub(b.im))
}

/// a - j b and a + j b.
#[inline(always)]
fn rotate_j(a: Complex<i32>, b: Complex<i32>) -> (Complex<i32>, Complex<i32>) {
    let (ar, ai) = (a.re, a.im);
    (
        Complex::new(ar.wrapping_add(b.im), ai.wrapping_sub(b.re)),
        Complex::new(ar.wrapping_sub(b.im), ai.wrapping_add(b.re)),
    )
}

/// Four sums of radix 4.
#[inline(always)]
fn butterfly([a, b, c, d]: [Complex<i32>; 4]) -> [Complex<i32>; 4] {
    let (s, t) = (add(a, c), add(b, d));
    let (u, v) = rotate_j(sub(a, c), sub(b, d));
    [add(s, t), u, sub(s, t), v]
}

/// A windowed sample, times 2^`SHIFT`.
#[inline(always)]
fn sample<const SHIFT: u32>(y: Complex<i32>, w: i32) -> Complex<i32> {
    Complex::new(mulh(y.re << (SHIFT + 1), w), mulh(y.im << (SHIFT + 1), w))
}

/// Sums of a stage, rotate_j and stored `SPAN` apart.
#[inline(always)]
fn store<const SPAN: usize, const N: usize>(
    part: &mut [Complex<i32>; N],
    n: usize,
    sums: [Complex<i32>; 4],
    twiddles: &[Complex<i32>; 3],
) {
    part[n % N] = half(sums[0]);
    for k in [2, 1, 3] {
        part[(n + SPAN * k) % N] = twiddle_mul(sums[k], twiddles[k - 1]);
    }
}

/// The first stage of part `r` for a window of which the second half of the transform sees nothing.
#[inline(never)]
fn stage1_half(signal: &[Complex<i32>; 128], window: &[i32; FFT_LEN], r: usize, part: &mut Part) {
    let (signal, _) = signal.as_chunks::<PARTS>();
    let (window, _) = window.as_chunks::<PARTS>();
    let r = r % PARTS;
    for (n, twiddles) in TWIDDLES_64.iter().enumerate() {
        let a = sample::<HALF_SHIFT>(signal[n][r], window[n][r]);
        let b = sample::<HALF_SHIFT>(signal[n + 16][r], window[n + 16][r]);
        let (u, v) = rotate_j(a, b);
        store::<16, PART>(part, n, [add(a, b), u, sub(a, b), v], twiddles);
    }
}

/// The first stage of part `r`.
#[inline(never)]
fn stage1_full(signal: &[Complex<i32>; FFT_LEN], window: &[i32; FFT_LEN], r: usize, part: &mut Part) {
    let (signal, _) = signal.as_chunks::<PARTS>();
    let (window, _) = window.as_chunks::<PARTS>();
    let r = r % PARTS;
    for (n, twiddles) in TWIDDLES_64.iter().enumerate() {
        let at = |k: usize| sample::<FULL_SHIFT>(signal[n + 16 * k][r], window[n + 16 * k][r]);
        store::<16, PART>(part, n, butterfly([at(0), at(1), at(2), at(3)]), twiddles);
    }
}

/// The second stage of a part.
#[inline(never)]
fn second(part: &mut Part) {
    let (blocks, _) = part.as_chunks_mut::<16>();
    for block in blocks {
        for (n, twiddles) in TWIDDLES_16.iter().enumerate() {
            let sums = butterfly([block[n], block[n + 4], block[n + 8], block[n + 12]]);
            store::<4, 16>(block, n, sums, twiddles);
        }
    }
}

/// The third stage of a part.
#[inline(never)]
fn third(part: &mut Part) {
    let (blocks, _) = part.as_chunks_mut::<4>();
    for block in blocks {
        *block = butterfly(*block);
    }
}

/// The central `kept` bins of the whole.
#[inline(never)]
fn combine(parts: &[Part; PARTS], kept: usize, bins: &mut FixedBins) {
    for bin in (0..kept).map(|row| row.wrapping_sub(kept / 2) % FFT_LEN) {
        let place = usize::from(DIGIT_REVERSAL[bin % PART]) % PART;
        let Complex { mut re, mut im } = half(parts[0][place]);
        for (part, w) in parts.iter().skip(1).zip(&RADIX4_TWIDDLES[bin]) {
            let z = part[place];
            re = mla_h(mla_h(re, z.re, w.re), z.im.wrapping_neg(), w.im);
            im = mla_h(mla_h(im, z.re, w.im), z.im, w.re);
        }
        bins[bin] = Complex::new(re, im);
    }
}

impl FixedStft {
    /// The window in Q1.31, `[slow_time]`, zeros behind its length.
    pub fn window(&self) -> &[i32; FFT_LEN] {
        &self.window
    }

    /// The first stage of all parts, for a signal of at least half the transform's length.
    fn first(&self, signal: &[Complex<i32>], parts: &mut [Part; PARTS]) -> Option<()> {
        for (r, part) in parts.iter_mut().enumerate() {
            if self.length <= FFT_LEN / 2 {
                stage1_half(signal.first_chunk()?, &self.window, r, part);
            } else {
                stage1_full(signal.first_chunk()?, &self.window, r, part);
            }
        }
        Some(())
    }

    /// [`Self::first`] where the signal ends before: it lies in `bins` for that time, with zeros behind its end.
    #[inline(never)]
    fn stage1_padded(&self, signal: &[Complex<i32>], bins: &mut FixedBins, parts: &mut [Part; PARTS]) {
        bins.fill(Complex::new(0, 0));
        bins.iter_mut().zip(signal.iter().take(self.length)).for_each(|(to, from)| *to = *from);
        let _ = self.first(bins, parts); // long enough
        bins.fill(Complex::new(0, 0));
    }
}

impl Stft for FixedStft {
    type Spectrum = FixedSpectrum;

    fn spectrum(memory: &mut FixedSpectrum) -> &mut FixedSpectrum {
        memory
    }

    fn new(length: u16, beta: f32, hop: u16) -> Self {
        let mut stft = FixedStft { window: [0; FFT_LEN], length: 0, hop: 0 };
        let window = &mut stft.window;
        (stft.length, stft.hop) = kaiser(length, beta, hop, |n, w| window[n % FFT_LEN] = to_q31(w.into()));
        stft
    }

    fn frames(&self, slots: usize) -> usize {
        super::frames(slots, self.length, self.hop)
    }

    /// Cost: 48 butterflies of radix 4 with 3 products each, 3 more products a bin.
    fn frame(&self, slow_time: &[Complex<i32>], k: usize, per_row: u8, spectrum: &mut FixedSpectrum) {
        let [bins, parts] = spectrum;
        let parts = bytemuck::must_cast_mut(parts);
        let signal = slow_time.get(k.saturating_mul(self.hop)..).unwrap_or(&[]);
        if self.first(signal, parts).is_none() {
            self.stage1_padded(signal, bins, parts);
        }
        for part in parts.iter_mut() {
            second(part);
            third(part);
        }
        combine(parts, (ROWS * usize::from(per_row)).min(FFT_LEN), bins);
    }

    fn level([bins, _]: &FixedSpectrum, first: usize, count: usize) -> i16 {
        let mut power = 0_u64;
        for k in 0..count {
            let z = bins[first.wrapping_add(k) % FFT_LEN];
            let (re, im) = (i64::from(z.re), i64::from(z.im));
            // a magnitude is below 2^30.5
            power = power.wrapping_add((re * re + im * im) as u64);
        }
        if power == 0 { FLOOR } else { level_u64(power) }
    }

    fn probe([bins, _]: &FixedSpectrum, k: usize, probe: &mut impl Probe) {
        probe.fixed_frame(k, bins);
    }
}
