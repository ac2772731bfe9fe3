//! `80211ax`: TGn channel models B to D, which TGac and TGax keep for indoor rooms up to 40 MHz.
//!
//! 11-03/940r4 with 11-09/0308 and 11-14/0882: overlapping clusters on 10 ns taps, a line of sight on the first tap within the
//! break point, Rayleigh taps; their bell spectrum 1 / (1 + 9 (f / f_d)^2) is that of a first-order recursion with
//! rho = exp(-2 pi f_d T / 3).

use super::autoregressive::{Ar1Process, Innovation};
use super::ieee80211ay::Ray;
use super::room::{conference_room, free_space, mean_power};
use super::target::direct;
use super::{ChannelModel, Complex64, Path, Scene, wavelength};
use crate::numerics::random::Random;
use crate::scenario::{Advance, ArMode, Channel, SPEED_OF_LIGHT, Scenario, Tgn};
use crate::simulator::body::Vec3;
use std::f64::consts::{FRAC_1_SQRT_2, PI};

/// A cluster: powers in dB from its first tap on, and its mean angle of arrival in degrees.
struct Cluster {
    first: usize,
    db: &'static [f64],
    arrival_deg: f64,
}

/// A model: tap delays in ns, the rms delay spread in s it is named for, clusters, break point in m, K factor of the first tap.
struct Table {
    delays_ns: &'static [f64],
    spread_s: f64,
    clusters: &'static [Cluster],
    break_m: f64,
    k: f64,
}

const B: Table = Table {
    delays_ns: &[0., 10., 20., 30., 40., 50., 60., 70., 80.],
    spread_s: 15e-9,
    clusters: &[
        Cluster { first: 0, db: &[0.0, -5.4, -10.8, -16.2, -21.7], arrival_deg: 4.39 },
        Cluster { first: 2, db: &[-3.2, -6.3, -9.4, -12.5, -15.6, -18.7, -21.8], arrival_deg: 118.43 },
    ],
    break_m: 5.0,
    k: 1.0,
};

const C: Table = Table {
    delays_ns: &[0., 10., 20., 30., 40., 50., 60., 70., 80., 90., 110., 140., 170., 200.],
    spread_s: 30e-9,
    clusters: &[
        Cluster {
            first: 0,
            db: &[0.0, -2.1, -4.3, -6.5, -8.6, -10.8, -13.0, -15.2, -17.3, -19.5],
            arrival_deg: 290.37,
        },
        Cluster { first: 6, db: &[-5.0, -7.2, -9.3, -11.5, -13.7, -15.8, -18.0, -20.2], arrival_deg: 332.38 },
    ],
    break_m: 5.0,
    k: 1.0,
};

const D: Table = Table {
    delays_ns: &[
        0., 10., 20., 30., 40., 50., 60., 70., 80., 90., 110., 140., 170., 200., 240., 290., 340., 390.,
    ],
    spread_s: 50e-9,
    clusters: &[
        Cluster {
            first: 0,
            db: &[
                0.0, -0.9, -1.7, -2.6, -3.5, -4.3, -5.2, -6.1, -6.9, -7.8, -9.0, -11.1, -13.7, -16.3, -19.3,
                -23.2,
            ],
            arrival_deg: 158.93,
        },
        Cluster { first: 10, db: &[-6.6, -9.5, -12.1, -14.7, -17.4, -21.9, -25.5], arrival_deg: 320.29 },
        Cluster { first: 14, db: &[-18.8, -23.2, -25.2, -26.7], arrival_deg: 276.12 },
    ],
    break_m: 10.0,
    k: 1.995_262_314_968_88, // 3 dB
};

fn table(model: Tgn) -> &'static Table {
    match model {
        Tgn::B => &B,
        Tgn::C => &C,
        Tgn::D => &D,
    }
}

/// Delay in s, mean power (they sum to 1) and mean azimuth of arrival in rad of each tap.
///
/// The printed tables have rms delay spreads of 15.65, 33.44 and 50.16 ns; delays, which nothing here ties to a grid, are scaled so
/// that the spreads are the nominal 15, 30 and 50 ns.
pub fn tap_powers(model: Tgn) -> Vec<(f64, f64, f64)> {
    let table = table(model);
    let mut taps: Vec<(f64, f64, f64, f64)> =
        table.delays_ns.iter().map(|ns| (ns * 1e-9, 0.0, 0.0, 0.0)).collect();
    for cluster in table.clusters {
        for (tap, db) in taps[cluster.first..].iter_mut().zip(cluster.db) {
            let power = libm::pow(10.0, db / 10.0);
            tap.1 += power;
            if power > tap.3 {
                (tap.2, tap.3) = (cluster.arrival_deg * PI / 180.0, power);
            }
        }
    }
    let moment = |n: i32| -> f64 { taps.iter().map(|tap| tap.1 * tap.0.powi(n)).sum() };
    let (total, mean) = (moment(0), moment(1) / moment(0));
    let scale = table.spread_s / (moment(2) / total - mean * mean).sqrt();
    taps.into_iter().map(|(delay, power, azimuth, _)| (delay * scale, power / total, azimuth)).collect()
}

/// Mean power ratio between two points by the models' path loss: free space up to the break point, then 35 dB a decade; for
/// the radar, the room's mean.
fn mean_gain(scenario: &Scenario, (from, to): (Vec3, Vec3)) -> f64 {
    if from == to {
        return mean_power(scenario);
    }
    let table = table(scenario.channel.tgn);
    let scene = Scene { slot: 0, time_s: 0.0, from, to, people: &[] };
    let distance = scene.distance_m().max(0.1);
    let free = free_space(distance.min(table.break_m), wavelength(scenario.radar.carrier_hz));
    free * free * libm::pow((distance / table.break_m).max(1.0), -3.5)
}

