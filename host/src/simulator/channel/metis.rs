//! `metis`: the hybrid of a map and of stochastic clusters, after METIS deliverable D1.4.
//!
//! Map-based part (its clause 6): the room's surfaces traced up to second order, tiles of rough surfaces as point sources
//! ([`super::roughness`]), random objects that scatter as spheres, and screens that block, which are the objects, the furniture and the
//! people. A screen's loss is the knife-edge formula of four edges that 3GPP took over as blockage model B ([`super::shadowing`]).
//!
//! Stochastic part: fifteen clusters of twenty rays with the distributions of ITU-R M.2135's indoor hotspot in line of sight. Their delay spread is
//! that of the traced paths, their directions lie around traced paths, and their power lies the mean K factor of 7 dB below them.
//!
//! The map knows no motion of scatterers: a person echoes where it first stood. An empty box has no edges: the recursive diffraction at corners of
//! D1.4 has nothing to do here.

use super::ieee80211ay::rotated;
use super::room::StaticPath;
use super::roughness::Traced;
use super::shadowing::{Screen, transmission, transmissions};
use super::target::{direct, scattered};
use super::{ChannelModel, Complex64, Path, Scene, carrier_phase, phasor, wavelength};
use crate::numerics::random::Random;
use crate::scenario::{SPEED_OF_LIGHT, Scenario};
use crate::simulator::body::{Vec3, dot, norm, sub};
use std::f64::consts::{PI, TAU};

/// Random objects in a room, and the range of their cross sections in m^2: a sphere's is pi r^2.
const OBJECTS: usize = 6;
const CROSS_SECTION_M2: [f64; 2] = [0.02, 0.5];
/// Nearest an object stands to an end in m.
const AWAY_M: f64 = 0.5;
/// ITU-R M.2135-1 Table A1-7, indoor hotspot, line of sight: clusters, rays, ratio of the delays' spread to the delay spread, shadowing of a cluster
/// in dB, spread of a cluster's rays in degrees at departure and arrival, mean K factor in dB.
const CLUSTERS: usize = 15;
const RAYS: usize = 20;
const DELAY_RATIO: f64 = 3.6;
const CLUSTER_SHADOWING_DB: f64 = 6.0;
const RAY_SPREAD_DEG: [f64; 2] = [5.0, 8.0];
const K_DB: f64 = 7.0;

/// An object: place, root of its cross section in m, phase.
type Object = (Vec3, f64, f64);

#[derive(Debug)]
pub struct MapBased {
    lambda: f64,
    traced: Traced,
    ends: (Vec3, Vec3),
    objects: Vec<Object>,
    /// The furniture's and the objects' screens.
    screens: Vec<Screen>,
    shadowing: bool,
    /// The stochastic rays between the first ends.
    rays: Vec<Path>,
    person: f64,
}

/// Power and rms delay spread in s of paths.
fn spread<'a>(paths: impl Iterator<Item = &'a Path> + Clone) -> (f64, f64) {
    let moment = |n: i32| paths.clone().map(|p| p.gain.norm_sqr() * p.delay_s.powi(n)).sum::<f64>();
    let (power, mean) = (moment(0), moment(1) / moment(0));
    (power, (moment(2) / power - mean * mean).max(0.0).sqrt())
}

/// The stochastic rays of a room with these traced paths, the first arriving at `first` s.
fn stochastic(paths: &[StaticPath], first: f64, random: &mut Random) -> Vec<Path> {
    let (traced, delay_spread) = spread(paths.iter().map(|path| &path.path));
    let mut delays: Vec<f64> =
        (0..CLUSTERS).map(|_| -DELAY_RATIO * delay_spread * libm::log(1.0 - random.uniform())).collect();
    let least = delays.iter().copied().fold(f64::INFINITY, f64::min);
    delays.iter_mut().for_each(|delay| *delay -= least);
    let slope = (DELAY_RATIO - 1.0) / (DELAY_RATIO * delay_spread.max(f64::MIN_POSITIVE));
    let power = |delay: &f64| {
        libm::exp(-delay * slope) * libm::pow(10.0, -CLUSTER_SHADOWING_DB * random.gaussian() / 10.0)
    };
    let powers: Vec<f64> = delays.iter().map(power).collect();
    let scale = traced * libm::pow(10.0, -K_DB / 10.0) / (powers.iter().sum::<f64>() * RAYS as f64);
    let mut rays = Vec::with_capacity(CLUSTERS * RAYS);
    for (delay, power) in delays.iter().zip(&powers) {
        let mut rest = traced * random.uniform();
        let around = paths.iter().find(|path| {
            rest -= path.path.gain.norm_sqr();
            rest <= 0.0
        });
        let Some(StaticPath { path: around, .. }) = around.or(paths.last()) else { continue };
        for _ in 0..RAYS {
            let mut turn = |direction: Vec3, spread_deg: f64| {
                let angle = [0; 2].map(|_| spread_deg * PI / 180.0 * random.laplacian());
                rotated(direction, angle)
            };
            let [at_departure, at_arrival] = RAY_SPREAD_DEG;
            let departure = turn(around.departure, at_departure);
            let arrival = turn(around.arrival, at_arrival);
            let gain = phasor(TAU * random.uniform()) * (power * scale).sqrt();
            rays.push(Path { gain, delay_s: first + delay, departure, arrival });
        }
    }
    rays
}

