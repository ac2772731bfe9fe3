//! `dahc`: the paper's data-assisted hybrid channel, h = u + v.
//!
//! u is geometry (sixteen primitives per person), v the room's response with memory; rho is calibrated on data. The beats of
//! a recording are formed several slots at a time.

use super::autoregressive::{Ar1Process, Innovation};
use super::ieee80211ax::taps;
use super::ieee80211ay::rays;
use super::response::Response;
use super::target::{NEAREST_M, Target, direct};
use super::{
    BLOCK_S, BLOCKS, Blocks, ChannelModel, Complex64, MIDDLE_S, Path, SWEEP_RATE, Scene, boxcar, wavelength,
};
use crate::numerics::random::Random;
use crate::scenario::{Clusters, SPEED_OF_LIGHT, Scenario};
use crate::simulator::body::Vec3;
use crate::simulator::body::number::{LANES, Lanes, Real};
use crate::simulator::body::primitives::primitive;
use std::f64::consts::{PI, TAU};

#[derive(Debug, Clone)]
pub struct Dahc {
    lambda: f64,
    room: Ar1Process,
    random: Random,
}

impl Dahc {
    /// Draws a room between two points.
    pub fn new(scenario: &Scenario, ends: (Vec3, Vec3), rho: f64, mut random: Random) -> Self {
        let (rays, innovation_kind) = match scenario.channel.clusters {
            Clusters::Ieee80211ax => (taps(scenario, ends), Innovation::Gaussian),
            Clusters::Ieee80211ay => (rays(scenario, ends, &mut random), Innovation::Phase),
        };
        let room =
            Ar1Process::new(&scenario.channel, rays, innovation_kind, rho, scenario.frame.spacing_slots);
        Dahc { lambda: wavelength(scenario.radar.carrier_hz), room, random }
    }
}

impl ChannelModel for Dahc {
    fn paths(&mut self, scene: &Scene, paths: &mut Vec<Path>) {
        self.room.step(&mut self.random);
        paths.extend(direct(scene, self.lambda));
        self.room.paths(paths);
        scene.people.iter().for_each(|person| person.echoes(scene, self.lambda, paths));
    }

    fn beats(&mut self, scene: &Scene, interval_s: f64, response: &Response, beats: &mut [Blocks]) {
        for beat in beats.iter_mut() {
            self.room.step(&mut self.random);
            self.room.beat(response, beat);
        }
        for target in scene.people {
            for (group, beats) in beats.chunks_mut(LANES).enumerate() {
                let first = scene.time_s + (group * LANES) as f64 * interval_s;
                let echo = match response {
                    Response::Paper => narrow_echo,
                    Response::Table(_) => wide_echo,
                };
                echo(response, target, scene.to, self.lambda, first, interval_s, beats);
            }
        }
    }
}

/// Adds a person's range samples of up to [`LANES`] slots, every primitive at its own delay: range cells may be smaller than a body.
fn wide_echo(
    response: &Response,
    target: &Target,
    radar: Vec3,
    lambda: f64,
    first: f64,
    interval_s: f64,
    beats: &mut [Blocks],
) {
    let t = Lanes::new(std::array::from_fn(|lane| first + lane as f64 * interval_s));
    let person = &target.person;
    let joints = person.joints(t);
    let front = target.gain * lambda / libm::pow(4.0 * PI, 1.5);
    for (index, phase) in target.phases.iter().enumerate() {
        let part = primitive(&joints, person.segments(), person.truth.height_m, index);
        let (distance, amplitude) = part.echo(radar);
        let (s, c) = distance.times(-2.0 / lambda).plus(phase / TAU).sin_cos_turns();
        let amplitude = amplitude.times(front * target.weights[index]);
        let (re, im) = ((amplitude * c).to_array(), (amplitude * s).to_array());
        for (lane, (beat, distance)) in beats.iter_mut().zip(distance.to_array()).enumerate() {
            response.add(beat, Complex64::new(re[lane], im[lane]), 2.0 * distance / SPEED_OF_LIGHT);
        }
    }
}

/// Terms of the series in the delays' differences. A body's primitives lie within 1.2 m of its torso: 8 ns or 0.22 rad at
/// the ends of the sweep, 0.22^4 / 24 = -80 dB.
const TERMS: usize = 4;

