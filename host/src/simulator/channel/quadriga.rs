//! `quadriga`: drifting clusters after QuaDRiGa.
//!
//! The clusters of TR 38.901 become scatterers at fixed places (the last bounce) for half a metre of the receiver's track; delays, angles and
//! phases follow from exact distances in every slot. At the border of two segments their powers are cross-faded. Terminals
//! move, scatterers do not: a person stays, within a segment, where the segment began.

use super::room::isotropic_power;
use super::target::direct;
use super::tr38901::{Office, Parameters, between, direction};
use super::{ChannelModel, Path, Scene, carrier_phase, phasor, wavelength};
use crate::numerics::random::Random;
use crate::scenario::{SPEED_OF_LIGHT, Scenario};
use crate::simulator::body::{Vec3, add, dot, scale, sub};

/// Length of a segment in m.
const SEGMENT_M: f64 = 0.5;
/// Its last part, in which the next one is faded in, in m.
const FADE_M: f64 = 0.1;
/// Rays of a cluster that become scatterers.
const RAYS: usize = 20;

/// One scatterer: its place, the length of the path from the transmitter to it beyond the straight one, amplitude and phase.
#[derive(Debug, Clone)]
struct Scatterer {
    place: Vec3,
    detour_m: f64,
    amplitude: f64,
    phase: f64,
}

/// The clusters of one segment of the track.
#[derive(Debug, Clone)]
struct Segment {
    begun: Vec3,
    person_t: f64,
    scatterers: Vec<Scatterer>,
    direct: f64,
}

#[derive(Debug)]
pub struct Drifting {
    office: Office,
    carrier_hz: f64,
    room_power: f64,
    phase: f64,
    /// The segment that fades out and the one that plays.
    before: Option<Segment>,
    now: Option<Segment>,
}

impl Drifting {
    /// Draws the fields behind the segments.
    pub fn new(scenario: &Scenario, mut random: Random) -> Self {
        let parameters = Parameters::indoor_office(scenario.radar.carrier_hz, scenario.channel.line_of_sight);
        Drifting {
            office: Office::new(parameters, &mut random),
            carrier_hz: scenario.radar.carrier_hz,
            room_power: isotropic_power(scenario),
            phase: std::f64::consts::TAU * random.uniform(),
            before: None,
            now: None,
        }
    }

    /// What moves: the receiver, or for the radar the first person.
    fn mobile(scene: &Scene) -> Vec3 {
        match scene.people.first() {
            Some(person) if scene.monostatic() => person.centre(scene.time_s),
            _ => scene.to,
        }
    }

    fn begin(&self, scene: &Scene) -> Segment {
        let place = if scene.monostatic() { Self::mobile(scene) } else { scene.to };
        let drop = self.office.at(place);
        let distance = scene.distance_m();
        let gain = if scene.monostatic() {
            self.room_power / (1.0 - drop.direct)
        } else {
            let loss = self.office.parameters.path_loss_db(distance, self.carrier_hz);
            libm::pow(10.0, (drop.shadow_db - loss) / 10.0)
        };
        let towards = if scene.monostatic() {
            [1.0, 0.0, 0.0]
        } else {
            super::ieee80211ay::unit(sub(scene.from, scene.to))
        };
        // a monostatic radar's first path is 2 m long
        let shortest = if scene.monostatic() { 2.0 } else { distance };
        let mut scatterers = Vec::with_capacity(drop.clusters.len() * RAYS);
        for (n, cluster) in drop.clusters.iter().enumerate() {
            let length = (shortest + SPEED_OF_LIGHT * cluster.delay_s).max(shortest * 1.001);
            for ray in 0..RAYS {
                let arrival = direction(towards, self.office.ray_angles(cluster, ray));
                // the last bounce lies on the ellipse of this length: a = (L^2 - d^2) / (2 (L - d cos))
                let cosine = dot(arrival, towards);
                let away =
                    (length * length - distance * distance) / (2.0 * (length - distance * cosine)).max(1e-6);
                let place = add(scene.to, scale(arrival, away));
                scatterers.push(Scatterer {
                    detour_m: length - away - between(place, scene.from),
                    place,
                    amplitude: (gain * cluster.power / RAYS as f64).sqrt(),
                    phase: self.office.phase(n, ray),
                });
            }
        }
        Segment {
            begun: Self::mobile(scene),
            person_t: scene.time_s,
            scatterers,
            direct: (gain * drop.direct).sqrt(),
        }
    }

