//! Range samples of a person's sixteen primitives, several slots at a time.

use super::antenna::Antenna;
use super::target::{NEAREST_M, SPREADING, Target};
use super::{BLOCK_S, BLOCKS, Blocks, Complex64, MIDDLE_S, SWEEP_RATE, Sensor, boxcar};
use crate::scenario::SPEED_OF_LIGHT;
use crate::simulator::body::number::{LANES, Lanes, Real};
use crate::simulator::body::primitives::{PRIMITIVES, primitive};
use crate::simulator::body::{Vec3, sub};
use std::f64::consts::TAU;

/// From where a person is seen, when, and what is left of it.
pub(super) struct View {
    pub radar: Vec3,
    pub lambda: f64,
    /// Time in s from which slots are counted.
    pub begin_s: f64,
    /// The first of the slots.
    pub first: u32,
    pub interval_s: f64,
    /// Amplitude that obstruction leaves of each primitive.
    pub kept: Option<[Lanes; PRIMITIVES]>,
}

impl View {
    #[inline(always)]
    fn times(&self) -> Lanes {
        // in fours: recordings keep their rounding
        let four = |lane: u32| self.begin_s + f64::from(self.first + lane / 4 * 4) * self.interval_s;
        let at = |lane: u32| four(lane) + f64::from(lane % 4) * self.interval_s;
        Lanes::new(std::array::from_fn(|lane| at(lane as u32)))
    }

    /// A primitive's amplitude through the antenna, there and back, and past what hides it.
    #[inline(always)]
    fn seen(&self, antenna: &Antenna, index: usize, centre: Vec3<Lanes>, mut amplitude: Lanes) -> Lanes {
        if !antenna.is_constant() {
            let direction = sub(centre, self.radar.map(Lanes::of));
            let one = Lanes::new(antenna.amplitudes(&direction.map(Lanes::to_array)));
            amplitude = amplitude * (one * one);
        }
        match &self.kept {
            Some(kept) => amplitude * kept[index],
            None => amplitude,
        }
    }
}

/// Adds a person's range samples of up to [`LANES`] slots, every primitive at its own delay: range cells may be smaller than a body.
#[inline(always)]
pub(super) fn wide_echo(sensor: &Sensor, target: &Target, view: &View, beats: &mut [Blocks]) {
    let (t, radar, lambda) = (view.times(), view.radar, view.lambda);
    let person = &target.person;
    let joints = person.joints(t);
    let front = target.gain * lambda / SPREADING;
    for (index, phase) in target.phases.iter().enumerate() {
        let part = primitive(&joints, person.segments(), person.truth.height_m, index);
        let (distance, amplitude) = part.echo(radar);
        let (s, c) = distance.times(-2.0 / lambda).plus(phase / TAU).sin_cos_turns();
        let amplitude = amplitude.times(front * target.weights[index]);
        let amplitude = view.seen(&sensor.antenna, index, part.centre, amplitude);
        let (re, im) = ((amplitude * c).to_array(), (amplitude * s).to_array());
        for (lane, (beat, distance)) in beats.iter_mut().zip(distance.to_array()).enumerate() {
            sensor.response.add(beat, Complex64::new(re[lane], im[lane]), 2.0 * distance / SPEED_OF_LIGHT);
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
#[inline(always)]
pub(super) fn narrow_echo(sensor: &Sensor, target: &Target, view: &View, beats: &mut [Blocks]) {
    let (t, radar, lambda) = (view.times(), view.radar, view.lambda);
    let person = &target.person;
    let joints = person.joints(t);
    let part = |index| primitive(&joints, person.segments(), person.truth.height_m, index);
    let front = target.gain * lambda / SPREADING;
    // turns per metre of distance: the carrier and the sweep's middle
    let turns = 2.0 / lambda + 2.0 / SPEED_OF_LIGHT * SWEEP_RATE * MIDDLE_S;
    // the sweep's phase in rad per metre and block, from the middle
    let slope = TAU * SWEEP_RATE * BLOCK_S * 2.0 / SPEED_OF_LIGHT;
    let (torso, _) = part(1).echo(radar);
    let zero = Lanes::of(0.0);
    let mut moments = [[zero; 2]; TERMS];
    for (index, phase) in target.phases.iter().enumerate() {
        let part = part(index);
        let (distance, amplitude) = part.echo(radar);
        let amplitude = amplitude.times(front * target.weights[index]);
        let amplitude = view.seen(&sensor.antenna, index, part.centre, amplitude);
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
