//! The room as a box: reflections by the image method, and how materials reflect.
//!
//! A reflected path is the straight path from the transmitter's image. Fresnel's coefficients take the angle at which that
//! straight line meets each wall. A bare room has the permittivities of the NIST Q-D software at 60 GHz, as the paper's baseline; a
//! furnished one slabs of ITU-R P.2040's materials at the carrier ([`super::material`]).

use super::antenna::Antenna;
use super::material::Slab;
use super::shadowing::{self, Leg};
use super::target::{mean_cross_section, scattered};
use super::{Complex64, Path, Scene, carrier_phase, free_space};
use crate::scenario::{ArMode, Furniture, Interior, SPEED_OF_LIGHT, Scenario};
use crate::simulator::body::{Vec3, norm, scale, sub};

/// A wall: the axis it is normal to and its coordinate.
pub type Plane = (usize, f64);

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reflection {
    /// Its whole length in m.
    pub length_m: f64,
    /// Reflections on the way.
    pub order: u8,
    /// Whether the ceiling is one of them.
    pub ceiling: bool,
    /// Unit vector from the transmitter towards the receiver's last image.
    pub departure: Vec3,
    /// Unit vector from the receiver towards the transmitter's last image.
    pub arrival: Vec3,
}

impl Reflection {
    /// Its delay in s.
    pub fn delay_s(&self) -> f64 {
        self.length_m / SPEED_OF_LIGHT
    }
}

/// Relative permittivity of concrete (walls, floor) and of plasterboard (ceiling); losses are negative imaginary parts.
const CONCRETE: Complex64 = Complex64::new(4.0, -0.2);
const PLASTERBOARD: Complex64 = Complex64::new(6.25, -0.3);

/// Fresnel's coefficient of a half space for a vertically polarised wave: perpendicular to the plane of incidence at a
/// wall, parallel to it at ceiling and floor. `cosine` is that of the angle of incidence.
pub fn fresnel(permittivity: Complex64, cosine: f64, wall: bool) -> Complex64 {
    let root = (permittivity - (1.0 - cosine * cosine)).sqrt();
    let c = Complex64::new(cosine, 0.0);
    if wall { (c - root) / (c + root) } else { (permittivity * c - root) / (permittivity * c + root) }
}

pub fn image(p: Vec3, (axis, plane): Plane) -> Vec3 {
    let mut image = p;
    image[axis] = 2.0 * plane - p[axis];
    image
}

fn reflection(size: Vec3, planes: &[Plane], from: Vec3, to: Vec3) -> Reflection {
    let source = planes.iter().fold(from, |p, &plane| image(p, plane));
    let sink = planes.iter().rev().fold(to, |p, &plane| image(p, plane));
    let offset = sub(source, to);
    let length_m = norm(offset).max(1e-6);
    let arrival = scale(offset, 1.0 / length_m);
    Reflection {
        length_m,
        order: planes.len() as u8,
        ceiling: planes.contains(&(2, size[2])),
        departure: scale(sub(sink, from), 1.0 / length_m),
        arrival,
    }
}

/// The 17 reflections of the 802.11ay conference room between two points: ceiling, four walls, four wall-ceiling, eight
/// double walls. The floor and the table are left out.
pub fn conference_room(size: Vec3, from: Vec3, to: Vec3) -> Vec<Reflection> {
    let walls = [(0, 0.0), (0, size[0]), (1, 0.0), (1, size[1])];
    let ceiling = (2, size[2]);
    let mut found = Vec::with_capacity(17);
    let mut push = |planes: &[Plane]| found.push(reflection(size, planes, from, to));
    push(&[ceiling]);
    walls.iter().for_each(|&wall| push(&[wall]));
    walls.iter().for_each(|&wall| push(&[wall, ceiling]));
    for x in &walls[..2] {
        for y in &walls[2..] {
            push(&[*x, *y]);
        }
    }
    for pair in [[0, 1], [1, 0], [2, 3], [3, 2]] {
        push(&[walls[pair[0]], walls[pair[1]]]);
    }
    found
}

