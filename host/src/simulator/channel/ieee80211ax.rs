//! `80211ax`: TGn channel models A to F, which TGac and TGax keep for indoor rooms up to 40 MHz.
//!
//! 11-03/940r4 with 11-09/0308 and 11-14/0882: overlapping clusters on taps ([`super::tgn`]), a line of sight on the first tap within the
//! break point, Rayleigh taps; their bell spectrum 1 / (1 + 9 (f / f_d)^2) is that of a first-order recursion with
//! rho = exp(-2 pi f_d T / 3). Within a cluster the power azimuth spectrum is Laplacian: a tap is a sum of plane waves of drawn
//! directions, so that antennas apart from each other see it with the correlation that this spectrum makes.

use super::autoregressive::{Ar1Process, Innovation};
use super::ieee80211ay::Ray;
use super::room::{conference_room, isotropic_power};
use super::target::direct;
use super::tgn::{table, tap_powers};
use super::{ChannelModel, Complex64, Path, Scene, carrier_phase, free_space, wavelength};
use crate::numerics::random::Random;
use crate::scenario::{Advance, ArMode, Channel, SPEED_OF_LIGHT, Scenario};
use crate::simulator::body::{Vec3, dot, sub};
use std::f64::consts::{FRAC_1_SQRT_2, PI};

