//! `dahc`: the paper's data-assisted hybrid channel, h = u + v.
//!
//! u is geometry (sixteen primitives per person), v the room's AR(1) response; rho is calibrated on data. With `mode = "rician"` v
//! is a constant mean m from geometry and a stationary fluctuation: E|v - m|^2 = |m|^2 / K as received, both through the radar's antenna.
//! The beats of a recording are formed several slots at a time.

use super::antenna::Antenna;
use super::autoregressive::{Ar1Process, Innovation};
use super::echo::{View, narrow_echo, wide_echo};
use super::ieee80211ax::taps;
use super::ieee80211ay::{Ray, rays};
use super::obstruction::{Obstruction, SPACING, share};
use super::response::Response;
use super::room::{StaticPath, received_power, static_paths};
use super::target::direct;
use super::{Blocks, ChannelModel, Path, Scene, Sensor, wavelength};
use crate::numerics::random::Random;
use crate::numerics::vectors::vectorised;
use crate::scenario::{ArMode, Scenario};
use crate::simulator::body::Vec3;
use crate::simulator::body::number::{LANES, Lanes};
use crate::simulator::body::primitives::PRIMITIVES;

#[derive(Debug, Clone)]
pub struct Dahc {
    lambda: f64,
    room: Ar1Process,
    mean: Vec<StaticPath>,
    /// The mean's range samples, once they are asked for.
    mean_parts: Vec<Blocks>,
    obstruction: Obstruction,
    random: Random,
}

/// The room's clusters at the scenario's carrier: 802.11ax's taps, 802.11ay's rays, or both by their share of the power.
fn clusters(scenario: &Scenario, ends: (Vec3, Vec3), random: &mut Random) -> (Vec<Ray>, Innovation) {
    let share = scenario.channel.clusters.share_80211ay(scenario.radar.carrier_hz);
    if share == 0.0 {
        return (taps(scenario, ends), Innovation::Gaussian);
    }
    let mut all = rays(scenario, ends, random);
    if share == 1.0 {
        return (all, Innovation::Phase);
    }
    all.iter_mut().for_each(|ray| ray.amplitude *= share.sqrt());
    let taps = taps(scenario, ends).into_iter();
    all.extend(taps.map(|ray| Ray { amplitude: ray.amplitude * (1.0 - share).sqrt(), ..ray }));
    (all, Innovation::Gaussian)
}

impl Dahc {
    /// Draws a room between two points.
    pub fn new(scenario: &Scenario, ends: (Vec3, Vec3), rho: f64, mut random: Random) -> Self {
        let (mut rays, innovation_kind) = clusters(scenario, ends, &mut random);
        let mut mean = Vec::new();
        if scenario.channel.mode == ArMode::Rician {
            mean = static_paths(scenario, ends.0, ends.1);
            let antenna = if ends.0 == ends.1 { Antenna::of(scenario) } else { Antenna::constant() };
            // geometry's own rays are the mean; the power of the others is stated as received, at the antenna's maximum
            if innovation_kind == Innovation::Phase {
                rays.retain(|ray| ray.fixed.is_none());
            }
            let power: f64 = rays.iter().map(|ray| ray.amplitude * ray.amplitude).sum();
            let k = libm::pow(10.0, scenario.channel.k_factor_db / 10.0);
            let scale = (received_power(&mean, &antenna) / (k * power)).sqrt();
            for ray in &mut rays {
                ray.amplitude *= scale;
                (ray.departure, ray.arrival) = (antenna.boresight(), antenna.boresight());
            }
        }
        let room =
            Ar1Process::new(&scenario.channel, rays, innovation_kind, rho, scenario.frame.spacing_slots);
        Dahc {
            lambda: wavelength(scenario.radar.carrier_hz),
            room,
            mean,
            mean_parts: Vec::new(),
            obstruction: Obstruction::new(scenario),
            random,
        }
    }

    /// Adds the mean's range samples of the slots from `scene` on.
    fn mean_beats(&mut self, scene: &Scene, sensor: &Sensor, beats: &mut [Blocks]) {
        if self.mean_parts.is_empty() {
            let part = |one: &StaticPath| {
                let mut blocks = Blocks::default();
                sensor.add(&mut blocks, &[one.path]);
                blocks
            };
            self.mean_parts = self.mean.iter().map(part).collect();
        }
        let sum = |amplitudes: &[f64]| {
            let mut sum = Blocks::default();
            for (k, part) in self.mean_parts.iter().enumerate() {
                let amplitude = amplitudes.get(k).copied().unwrap_or(1.0);
                sum.iter_mut().zip(part).for_each(|(sum, z)| *sum += z * amplitude);
            }
            sum
        };
        let mut around = (u32::MAX, [sum(&[]); 2]);
        for (n, beat) in beats.iter_mut().enumerate() {
            let slot = scene.slot + n as u32;
            if self.obstruction.is_on() && around.0 != slot / SPACING {
                let [a, b] = self.obstruction.nodes(scene, slot / SPACING, &self.mean);
                around = (slot / SPACING, [sum(&a.room), sum(&b.room)]);
            }
            let share = share(slot);
            for ((beat, a), b) in beat.iter_mut().zip(&around.1[0]).zip(&around.1[1]) {
                *beat += a + (b - a) * share;
            }
        }
    }
}

