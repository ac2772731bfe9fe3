//! The downlink to a communication receiver: expected power gain of every sub-carrier.
//!
//! Eq. (H_sub) averaged over draws: line of sight plus the room (TGn B with K = 0 dB, or the image method's clusters).
//! Antennas are isotropic; the same draws serve every position, so nearer is better.

use super::room::{delay_s, draw_loss_db, draw_rays, reflections};
use super::tgn::{TAP_S, TAPS, tap_powers};
use super::{Complex64, phasor, wavelength};
use crate::scenario::{Clusters, Scenario};
use crate::simulator::body::{Vec3, norm, sub};
use crate::simulator::random::Random;
use std::f64::consts::{FRAC_1_SQRT_2, PI};

/// Stream number of the links' random draws.
const STREAM: u64 = 101;

/// `E |H_m|^2` of the `communication.subcarriers` sub-carriers over 10 MHz, averaged over `communication.draws`.
pub fn subcarrier_gains(scenario: &Scenario, receiver: Vec3, seed: u64) -> Vec<f64> {
    let m = scenario.communication.subcarriers as usize;
    let draws = scenario.communication.draws;
    let mut gains = vec![0.0; m];
    for draw in 0..draws {
        let mut random = Random::new(seed, STREAM, 0, u64::from(draw));
        let paths = paths(scenario, receiver, &mut random);
        for (k, gain) in gains.iter_mut().enumerate() {
            let frequency = 10e6 * k as f64 / m as f64;
            let h: Complex64 = paths.iter().map(|&(a, tau)| a * phasor(-2.0 * PI * frequency * tau)).sum();
            *gain += h.norm_sqr() / f64::from(draws);
        }
    }
    gains
}

fn paths(scenario: &Scenario, receiver: Vec3, random: &mut Random) -> Vec<(Complex64, f64)> {
    let lambda = wavelength(scenario.radar.carrier_hz);
    let station = scenario.radar.position_m;
    let distance = norm(sub(receiver, station));
    let free_space = lambda / (4.0 * PI * distance);
    match scenario.channel.clusters {
        Clusters::Ieee80211ax => {
            // within the break point of 5 m: half the power arrives directly on the first tap
            let powers = tap_powers();
            let mut paths: Vec<_> = (0..TAPS)
                .map(|tap| {
                    let draw = Complex64::new(random.gaussian(), random.gaussian()) * FRAC_1_SQRT_2;
                    (draw * free_space * (powers[tap] / 2.0).sqrt(), tap as f64 * TAP_S)
                })
                .collect();
            paths.push((Complex64::new(free_space * FRAC_1_SQRT_2, 0.0), 0.0));
            paths
        }
        Clusters::Ieee80211ay => {
            let mut paths = vec![(Complex64::new(free_space, 0.0), 0.0)];
            let direct = distance / crate::scenario::SPEED_OF_LIGHT;
            for reflection in reflections(scenario.room.size_m, station, receiver) {
                let loss = libm::pow(10.0, draw_loss_db(reflection.order, random) / 20.0);
                let amplitude = loss * lambda / (4.0 * PI * reflection.length_m);
                for ray in draw_rays(random) {
                    let phase = phasor(2.0 * PI * random.uniform());
                    let delay = delay_s(&reflection) - direct + ray.delay_s;
                    paths.push((phase * amplitude * ray.amplitude, delay));
                }
            }
            paths
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
    fn the_mean_gain_is_free_space_for_the_indoor_model() {
        let scenario = Scenario::default();
        let gains = subcarrier_gains(&scenario, [1.5, 3.0, 1.0], 1);
        let free = wavelength(3.5e9) / (4.0 * PI * 2.0);
        let mean = gains.iter().sum::<f64>() / gains.len() as f64;
        assert!((mean / (free * free) - 1.0).abs() < 0.15, "{}", mean / (free * free));
    }
}
