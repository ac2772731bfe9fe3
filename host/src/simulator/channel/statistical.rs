//! `statistical`: Saleh and Valenzuela's clusters of rays.
//!
//! Saleh, Valenzuela (1987): Poisson clusters and rays with doubly exponential decay, Rayleigh amplitudes, uniform phases. Decays are those
//! of a room of a few metres instead of the paper's office wing.
//!
//! The paper states no temporal correlation. `channel.doppler` adds one: each ray and each person's echo is a sum of eight sinusoids with uniform
//! phases and frequencies drawn from a Doppler spectrum, so that its autocorrelation over drawings is the spectrum's Fourier transform. TGn's bell
//! 1 / (1 + 9 (f / f_d)^2) has frequencies f_d / 3 tan(pi (u - 1/2)) and the autocorrelation exp(-2 pi f_d t / 3), Clarke's f_d cos(2 pi u) and
//! J0(2 pi f_d t); f_d = v / lambda at TGn's 1.2 km/h. With `redrawn` the model knows distributions alone: wherever an antenna or a person has
//! moved it answers with a fresh draw.

use super::room::isotropic_power;
use super::{ChannelModel, Complex64, Path, Scene, free_space, phasor, wavelength};
use crate::numerics::random::Random;
use crate::scenario::{Doppler, SPEED_OF_LIGHT, Scenario};
use crate::simulator::body::Vec3;
use std::f64::consts::{FRAC_1_SQRT_2, PI};

/// Mean time between clusters and between rays, decay of clusters and of rays, in s.
const CLUSTER_GAP: f64 = 30e-9;
const RAY_GAP: f64 = 5e-9;
const CLUSTER_DECAY: f64 = 15e-9;
const RAY_DECAY: f64 = 7e-9;
/// Draws end this far behind the first ray, in s: -40 dB.
const LAST: f64 = 140e-9;

/// TGn's speed of what moves in a room, in m/s.
const SPEED_M_S: f64 = 1.2 / 3.6;
/// Sinusoids of a ray.
const TONES: usize = 8;
/// Streams of the rays and of the people's echoes.
const RAYS_STREAM: u64 = 1;
const PEOPLE_STREAM: u64 = 2;

#[derive(Debug, Clone)]
pub struct SalehValenzuela {
    lambda: f64,
    room_power: f64,
    shadowing: f64,
    doppler: Doppler,
    seed: u64,
    /// The rays that a recording keeps: the first arrives at delay 0.
    rays: Vec<(Path, Fading)>,
}

/// Frequency in Hz and phase in turns of a fading ray's sinusoids.
type Fading = [(f64, f64); TONES];

fn draw_fading(doppler: Doppler, f_d: f64, random: &mut Random) -> Fading {
    std::array::from_fn(|_| {
        let u = random.uniform();
        let hz = match doppler {
            Doppler::Clarke => f_d * libm::cos(2.0 * PI * u),
            _ => f_d / 3.0 * libm::tan(PI * (u - 0.5)),
        };
        (hz, random.uniform())
    })
}

/// Their sum at `t` seconds, of mean power 1.
fn fading(tones: &Fading, t: f64) -> Complex64 {
    let one = |&(hz, start): &(f64, f64)| {
        let turns = hz * t + start;
        phasor(2.0 * PI * (turns - turns.floor()))
    };
    tones.iter().map(one).sum::<Complex64>() / (TONES as f64).sqrt()
}

/// Clusters of rays, the first at a delay of `first` s; `gain` makes a ray's amplitude of its mean power.
fn clusters(
    first: f64,
    random: &mut Random,
    mut gain: impl FnMut(f64, &mut Random) -> Complex64,
) -> Vec<Path> {
    let mut paths = Vec::new();
    let mut cluster = 0.0;
    while cluster < LAST {
        let azimuth = 2.0 * PI * random.uniform();
        let arrival = [libm::cos(azimuth), libm::sin(azimuth), 0.0];
        let mut ray = 0.0;
        while cluster + ray < LAST {
            let mean = libm::exp(-cluster / CLUSTER_DECAY - ray / RAY_DECAY);
            let gain = gain(mean, random);
            paths.push(Path { gain, delay_s: first + cluster + ray, departure: arrival, arrival });
            ray -= RAY_GAP * libm::log(1.0 - random.uniform());
        }
        cluster -= CLUSTER_GAP * libm::log(1.0 - random.uniform());
    }
    paths
}

impl SalehValenzuela {
    /// Draws the shadowing (3 dB) of the recording, and with a Doppler spectrum its rays.
    pub fn new(scenario: &Scenario, _: (Vec3, Vec3), random: &mut Random) -> Self {
        let mut model = SalehValenzuela {
            lambda: wavelength(scenario.radar.carrier_hz),
            room_power: isotropic_power(scenario),
            shadowing: libm::pow(10.0, 3.0 * random.gaussian() / 20.0),
            doppler: scenario.channel.doppler,
            seed: random.bits(),
            rays: Vec::new(),
        };
        if model.doppler != Doppler::Redrawn {
            let mut random = Random::new(model.seed, RAYS_STREAM, 0, 0);
            let means = clusters(0.0, &mut random, |mean, _| Complex64::new(mean.sqrt(), 0.0));
            model.rays = means.into_iter().map(|path| (path, model.draw(&mut random))).collect();
        }
        model
    }