    fn play(&self, segment: &Segment, scene: &Scene, share: f64, paths: &mut Vec<Path>) {
        let lambda = wavelength(self.carrier_hz);
        let ramp = share.sqrt();
        if segment.direct > 0.0 {
            paths.extend(direct(scene, lambda).map(|path| {
                let unit = path.gain / path.gain.norm();
                Path { gain: unit * (segment.direct * ramp), ..path }
            }));
        }
        for s in &segment.scatterers {
            let offset = sub(s.place, scene.to);
            let back = between(s.place, scene.to);
            let length = between(s.place, scene.from) + s.detour_m + back;
            paths.push(Path {
                gain: carrier_phase(length, lambda) * phasor(s.phase) * (s.amplitude * ramp),
                delay_s: length / SPEED_OF_LIGHT,
                departure: scale(sub(s.place, scene.from), 1.0 / between(s.place, scene.from).max(1e-6)),
                arrival: scale(offset, 1.0 / back.max(1e-6)),
            });
        }
        for person in scene.people {
            let mut path = person.mean_echo(scene, segment.person_t, lambda, self.phase);
            path.gain *= ramp;
            paths.push(path);
        }
    }
}

impl ChannelModel for Drifting {
    fn paths(&mut self, scene: &Scene, paths: &mut Vec<Path>) {
        let mobile = Self::mobile(scene);
        if self.now.as_ref().is_none_or(|segment| between(segment.begun, mobile) > SEGMENT_M - FADE_M) {
            self.before = self.now.take();
            self.now = Some(self.begin(scene));
        }
        let Some(now) = &self.now else { return };
        let walked = (between(now.begun, mobile) / FADE_M).min(1.0);
        match &self.before {
            Some(before) if walked < 1.0 => {
                self.play(before, scene, 1.0 - walked, paths);
                self.play(now, scene, walked, paths);
            }
            _ => self.play(now, scene, 1.0, paths),
        }
        if walked >= 1.0 {
            self.before = None;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_segments_delays_are_its_drops() {
        let scenario = Scenario::default();
        let model = Drifting::new(&scenario, Random::new(2, 0, 0, 0));
        let scene = Scene { slot: 0, time_s: 0.0, from: [1.5, 1.0, 1.0], to: [1.2, 3.4, 1.2], people: &[] };
        let segment = model.begin(&scene);
        let drop = model.office.at(scene.to);
        for (k, s) in segment.scatterers.iter().enumerate() {
            let length = between(s.place, scene.from) + s.detour_m + between(s.place, scene.to);
            let exact = scene.distance_m() + SPEED_OF_LIGHT * drop.clusters[k / RAYS].delay_s;
            assert!((length - exact.max(scene.distance_m() * 1.001)).abs() < 1e-9);
            assert!(s.detour_m.abs() < 1e-9, "single bounce: {}", s.detour_m);
        }
    }

    #[test]
    fn power_is_kept_where_segments_meet() {
        let scenario = Scenario::default();
        let mut model = Drifting::new(&scenario, Random::new(3, 0, 0, 0));
        let mut last: Option<f64> = None;
        for slot in 0..1500 {
            let y = 2.0 + 1e-3 * f64::from(slot);
            let scene = Scene { slot, time_s: 0.0, from: [1.5, 1.0, 1.0], to: [1.2, y, 1.0], people: &[] };
            let mut paths = Vec::new();
            model.paths(&scene, &mut paths);
            let power: f64 = paths.iter().map(|p| p.gain.norm_sqr()).sum();
            if let Some(last) = last {
                assert!((power / last - 1.0).abs() < 0.05, "slot {slot}: {power} after {last}");
            }
            last = Some(power);
        }
    }
}
