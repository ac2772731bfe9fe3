//! `metis`: map-based hybrid model after METIS.
//!
//! A simplified map (the room's six planes, traced with Fresnel's coefficients), random objects that scatter once, and a
//! stochastic diffuse rest around each traced way. The map knows furniture, not motion: a person is one of the objects, where
//! it first stood.

use super::ieee80211ay::{Offset, draw_rays, turned};
use super::ray_tracing::walls;
use super::room::{free_space, traced};
use super::target::{direct, scattered};
use super::{ChannelModel, Path, Scene, carrier_phase, phasor, wavelength};
use crate::numerics::random::Random;
use crate::scenario::Scenario;
use crate::simulator::body::Vec3;
use std::f64::consts::TAU;

/// Random objects in a room.
const OBJECTS: usize = 6;
/// Range of their cross sections in m^2.
const CROSS_SECTION_M2: [f64; 2] = [0.02, 0.5];

#[derive(Debug)]
pub struct MapBased {
    lambda: f64,
    size: Vec3,
    ends: (Vec3, Vec3),
    /// Place, root of the cross section in m, phase.
    objects: Vec<(Vec3, f64, f64)>,
    /// Rays (with phases) around each first-order way.
    diffuse: Vec<Vec<(Offset, f64)>>,
    person: f64,
}

impl MapBased {
    /// Draws objects and diffuse rays.
    pub fn new(scenario: &Scenario, ends: (Vec3, Vec3), mut random: Random) -> Self {
        let size = scenario.room.size_m;
        let [low, high] = CROSS_SECTION_M2;
        let objects = (0..OBJECTS)
            .map(|_| {
                let place = size.map(|s| s * random.uniform());
                let sigma = low * libm::pow(high / low, random.uniform());
                (place, sigma.sqrt(), TAU * random.uniform())
            })
            .collect();
        let diffuse = (0..6)
            .map(|_| {
                let rays = draw_rays(&mut random);
                rays.into_iter().filter(|ray| !ray.central).map(|ray| (ray, TAU * random.uniform())).collect()
            })
            .collect();
        let person = TAU * random.uniform();
        MapBased { lambda: wavelength(scenario.radar.carrier_hz), size, ends, objects, diffuse, person }
    }
}

impl ChannelModel for MapBased {
    fn paths(&mut self, scene: &Scene, paths: &mut Vec<Path>) {
        let lambda = self.lambda;
        paths.extend(direct(scene, lambda));
        walls(self.size, lambda, scene, paths);
        for (way, rays) in traced(self.size, scene.from, scene.to, 1).iter().zip(&self.diffuse) {
            let gain = carrier_phase(way.length_m, lambda) * way.fresnel * free_space(way.length_m, lambda);
            for (offset, phase) in rays {
                let delay_s = way.delay_s() + offset.delay_s;
                if delay_s >= 0.0 {
                    let arrival = turned(way.arrival, offset.angle);
                    let departure = turned(way.departure, offset.angle);
                    let gain = gain * phasor(*phase) * offset.amplitude;
                    paths.push(Path { gain, delay_s, departure, arrival });
                }
            }
        }
        for &(place, root, phase) in &self.objects {
            paths.push(scattered(scene, place, root, lambda, phase));
        }
        let ends = Scene { from: self.ends.0, to: self.ends.1, ..*scene };
        for person in scene.people {
            paths.push(person.mean_echo(&ends, 0.0, lambda, self.person));
        }
    }
}