/// Mean power ratio between two points by the models' path loss: free space up to the break point, then 35 dB a decade; for
/// the radar, the room's mean.
fn mean_gain(scenario: &Scenario, (from, to): (Vec3, Vec3)) -> f64 {
    if from == to {
        return isotropic_power(scenario);
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
/// direct path for a receiver.
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

/// Plane waves of a tap's share in a cluster.
const WAVES: usize = 20;

/// The same taps, every cluster's share as plane waves with Laplacian azimuths. A radar's waves come back where they left.
fn waves(scenario: &Scenario, ends: (Vec3, Vec3), random: &mut Random) -> Vec<Ray> {
    let (model, taps) = (scenario.channel.tgn, taps(scenario, ends));
    let power = |db: &f64| libm::pow(10.0, db / 10.0);
    let clusters = table(model).clusters;
    let printed: f64 = clusters.iter().flat_map(|cluster| cluster.db).map(power).sum();
    let all: f64 = taps.iter().map(|tap| tap.amplitude * tap.amplitude).sum();
    let mut waves = Vec::new();
    for cluster in clusters {
        for (tap, db) in taps[cluster.first..].iter().zip(cluster.db) {
            for _ in 0..WAVES {
                let mut towards = |[mean, spread]: [f64; 2]| {
                    let azimuth = (mean + spread * random.laplacian()) * PI / 180.0;
                    [libm::cos(azimuth), libm::sin(azimuth), 0.0]
                };
                let arrival = towards(cluster.arrival);
                let departure = if ends.0 == ends.1 { arrival } else { towards(cluster.departure) };
                let amplitude = (all * power(db) / (printed * WAVES as f64)).sqrt();
                waves.push(Ray { amplitude, departure, arrival, fixed: None, ..*tap });
            }
        }
    }
    waves
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
        let waves = waves(scenario, ends, &mut random);
        let room = Ar1Process::new(&channel, waves, Innovation::Gaussian, rho(ROOM_M_S), 0);
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
        let begin = paths.len();
        self.room.paths(paths);
        // plane waves: a step towards one shortens it
        let (from, to) = (sub(scene.from, self.ends.0), sub(scene.to, self.ends.1));
        if from != [0.0; 3] || to != [0.0; 3] {
            for path in &mut paths[begin..] {
                path.gain *= carrier_phase(-dot(path.departure, from) - dot(path.arrival, to), self.lambda);
            }
        }
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
    use crate::scenario::Tgn;

    const ENDS: (Vec3, Vec3) = ([1.5, 1.0, 1.0], [1.5, 3.0, 1.0]);
    /// Each model with its rms delay spread in ns and its K factor in dB.
    const MODELS: [(Tgn, f64, f64); 6] = [
        (Tgn::A, 0.0, 0.0),
        (Tgn::B, 15.0, 0.0),
        (Tgn::C, 30.0, 0.0),
        (Tgn::D, 50.0, 3.0),
        (Tgn::E, 100.0, 6.0),
        (Tgn::F, 150.0, 6.0),
    ];

    fn of(tgn: Tgn) -> Scenario {
        let mut scenario = Scenario::default();
        scenario.channel.tgn = tgn;
        scenario
    }

    #[test]
    fn rms_delay_spreads_are_the_standards() {
        for (model, exact, k_db) in MODELS {
            let scenario = of(model);
            let waves = waves(&scenario, ENDS, &mut Random::new(1, 0, 0, 0));
            let first = waves[0].delay_s;
            let moment = |n: i32| -> f64 {
                waves.iter().map(|w| w.amplitude * w.amplitude * ((w.delay_s - first) * 1e9).powi(n)).sum()
            };
            let (power, mean) = (moment(0), moment(1) / moment(0));
            let spread = (moment(2) / power - mean * mean).max(0.0).sqrt();
            assert!((spread - exact).abs() <= 1e-6 * exact, "{model:?}: {spread}");
            // the printed grid is 10 ns
            assert!(model == Tgn::A || (0.88..1.03).contains(&(tap_powers(model)[1].0 / 10e-9)), "{model:?}");
            // what comes directly, over the first tap
            let mut paths = Vec::new();
            let scene = Scene { slot: 0, time_s: 0.0, from: ENDS.0, to: ENDS.1, people: &[] };
            Indoor::new(&scenario, ENDS, Random::new(1, 0, 0, 0)).paths(&scene, &mut paths);
            let of_first = |w: &&Ray| w.delay_s == first;
            let tap: f64 = waves.iter().filter(of_first).map(|w| w.amplitude * w.amplitude).sum();
            let k = 10.0 * libm::log10(paths[0].gain.norm_sqr() / tap);
            println!(
                "number: TGn {model:?}: rms delay spread {spread:.2} ns ({exact}), K {k:.2} dB ({k_db})"
            );
            assert!((k - k_db).abs() < 0.13, "{model:?}: {k} dB");
        }
    }

    #[test]
    fn angular_spreads_are_the_standards() {
        for (model, ..) in MODELS {
            let clusters = table(model).clusters;
            let mut sums = vec![[[0.0; 2]; 2]; clusters.len()];
            for index in 0..600 {
                let waves = waves(&of(model), ENDS, &mut Random::new(2, 0, 0, index));
                let owners = clusters.iter().enumerate().flat_map(|(n, c)| vec![n; c.db.len() * WAVES]);
                for (wave, n) in waves.iter().zip(owners) {
                    for (sum, towards) in sums[n].iter_mut().zip([wave.arrival, wave.departure]) {
                        sum[0] += towards[0];
                        sum[1] += towards[1];
                    }
                }
            }
            let mut worst = [1.0_f64, 1.0];
            for (cluster, sums) in clusters.iter().zip(&sums) {
                for ([mean, spread], [x, y]) in [cluster.arrival, cluster.departure].into_iter().zip(sums) {
                    // a Laplacian's characteristic function is 1 / (1 + sigma^2 / 2), whole turns or not
                    let length = (x * x + y * y).sqrt() / (cluster.db.len() * WAVES * 600) as f64;
                    let found = (2.0 * (1.0 / length - 1.0)).sqrt() * 180.0 / PI;
                    let azimuth = libm::atan2(*y, *x) * 180.0 / PI;
                    let off = (azimuth - mean + 540.0).rem_euclid(360.0) - 180.0;
                    if (found / spread - 1.0).abs() > (worst[0] / worst[1] - 1.0).abs() {
                        worst = [found, spread];
                    }
                    assert!(
                        (found / spread - 1.0).abs() < 0.03 && off.abs() < 1.5,
                        "{model:?}: {found} {spread} {off}"
                    );
                }
            }
            let [found, spread] = worst;
            println!(
                "number: TGn {model:?}: angular spread farthest from the table {found:.2} degrees ({spread})"
            );
        }
    }

    #[test]
    fn a_half_wave_array_has_the_correlation_of_the_angular_spectrum() {
        for (model, ..) in MODELS {
            let scenario = of(model);
            let lambda = wavelength(scenario.radar.carrier_hz);
            let clusters = table(model).clusters;
            let share = |n: usize| clusters[n].db.iter().map(|db| libm::pow(10.0, db / 10.0)).sum::<f64>();
            let all: f64 = (0..clusters.len()).map(share).sum();
            // first row of the matrix of four antennas along x, integrated over the Laplacian spectra
            let exact = |antenna: u32| -> Complex64 {
                let phase = PI * f64::from(antenna);
                let integral = |n: usize| -> Complex64 {
                    let [mean, spread] = clusters[n].arrival.map(|deg| deg * PI / 180.0);
                    let step = spread / 200.0;
                    let at = |k: i32| {
                        let x = f64::from(k) * step;
                        let density =
                            libm::exp(-2.0_f64.sqrt() * x.abs() / spread) / (2.0_f64.sqrt() * spread);
                        super::super::phasor(phase * libm::cos(mean + x)) * (density * step)
                    };
                    (-3000..=3000).map(at).sum::<Complex64>() * (share(n) / all)
                };
                (0..clusters.len()).map(integral).sum()
            };
            let mut row = [Complex64::default(); 4];
            let n = 400;
            for index in 0..n {
                // the same draw at four places
                let at = |antenna: u32| {
                    let mut model = Indoor::new(&scenario, ENDS, Random::new(3, 0, 0, index));
                    let mut paths = Vec::new();
                    let to = [ENDS.1[0] + 0.5 * lambda * f64::from(antenna), ENDS.1[1], ENDS.1[2]];
                    model.paths(&Scene { slot: 0, time_s: 0.0, from: ENDS.0, to, people: &[] }, &mut paths);
                    paths.split_off(1)
                };
                let first = at(0);
                let power: f64 = first.iter().map(|path| path.gain.norm_sqr()).sum();
                for (antenna, sum) in row.iter_mut().enumerate() {
                    // waves are independent of each other: only each with itself counts
                    let waves = at(antenna as u32).into_iter().zip(&first);
                    *sum +=
                        waves.map(|(a, b)| a.gain * b.gain.conj()).sum::<Complex64>() / (power * n as f64);
                }
            }
            for (antenna, found) in row.iter().enumerate().skip(1) {
                let exact = exact(antenna as u32);
                println!(
                    "number: TGn {model:?}: correlation {:.1} wavelengths apart {found:.3} ({exact:.3})",
                    0.5 * antenna as f64
                );
                assert!((found - exact).norm_sqr() < 0.03 * 0.03, "{model:?}, {antenna}: {found} {exact}");
            }
        }
    }

    #[test]
    fn the_mean_gain_is_free_space_within_the_break_point() {
        let scenario = Scenario::default();
        let mut sum = 0.0;
        for index in 0..2000 {
            let mut model = Indoor::new(&scenario, ENDS, Random::new(1, 0, 0, index));
            let mut paths = Vec::new();
            let scene = Scene { slot: 0, time_s: 0.0, from: ENDS.0, to: ENDS.1, people: &[] };
            model.paths(&scene, &mut paths);
            sum += paths.iter().map(|p| p.gain.norm_sqr()).sum::<f64>() / 2000.0;
        }
        let free = free_space(2.0, wavelength(3.5e9));
        assert!((sum / (free * free) - 1.0).abs() < 0.03, "{}", sum / (free * free));
    }
}
