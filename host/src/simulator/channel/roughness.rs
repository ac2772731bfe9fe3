//! Diffuse scattering of rough surfaces: the effective roughness model with a directive pattern.
//!
//! Degli-Esposti, Fuschini, Vitucci, Falciasecca (2007), IEEE Trans. Antennas Propag. 55(1): a surface of reflection coefficient Gamma
//! scatters the share S^2 of what it reflects and leaves 1 - S^2 to the specular ray. An element of area dA has the pattern
//! ((1 + cos psi) / 2)^4 about the specular direction (alpha_R = 4), normalised by its integral over the half space, F(theta_i):
//!
//! P_r / P_t = (lambda / (4 pi))^2 S^2 |Gamma|^2 cos(theta_i) dA ((1 + cos psi) / 2)^4 / (F r_i^2 r_s^2)
//!
//! Each tile of a surface is one such element with a phase of its own. The phases are the same in every recording.

use super::room::{Map, Plane, StaticPath};
use super::{Complex64, Path, carrier_phase, phasor, wavelength};
use crate::numerics::random::Random;
use crate::scenario::{SPEED_OF_LIGHT, Scenario};
use crate::simulator::body::{Vec3, dot, norm, scale, sub};
use std::f64::consts::{PI, TAU};

/// Greatest side of a tile in m, and most tiles along a side of a surface.
const SIDE_M: f64 = 0.75;
const MOST: f64 = 8.0;
/// Seed of the tiles' phases.
const PHASES: u64 = 0x7469_6c65;

#[derive(Debug, Clone)]
struct Tile {
    plane: Plane,
    centre: Vec3,
    area: f64,
    phase: f64,
}

/// The tiles of a room.
#[derive(Debug, Clone)]
pub struct Roughness {
    s: f64,
    tiles: Vec<Tile>,
}

/// Integral of the pattern over the half space, at the cosine of the angle of incidence: the paper's closed form for alpha_R = 4.
fn integral(cosine: f64) -> f64 {
    PI / 16.0 * (6.4 + 6.0 * cosine + cosine * (1.0 - cosine * cosine))
}

impl Roughness {
    /// The surfaces of a room with scattering coefficient `s`; none for 0.
    pub fn new(size: Vec3, s: f64) -> Self {
        let mut random = Random::new(PHASES, 0, 0, 0);
        let mut tiles = Vec::new();
        for k in 0..if s > 0.0 { 6 } else { 0 } {
            let (axis, far) = (k / 2, k % 2 == 1);
            let plane = (axis, if far { size[axis] } else { 0.0 });
            let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
            let [n, m] = [a, b].map(|axis| (size[axis] / SIDE_M).ceil().min(MOST));
            for cell in 0..(n * m) as u32 {
                let (i, j) = (f64::from(cell % n as u32), f64::from(cell / n as u32));
                let mut centre = [plane.1; 3];
                (centre[a], centre[b]) = ((i + 0.5) * size[a] / n, (j + 0.5) * size[b] / m);
                let area = size[a] * size[b] / (n * m);
                tiles.push(Tile { plane, centre, area, phase: TAU * random.uniform() });
            }
        }
        Roughness { s, tiles }
    }

    /// Every tile's path between two points.
    pub fn paths(&self, map: &Map, from: Vec3, to: Vec3, lambda: f64) -> Vec<StaticPath> {
        let path = |tile: &Tile| {
            let (there, back) = (sub(tile.centre, from), sub(to, tile.centre));
            // nearer than half a side a tile is no point
            let [r_i, r_s] = [there, back].map(|v| norm(v).max(0.5 * SIDE_M));
            let (departure, leaving) = (scale(there, 1.0 / r_i), scale(back, 1.0 / r_s));
            let cosine = departure[tile.plane.0].abs();
            let mut specular = departure;
            specular[tile.plane.0] *= -1.0;
            let lobe = 0.5 * (1.0 + dot(specular, leaving));
            let gamma = map.smooth(tile.plane, cosine).norm_sqr();
            let power = gamma * cosine * tile.area * lobe * lobe * lobe * lobe / integral(cosine);
            let amplitude = lambda / (4.0 * PI) * self.s * power.sqrt() / (r_i * r_s);
            let path = Path {
                gain: carrier_phase(r_i + r_s, lambda) * phasor(tile.phase) * amplitude,
                delay_s: (r_i + r_s) / SPEED_OF_LIGHT,
                departure,
                arrival: scale(leaving, -1.0),
            };
            StaticPath { path, legs: vec![(from, tile.centre), (tile.centre, to)] }
        };
        self.tiles.iter().map(path).collect()
    }
}