/// The planes of every reflection up to `order` (1 or 2) off walls, floor and ceiling: 6, or 24 in all.
pub fn orders(size: Vec3, order: u8) -> Vec<Vec<Plane>> {
    let planes: [Plane; 6] = std::array::from_fn(|k| (k / 2, if k % 2 == 0 { 0.0 } else { size[k / 2] }));
    let mut found: Vec<Vec<Plane>> = planes.iter().map(|&p| vec![p]).collect();
    if order >= 2 {
        for (i, &a) in planes.iter().enumerate() {
            for (j, &b) in planes.iter().enumerate() {
                // images in planes of different axes commute: each pair once; opposite planes do not
                if a.0 == b.0 && i != j || a.0 < b.0 {
                    found.push(vec![a, b]);
                }
            }
        }
    }
    found
}

/// A path through the room that never changes.
#[derive(Debug, Clone)]
pub struct StaticPath {
    /// Amplitude between isotropic antennas, delay and directions.
    pub path: Path,
    /// Its straight legs, from the transmitter on.
    pub legs: Vec<Leg>,
}

/// What waves meet in a room: six surfaces, and what stands between them.
#[derive(Debug, Clone)]
pub struct Map {
    pub size: Vec3,
    carrier_hz: f64,
    /// Walls, floor and ceiling as slabs; else half spaces with the permittivities of the NIST Q-D software.
    slabs: Option<[Slab; 3]>,
    pub furniture: Vec<Furniture>,
    /// Amplitude that each surface leaves to the specular reflection.
    pub kept: f64,
}

impl Map {
    /// The room's own materials and furniture, smooth surfaces. Pieces outside the room do not count.
    pub fn furnished(scenario: &Scenario) -> Self {
        let room = &scenario.room;
        let inside =
            |piece: &&Furniture| piece.centre_m.iter().zip(&room.size_m).all(|(x, s)| (0.0..=*s).contains(x));
        Map {
            size: room.size_m,
            carrier_hz: scenario.radar.carrier_hz,
            slabs: Some(
                [room.walls, room.floor, room.ceiling].map(|s| Slab::new(&s, scenario.radar.carrier_hz)),
            ),
            furniture: room.furniture.iter().filter(inside).copied().collect(),
            kept: 1.0,
        }
    }

    /// As `channel.interior` and `channel.scattering` have it: a rough surface reflects 1 - S^2 of the power.
    pub fn of(scenario: &Scenario) -> Self {
        let channel = &scenario.channel;
        let mut map = Map::furnished(scenario);
        map.kept = (1.0 - channel.scattering * channel.scattering).sqrt();
        if channel.interior == Interior::Bare {
            (map.slabs, map.furniture) = (None, Vec::new());
        }
        map
    }

    /// What a smooth plane reflects of a vertically polarised wave at a cosine of the angle of incidence.
    pub fn smooth(&self, (axis, plane): Plane, cosine: f64) -> Complex64 {
        let part = if axis != 2 { 0 } else { 1 + usize::from(plane != 0.0) };
        match &self.slabs {
            Some(slabs) => slabs[part].reflected(cosine, axis == 2),
            None => fresnel(if part == 2 { PLASTERBOARD } else { CONCRETE }, cosine, axis != 2),
        }
    }

    /// What planes reflect of a wave that comes along `direction`, one after the other.
    pub fn reflected(&self, planes: &[Plane], direction: Vec3) -> Complex64 {
        let bounce = |&plane: &Plane| self.smooth(plane, direction[plane.0].abs()) * self.kept;
        planes.iter().map(bounce).product()
    }

    /// Every path between two points by reflections up to second order and by the furniture.
    pub fn paths(&self, from: Vec3, to: Vec3) -> Vec<StaticPath> {
        let lambda = super::wavelength(self.carrier_hz);
        let mut found: Vec<StaticPath> = Vec::new();
        for planes in orders(self.size, 2) {
            let r = reflection(self.size, &planes, from, to);
            let coefficient = self.reflected(&planes, r.arrival);
            let path = Path {
                gain: carrier_phase(r.length_m, lambda) * coefficient * free_space(r.length_m, lambda),
                delay_s: r.delay_s(),
                departure: r.departure,
                arrival: r.arrival,
            };
            found.push(StaticPath { path, legs: legs(self.size, &planes, from, to) });
        }
        let scene = Scene { slot: 0, time_s: 0.0, from, to, people: &[] };
        for piece in &self.furniture {
            let root = libm::pow(10.0, piece.cross_section_dbsm / 20.0);
            let path = scattered(&scene, piece.centre_m, root, lambda, 0.0);
            found.push(StaticPath { path, legs: vec![(from, piece.centre_m), (piece.centre_m, to)] });
        }
        found
    }
}

