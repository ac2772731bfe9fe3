//! `80211ay`: the quasi-deterministic conference room of IEEE 802.11ad/ay.
//!
//! 11-09/0334r8, 11-15/1150: image-method clusters with lognormal losses and blockage, each a bundle of rays before and after
//! its central one. The room's phases are drawn once; a person is one more cluster of fixed phase.

use super::room::{LOSS_DB, Reflection, conference_room, free_space};
use super::target::direct;
use super::{ChannelModel, Complex64, Path, Scene, carrier_phase, phasor, wavelength};
use crate::numerics::random::Random;
use crate::scenario::Scenario;
use crate::simulator::body::{Vec3, norm, scale};
use std::f64::consts::PI;

/// One ray of the room before its phase is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Amplitude ratio between isotropic antennas.
    pub amplitude: f64,
    pub delay_s: f64,
    /// Unit vector from the transmitter towards where it leaves.
    pub departure: Vec3,
    /// Unit vector from the receiver towards where it comes from.
    pub arrival: Vec3,
    /// Phase in rad of a ray that geometry gives; `None` for a diffuse one.
    pub fixed: Option<f64>,
}

/// A reflection loss in dB: normal, never above -2 dB.
pub fn draw_loss_db(order: u8, random: &mut Random) -> f64 {
    let (mean, deviation) = LOSS_DB[usize::from(order.clamp(1, 2)) - 1];
    truncated(mean, deviation, -2.0, random)
}

/// Normal with the part above `most` drawn again.
fn truncated(mean: f64, deviation: f64, most: f64, random: &mut Random) -> f64 {
    loop {
        let value = mean + deviation * random.gaussian();
        if value <= most {
            return value;
        }
    }
}

/// One ray within a cluster: amplitude (the cluster's rays have unit energy), delay after the central ray in s, azimuth and
/// elevation away from it in rad, and whether it is the central one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Offset {
    pub amplitude: f64,
    /// Delay in s, negative before the central ray.
    pub delay_s: f64,
    /// Azimuth and elevation in rad.
    pub angle: [f64; 2],
    /// The central, geometric ray.
    pub central: bool,
}

/// (rays, K factor in dB, decay in ns, arrival rate in 1/ns, sign of the delay) before and after the central ray.
pub const BUNDLES: [(usize, f64, f64, f64, f64); 2] = [(6, 10.0, 3.7, 0.37, -1.0), (8, 14.2, 4.5, 0.31, 1.0)];

/// Rays of one cluster of the conference room: six before and eight after the central one, Poisson arrivals, Rayleigh
/// amplitudes, exponential decay, angles within 5 degrees.
pub fn draw_rays(random: &mut Random) -> Vec<Offset> {
    let mut rays = vec![Offset { amplitude: 1.0, delay_s: 0.0, angle: [0.0; 2], central: true }];
    for (count, k_db, decay, arrival, sign) in BUNDLES {
        let mut delay = 0.0;
        for _ in 0..count {
            delay -= libm::log(1.0 - random.uniform()) / arrival;
            let mean_power = libm::exp(-delay / decay) * libm::pow(10.0, -k_db / 10.0);
            let (x, y) = (random.gaussian(), random.gaussian());
            let amplitude = (mean_power * (x * x + y * y) / 2.0).sqrt();
            let angle = [5.0 * PI / 180.0 * random.gaussian(), 5.0 * PI / 180.0 * random.gaussian()];
            rays.push(Offset { amplitude, delay_s: sign * delay * 1e-9, angle, central: false });
        }
    }
    let energy: f64 = rays.iter().map(|r| r.amplitude * r.amplitude).sum();
    rays.iter_mut().for_each(|r| r.amplitude /= energy.sqrt());
    rays
}

/// A direction turned by an azimuth and an elevation.
pub fn turned([x, y, z]: Vec3, [azimuth, elevation]: [f64; 2]) -> Vec3 {
    let az = libm::atan2(y, x) + azimuth;
    let el = libm::asin(z.clamp(-1.0, 1.0)) + elevation;
    let across = libm::cos(el);
    [across * libm::cos(az), across * libm::sin(az), libm::sin(el)]
}

