//! The downlink to a communication receiver: expected power gain of every sub-carrier.
//!
//! Eq. (H_sub) averaged over draws of the scenario's channel model between base station and receiver. Antennas are isotropic; the
//! same draws serve every position, so nearer is better.

use super::{Path, Scene, model, phasor};
use crate::scenario::Scenario;
use crate::simulator::body::Vec3;
use crate::simulator::random::Random;
use std::f64::consts::PI;

/// Stream number of the links' random draws.
const STREAM: u64 = 101;

/// `E |H_m|^2` of the `communication.subcarriers` sub-carriers over 10 MHz, averaged over `communication.draws`.
pub fn subcarrier_gains(scenario: &Scenario, receiver: Vec3, seed: u64) -> Vec<f64> {
    let m = scenario.communication.subcarriers as usize;
    let draws = scenario.communication.draws;
    let station = scenario.radar.position_m;
    let mut gains = vec![0.0; m];
    let mut paths = Vec::new();
    for draw in 0..draws {
        let random = Random::new(seed, STREAM, 0, u64::from(draw));
        let mut channel = model(scenario, station, receiver, 1.0, random);
        let scene = Scene { slot: 0, time_s: 0.0, from: station, to: receiver, people: &[] };
        paths.clear();
        channel.paths(&scene, &mut paths);
        add_response(&paths, scenario.radar.bandwidth_hz / m as f64, 1.0 / f64::from(draws), &mut gains);
    }
    gains
}

/// Adds `weight` |H|^2 at the multiples of `spacing_hz`.
fn add_response(paths: &[Path], spacing_hz: f64, weight: f64, gains: &mut [f64]) {
    let mut tones: Vec<_> =
        paths.iter().map(|p| (p.gain, phasor(-2.0 * PI * spacing_hz * p.delay_s))).collect();
    for gain in gains {
        let h: super::Complex64 = tones.iter().map(|(value, _)| value).sum();
        *gain += weight * h.norm_sqr();
        tones.iter_mut().for_each(|(value, step)| *value *= *step);
    }
}

#[cfg(test)]
mod tests {
    use super::super::room::free_space;
    use super::super::wavelength;
    use super::*;
    use crate::scenario::{Clusters, Model};

    #[test]
    fn nearer_receivers_have_better_gains() {
        for clusters in [Clusters::Ieee80211ax, Clusters::Ieee80211ay] {
            let mut scenario = Scenario::default();
            scenario.channel.clusters = clusters;
            let mean = |p: Vec3| subcarrier_gains(&scenario, p, 1).iter().sum::<f64>();
            assert!(mean([1.5, 2.8, 1.0]) > mean([1.5, 3.0, 1.0]));
            assert!(mean([2.3, 1.0, 1.0]) > mean([2.5, 1.0, 1.0]));
        }
    }

    #[test]
    fn every_model_links_a_receiver_near_free_space() {
        let mut scenario = Scenario::default();
        let free = free_space(2.0, wavelength(3.5e9));
        for model in Model::ALL {
            scenario.channel.model = model;
            let gains = subcarrier_gains(&scenario, [1.5, 3.0, 1.0], 1);
            let mean = gains.iter().sum::<f64>() / gains.len() as f64;
            let db = 10.0 * libm::log10(mean / (free * free));
            assert!(db.abs() < 6.0, "{model:?}: {db} dB");
            assert!(gains.iter().all(|g| g.is_finite() && *g > 0.0));
        }
    }
}