/// The mean of the hybrid channel's room between two points.
pub fn static_paths(scenario: &Scenario, from: Vec3, to: Vec3) -> Vec<StaticPath> {
    let mut paths = Map::furnished(scenario).paths(from, to);
    if scenario.channel.clutter_gain_db != 0.0 {
        let gain = libm::pow(10.0, scenario.channel.clutter_gain_db / 20.0);
        paths.iter_mut().for_each(|one| one.path.gain *= gain);
    }
    paths
}

/// The straight legs of a reflected path. Two planes of different axes have the same image in either order, but only one order has its
/// points on the walls.
pub fn legs(size: Vec3, planes: &[Plane], from: Vec3, to: Vec3) -> Vec<Leg> {
    let trace = |planes: &[Plane]| {
        // images of the transmitter, the last one first
        let images: Vec<Vec3> = (0..=planes.len())
            .rev()
            .map(|n| planes[..n].iter().fold(from, |p, &plane| image(p, plane)))
            .collect();
        let mut points = vec![to];
        let mut end = to;
        for (&source, &(axis, plane)) in images.iter().zip(planes.iter().rev()) {
            let step = end[axis] - source[axis];
            let share = if step.abs() < 1e-12 { 0.5 } else { (plane - source[axis]) / step };
            end = shadowing::between(source, end, share);
            points.push(end);
        }
        points.push(from);
        points.reverse();
        points
    };
    let inside = |point: &Vec3| point.iter().zip(&size).all(|(x, size)| (-1e-9..=size + 1e-9).contains(x));
    let mut points = trace(planes);
    if !points.iter().all(inside) {
        let reversed: Vec<Plane> = planes.iter().rev().copied().collect();
        points = trace(&reversed);
    }
    points.windows(2).map(|pair| (pair[0], pair[1])).collect()
}

/// Mean reflection loss in dB of an order before truncation at -2 dB, and its standard deviation (11-09/0334r8).
pub const LOSS_DB: [(f64, f64); 2] = [(-10.0, 4.0), (-16.0, 5.0)];

/// Power ratio of all reflections at their mean losses, isotropic antennas: the large-scale law of a monostatic radar in
/// every stochastic model here.
pub fn isotropic_power(scenario: &Scenario) -> f64 {
    let radar = &scenario.radar;
    let lambda = super::wavelength(radar.carrier_hz);
    conference_room(scenario.room.size_m, radar.position_m, radar.position_m)
        .iter()
        .map(|r| {
            let amplitude = mean_amplitude(r, lambda);
            amplitude * amplitude
        })
        .sum()
}

/// Power that the mean of the room has at a receiver, relative to what isotropic antennas send.
pub fn received_power(mean: &[StaticPath], antenna: &Antenna) -> f64 {
    let power = |one: &StaticPath| {
        let weight = antenna.weight(&one.path);
        one.path.gain.norm_sqr() * weight * weight
    };
    mean.iter().map(power).sum()
}

/// Where a person is expected who sets the converter's full scale, in m.
const PERSON_M: f64 = 2.0;

/// Power ratio of the loudest that a radar has to expect, through its antenna: what sets the converter's full scale.
///
/// As the paper has it, that is the room at its mean losses seen at the antenna's maximum. With an antenna's pattern or a room that has a
/// mean it is the room through the antenna and a person at 2 m ([`PERSON_M`]): with 12 dB above it a person may come to 1 m.
pub fn expected_power(scenario: &Scenario) -> f64 {
    let antenna = Antenna::of(scenario);
    let rician = scenario.channel.mode == ArMode::Rician;
    if antenna.is_constant() && !rician {
        return isotropic_power(scenario);
    }
    let radar = scenario.radar.position_m;
    let lambda = super::wavelength(scenario.radar.carrier_hz);
    let room = if rician {
        let mean = received_power(&static_paths(scenario, radar, radar), &antenna);
        mean * (1.0 + libm::pow(10.0, -scenario.channel.k_factor_db / 10.0))
    } else {
        let power = |r: &Reflection| {
            let one =
                mean_amplitude(r, lambda) * antenna.amplitude(r.departure) * antenna.amplitude(r.arrival);
            one * one
        };
        conference_room(scenario.room.size_m, radar, radar).iter().map(power).sum()
    };
    let distance4 = libm::pow(PERSON_M, 4.0) * libm::pow(4.0 * std::f64::consts::PI, 3.0);
    room + lambda * lambda * mean_cross_section(1.75, 0.0) / distance4
}