/// Extra loss in dB of each reflection by people and furniture in its way: which reflections may be blocked and how
/// often is the standard's table for stations at table height.
fn blockage_db(room: &[Reflection], random: &mut Random) -> Vec<f64> {
    let bernoulli = |random: &mut Random, p: f64| random.uniform() < p;
    let (mut wall, mut edge) = (0, 0);
    // one of the four walls, one of the four wall-ceiling edges
    let chosen = [(4.0 * random.uniform()) as usize, (4.0 * random.uniform()) as usize];
    room.iter()
        .map(|r| {
            let unblocked = match (r.order, r.ceiling) {
                (1, true) => 1.0,
                (1, false) => {
                    wall += 1;
                    if wall - 1 == chosen[0] { 0.76 } else { 1.0 }
                }
                (_, true) => {
                    edge += 1;
                    if edge - 1 == chosen[1] { 0.963 } else { 1.0 }
                }
                (_, false) => 0.825,
            };
            if bernoulli(random, unblocked) {
                0.0
            } else if r.ceiling {
                truncated(-18.4, 8.8, 0.0, random)
            } else if bernoulli(random, 0.83) {
                truncated(-18.2, 8.3, 0.0, random)
            } else {
                truncated(-47.2, 10.0, 0.0, random)
            }
        })
        .collect()
}

/// The rays of the room between two points, losses, blockage and bundles drawn.
pub fn rays(scenario: &Scenario, (from, to): (Vec3, Vec3), random: &mut Random) -> Vec<Ray> {
    let lambda = wavelength(scenario.radar.carrier_hz);
    let room = conference_room(scenario.room.size_m, from, to);
    let blockage = if scenario.channel.blockage { blockage_db(&room, random) } else { vec![0.0; room.len()] };
    let mut rays = Vec::new();
    for (reflection, blocked) in room.iter().zip(blockage) {
        let loss = draw_loss_db(reflection.order, random) + blocked;
        let amplitude = libm::pow(10.0, loss / 20.0) * free_space(reflection.length_m, lambda);
        for offset in draw_rays(random) {
            let delay_s = reflection.delay_s() + offset.delay_s;
            if delay_s < 0.0 {
                continue;
            }
            rays.push(Ray {
                amplitude: amplitude * offset.amplitude,
                delay_s,
                departure: turned(reflection.departure, offset.angle),
                arrival: turned(reflection.arrival, offset.angle),
                fixed: offset.central.then(|| carrier_phase(reflection.length_m, lambda).arg()),
            });
        }
    }
    rays
}

/// The model: rays of a room that keeps them.
#[derive(Debug)]
pub struct ConferenceRoom {
    lambda: f64,
    size: Vec3,
    ends: (Vec3, Vec3),
    /// Loss amplitude and bundle (with phases) of each reflection.
    clusters: Vec<(f64, Vec<(Offset, Complex64)>)>,
    person: f64,
}

impl ConferenceRoom {
    /// Draws the losses and the bundles once.
    pub fn new(scenario: &Scenario, (from, to): (Vec3, Vec3), random: &mut Random) -> Self {
        let room = conference_room(scenario.room.size_m, from, to);
        let blockage =
            if scenario.channel.blockage { blockage_db(&room, random) } else { vec![0.0; room.len()] };
        let cluster = |(reflection, blocked): (&Reflection, &f64)| {
            let loss = libm::pow(10.0, (draw_loss_db(reflection.order, random) + blocked) / 20.0);
            let bundle = draw_rays(random);
            let phased = bundle.into_iter().map(|offset| {
                let phase = if offset.central { 0.0 } else { 2.0 * PI * random.uniform() };
                (offset, phasor(phase))
            });
            (loss, phased.collect())
        };
        ConferenceRoom {
            lambda: wavelength(scenario.radar.carrier_hz),
            size: scenario.room.size_m,
            ends: (from, to),
            clusters: room.iter().zip(&blockage).map(cluster).collect(),
            person: 2.0 * PI * random.uniform(),
        }
    }
}

impl ChannelModel for ConferenceRoom {
    fn paths(&mut self, scene: &Scene, paths: &mut Vec<Path>) {
        paths.extend(direct(scene, self.lambda));
        for (reflection, (loss, bundle)) in
            conference_room(self.size, scene.from, scene.to).iter().zip(&self.clusters)
        {
            let gain = carrier_phase(reflection.length_m, self.lambda)
                * (loss * free_space(reflection.length_m, self.lambda));
            for (offset, phase) in bundle {
                let delay_s = reflection.delay_s() + offset.delay_s;
                if delay_s >= 0.0 {
                    let arrival = turned(reflection.arrival, offset.angle);
                    let departure = turned(reflection.departure, offset.angle);
                    let gain = gain * phase * offset.amplitude;
                    paths.push(Path { gain, delay_s, departure, arrival });
                }
            }
        }
        // a person is a cluster where it first stood
        let ends = Scene { from: self.ends.0, to: self.ends.1, ..*scene };
        for person in scene.people {
            paths.push(person.mean_echo(&ends, 0.0, self.lambda, self.person));
        }
    }
}

