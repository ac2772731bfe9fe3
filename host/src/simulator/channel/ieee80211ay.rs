//! `80211ay`: the quasi-deterministic rooms of IEEE 802.11ad/ay.
//!
//! 11-09/0334r8, 11-15/1150: image-method clusters with lognormal losses and blockage, each a bundle of rays before and after
//! its central one ([`bundle`]), and a polarisation matrix per cluster. The room's phases are drawn once; a person is one more cluster of
//! fixed phase. Losses, blockage and polarisation are those of the conference room between two stations in every environment.

use super::room::{LOSS_DB, Reflection, conference_room};
use super::target::direct;
use super::{ChannelModel, Complex64, Path, Scene, carrier_phase, free_space, phasor, wavelength};
use crate::numerics::random::Random;
use crate::scenario::{Environment, Polarisation, Scenario};
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

/// The rays of a cluster besides the central one: (rays, K factor in dB, decay in ns, arrival rate in 1/ns, sign of the delay) before and
/// after it, and the standard deviation of their angles in degrees.
type Bundle = ([(usize, f64, f64, f64, f64); 2], f64);

/// An environment's bundle: the conference room's is 11-09/0334r8's, the others are those of 11-15/1150 as the NIST Q-D software lists them.
pub fn bundle(environment: Environment) -> Bundle {
    let none = (0, 0.0, 1.0, 1.0, -1.0);
    match environment {
        Environment::ConferenceRoom => ([(6, 10.0, 3.7, 0.37, -1.0), (8, 14.2, 4.5, 0.31, 1.0)], 5.0),
        Environment::LivingRoom => ([(6, 11.5, 1.25, 0.29, -1.0), (8, 10.9, 8.7, 1.0, 1.0)], 10.0),
        Environment::Cubicle => ([(6, 5.0, 3.7, 0.37, -1.0), (8, 10.0, 4.5, 0.31, 1.0)], 5.0),
        Environment::HotelLobby => ([none, (6, 10.0, 4.5, 0.31, 1.0)], 5.0),
        Environment::OpenArea => ([none, (4, 4.0, 4.5, 0.31, 1.0)], 5.0),
    }
}

/// Rays of one cluster: Poisson arrivals, Rayleigh amplitudes, exponential decay, normal angles.
pub fn draw_rays((sides, angle_deg): Bundle, random: &mut Random) -> Vec<Offset> {
    let mut rays = vec![Offset { amplitude: 1.0, delay_s: 0.0, angle: [0.0; 2], central: true }];
    for (count, k_db, decay, arrival, sign) in sides {
        let mut delay = 0.0;
        for _ in 0..count {
            delay -= libm::log(1.0 - random.uniform()) / arrival;
            let mean_power = libm::exp(-delay / decay) * libm::pow(10.0, -k_db / 10.0);
            let (x, y) = (random.gaussian(), random.gaussian());
            let amplitude = (mean_power * (x * x + y * y) / 2.0).sqrt();
            let angle =
                [angle_deg * PI / 180.0 * random.gaussian(), angle_deg * PI / 180.0 * random.gaussian()];
            rays.push(Offset { amplitude, delay_s: sign * delay * 1e-9, angle, central: false });
        }
    }
    let energy: f64 = rays.iter().map(|r| r.amplitude * r.amplitude).sum();
    rays.iter_mut().for_each(|r| r.amplitude /= energy.sqrt());
    rays
}

/// What the polarisation matrix of 11-09/0334r8 makes of a reflection with the amplitude `loss`: R11 from vertical to vertical, R22 from
/// horizontal to horizontal, or the cross term from vertical to horizontal, which does not depend on the loss.
fn polarised(polarisation: Polarisation, r: &Reflection, loss: f64, random: &mut Random) -> f64 {
    let positive = match (polarisation, r.order, r.ceiling) {
        (Polarisation::Crossed, 1, _) => return if random.uniform() < 0.5 { 0.1 } else { -0.1 },
        (Polarisation::Crossed, ..) => return 0.2 * random.uniform() - 0.1,
        (Polarisation::Vertical, 1, ceiling) => ceiling,
        (Polarisation::Horizontal, 1, ceiling) => !ceiling,
        (_, _, true) => false,
        (Polarisation::Vertical, ..) => true,
        (Polarisation::Horizontal, ..) => random.uniform() < 0.87,
    };
    if positive { loss } else { -loss }
}

