//! Raw samples of seeded noise and of point echoes, exact in f64 and the same on every processor.
//!
//! Samples are interleaved I, Q or real, in LSB, rounded to nearest and clipped to 16 bits. The target stands still within a
//! sweep and moves between sweeps.

use core::f64::consts::TAU;
use rand_core::Rng;

/// Fills a slot with noise of about +-4096 LSB: two samples of every draw, the lower half first.
pub fn noise(rng: &mut impl Rng, samples: &mut [i16]) {
    for pair in samples.chunks_mut(2) {
        let word = rng.next_u32();
        pair.iter_mut().zip([word as i16, (word >> 16) as i16]).for_each(|(x, draw)| *x = draw >> 3);
    }
}

/// The echo of a point target.
#[derive(Debug, Clone, Copy, Default)]
pub struct Echo {
    /// Amplitude in LSB.
    pub amplitude: f64,
    /// Delay in range cells: tau B.
    pub delay: f64,
    /// Doppler frequency in cycles a slot; positive: the target approaches.
    pub doppler: f64,
    /// Change of the delay in range cells a slot; negative: the target approaches.
    pub delay_step: f64,
}

impl Echo {
    /// Delay in range cells, and phase of the carrier in cycles.
    fn at(&self, slot: u32) -> (f64, f64) {
        (self.delay + self.delay_step * f64::from(slot), self.doppler * f64::from(slot))
    }
}

/// The received chirp of slot number `slot`, as many complex samples as `samples` holds pairs.
///
/// s(t - tau) of s(t) = exp(j pi B t^2 / T) at t = n / f_s, n = 1 to L, with f_s = B and L = B T: exp(j pi (n - tau B)^2 / L).
pub fn chirp_echo(echoes: &[Echo], slot: u32, samples: &mut [i16]) {
    let (pairs, _) = samples.as_chunks_mut::<2>();
    let sweep = pairs.len() as f64;
    for (n, pair) in (1_u32..).zip(pairs) {
        *pair = sum(echoes, |echo| {
            let (delay, carrier) = echo.at(slot);
            let since = f64::from(n) - delay;
            carrier + since * since / (2.0 * sweep)
        });
    }
}

/// The beat of slot number `slot` of a sensor that dechirps in analogue, as many complex samples as `samples` holds pairs.
///
/// The mixer multiplies the sent chirp by the conjugate of the received one: exp(j 2 pi (f_c tau + (B / T) tau t)) at t = n / f_s,
/// n = 1 to L, with L = f_s T. The range FFT has the echo at bin tau B, and its phase falls while the target approaches.
pub fn beat_echo(echoes: &[Echo], slot: u32, samples: &mut [i16]) {
    let (pairs, _) = samples.as_chunks_mut::<2>();
    let sweep = pairs.len() as f64;
    (1_u32..).zip(pairs).for_each(|(n, pair)| *pair = beat(echoes, slot, f64::from(n) / sweep));
}

/// As [`beat_echo`] from a sensor with real samples: the in-phase part.
pub fn beat_echo_real(echoes: &[Echo], slot: u32, samples: &mut [i16]) {
    let sweep = samples.len() as f64;
    (1_u32..).zip(samples).for_each(|(n, x)| [*x, _] = beat(echoes, slot, f64::from(n) / sweep));
}

/// The beat at a fraction of the sweep.
fn beat(echoes: &[Echo], slot: u32, time: f64) -> [i16; 2] {
    sum(echoes, |echo| {
        let (delay, carrier) = echo.at(slot);
        delay * time - carrier
    })
}

/// In-phase and quadrature sample of echoes with phases `cycles` in cycles.
fn sum(echoes: &[Echo], cycles: impl Fn(&Echo) -> f64) -> [i16; 2] {
    let (mut i, mut q) = (0.0, 0.0);
    for echo in echoes {
        let cycles = cycles(echo);
        let (sine, cosine) = libm::sincos(TAU * (cycles - libm::floor(cycles)));
        i += echo.amplitude * cosine;
        q += echo.amplitude * sine;
    }
    // the conversion saturates
    [libm::round(i) as i16, libm::round(q) as i16]
}