/// A room's paths between two points, reflected and scattered, kept until an end moves.
#[derive(Debug, Clone)]
pub struct Traced {
    pub map: Map,
    lambda: f64,
    roughness: Roughness,
    known: Option<((Vec3, Vec3), Vec<StaticPath>)>,
}

impl Traced {
    /// As a scenario has them.
    pub fn new(scenario: &Scenario) -> Self {
        let map = Map::of(scenario);
        let roughness = Roughness::new(map.size, scenario.channel.scattering);
        Traced { lambda: wavelength(scenario.radar.carrier_hz), roughness, map, known: None }
    }

    /// Between two ends; `kept` is what resting screens leave of each path.
    pub fn paths(
        &mut self,
        ends: (Vec3, Vec3),
        kept: impl Fn(&[StaticPath]) -> Vec<Complex64>,
    ) -> &[StaticPath] {
        if self.known.as_ref().is_none_or(|(known, _)| *known != ends) {
            let mut paths = self.map.paths(ends.0, ends.1);
            paths.extend(self.roughness.paths(&self.map, ends.0, ends.1, self.lambda));
            let kept = kept(&paths);
            paths.iter_mut().zip(kept).for_each(|(path, kept)| path.path.gain *= kept);
            self.known = Some((ends, paths));
        }
        self.known.as_ref().map_or(&[], |(_, paths)| paths)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn specular_and_diffuse_energy_are_what_a_smooth_surface_reflects() {
        let mut scenario = Scenario::default();
        scenario.channel.scattering = 0.4;
        let (map, lambda) = (Map::of(&scenario), 0.0857);
        let mut roughness = Roughness::new(map.size, 0.4);
        for (name, from) in
            [("normal", [1.5, 2.25, 3.0]), ("60 degrees", [1.5, 2.25 + 3.0 * 3.0_f64.sqrt(), 3.0])]
        {
            // a tile of the floor in the middle, seen by receivers all over a half sphere of 5 m
            let centre = [1.5, 2.25, 0.0];
            roughness.tiles = vec![Tile { plane: (2, 0.0), centre, area: 0.25, phase: 0.0 }];
            let (mut scattered, n) = (0.0, 200);
            for i in 0..n {
                let z = (f64::from(i) + 0.5) / f64::from(n);
                for j in 0..n {
                    let angle = TAU * f64::from(j) / f64::from(n);
                    let across = 5.0 * (1.0 - z * z).sqrt();
                    let to = [1.5 + across * libm::cos(angle), 2.25 + across * libm::sin(angle), 5.0 * z];
                    let power = roughness.paths(&map, from, to, lambda)[0].path.gain.norm_sqr();
                    // what an isotropic antenna receives is lambda^2 / 4 pi of the density
                    scattered += power * 4.0 * PI / (lambda * lambda) * 25.0 * TAU / f64::from(n * n);
                }
            }
            let distance = norm(sub(from, centre));
            let cosine = 3.0 / distance;
            let incident = 0.25 * cosine / (4.0 * PI * distance * distance);
            let direction = scale(sub(centre, from), 1.0 / distance);
            let specular = incident * map.reflected(&[(2, 0.0)], direction).norm_sqr();
            let whole = incident * map.smooth((2, 0.0), cosine).norm_sqr();
            let share = (specular + scattered) / whole;
            println!(
                "number: {name}: specular {:.4} + diffuse {:.4} = {share:.4} of what a smooth floor reflects",
                specular / whole,
                scattered / whole
            );
            assert!((share - 1.0).abs() < 1e-3 && (specular / whole - 0.84).abs() < 1e-9, "{share}");
        }
    }

    #[test]
    fn tiles_cover_the_room() {
        let area: f64 = Roughness::new([3.0, 4.5, 3.0], 0.2).tiles.iter().map(|tile| tile.area).sum();
        assert!((area - 2.0 * (13.5 + 13.5 + 9.0)).abs() < 1e-9, "{area}");
        assert!(Roughness::new([3.0, 4.5, 3.0], 0.0).tiles.is_empty());
    }
}
