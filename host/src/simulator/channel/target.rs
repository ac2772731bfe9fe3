//! Echoes of a person: sixteen primitives by the radar equation, or one mean echo where a model knows no limbs.
//!
//! Eq. (uit) with the radar equation's amplitude, lambda sqrt(sigma) / ((4 pi)^1.5 D^2), the phase of the exact distance and
//! the delay 2 D / c; on the way to a receiver the two distances differ. Mean echo: 3GPP TR 38.901 clause 7.9.2, human model 1.

use super::{Complex64, Path, Scene, carrier_angle, carrier_phase, free_space, phasor};
use crate::numerics::random::Random;
use crate::numerics::sincos::sincos;
use crate::numerics::vectors::vectorised;
use crate::scenario::SPEED_OF_LIGHT;
use crate::simulator::body::motion::Person;
use crate::simulator::body::primitives::{PRIMITIVES, Primitive};
use crate::simulator::body::{Vec3, add, norm, scale, sub};
use std::f64::consts::PI;

/// A person as channels see it: how it moves, and the initial phase of each primitive, fixed for the recording.
#[derive(Debug, Clone)]
pub struct Target {
    pub person: Person,
    pub phases: [f64; PRIMITIVES],
    /// Amplitude of its echo: below 1 off the antenna's main lobe.
    pub gain: f64,
    /// Amplitude of each primitive's echo besides: 1 unless bodies are to differ.
    pub weights: [f64; PRIMITIVES],
    /// A rigid body instead of a moving one: the pose of time 0 carried along at this velocity in m/s.
    pub rigid: Option<Vec3>,
}

/// Nearest a scatterer may come to an antenna in m: the far field ends there.
pub const NEAREST_M: f64 = 0.1;

/// Mean bistatic cross section of an adult of 1.75 m: -1.37 dBsm - 3 sin(beta / 2) dB, in m^2.
pub fn mean_cross_section(height_m: f64, bistatic_angle: f64) -> f64 {
    let area = height_m / 1.75;
    libm::pow(10.0, (-1.37 - 3.0 * libm::sin(bistatic_angle / 2.0)) / 10.0) * area * area
}

impl Target {
    /// Initial phases are uniform.
    pub fn new(person: Person, random: &mut Random) -> Self {
        Target {
            person,
            phases: std::array::from_fn(|_| 2.0 * PI * random.uniform()),
            gain: 1.0,
            weights: [1.0; PRIMITIVES],
            rigid: None,
        }
    }

    /// Primitives at `t` seconds.
    pub fn primitives(&self, t: f64) -> [Primitive; PRIMITIVES] {
        match self.rigid {
            None => self.person.primitives(t),
            Some(velocity) => self.person.primitives(0.0).map(|mut p| {
                p.centre = add(p.centre, scale(velocity, t));
                p
            }),
        }
    }

    /// Middle of the torso at `t` seconds in m.
    pub fn centre(&self, t: f64) -> Vec3 {
        self.primitives(t)[1].centre
    }

    /// Appends the echo of every primitive on the way from `scene.from` to `scene.to`.
    pub fn echoes(&self, scene: &Scene, lambda: f64, paths: &mut Vec<Path>) {
        let primitives = self.primitives(scene.time_s);
        let ways = primitives.each_ref().map(|primitive| Way::of(scene, primitive.centre));
        let turned = ways.each_ref().map(|way| carrier_angle(way.length(), lambda));
        let [[s, c], [first_s, first_c]] = vectorised(
            #[inline(always)]
            || [sincos(&turned), sincos(&self.phases)],
        );
        for (k, (primitive, way)) in primitives.iter().zip(&ways).enumerate() {
            let root =
                self.gain * self.weights[k] * primitive.root_bistatic_cross_section(scene.from, scene.to);
            let (carrier, first) = (Complex64::new(c[k], s[k]), Complex64::new(first_c[k], first_s[k]));
            paths.push(way.path(carrier * first, root, lambda));
        }
    }

    /// The whole body as one scatterer of its mean cross section, at its place of `t` seconds.
    pub fn mean_echo(&self, scene: &Scene, t: f64, lambda: f64, phase: f64) -> Path {
        let centre = self.centre(t);
        let (a, b) = (sub(scene.from, centre), sub(scene.to, centre));
        let cosine = super::super::body::dot(a, b) / (norm(a) * norm(b)).max(1e-9);
        let sigma = mean_cross_section(self.person.truth.height_m, libm::acos(cosine.clamp(-1.0, 1.0)));
        scattered(scene, centre, self.gain * sigma.sqrt(), lambda, phase)
    }
}