impl MapBased {
    /// Draws objects and clusters.
    pub fn new(scenario: &Scenario, ends: (Vec3, Vec3), mut random: Random) -> Self {
        let mut traced = Traced::new(scenario);
        let [low, high] = CROSS_SECTION_M2;
        let object = |_| {
            let place = loop {
                let place = traced.map.size.map(|s| s * random.uniform());
                if [ends.0, ends.1].iter().all(|&end| norm(sub(place, end)) > AWAY_M) {
                    break place;
                }
            };
            let sigma = low * libm::pow(high / low, random.uniform());
            (place, sigma.sqrt(), TAU * random.uniform())
        };
        let objects: Vec<Object> = (0..OBJECTS).map(object).collect();
        let mut screens: Vec<Screen> = traced.map.furniture.iter().filter_map(Screen::furniture).collect();
        screens.extend(objects.iter().map(screen));
        let lambda = wavelength(scenario.radar.carrier_hz);
        let paths = traced.paths(ends, |paths| behind(&screens, paths, lambda));
        let distance = norm(sub(ends.1, ends.0)) / SPEED_OF_LIGHT;
        let shortest = paths.iter().map(|path| path.path.delay_s).fold(f64::INFINITY, f64::min);
        let first = if ends.0 == ends.1 { shortest } else { distance };
        MapBased {
            lambda,
            rays: stochastic(paths, first, &mut random),
            traced,
            ends,
            objects,
            screens,
            shadowing: scenario.channel.shadowing,
            person: TAU * random.uniform(),
        }
    }
}

/// A sphere's screen: as wide and as high as the sphere.
fn screen(&([x, y, z], root, _): &Object) -> Screen {
    let radius = root / PI.sqrt();
    Screen { place: [x, y], heights: [z - radius, z + radius], width: 2.0 * radius }
}

/// Amplitudes that paths keep behind screens.
fn behind(screens: &[Screen], paths: &[StaticPath], lambda: f64) -> Vec<Complex64> {
    let kept = transmissions(screens, paths.iter().map(|path| &path.legs[..]), lambda);
    kept.into_iter().map(Complex64::from).collect()
}

impl ChannelModel for MapBased {
    fn paths(&mut self, scene: &Scene, paths: &mut Vec<Path>) {
        let (lambda, ends) = (self.lambda, (scene.from, scene.to));
        let people = scene.people.iter().filter(|_| self.shadowing);
        let people: Vec<Screen> = people.map(|person| Screen::of(person, scene.time_s)).collect();
        let by = |screens, legs: &[_]| transmission(screens, legs, lambda);
        let kept = |legs: &[_]| by(&self.screens, legs) * by(&people, legs);
        if let Some(path) = direct(scene, lambda) {
            paths.push(Path { gain: path.gain * kept(&[ends]), ..path });
        }
        let traced = self.traced.paths(ends, |paths| behind(&self.screens, paths, lambda));
        for (StaticPath { path, .. }, kept) in traced.iter().zip(behind(&people, traced, lambda)) {
            paths.push(Path { gain: path.gain * kept, ..*path });
        }
        for &(place, root, phase) in &self.objects {
            let path = scattered(scene, place, root, lambda, phase);
            paths.push(Path { gain: path.gain * kept(&[(scene.from, place), (place, scene.to)]), ..path });
        }
        // plane waves: a step towards one shortens it
        let (from, to) = (sub(scene.from, self.ends.0), sub(scene.to, self.ends.1));
        for ray in &self.rays {
            let longer = -dot(ray.departure, from) - dot(ray.arrival, to);
            let delay_s = ray.delay_s + longer / SPEED_OF_LIGHT;
            paths.push(Path { gain: ray.gain * carrier_phase(longer, lambda), delay_s, ..*ray });
        }
        let first = Scene { from: self.ends.0, to: self.ends.1, ..*scene };
        for person in scene.people {
            paths.push(person.mean_echo(&first, 0.0, lambda, self.person));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ENDS: (Vec3, Vec3) = ([1.5, 1.0, 1.0], [1.5, 3.5, 1.0]);

    #[test]
    fn clusters_have_the_delay_spread_and_the_k_factor_of_the_map() {
        let mut traced = Traced::new(&Scenario::default());
        let paths = traced.paths(ENDS, |paths| vec![1.0.into(); paths.len()]);
        let (power, delay_spread) = spread(paths.iter().map(|path| &path.path));
        let (mut sum, mut found) = (0.0, 0.0);
        let n = 4000;
        for index in 0..n {
            let rays = stochastic(paths, 0.0, &mut Random::new(1, 0, 0, index));
            let (power, delay_spread) = spread(rays.iter());
            sum += power / n as f64;
            found += delay_spread / n as f64;
        }
        let k = 10.0 * libm::log10(power / sum);
        println!(
            "number: METIS K {k:.2} dB (7 dB), delay spread of the clusters {:.2} ns (map {:.2} ns)",
            found * 1e9,
            delay_spread * 1e9
        );
        assert!((k - K_DB).abs() < 1e-9, "{k}");
        assert!((found / delay_spread - 1.0).abs() < 0.15, "{found:e} {delay_spread:e}");
    }

    #[test]
    fn an_object_blocks_like_four_knife_edges() {
        // by hand at 60 GHz: a sphere of 0.3 m in the middle of 6 m: D1 + D2 - r = 2 sqrt(9 + 0.09) - 6 = 29.85 mm, F = atan(pi / 2
        // sqrt(pi / 4.997 mm * 29.85 mm)) / pi = 0.4536, amplitude 1 - (4 * 0.4536^2) = 0.177
        let object = ([3.0, 0.0, 1.0], 0.3 * PI.sqrt(), 0.0);
        let leg = ([0.0, 0.0, 1.0], [6.0, 0.0, 1.0]);
        let db = 20.0 * libm::log10(transmission(&[screen(&object)], &[leg], wavelength(60e9)));
        println!(
            "number: METIS screen of 0.6 m in the middle of 6 m at 60 GHz {db:.2} dB, by hand -15.03 dB"
        );
        assert!((db + 15.03).abs() < 0.05, "{db}");
    }
}
