//! Range samples of a person's sixteen primitives, several slots at a time.

use super::antenna::Antenna;
use super::target::{NEAREST_M, SPREADING, Target};
use super::{BLOCK_S, BLOCKS, Blocks, Complex64, MIDDLE_S, SWEEP_RATE, Sensor, boxcar};
use crate::scenario::SPEED_OF_LIGHT;
use crate::simulator::body::gait::JOINTS;
use crate::simulator::body::number::{LANES, Lanes, sin_cos_turns};
use crate::simulator::body::primitives::{Limb, PRIMITIVES, Primitive, limb};
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

    /// Relative amplitude by the antenna's pattern, out and back, of a primitive with these centres, `[instant]`.
    #[inline(always)]
    fn pattern(&self, antenna: &Antenna, centre: impl Fn(usize) -> Vec3) -> [f64; LANES] {
        if antenna.is_constant() {
            return [1.0; LANES];
        }
        let mut direction = [[0.0; LANES]; 3];
        for lane in 0..LANES {
            let [x, y, z] = sub(centre(lane), self.radar);
            (direction[0][lane], direction[1][lane], direction[2][lane]) = (x, y, z);
        }
        antenna.amplitudes(&direction).map(|one| one * one)
    }
}

/// The primitive of a limb with these ends at one instant.
#[inline(always)]
fn primitive(limb: &Limb, ends: [&Vec3<Lanes>; 2], lane: usize) -> Primitive {
    let [[ax, ay, az], [bx, by, bz]] = ends;
    limb.between([ax.at(lane), ay.at(lane), az.at(lane)], [bx.at(lane), by.at(lane), bz.at(lane)])
}

/// Calls `each` with a primitive's index, the instant, its distance in m, and its echo's real and imaginary part, of phase -2 pi `turns` times
/// the distance, for every primitive and instant.
///
/// One loop over the instants has the whole formula: the compiler vectorises that, and no chain of operations on whole [`Lanes`].
#[inline(always)]
fn echoes(
    antenna: &Antenna,
    target: &Target,
    view: &View,
    joints: &[Vec3<Lanes>; JOINTS],
    turns: f64,
    mut each: impl FnMut(usize, usize, f64, [f64; 2]),
) {
    let front = target.gain * view.lambda / SPREADING;
    for index in 0..PRIMITIVES {
        let limb = limb(target.person.segments(), target.person.truth.height_m, index);
        let ends = limb.ends.map(|joint| &joints[joint]);
        let pattern = view.pattern(
            antenna,
            #[inline(always)]
            |lane| primitive(&limb, ends, lane).centre,
        );
        let kept = view.kept.as_ref().map_or([1.0; LANES], |kept| kept[index].to_array());
        let (weight, phase) = (front * target.weights[index], target.phases[index] / TAU);
        for lane in 0..LANES {
            let (distance, amplitude) = primitive(&limb, ends, lane).echo(view.radar);
            let amplitude = amplitude * weight * pattern[lane] * kept[lane];
            let (s, c) = sin_cos_turns(distance * -turns + phase);
            each(index, lane, distance, [amplitude * c, amplitude * s]);
        }
    }
}

/// Adds a person's range samples of up to [`LANES`] slots, every primitive at its own delay: range cells may be smaller than a body.
#[inline(always)]
pub(super) fn wide_echo(sensor: &Sensor, target: &Target, view: &View, beats: &mut [Blocks]) {
    let joints = target.person.joints(view.times());
    let mut found = [[[0.0; LANES]; 3]; PRIMITIVES];
    echoes(
        &sensor.antenna,
        target,
        view,
        &joints,
        2.0 / view.lambda,
        #[inline(always)]
        |index, lane, distance, [re, im]| {
            let [to_distance, to_re, to_im] = &mut found[index];
            (to_distance[lane], to_re[lane], to_im[lane]) = (distance, re, im);
        },
    );
    for [distance, re, im] in &found {
        for (lane, beat) in beats.iter_mut().enumerate() {
            let delay_s = 2.0 * distance[lane] / SPEED_OF_LIGHT;
            sensor.response.add(beat, Complex64::new(re[lane], im[lane]), delay_s);
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
    let person = &target.person;
    let joints = person.joints(view.times());
    let torso = {
        let limb = limb(person.segments(), person.truth.height_m, 1);
        let [a, b] = limb.ends.map(|joint| joints[joint]);
        limb.between(a, b).echo(view.radar).0.to_array()
    };
    // turns per metre of distance: the carrier and the sweep's middle
    let turns = 2.0 / view.lambda + 2.0 / SPEED_OF_LIGHT * SWEEP_RATE * MIDDLE_S;
    // the sweep's phase in rad per metre and block, from the middle
    let slope = TAU * SWEEP_RATE * BLOCK_S * 2.0 / SPEED_OF_LIGHT;
    let mut moments = [[[0.0; LANES]; 2]; TERMS];
    echoes(
        &sensor.antenna,
        target,
        view,
        &joints,
        turns,
        #[inline(always)]
        |_, lane, distance, [mut re, mut im]| {
            let delta = (distance - torso[lane]) * slope;
            for (q, moment) in moments.iter_mut().enumerate() {
                if q > 0 {
                    (re, im) = (re * delta, im * delta);
                }
                moment[0][lane] += re;
                moment[1][lane] += im;
            }
        },
    );
    let mut sums = [[0.0; LANES]; 2 * BLOCKS];
    for lane in 0..LANES {
        // phases of tau_0 at the blocks: odd powers of half a block's turn, both signs
        let (s, c) = sin_cos_turns(torso[lane] * (slope / (2.0 * TAU)));
        let square = (c * c - s * s, c * s * 2.0);
        let (mut cosine, mut sine) = (c, s);
        let delay = torso[lane] * (2.0 / SPEED_OF_LIGHT);
        let mean = boxcar(SWEEP_RATE * delay);
        let start = sin_cos_turns(delay * delay * (SWEEP_RATE / 2.0));
        for pair in 0..BLOCKS / 2 {
            let k = pair as f64 + 0.5;
            for (b, k, sign) in [(BLOCKS / 2 + pair, k, 1.0), (BLOCKS / 2 - 1 - pair, -k, -1.0)] {
                // sum_q (-j k)^q / q! M_q
                let [[r0, i0], [r1, i1], [r2, i2], [r3, i3]] = moments.each_ref().map(
                    #[inline(always)]
                    |[re, im]| [re[lane], im[lane]],
                );
                let (k1, k2, k3) = (k, -k * k / 2.0, -k * k * k / 6.0);
                let re = r0 + i1 * k1 + r2 * k2 + i3 * k3;
                let im = i0 - r1 * k1 + i2 * k2 - r3 * k3;
                // times exp(-j k slope D_0)
                let sine = sine * sign;
                let (re, im) = (re * cosine + im * sine, im * cosine - re * sine);
                let (re, im) = (re * start.1 - im * start.0, re * start.0 + im * start.1);
                (sums[2 * b][lane], sums[2 * b + 1][lane]) = (re * mean, im * mean);
            }
            (cosine, sine) = (cosine * square.0 - sine * square.1, cosine * square.1 + sine * square.0);
        }
    }
    for (lane, beat) in beats.iter_mut().enumerate() {
        for (b, z) in beat.iter_mut().enumerate() {
            *z += Complex64::new(sums[2 * b][lane], sums[2 * b + 1][lane]);
        }
    }
    debug_assert!(torso.iter().all(|&d| d > NEAREST_M) || beats.len() < LANES);
}