/// (4 pi)^1.5.
pub const SPREADING: f64 = 44.546_623_974_653_656;

/// From an antenna to a scatterer and on to the other.
struct Way {
    from: Vec3,
    to: Vec3,
    there: f64,
    back: f64,
}

impl Way {
    fn of(scene: &Scene, centre: Vec3) -> Self {
        let from = sub(centre, scene.from);
        let there = norm(from).max(NEAREST_M);
        if scene.monostatic() {
            return Way { from, to: from, there, back: there };
        }
        let to = sub(centre, scene.to);
        Way { from, to, there, back: norm(to).max(NEAREST_M) }
    }

    fn length(&self) -> f64 {
        self.there + self.back
    }

    /// Off a cross section of root `root` in m, with a phasor.
    fn path(&self, phasor: Complex64, root: f64, lambda: f64) -> Path {
        let amplitude = lambda * root / (SPREADING * self.there * self.back);
        Path {
            gain: phasor * amplitude,
            delay_s: self.length() / SPEED_OF_LIGHT,
            departure: scale(self.from, 1.0 / self.there),
            arrival: scale(self.to, 1.0 / self.back),
        }
    }
}

/// A wave scattered at `centre` with the root of the cross section `root` in m.
pub fn scattered(scene: &Scene, centre: Vec3, root: f64, lambda: f64, phase: f64) -> Path {
    let way = Way::of(scene, centre);
    way.path(carrier_phase(way.length(), lambda) * phasor(phase), root, lambda)
}

/// The direct path between two antennas; `None` for the radar, which has none.
pub fn direct(scene: &Scene, lambda: f64) -> Option<Path> {
    if scene.monostatic() {
        return None;
    }
    let length = scene.distance_m().max(NEAREST_M);
    let gain = carrier_phase(length, lambda) * free_space(length, lambda);
    let arrival = scale(sub(scene.from, scene.to), 1.0 / length);
    let departure = scale(arrival, -1.0);
    Some(Path { gain, delay_s: length / SPEED_OF_LIGHT, departure, arrival })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulator::body::motion::GroundTruth;

    #[test]
    fn the_spreading_is_a_power_of_four_pi() {
        assert_eq!(SPREADING, libm::pow(4.0 * PI, 1.5));
    }

    #[test]
    fn a_sphere_at_two_metres_echoes_by_the_radar_equation() {
        let scene = Scene { slot: 0, time_s: 0.0, from: [0.0; 3], to: [0.0; 3], people: &[] };
        let lambda = 0.1;
        let path = scattered(&scene, [2.0, 0.0, 0.0], 0.5, lambda, 0.0);
        // P_r / P_t = lambda^2 sigma / ((4 pi)^3 D^4)
        let exact = 0.01 * 0.25 / (libm::pow(4.0 * PI, 3.0) * 16.0);
        assert!((path.gain.norm_sqr() / exact - 1.0).abs() < 1e-12);
        assert!((path.delay_s * SPEED_OF_LIGHT - 4.0).abs() < 1e-12);
        // forty whole wavelengths there and back
        assert!((path.gain.arg()).abs() < 1e-9);
    }

    #[test]
    fn the_mean_echo_is_that_of_the_primitives_within_three_decibels() {
        let truth = GroundTruth::standing(1.75, [1.5, 3.0]);
        let mut random = Random::new(1, 0, 0, 0);
        let (mut whole, mut limbs) = (0.0, 0.0);
        for degrees in (0..360).step_by(10) {
            let truth = GroundTruth { heading_deg: f64::from(degrees), ..truth.clone() };
            let target = Target::new(Person::new(truth, [3.0, 4.5, 3.0], &mut random), &mut random);
            let radar = [1.5, 1.0, 1.0];
            let scene = Scene { slot: 0, time_s: 0.0, from: radar, to: radar, people: &[] };
            let mut paths = Vec::new();
            target.echoes(&scene, 0.0857, &mut paths);
            limbs += paths.iter().map(|p| p.gain.norm_sqr()).sum::<f64>();
            whole += target.mean_echo(&scene, 0.0, 0.0857, 0.0).gain.norm_sqr();
        }
        let db = 10.0 * libm::log10(limbs / whole);
        assert!(db.abs() < 3.0, "{db}");
    }
}
