//! Change of sampling rate by a windowed sinc, low-pass at the lower of the two Nyquist frequencies.
//!
//! Kaiser window with beta 9 over 32 zero crossings a side: stop band below -90 dB.

use crate::numerics::bessel::bessel_i0;

/// Zero crossings of the sinc on each side.
const CROSSINGS: f64 = 32.0;
/// Table entries per zero crossing; linear interpolation between them errs by less than -115 dB.
const STEPS: f64 = 1024.0;

/// `signal` at `from_hz` to `to_hz`.
pub fn resample(signal: &[f64], from_hz: f64, to_hz: f64) -> Vec<f64> {
    let cutoff = (to_hz / from_hz).min(1.0);
    let half = CROSSINGS / cutoff;
    let count = (signal.len() as f64 * to_hz / from_hz).floor() as usize;
    let entries = (CROSSINGS * STEPS) as usize + 2;
    let table: Vec<f64> = (0..entries).map(|k| kernel(k as f64 / STEPS) * cutoff).collect();
    let weight = |x: f64| {
        let place = x.abs() * cutoff * STEPS;
        let entry = (place as usize).min(entries - 2);
        table[entry] + (table[entry + 1] - table[entry]) * (place - entry as f64)
    };
    (0..count)
        .map(|n| {
            let centre = n as f64 * from_hz / to_hz;
            let first = (centre - half).ceil().max(0.0) as usize;
            let end = (centre + half).floor() as usize + 1;
            let near = signal[..end.min(signal.len())].iter().enumerate().skip(first);
            near.map(|(k, x)| x * weight(k as f64 - centre)).sum()
        })
        .collect()
}

/// Windowed sinc at `x` zero crossings from its centre.
fn kernel(x: f64) -> f64 {
    let turn = std::f64::consts::PI * x;
    let sinc = if x.abs() < 1e-9 { 1.0 } else { libm::sin(turn) / turn };
    let inside = 1.0 - (x / CROSSINGS) * (x / CROSSINGS);
    sinc * bessel_i0(9.0 * inside.max(0.0).sqrt()) / bessel_i0(9.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tones_below_the_border_pass_and_above_it_vanish() {
        let tone = |hz: f64| -> Vec<f64> {
            (0..8820).map(|n| libm::sin(std::f64::consts::TAU * hz * f64::from(n) / 44100.0)).collect()
        };
        let low = resample(&tone(300.0), 44100.0, 2000.0);
        for (n, x) in low.iter().enumerate().skip(50).take(250) {
            let exact = libm::sin(std::f64::consts::TAU * 300.0 * n as f64 / 2000.0);
            assert!((x - exact).abs() < 1e-4, "{n}: {x} {exact}");
        }
        let high = resample(&tone(1300.0), 44100.0, 2000.0);
        assert!(high.iter().skip(50).take(250).all(|x| x.abs() < 1e-4));
    }
}
