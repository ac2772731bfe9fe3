//! `ray-tracing`: the deterministic baseline of the paper.
//!
//! Image method up to second order with Fresnel's coefficients; a moving body of sixteen primitives seen directly and by way of
//! one wall, ceiling or floor. Nothing is random.

use super::room::{free_space, images, traced};
use super::target::{direct, scattered};
use super::{ChannelModel, Path, Scene, carrier_phase, wavelength};
use crate::scenario::Scenario;
use crate::simulator::body::Vec3;

#[derive(Debug, Clone)]
pub struct RayTracing {
    lambda: f64,
    size: Vec3,
}

impl RayTracing {
    /// In a scenario's room.
    pub fn new(scenario: &Scenario) -> Self {
        RayTracing { lambda: wavelength(scenario.radar.carrier_hz), size: scenario.room.size_m }
    }
}

/// Appends the traced ways off the room's six planes.
pub fn walls(size: Vec3, lambda: f64, scene: &Scene, paths: &mut Vec<Path>) {
    paths.extend(traced(size, scene.from, scene.to, 2).iter().map(|r| Path {
        gain: carrier_phase(r.length_m, lambda) * r.fresnel * free_space(r.length_m, lambda),
        delay_s: r.delay_s(),
        departure: r.departure,
        arrival: r.arrival,
    }));
}

impl ChannelModel for RayTracing {
    fn paths(&mut self, scene: &Scene, paths: &mut Vec<Path>) {
        paths.extend(direct(scene, self.lambda));
        walls(self.size, self.lambda, scene, paths);
        for person in scene.people {
            person.echoes(scene, self.lambda, paths);
            let primitives = person.primitives(scene.time_s);
            for (primitive, phase) in primitives.iter().zip(&person.phases) {
                // out by a wall and straight back, and the other way round
                for (bent_from, bent_to) in [(true, false), (false, true)] {
                    let end = if bent_from { scene.from } else { scene.to };
                    for (image, fresnel) in images(self.size, end, primitive.centre) {
                        let bent = Scene {
                            from: if bent_from { image } else { scene.from },
                            to: if bent_to { image } else { scene.to },
                            ..*scene
                        };
                        let root = person.gain * primitive.bistatic_cross_section(bent.from, bent.to).sqrt();
                        let mut path = scattered(&bent, primitive.centre, root, self.lambda, *phase);
                        path.gain *= fresnel;
                        paths.push(path);
                    }
                }
            }
        }
    }
}