    fn draw(&self, random: &mut Random) -> Fading {
        draw_fading(self.doppler, SPEED_M_S / self.lambda, random)
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
        let (power, first) = if scene.monostatic() {
            (self.room_power, 2.0 / SPEED_OF_LIGHT)
        } else {
            let free = free_space(scene.distance_m().max(0.1), self.lambda);
            (free * free, scene.distance_m() / SPEED_OF_LIGHT)
        };
        let begin = paths.len();
        let people = scene.people.iter().map(|person| person.centre(scene.time_s));
        let places = [scene.from, scene.to].into_iter().chain(people);
        let mut random = Random::new(self.seed, RAYS_STREAM, 0, place(places));
        let redrawn = self.doppler == Doppler::Redrawn;
        // the power of a fresh draw is exact, that of fading rays is so in the mean
        let energy: f64 = if redrawn {
            let drawn = clusters(first, &mut random, |mean, random| complex_gaussian(random) * mean.sqrt());
            paths.extend(drawn);
            paths[begin..].iter().map(|p| p.gain.norm_sqr()).sum()
        } else {
            let faded = |(path, tones): &(Path, Fading)| Path {
                gain: path.gain * fading(tones, scene.time_s),
                ..*path
            };
            paths.extend(self.rays.iter().map(faded));
            self.rays.iter().map(|(path, _)| path.gain.norm_sqr()).sum()
        };
        let scale = self.shadowing * (power / energy.max(f64::MIN_POSITIVE)).sqrt();
        paths[begin..].iter_mut().for_each(|path| path.gain *= scale);
        for (number, person) in scene.people.iter().enumerate() {
            let mut path = person.mean_echo(scene, scene.time_s, self.lambda, 0.0);
            let draw = if redrawn {
                complex_gaussian(&mut random)
            } else {
                let random = &mut Random::new(self.seed, PEOPLE_STREAM, 0, number as u64);
                fading(&self.draw(random), scene.time_s)
            };
            path.gain = draw * path.gain.norm();
            paths.push(path);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_draw_belongs_to_a_place() {
        let mut scenario = Scenario::default();
        scenario.channel.doppler = Doppler::Redrawn;
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
    fn taps_are_correlated_over_slots_by_their_doppler_spectrum() {
        // J0 by its integral over a turn
        let bessel = |x: f64| {
            (0..64).map(|k| libm::cos(x * libm::sin(PI * (f64::from(k) + 0.5) / 64.0))).sum::<f64>() / 64.0
        };
        let f_d = SPEED_M_S / wavelength(3.5e9);
        for doppler in [Doppler::Bell, Doppler::Clarke] {
            for slots in [1, 20, 60, 100, 160] {
                let t = f64::from(slots) * 1e-3;
                let exact = match doppler {
                    Doppler::Clarke => bessel(2.0 * PI * f_d * t),
                    _ => libm::exp(-2.0 * PI * f_d * t / 3.0),
                };
                let (mut product, mut power) = (Complex64::default(), 0.0);
                for index in 0..20_000 {
                    let tones = draw_fading(doppler, f_d, &mut Random::new(1, 0, 0, index));
                    let (now, then) = (fading(&tones, 0.3), fading(&tones, 0.3 + t));
                    product += now * then.conj();
                    power += now.norm_sqr();
                }
                let found = product / power;
                println!(
                    "number: {doppler:?}, f_d = {f_d:.2} Hz, {slots} ms: autocorrelation {:.4} ({exact:.4})",
                    found.re
                );
                assert!((found - exact).norm_sqr() < 0.02 * 0.02, "{doppler:?}, {slots}: {found} {exact}");
            }
        }
        // a receiver's taps are those sums
        let (scenario, ends) = (Scenario::default(), ([1.5, 1.0, 1.0], [1.5, 3.0, 1.0]));
        let mut model = SalehValenzuela::new(&scenario, ends, &mut Random::new(1, 0, 0, 0));
        let mut at = |time_s: f64| {
            let mut paths = Vec::new();
            model.paths(&Scene { slot: 0, time_s, from: ends.0, to: ends.1, people: &[] }, &mut paths);
            paths
        };
        let (now, then) = (at(0.1), at(0.2));
        for ((a, b), (_, tones)) in now.iter().zip(&then).zip(&model.rays) {
            let ratio = fading(tones, 0.1) * b.gain - fading(tones, 0.2) * a.gain;
            assert!(ratio.norm_sqr() < 1e-20 * a.gain.norm_sqr() && a.delay_s == b.delay_s);
        }
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