/// A direction rotated by an azimuth and an elevation.
pub fn rotated([x, y, z]: Vec3, [azimuth, elevation]: [f64; 2]) -> Vec3 {
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
    let bundle = bundle(scenario.channel.environment);
    let mut rays = Vec::new();
    for (reflection, blocked) in room.iter().zip(blockage) {
        let loss = draw_loss_db(reflection.order, random) + blocked;
        let amplitude = libm::pow(10.0, loss / 20.0) * free_space(reflection.length_m, lambda);
        for offset in draw_rays(bundle, random) {
            let delay_s = reflection.delay_s() + offset.delay_s;
            if delay_s < 0.0 {
                continue;
            }
            rays.push(Ray {
                amplitude: amplitude * offset.amplitude,
                delay_s,
                departure: rotated(reflection.departure, offset.angle),
                arrival: rotated(reflection.arrival, offset.angle),
                fixed: offset.central.then(|| carrier_phase(reflection.length_m, lambda).arg()),
            });
        }
    }
    rays
}

/// Mean cross-polar ratio of a person in dB, of 3GPP TR 38.901's sensing additions: IEEE has none.
const PERSON_XPR_DB: f64 = 19.81;

/// The model: rays of a room that keeps them.
#[derive(Debug)]
pub struct ConferenceRoom {
    lambda: f64,
    size: Vec3,
    ends: (Vec3, Vec3),
    /// Signed amplitude and bundle (with phases) of each reflection.
    clusters: Vec<(f64, Vec<(Offset, Complex64)>)>,
    person: f64,
    /// Whether the receiver has the other polarisation: it gets nothing directly.
    crossed: bool,
}

impl ConferenceRoom {
    /// Draws the losses and the bundles once.
    pub fn new(scenario: &Scenario, (from, to): (Vec3, Vec3), random: &mut Random) -> Self {
        let room = conference_room(scenario.room.size_m, from, to);
        let blockage =
            if scenario.channel.blockage { blockage_db(&room, random) } else { vec![0.0; room.len()] };
        let bundle = bundle(scenario.channel.environment);
        let cluster = |(reflection, blocked): (&Reflection, &f64)| {
            let loss_db = draw_loss_db(reflection.order, random);
            let phased = draw_rays(bundle, random).into_iter().map(|offset| {
                let phase = if offset.central { 0.0 } else { 2.0 * PI * random.uniform() };
                (offset, phasor(phase))
            });
            ([loss_db, *blocked].map(|db| libm::pow(10.0, db / 20.0)), phased.collect())
        };
        let drawn: Vec<([f64; 2], Vec<_>)> = room.iter().zip(&blockage).map(cluster).collect();
        let person = 2.0 * PI * random.uniform();
        let polarisation = scenario.channel.polarisation;
        let signed = |(reflection, ([loss, blocked], bundle)): (&Reflection, ([f64; 2], Vec<_>))| {
            (polarised(polarisation, reflection, loss, random) * blocked, bundle)
        };
        ConferenceRoom {
            lambda: wavelength(scenario.radar.carrier_hz),
            size: scenario.room.size_m,
            ends: (from, to),
            clusters: room.iter().zip(drawn).map(signed).collect(),
            person,
            crossed: polarisation == Polarisation::Crossed,
        }
    }
}