pub fn unit(v: Vec3) -> Vec3 {
    scale(v, 1.0 / norm(v).max(1e-12))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn losses_have_their_means_and_rays_unit_energy() {
        let mut random = Random::new(9, 0, 0, 0);
        for (order, mean) in [(1, -10.2), (2, -16.0)] {
            let sum: f64 = (0..40_000).map(|_| draw_loss_db(order, &mut random)).sum();
            assert!((sum / 40_000.0 - mean).abs() < 0.1, "order {order}: {}", sum / 40_000.0);
        }
        for _ in 0..100 {
            let energy: f64 = draw_rays(&mut random).iter().map(|r| r.amplitude * r.amplitude).sum();
            assert!((energy - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn arrivals_and_decays_are_the_standards() {
        let mut random = Random::new(4, 0, 0, 0);
        let draws: Vec<_> = (0..40_000).map(|_| draw_rays(&mut random)).collect();
        let mut first = 1;
        for (count, k_db, decay, arrival, sign) in BUNDLES {
            // mean gap between rays: 1 / arrival
            let last: f64 = draws.iter().map(|rays| sign * rays[first + count - 1].delay_s * 1e9).sum();
            let gap = last / (draws.len() * count) as f64;
            assert!((gap * arrival - 1.0).abs() < 0.02, "gap {gap}");
            // power relative to the central ray against delay: a weighted line through the logarithms of mean powers
            let mut bins = vec![(0.0, 0_u32); 24];
            for rays in &draws {
                let central = rays[0].amplitude * rays[0].amplitude;
                for ray in &rays[first..first + count] {
                    let bin = (sign * ray.delay_s * 1e9 / 0.5) as usize;
                    if let Some((power, n)) = bins.get_mut(bin) {
                        *power += ray.amplitude * ray.amplitude / central;
                        *n += 1;
                    }
                }
            }
            let (mut s, mut sx, mut sy, mut sxx, mut sxy) = (0.0, 0.0, 0.0, 0.0, 0.0);
            for (bin, (power, n)) in bins.iter().enumerate() {
                let (x, y, w) = ((bin as f64 + 0.5) * 0.5, libm::log(power / f64::from(*n)), f64::from(*n));
                s += w;
                sx += w * x;
                sy += w * y;
                sxx += w * x * x;
                sxy += w * x * y;
            }
            let slope = (s * sxy - sx * sy) / (s * sxx - sx * sx);
            let start = (sy - slope * sx) / s;
            assert!((-1.0 / slope / decay - 1.0).abs() < 0.02, "decay {}", -1.0 / slope);
            let k = -10.0 * libm::log10(libm::exp(start));
            assert!((k - k_db).abs() < 0.15, "K {k}");
            first += count;
        }
    }

    #[test]
    fn blockage_happens_as_often_as_the_table_says() {
        let room = conference_room([3.0, 4.5, 3.0], [1.5, 1.0, 1.0], [1.5, 3.0, 1.0]);
        let mut random = Random::new(2, 0, 0, 0);
        let n = 20_000;
        let mut blocked = vec![0_u32; room.len()];
        for _ in 0..n {
            for (count, db) in blocked.iter_mut().zip(blockage_db(&room, &mut random)) {
                *count += u32::from(db < 0.0);
            }
        }
        let share = |range: std::ops::Range<usize>| -> f64 {
            blocked[range].iter().map(|&c| f64::from(c)).sum::<f64>() / f64::from(n)
        };
        assert_eq!(blocked[0], 0); // the ceiling
        assert!((share(1..5) - 0.24).abs() < 0.01, "{}", share(1..5));
        assert!((share(5..9) - 0.037).abs() < 0.005, "{}", share(5..9));
        assert!((share(9..17) / 8.0 - 0.175).abs() < 0.01, "{}", share(9..17) / 8.0);
    }
}