/// Share of the power that arrives directly: K times the first tap's, within the break point and never for the radar.
fn direct_share(scenario: &Scenario, (from, to): (Vec3, Vec3)) -> f64 {
    let table = table(scenario.channel.tgn);
    let scene = Scene { slot: 0, time_s: 0.0, from, to, people: &[] };
    if from == to || scene.distance_m() > table.break_m {
        return 0.0;
    }
    let first = tap_powers(scenario.channel.tgn)[0].1 * table.k;
    first / (1.0 + first)
}

/// The taps between two points as rays of unit-power processes: behind the shortest reflection for the radar, behind the
/// direct way for a receiver.
pub fn taps(scenario: &Scenario, ends: (Vec3, Vec3)) -> Vec<Ray> {
    let power = mean_gain(scenario, ends) * (1.0 - direct_share(scenario, ends));
    let scene = Scene { slot: 0, time_s: 0.0, from: ends.0, to: ends.1, people: &[] };
    let first = if scene.monostatic() {
        let room = conference_room(scenario.room.size_m, ends.0, ends.1);
        room.iter().map(|r| r.length_m).fold(f64::INFINITY, f64::min)
    } else {
        scene.distance_m()
    };
    let ray = |(n, (delay, share, azimuth)): (usize, (f64, f64, f64))| Ray {
        amplitude: (power * share).sqrt(),
        delay_s: first / SPEED_OF_LIGHT + delay,
        departure: [libm::cos(azimuth), libm::sin(azimuth), 0.0],
        arrival: [libm::cos(azimuth), libm::sin(azimuth), 0.0],
        fixed: (n == 0).then_some(0.0),
    };
    tap_powers(scenario.channel.tgn).into_iter().enumerate().map(ray).collect()
}

/// Speed of the scatterers in m/s: 0.089 km/h since TGac for the room; TGn's 1.2 km/h for the one that is a person.
const ROOM_M_S: f64 = 0.089 / 3.6;
const PERSON_M_S: f64 = 1.2 / 3.6;

/// The model: a Rician first tap and Rayleigh taps that fade slowly. A person is one more tap with the bell spectrum of people.
#[derive(Debug)]
pub struct Indoor {
    lambda: f64,
    direct: f64,
    room: Ar1Process,
    person: Complex64,
    person_rho: f64,
    ends: (Vec3, Vec3),
    random: Random,
}

impl Indoor {
    /// Draws the taps between two points.
    pub fn new(scenario: &Scenario, ends: (Vec3, Vec3), mut random: Random) -> Self {
        let lambda = wavelength(scenario.radar.carrier_hz);
        let rho = |speed: f64| libm::exp(-2.0 * PI / 3.0 * speed / lambda * scenario.interval_s());
        let channel = Channel {
            mode: ArMode::VariancePreserving,
            advance: Advance::SensingSlot,
            stationary_start: false,
            ..scenario.channel.clone()
        };
        let room = Ar1Process::new(&channel, taps(scenario, ends), Innovation::Gaussian, rho(ROOM_M_S), 0);
        Indoor {
            lambda,
            direct: (direct_share(scenario, ends) * mean_gain(scenario, ends)).sqrt(),
            room,
            person: Complex64::new(random.gaussian(), random.gaussian()) * FRAC_1_SQRT_2,
            person_rho: rho(PERSON_M_S),
            ends,
            random,
        }
    }
}

impl ChannelModel for Indoor {
    fn paths(&mut self, scene: &Scene, paths: &mut Vec<Path>) {
        self.room.step(&mut self.random);
        if let Some(path) = direct(scene, self.lambda) {
            let gain = path.gain / path.gain.norm() * self.direct;
            paths.push(Path { gain, ..path });
        }
        self.room.paths(paths);
        let draw = Complex64::new(self.random.gaussian(), self.random.gaussian()) * FRAC_1_SQRT_2;
        let rho = self.person_rho;
        self.person = self.person * rho + draw * (1.0 - rho * rho).sqrt();
        let ends = Scene { from: self.ends.0, to: self.ends.1, ..*scene };
        for person in scene.people {
            let mut path = person.mean_echo(&ends, 0.0, self.lambda, 0.0);
            path.gain *= self.person;
            paths.push(path);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rms_delay_spreads_are_the_standards() {
        for (model, exact) in [(Tgn::B, 15.0), (Tgn::C, 30.0), (Tgn::D, 50.0)] {
            let taps = tap_powers(model);
            let moment = |n: i32| -> f64 { taps.iter().map(|(d, p, _)| p * (d * 1e9).powi(n)).sum() };
            let spread = (moment(2) - moment(1) * moment(1)).sqrt();
            assert!((spread - exact).abs() < 1e-9, "{model:?}: {spread}");
            // the printed grid is 10 ns
            assert!((0.88..1.01).contains(&(taps[1].0 / 10e-9)), "{model:?}: {}", taps[1].0);
        }
    }

    #[test]
    fn the_mean_gain_is_free_space_within_the_break_point() {
        let scenario = Scenario::default();
        let ends = ([1.5, 1.0, 1.0], [1.5, 3.0, 1.0]);
        let mut sum = 0.0;
        for index in 0..2000 {
            let mut model = Indoor::new(&scenario, ends, Random::new(1, 0, 0, index));
            let mut paths = Vec::new();
            let scene = Scene { slot: 0, time_s: 0.0, from: ends.0, to: ends.1, people: &[] };
            model.paths(&scene, &mut paths);
            sum += paths.iter().map(|p| p.gain.norm_sqr()).sum::<f64>() / 2000.0;
        }
        let free = free_space(2.0, wavelength(3.5e9));
        assert!((sum / (free * free) - 1.0).abs() < 0.03, "{}", sum / (free * free));
    }
}
