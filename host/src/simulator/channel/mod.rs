//! The data-assisted hybrid channel: target echoes of geometry plus a room that remembers.
//!
//! h = u + v, eqs. (DAHC), (uit) and (vit) of the paper. A slot's baseband is smooth over the sweep: it is held as its
//! values on [`NODES`] Chebyshev nodes in the beat domain ([`tone`]) and interpolated by `radar`.

pub mod autoregressive;
pub mod link;
pub mod room;
pub mod target;
pub mod tgn;

use crate::scenario::SPEED_OF_LIGHT;
use rustfft::num_complex::Complex;
use std::f64::consts::PI;

/// Complex amplitude.
pub type Complex64 = Complex<f64>;

/// Chebyshev nodes of a sweep. A delay of 110 ns turns the beat by 7 rad: sixteen nodes hold it to -180 dB.
pub const NODES: usize = 16;

/// A slot's beat at the nodes.
pub type Sweep = [Complex64; NODES];

/// Sweep rate B / T_sw in Hz/s.
pub const SWEEP_RATE: f64 = 10e6 / 100e-6;
/// Sweep duration in s.
pub const SWEEP_S: f64 = 100e-6;

/// Time of a node in s.
pub fn node_time(k: usize) -> f64 {
    SWEEP_S * 0.5 * (1.0 - libm::cos(PI * (k as f64 + 0.5) / NODES as f64))
}

/// One path's beat: `amplitude` times s(t - tau) / s(t) at the nodes, the carrier's phase left to the amplitude.
pub fn tone(amplitude: Complex64, delay_s: f64) -> Sweep {
    let start = phasor(PI * SWEEP_RATE * delay_s * delay_s) * amplitude;
    std::array::from_fn(|k| start * phasor(-2.0 * PI * SWEEP_RATE * delay_s * node_time(k)))
}

/// exp(j angle).
pub fn phasor(angle: f64) -> Complex64 {
    Complex64::new(libm::cos(angle), libm::sin(angle))
}

/// Wavelength in m.
pub fn wavelength(carrier_hz: f64) -> f64 {
    SPEED_OF_LIGHT / carrier_hz
}

/// a += b.
pub fn accumulate(a: &mut Sweep, b: &Sweep) {
    a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
}
