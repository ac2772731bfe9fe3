//! What a sensor leaves of a slow-time signal, applied to the measured and to the simulated one alike.
//!
//! CW sensors are AC-coupled and real; pulsed and FMCW radars lose their clutter to the truncated SVD, or, with a single range
//! cell, their mean.

pub use crate::numerics::filter::ac_couple;
use crate::simulator::channel::{BLOCKS, Blocks, Complex64};

/// Least energy of a window with motion, as a share of the median window's.
const MOTION_SHARE: f64 = 0.5;

/// Takes the mean off.
pub fn remove_mean(y: &mut [Complex64]) {
    let mean: Complex64 = y.iter().sum::<Complex64>() / y.len().max(1) as f64;
    y.iter_mut().for_each(|z| *z -= mean);
}

/// y = w^H b with w = (I - u u^H) 1 and u the leading left singular vector of the beat matrix, found by power iteration on its
/// Gram matrix: the core's clutter removal at d = 2, in f64.
pub fn clutter_free(beats: &[Blocks]) -> Vec<Complex64> {
    let mut gram = [[Complex64::default(); BLOCKS]; BLOCKS];
    for beat in beats {
        for (row, a) in gram.iter_mut().zip(beat) {
            row.iter_mut().zip(beat).for_each(|(g, b)| *g += a * b.conj());
        }
    }
    let mut u = [Complex64::new(1.0, 0.0); BLOCKS];
    for _ in 0..100 {
        let mut next = gram.map(|row| row.iter().zip(&u).map(|(g, u)| g * u).sum::<Complex64>());
        let length = next.iter().map(|z| z.norm_sqr()).sum::<f64>().sqrt();
        if length > 0.0 {
            next.iter_mut().for_each(|z| *z /= length);
            u = next;
        }
    }
    let inner: Complex64 = u.iter().map(|u| u.conj()).sum();
    let w = u.map(|u| Complex64::new(1.0, 0.0) - u * inner);
    beats.iter().map(|beat| beat.iter().zip(&w).map(|(b, w)| w.conj() * b).sum()).collect()
}

/// Energy of a window.
fn energy(window: &[Complex64]) -> f64 {
    window.iter().map(|z| z.norm_sqr()).sum()
}

/// Consecutive windows of `length` samples in which somebody moves, by their numbers, the most energetic first: pauses and turns show
/// the room, not the person.
pub fn moving_windows(signal: &[Complex64], length: usize) -> Vec<usize> {
    let energies: Vec<f64> = signal.chunks_exact(length.max(1)).map(energy).collect();
    let mut windows: Vec<usize> = (0..energies.len()).collect();
    windows.sort_by(|&a, &b| energies[b].total_cmp(&energies[a]));
    let median = windows.get(windows.len() / 2).map_or(0.0, |&w| energies[w]);
    windows.retain(|&w| energies[w] > 0.0 && energies[w] >= MOTION_SHARE * median);
    windows
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulator::channel::phasor;
    use std::f64::consts::TAU;

    #[test]
    fn what_stands_still_vanishes_and_a_torso_passes() {
        let gain = |hz: f64| {
            let mut signal: Vec<_> =
                (0..4000).map(|n| Complex64::new(libm::cos(TAU * hz * f64::from(n) / 2000.0), 0.0)).collect();
            ac_couple(&mut signal, 2000.0);
            (2.0 * energy(&signal[2000..]) / 2000.0).sqrt()
        };
        assert!(gain(0.0) < 1e-12);
        // two sections: 6 dB at the corner, 40 dB a decade below, nothing at the torso's 140 Hz
        assert!((gain(20.0) - 0.5).abs() < 0.04 && gain(2.0) < 0.011 && gain(140.0) > 0.9);
    }

    #[test]
    fn a_static_echo_is_removed_and_a_moving_one_stays() {
        let tone = |delay: f64, b: usize| phasor(-delay * b as f64);
        let beats: Vec<Blocks> = (0..400)
            .map(|n| {
                let moving = phasor(0.1 * f64::from(n)) * 0.01;
                std::array::from_fn(|b| tone(0.03, b) + moving * tone(0.4, b))
            })
            .collect();
        let y = clutter_free(&beats);
        let mean: Complex64 = y.iter().sum::<Complex64>() / 400.0;
        assert!(mean.norm() < 0.05 * (energy(&y) / 400.0).sqrt(), "{mean}");
    }

    #[test]
    fn pauses_are_left_out() {
        let mut signal = vec![Complex64::new(1.0, 0.0); 1000];
        signal[300..400].fill(Complex64::new(0.1, 0.0));
        signal[500..600].fill(Complex64::new(2.0, 0.0));
        let windows = moving_windows(&signal, 100);
        assert_eq!(windows.len(), 9);
        assert_eq!(windows[0], 5);
        assert!(!windows.contains(&3));
    }
}