/// Free-space amplitude of a path times its mean reflection loss.
pub fn mean_amplitude(reflection: &Reflection, lambda: f64) -> f64 {
    let (mean, _) = LOSS_DB[usize::from(reflection.order.clamp(1, 2)) - 1];
    free_space(reflection.length_m, lambda) * libm::pow(10.0, mean / 20.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: Vec3 = [3.0, 4.5, 3.0];
    const RADAR: Vec3 = [1.5, 1.0, 1.0];

    #[test]
    fn path_lengths_of_the_papers_room() {
        let lengths: Vec<f64> = conference_room(SIZE, RADAR, RADAR).iter().map(|r| r.length_m).collect();
        let golden =
            [4.0, 3.0, 3.0, 2.0, 7.0, 5.0, 5.0, 4.472, 8.062, 3.606, 7.616, 3.606, 7.616, 6.0, 6.0, 9.0, 9.0];
        assert_eq!(lengths.len(), 17);
        for (found, expected) in lengths.iter().zip(golden) {
            assert!((found - expected).abs() < 1e-3, "{found} {expected}");
        }
    }

    #[test]
    fn ways_are_the_conference_rooms_and_those_of_the_floor() {
        let (to, mut scenario) = ([2.1, 3.3, 1.4], Scenario::default());
        scenario.room.furniture.clear();
        let paths = static_paths(&scenario, RADAR, to);
        assert_eq!(paths.len(), 24);
        for r in conference_room(SIZE, RADAR, to) {
            assert!(paths.iter().any(|path| (path.path.delay_s - r.delay_s()).abs() < 1e-20), "{r:?}");
        }
    }

    #[test]
    fn legs_are_as_long_as_their_way_and_stay_inside() {
        let scenario = Scenario::default();
        for to in [RADAR, [2.1, 3.3, 1.4], [0.5, 1.0, 1.0]] {
            for one in static_paths(&scenario, RADAR, to) {
                let sum: f64 = one.legs.iter().map(|&(a, b)| norm(sub(b, a))).sum();
                assert!((sum - one.path.delay_s * SPEED_OF_LIGHT).abs() < 1e-9, "{one:?}");
                let inside = |p: Vec3| p.iter().zip(&SIZE).all(|(x, s)| (-1e-6..=s + 1e-6).contains(x));
                assert!(one.legs.iter().all(|&(a, b)| inside(a) && inside(b)), "{one:?}");
                assert_eq!((one.legs[0].0, one.legs[one.legs.len() - 1].1), (RADAR, to));
                // it leaves along its first leg and comes along its last
                let along = |(a, b): Leg| scale(sub(b, a), 1.0 / norm(sub(b, a)).max(1e-12));
                let first = norm(sub(along(one.legs[0]), one.path.departure));
                let (a, b) = one.legs[one.legs.len() - 1];
                let last = norm(sub(along((b, a)), one.path.arrival));
                assert!(first < 1e-6 && last < 1e-6, "{one:?}");
            }
        }
    }

    #[test]
    fn fresnel_knows_normal_grazing_and_brewster() {
        let real = Complex64::new(4.0, 0.0);
        assert!((fresnel(real, 1.0, true).re + 1.0 / 3.0).abs() < 1e-12);
        assert!((fresnel(real, 1.0, false).re - 1.0 / 3.0).abs() < 1e-12);
        assert!((fresnel(real, 1e-9, true).re + 1.0).abs() < 1e-6);
        // Brewster's angle: tan = sqrt(4)
        assert!(fresnel(real, libm::cos(libm::atan(2.0)), false).norm() < 1e-12);
    }
}