impl ChannelModel for Dahc {
    fn paths(&mut self, scene: &Scene, paths: &mut Vec<Path>) {
        self.room.step(&mut self.random);
        let kept = self.obstruction.is_on().then(|| self.obstruction.at(scene, &self.mean));
        let begin = paths.len();
        paths.extend(direct(scene, self.lambda));
        if let Some(kept) = &kept {
            paths[begin..].iter_mut().for_each(|path| path.gain *= kept.direct);
        }
        self.room.paths(paths);
        for (k, one) in self.mean.iter().enumerate() {
            let kept = kept.as_ref().map_or(1.0, |kept| kept.room[k]);
            paths.push(Path { gain: one.path.gain * kept, ..one.path });
        }
        for (number, person) in scene.people.iter().enumerate() {
            let begin = paths.len();
            person.echoes(scene, self.lambda, paths);
            if let Some(kept) = &kept {
                let kept = paths[begin..].iter_mut().zip(&kept.people[number]);
                kept.for_each(|(path, kept)| path.gain *= kept);
            }
        }
    }

    fn fluctuation(&mut self, sensor: &Sensor, beats: &mut [Blocks]) {
        self.room.beats(&mut self.random, sensor, beats);
    }

    fn steady_beats(&mut self, scene: &Scene, interval_s: f64, sensor: &Sensor, beats: &mut [Blocks]) {
        if !self.mean.is_empty() {
            self.mean_beats(scene, sensor, beats);
        }
        for (group, beats) in beats.chunks_mut(LANES).enumerate() {
            let first = (group * LANES) as u32;
            let kept: Option<[Vec<[f64; PRIMITIVES]>; LANES]> = self.obstruction.is_on().then(|| {
                std::array::from_fn(|lane| {
                    let n = first + (lane as u32).min(beats.len() as u32 - 1);
                    let time_s = scene.time_s + f64::from(n) * interval_s;
                    self.obstruction.people(&Scene { slot: scene.slot + n, time_s, ..*scene }, &self.mean)
                })
            });
            for (number, target) in scene.people.iter().enumerate() {
                let view = View {
                    radar: scene.to,
                    lambda: self.lambda,
                    begin_s: scene.time_s,
                    first,
                    interval_s,
                    kept: kept.as_ref().map(|kept| {
                        std::array::from_fn(|k| Lanes::new(kept.each_ref().map(|kept| kept[number][k])))
                    }),
                };
                vectorised(
                    #[inline(always)]
                    || match sensor.response {
                        Response::Paper => narrow_echo(sensor, target, &view, beats),
                        Response::Table(_) => wide_echo(sensor, target, &view, beats),
                    },
                );
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::{AntennaPattern, Class, Clusters};
    use crate::simulator::body::motion::Person;
    use crate::simulator::channel::target::Target;

    #[test]
    fn beats_agree_with_paths_to_eighty_decibels() {
        let shipped = |name: &str| crate::scenario::builtin::named(name.as_ref()).unwrap().scenario();
        let at = |carrier_hz| {
            let mut scenario = Scenario::default();
            scenario.radar.carrier_hz = carrier_hz;
            scenario
        };
        let real = |mut scenario: Scenario| {
            scenario.radar.antenna_pattern = AntennaPattern::Element;
            scenario.radar.sidelobe_db = 30.0;
            let channel = &mut scenario.channel;
            (channel.mode, channel.clusters) = (ArMode::Rician, Clusters::ByCarrier);
            (channel.shadowing, channel.occlusion) = (true, true);
            scenario
        };
        let all = [at(3.5e9), at(24e9), at(60e9), shipped("bgt60"), shipped("iwr")];
        for scenario in all.iter().cloned().chain(all.iter().cloned().map(real)) {
            let sensor = Sensor::of(&scenario);
            let radar = scenario.radar.position_m;
            let ends = (radar, radar);
            for class in Class::EVERY {
                let mut random = Random::new(4, 0, class as u64, 0);
                let person = Person::draw(class, &scenario.target, scenario.room.size_m, radar, &mut random);
                let people = [Target::new(person, &mut random)];
                let scene = Scene { slot: 0, time_s: 0.0, from: radar, to: radar, people: &people };
                let mut fast = vec![Blocks::default(); 203];
                let interval_s = scenario.interval_s();
                let mut model = Dahc::new(&scenario, ends, 0.997, random.clone());
                model.beats(&scene, interval_s, &sensor, &mut fast);
                let mut slow = Dahc::new(&scenario, ends, 0.997, random);
                let (mut error, mut power) = (0.0, 0.0);
                for (n, fast) in fast.iter().enumerate() {
                    let scene = Scene { slot: n as u32, time_s: n as f64 * interval_s, ..scene };
                    let mut paths = Vec::new();
                    slow.paths(&scene, &mut paths);
                    let mut exact = Blocks::default();
                    sensor.add(&mut exact, &paths);
                    // relative to the person alone, not to the louder room
                    let mut person = Blocks::default();
                    sensor.add(&mut person, &paths[paths.len() - PRIMITIVES..]);
                    error += fast.iter().zip(&exact).map(|(a, b)| (a - b).norm_sqr()).sum::<f64>();
                    power += person.iter().map(|z| z.norm_sqr()).sum::<f64>();
                }
                let db = 10.0 * libm::log10(error / power);
                // whoever sits, bends or lies has limbs before the torso, which echoes less: the series in the delays is as exact,
                // relative to less power
                let most = if class as usize <= Class::AdultRunning as usize { -80.0 } else { -65.0 };
                assert!(
                    db < most,
                    "{class:?}, {}, {:e} Hz: {db} dB",
                    scenario.name,
                    scenario.radar.carrier_hz
                );
            }
        }
    }

    /// The default room that was there before the recording began.
    fn settled() -> Scenario {
        let mut scenario = Scenario::default();
        (scenario.radar.antenna_pattern, scenario.radar.sidelobe_db) = (AntennaPattern::Element, 30.0);
        (scenario.channel.mode, scenario.channel.clusters) = (ArMode::Rician, Clusters::ByCarrier);
        scenario
    }

    #[test]
    fn the_fluctuation_lies_the_k_factor_below_the_mean_at_every_carrier() {
        for carrier_hz in [3.5e9, 24e9, 60e9] {
            let mut scenario = settled();
            scenario.radar.carrier_hz = carrier_hz;
            let (radar, sensor) = (scenario.radar.position_m, Sensor::of(&scenario));
            let scene = Scene { slot: 0, time_s: 0.0, from: radar, to: radar, people: &[] };
            let (mut fluctuation, mut mean) = (0.0, 0.0);
            for index in 0..600 {
                let random = Random::new(7, 0, 0, index);
                let mut room = Dahc::new(&scenario, (radar, radar), 0.997, random);
                let mut paths = Vec::new();
                room.paths(&scene, &mut paths);
                let fixed = paths.len() - room.mean.len();
                let power = |paths: &[Path]| -> f64 {
                    let one =
                        |p: &Path| p.gain.norm_sqr() * sensor.antenna.weight(p) * sensor.antenna.weight(p);
                    paths.iter().map(one).sum()
                };
                fluctuation += power(&paths[..fixed]);
                mean += power(&paths[fixed..]);
            }
            let db = 10.0 * libm::log10(mean / fluctuation);
            assert!((db - 15.0).abs() < 0.3, "{carrier_hz}: {db} dB");
        }
    }

    #[test]
    fn the_power_of_a_settled_room_does_not_change_while_it_is_recorded() {
        let scenario = settled();
        let (radar, sensor) = (scenario.radar.position_m, Sensor::of(&scenario));
        let scene = Scene { slot: 0, time_s: 0.0, from: radar, to: radar, people: &[] };
        let mut sums = [0.0; 2];
        for index in 0..40 {
            let mut beats = vec![Blocks::default(); 1000];
            let mut room = Dahc::new(&scenario, (radar, radar), 0.997, Random::new(3, 0, 0, index));
            room.beats(&scene, 1e-3, &sensor, &mut beats);
            let power = |beats: &[Blocks]| beats.iter().flatten().map(|z| z.norm_sqr()).sum::<f64>();
            sums[0] += power(&beats[..100]);
            sums[1] += power(&beats[900..]);
        }
        let db = 10.0 * libm::log10(sums[1] / sums[0]);
        assert!(db.abs() < 1.0, "{db} dB");
    }
}