impl ChannelModel for ConferenceRoom {
    fn paths(&mut self, scene: &Scene, paths: &mut Vec<Path>) {
        paths.extend(direct(scene, self.lambda).filter(|_| !self.crossed));
        for (reflection, (loss, bundle)) in
            conference_room(self.size, scene.from, scene.to).iter().zip(&self.clusters)
        {
            let gain = carrier_phase(reflection.length_m, self.lambda)
                * (loss * free_space(reflection.length_m, self.lambda));
            for (offset, phase) in bundle {
                let delay_s = reflection.delay_s() + offset.delay_s;
                if delay_s >= 0.0 {
                    let arrival = rotated(reflection.arrival, offset.angle);
                    let departure = rotated(reflection.departure, offset.angle);
                    let gain = gain * phase * offset.amplitude;
                    paths.push(Path { gain, delay_s, departure, arrival });
                }
            }
        }
        // a person is a cluster where it first stood
        let ends = Scene { from: self.ends.0, to: self.ends.1, ..*scene };
        for person in scene.people {
            let mut path = person.mean_echo(&ends, 0.0, self.lambda, self.person);
            if self.crossed {
                path.gain *= libm::pow(10.0, -PERSON_XPR_DB / 20.0);
            }
            paths.push(path);
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
        for environment in Environment::ALL.into_iter().cycle().take(100) {
            let energy: f64 =
                draw_rays(bundle(environment), &mut random).iter().map(|r| r.amplitude * r.amplitude).sum();
            assert!((energy - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn arrivals_and_decays_are_the_standards() {
        for environment in Environment::ALL {
            arrivals_and_decays(environment);
        }
    }

    fn arrivals_and_decays(environment: Environment) {
        let mut random = Random::new(4, 0, 0, 0);
        let draws: Vec<_> = (0..40_000).map(|_| draw_rays(bundle(environment), &mut random)).collect();
        let mut first = 1;
        let (sides, angle_deg) = bundle(environment);
        for (count, k_db, decay, arrival, sign) in sides.into_iter().filter(|side| side.0 > 0) {
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
            let square = |ray: &Offset| ray.angle.iter().map(|x| x * x).sum::<f64>() / 2.0;
            let squares: f64 = draws.iter().flat_map(|rays| &rays[first..first + count]).map(square).sum();
            let angle = (squares / (draws.len() * count) as f64).sqrt() * 180.0 / PI;
            assert!((angle / angle_deg - 1.0).abs() < 0.02, "angles {angle}");
            println!(
                "number: {environment:?}, {} the central ray: K {k:.2} dB ({k_db}), decay {:.3} ns ({decay}), rate {:.4} /ns ({arrival}), angles \
                 {angle:.2} degrees ({angle_deg})",
                if sign < 0.0 { "before" } else { "after" },
                -1.0 / slope,
                1.0 / gap
            );
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

    #[test]
    fn polarisation_has_the_signs_and_cross_terms_of_the_matrix() {
        let mut scenario = Scenario::default();
        let ends = ([1.5, 1.0, 1.0], [1.5, 3.0, 1.0]);
        let mut draw = |polarisation, index| {
            scenario.channel.polarisation = polarisation;
            let model = ConferenceRoom::new(&scenario, ends, &mut Random::new(1, 0, 0, index));
            model.clusters.into_iter().map(|(amplitude, _)| amplitude).collect::<Vec<f64>>()
        };
        let n = 4000;
        let (mut cross, mut plus) = ([0.0; 2], 0.0);
        for index in 0..n {
            let (vertical, horizontal) =
                (draw(Polarisation::Vertical, index), draw(Polarisation::Horizontal, index));
            // ceiling, walls, walls with the ceiling, two walls: R11 + - - +, R22 - + - +-
            for (k, (v, h)) in vertical.iter().zip(&horizontal).enumerate() {
                assert_eq!(*v > 0.0, k == 0 || k >= 9, "{k}");
                assert!(v.abs() == h.abs() && (k >= 9 || (*h > 0.0) == (1..5).contains(&k)), "{k}");
            }
            plus += horizontal[9..].iter().filter(|h| **h > 0.0).count() as f64 / (8 * n) as f64;
            for (k, amplitude) in draw(Polarisation::Crossed, index).iter().enumerate() {
                let (order, of) = if k < 5 { (0, 5) } else { (1, 12) };
                cross[order] += amplitude * amplitude / (of * n) as f64;
            }
        }
        let db = cross.map(|power| 10.0 * libm::log10(power));
        println!(
            "number: cross-polar power of first order {:.2} dB (-20), of second {:.2} dB (0.1^2 / 3: -24.77); R22 of two walls is \
            positive with {plus:.3} (0.87)",
            db[0], db[1]
        );
        assert!((db[0] + 20.0).abs() < 1e-6 && (db[1] + 24.77).abs() < 0.1, "{db:?}");
        assert!((plus - 0.87).abs() < 0.01, "{plus}");
        // nothing comes directly
        let mut count = |polarisation| {
            scenario.channel.polarisation = polarisation;
            let mut paths = Vec::new();
            let scene = Scene { slot: 0, time_s: 0.0, from: ends.0, to: ends.1, people: &[] };
            ConferenceRoom::new(&scenario, ends, &mut Random::new(1, 0, 0, 0)).paths(&scene, &mut paths);
            paths.len()
        };
        assert_eq!(count(Polarisation::Crossed) + 1, count(Polarisation::Vertical));
    }
}
