//! `statistical`: Saleh and Valenzuela's clusters of rays.
//!
//! Saleh, Valenzuela (1987): Poisson clusters and rays with doubly exponential decay, Rayleigh amplitudes, uniform phases. Such a
//! model knows distributions and no places: wherever an antenna or a person has moved it answers with a fresh draw; only the
//! large-scale power lives on. Decays are those of a room of a few metres instead of the paper's office wing.

use super::room::{free_space, mean_power};
use super::{ChannelModel, Complex64, Path, Scene, wavelength};
use crate::numerics::random::Random;
use crate::scenario::{SPEED_OF_LIGHT, Scenario};
use crate::simulator::body::Vec3;
use std::f64::consts::{FRAC_1_SQRT_2, PI};

/// Mean time between clusters and between rays, decay of clusters and of rays, in s.
const CLUSTER_GAP: f64 = 30e-9;
const RAY_GAP: f64 = 5e-9;
const CLUSTER_DECAY: f64 = 15e-9;
const RAY_DECAY: f64 = 7e-9;
/// Draws end this far behind the first ray, in s: -40 dB.
const LAST: f64 = 140e-9;

#[derive(Debug, Clone)]
pub struct SalehValenzuela {
    lambda: f64,
    room_power: f64,
    shadowing: f64,
    seed: u64,
}

impl SalehValenzuela {
    /// Draws the shadowing (3 dB) of the recording.
    pub fn new(scenario: &Scenario, _: (Vec3, Vec3), random: &mut Random) -> Self {
        SalehValenzuela {
            lambda: wavelength(scenario.radar.carrier_hz),
            room_power: mean_power(scenario),
            shadowing: libm::pow(10.0, 3.0 * random.gaussian() / 20.0),
            seed: random.bits(),
        }
    }
}

/// A number that differs wherever a place differs by a tenth of a millimetre.
fn place(points: impl Iterator<Item = Vec3>) -> u64 {
    let cells = points.flatten().map(|x| (x * 1e4).round() as i64 as u64);
    cells.fold(0xcbf2_9ce4_8422_2325, |hash, cell| {
        (hash ^ cell).wrapping_mul(0x0100_0000_01b3).rotate_left(23)
    })
}

fn complex_gaussian(random: &mut Random) -> Complex64 {
    Complex64::new(random.gaussian(), random.gaussian()) * FRAC_1_SQRT_2
}

impl ChannelModel for SalehValenzuela {
    fn paths(&mut self, scene: &Scene, paths: &mut Vec<Path>) {
        let people = scene.people.iter().map(|person| person.centre(scene.time_s));
        let mut random =
            Random::new(self.seed, 1, 0, place([scene.from, scene.to].into_iter().chain(people)));
        let (power, first) = if scene.monostatic() {
            (self.room_power, 2.0 / SPEED_OF_LIGHT)
        } else {
            let free = free_space(scene.distance_m().max(0.1), self.lambda);
            (free * free, scene.distance_m() / SPEED_OF_LIGHT)
        };
        let begin = paths.len();
        let mut cluster = 0.0;
        while cluster < LAST {
            let azimuth = 2.0 * PI * random.uniform();
            let arrival = [libm::cos(azimuth), libm::sin(azimuth), 0.0];
            let mut ray = 0.0;
            while cluster + ray < LAST {
                let mean = libm::exp(-cluster / CLUSTER_DECAY - ray / RAY_DECAY);
                let gain = complex_gaussian(&mut random) * mean.sqrt();
                paths.push(Path { gain, delay_s: first + cluster + ray, departure: arrival, arrival });
                ray -= RAY_GAP * libm::log(1.0 - random.uniform());
            }
            cluster -= CLUSTER_GAP * libm::log(1.0 - random.uniform());
        }
        let energy: f64 = paths[begin..].iter().map(|p| p.gain.norm_sqr()).sum();
        let scale = self.shadowing * (power / energy.max(f64::MIN_POSITIVE)).sqrt();
        paths[begin..].iter_mut().for_each(|p| p.gain *= scale);
        for person in scene.people {
            let mut path = person.mean_echo(scene, scene.time_s, self.lambda, 0.0);
            path.gain = complex_gaussian(&mut random) * path.gain.norm();
            paths.push(path);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_draw_belongs_to_a_place() {
        let scenario = Scenario::default();
        let ends = ([1.5, 1.0, 1.0], [1.5, 3.0, 1.0]);
        let mut model = SalehValenzuela::new(&scenario, ends, &mut Random::new(1, 0, 0, 0));
        let mut at = |to: Vec3| {
            let mut paths = Vec::new();
            model.paths(&Scene { slot: 0, time_s: 0.0, from: ends.0, to, people: &[] }, &mut paths);
            paths
        };
        let here = at(ends.1);
        assert_eq!(here, at(ends.1));
        let there = at([1.5, 3.001, 1.0]);
        assert!(here.iter().zip(&there).all(|(a, b)| a.gain != b.gain));
        // the power is free space's within the shadowing
        let power: f64 = here.iter().map(|p| p.gain.norm_sqr()).sum();
        let free = free_space(2.0, model.lambda) * model.shadowing;
        assert!((power / (free * free) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn delay_spreads_are_a_rooms() {
        let scenario = Scenario::default();
        let radar = scenario.radar.position_m;
        let mut mean = 0.0;
        for index in 0..400 {
            let mut model = SalehValenzuela::new(&scenario, (radar, radar), &mut Random::new(1, 0, 0, index));
            let mut paths = Vec::new();
            model.paths(&Scene { slot: 0, time_s: 0.0, from: radar, to: radar, people: &[] }, &mut paths);
            let sum = |n: i32| -> f64 { paths.iter().map(|p| p.gain.norm_sqr() * p.delay_s.powi(n)).sum() };
            let (m, s) = (sum(1) / sum(0), sum(2) / sum(0));
            mean += (s - m * m).sqrt() * 1e9 / 400.0;
        }
        assert!((5.0..20.0).contains(&mean), "{mean} ns");
    }
}