/// The same for the paper's radar, with range cells larger than a room.
///
/// With tau_0 the torso's delay, block b at kappa_b = 2 pi S (t_b - t_mid) sees
/// sum_p a_p exp(-j kappa_b tau_p) = exp(-j kappa_b tau_0) sum_q (-j kappa_b)^q / q! M_q with M_q = sum_p a_p (tau_p - tau_0)^q:
/// one phasor a primitive instead of eight.
fn narrow_echo(
    _: &Response,
    target: &Target,
    radar: Vec3,
    lambda: f64,
    first: f64,
    interval_s: f64,
    beats: &mut [Blocks],
) {
    let t = Lanes::new(std::array::from_fn(|lane| first + lane as f64 * interval_s));
    let person = &target.person;
    let joints = person.joints(t);
    let part = |index| primitive(&joints, person.segments(), person.truth.height_m, index);
    let front = target.gain * lambda / libm::pow(4.0 * PI, 1.5);
    // turns per metre of distance: the carrier and the sweep's middle
    let turns = 2.0 / lambda + 2.0 / SPEED_OF_LIGHT * SWEEP_RATE * MIDDLE_S;
    // the sweep's phase in rad per metre and block, from the middle
    let slope = TAU * SWEEP_RATE * BLOCK_S * 2.0 / SPEED_OF_LIGHT;
    let (torso, _) = part(1).echo(radar);
    let zero = Lanes::of(0.0);
    let mut moments = [[zero; 2]; TERMS];
    for (index, phase) in target.phases.iter().enumerate() {
        let (distance, amplitude) = part(index).echo(radar);
        let amplitude = amplitude.times(front * target.weights[index]);
        let (s, c) = distance.times(-turns).plus(phase / TAU).sin_cos_turns();
        let (mut re, mut im) = (amplitude * c, amplitude * s);
        let delta = (distance - torso).times(slope);
        for (q, moment) in moments.iter_mut().enumerate() {
            if q > 0 {
                (re, im) = (re * delta, im * delta);
            }
            moment[0] = moment[0] + re;
            moment[1] = moment[1] + im;
        }
    }
    // phases of tau_0 at the blocks: odd powers of half a block's turn, both signs
    let (s, c) = torso.times(slope / (2.0 * TAU)).sin_cos_turns();
    let square = (c * c - s * s, (c * s).times(2.0));
    let (mut cosine, mut sine) = (c, s);
    let delay = torso.times(2.0 / SPEED_OF_LIGHT);
    let mean = Lanes::new(delay.to_array().map(|tau| boxcar(SWEEP_RATE * tau)));
    let start = (delay * delay).times(SWEEP_RATE / 2.0).sin_cos_turns();
    for pair in 0..BLOCKS / 2 {
        let k = pair as f64 + 0.5;
        for (b, k, sign) in [(BLOCKS / 2 + pair, k, 1.0), (BLOCKS / 2 - 1 - pair, -k, -1.0)] {
            // sum_q (-j k)^q / q! M_q
            let [[r0, i0], [r1, i1], [r2, i2], [r3, i3]] = moments;
            let (k1, k2, k3) = (k, -k * k / 2.0, -k * k * k / 6.0);
            let re = r0 + i1.times(k1) + r2.times(k2) + i3.times(k3);
            let im = i0 - r1.times(k1) + i2.times(k2) - r3.times(k3);
            // times exp(-j k slope D_0)
            let sine = sine.times(sign);
            let (re, im) = (re * cosine + im * sine, im * cosine - re * sine);
            let (re, im) = (re * start.1 - im * start.0, re * start.0 + im * start.1);
            let (re, im) = (re * mean, im * mean);
            for (beat, (re, im)) in beats.iter_mut().zip(re.to_array().into_iter().zip(im.to_array())) {
                beat[b] += Complex64::new(re, im);
            }
        }
        (cosine, sine) = (cosine * square.0 - sine * square.1, cosine * square.1 + sine * square.0);
    }
    debug_assert!(torso.to_array().iter().all(|&d| d > NEAREST_M) || beats.len() < LANES);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::Class;
    use crate::simulator::body::motion::Person;

    #[test]
    fn beats_agree_with_paths_to_eighty_decibels() {
        let shipped = |name: &str| crate::scenario::builtin::named(name.as_ref()).unwrap().scenario();
        let at = |carrier_hz| {
            let mut scenario = Scenario::default();
            scenario.radar.carrier_hz = carrier_hz;
            scenario
        };
        for scenario in [at(3.5e9), at(24e9), at(60e9), shipped("bgt60"), shipped("iwr")] {
            let response = Response::of(&scenario.radar);
            let radar = scenario.radar.position_m;
            let ends = (radar, radar);
            for class in Class::EVERY {
                let mut random = Random::new(4, 0, class as u64, 0);
                let person = Person::draw(class, &scenario.target, scenario.room.size_m, radar, &mut random);
                let people = [Target::new(person, &mut random)];
                let scene = Scene { slot: 0, time_s: 0.0, from: radar, to: radar, people: &people };
                let mut fast = vec![Blocks::default(); 203];
                Dahc::new(&scenario, ends, 0.997, random.clone()).beats(&scene, 1e-3, &response, &mut fast);
                let mut slow = Dahc::new(&scenario, ends, 0.997, random);
                let (mut error, mut power) = (0.0, 0.0);
                for (n, fast) in fast.iter().enumerate() {
                    let scene = Scene { slot: n as u32, time_s: n as f64 * 1e-3, ..scene };
                    let mut paths = Vec::new();
                    slow.paths(&scene, &mut paths);
                    let mut exact = Blocks::default();
                    paths.iter().for_each(|p| response.add(&mut exact, p.gain, p.delay_s));
                    let mut room = Blocks::default();
                    slow.room.beat(&response, &mut room);
                    for ((a, b), v) in fast.iter().zip(&exact).zip(&room) {
                        error += (a - b).norm_sqr();
                        // relative to the person alone, not to the louder room
                        power += (b - v).norm_sqr();
                    }
                }
                let db = 10.0 * libm::log10(error / power);
                assert!(
                    db < -80.0,
                    "{class:?}, {}, {:e} Hz: {db} dB",
                    scenario.name,
                    scenario.radar.carrier_hz
                );
            }
        }
    }
}
