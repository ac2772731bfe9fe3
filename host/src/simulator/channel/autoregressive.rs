//! The room's response with memory: v_j = rho v_{j-1} + (1 - rho) Upsilon_j, once per sensing slot.
//!
//! Eq. (vit) in three modes. Upsilon is a sum of paths with fixed delays and redrawn phases (802.11ay rays) or complex
//! Gaussian taps (802.11ax), so the recursion runs on one complex number per path.

use super::room::{Reflection, delay_s, draw_loss_db, draw_rays, mean_amplitude, reflections};
use super::tgn::{TAP_S, TAPS, tap_powers};
use super::{Complex64, Sweep, phasor, tone, wavelength};
use crate::scenario::{ArMode, Clusters, SPEED_OF_LIGHT, Scenario};
use crate::simulator::random::Random;
use std::f64::consts::PI;

/// A path of the room: its beat at unit amplitude and how its amplitude is drawn.
#[derive(Debug, Clone)]
struct Path {
    sweep: Sweep,
    /// Root of the mean power, antenna gains and transmit power included, in sqrt W.
    amplitude: f64,
    /// Phase of a geometric ray; `None` for a diffuse one.
    fixed: Option<f64>,
}

/// The room seen by the radar, slot after slot.
#[derive(Debug, Clone)]
pub struct RoomChannel {
    paths: Vec<Path>,
    state: Vec<Complex64>,
    rho: f64,
    mode: ArMode,
    rayleigh: bool,
    started: bool,
}

/// Mean power in W of all reflections the radar receives at their mean losses: sets the converter's full scale too.
pub fn mean_power_w(scenario: &Scenario) -> f64 {
    let radar = &scenario.radar;
    let lambda = wavelength(radar.carrier_hz);
    let gain = libm::pow(10.0, radar.antenna_gain_db / 10.0);
    let power: f64 = reflections(scenario.room.size_m, radar.position_m, radar.position_m)
        .iter()
        .map(|r| mean_amplitude(r, lambda) * mean_amplitude(r, lambda))
        .sum();
    radar.power_w * gain * gain * power
}

impl RoomChannel {
    /// Draws a room: losses and rays once per recording.
    pub fn new(scenario: &Scenario, rho: f64, random: &mut Random) -> Self {
        let radar = &scenario.radar;
        let room = reflections(scenario.room.size_m, radar.position_m, radar.position_m);
        let paths = match scenario.channel.clusters {
            Clusters::Ieee80211ax => taps(scenario, &room),
            Clusters::Ieee80211ay => rays(scenario, &room, random),
        };
        RoomChannel {
            state: vec![Complex64::default(); paths.len()],
            rayleigh: scenario.channel.clusters == Clusters::Ieee80211ax,
            mode: scenario.channel.mode,
            paths,
            rho,
            started: false,
        }
    }

    /// The next sensing slot's response in the beat domain.
    pub fn next(&mut self, random: &mut Random) -> Sweep {
        let rho = self.rho;
        let innovation = match self.mode {
            ArMode::Paper | ArMode::Consistent => 1.0 - rho,
            ArMode::VariancePreserving => (1.0 - rho * rho).sqrt(),
        };
        let mut sum = Sweep::default();
        for (path, state) in self.paths.iter().zip(&mut self.state) {
            let draw = if self.rayleigh {
                Complex64::new(random.gaussian(), random.gaussian()) * std::f64::consts::FRAC_1_SQRT_2
            } else {
                phasor(2.0 * PI * random.uniform())
            };
            let draw = match (self.mode, path.fixed) {
                (ArMode::Consistent, Some(phase)) => phasor(phase),
                _ => draw,
            };
            *state = if self.started { *state * rho + draw * innovation } else { draw };
            let amplitude = *state * path.amplitude;
            sum.iter_mut().zip(&path.sweep).for_each(|(sum, tone)| *sum += amplitude * tone);
        }
        self.started = true;
        sum
    }
}

/// Nine Gaussian taps behind the shortest reflection, with the room's mean power.
fn taps(scenario: &Scenario, room: &[Reflection]) -> Vec<Path> {
    let power = mean_power_w(scenario);
    let first = room.iter().map(|r| r.length_m).fold(f64::INFINITY, f64::min) / SPEED_OF_LIGHT;
    let powers = tap_powers();
    (0..TAPS)
        .map(|tap| Path {
            sweep: tone(Complex64::new(1.0, 0.0), first + tap as f64 * TAP_S),
            amplitude: (power * powers[tap]).sqrt(),
            fixed: (tap == 0).then_some(0.0),
        })
        .collect()
}

/// Image-method clusters, each with its drawn loss and rays.
fn rays(scenario: &Scenario, room: &[Reflection], random: &mut Random) -> Vec<Path> {
    let radar = &scenario.radar;
    let lambda = wavelength(radar.carrier_hz);
    let front = radar.power_w.sqrt() * libm::pow(10.0, radar.antenna_gain_db / 10.0);
    let mut paths = Vec::new();
    for reflection in room {
        let loss = libm::pow(10.0, draw_loss_db(reflection.order, random) / 20.0);
        let amplitude = front * loss * lambda / (4.0 * PI * reflection.length_m);
        let turns = reflection.length_m / lambda;
        for ray in draw_rays(random) {
            let delay = delay_s(reflection) + ray.delay_s;
            if delay < 0.0 {
                continue;
            }
            paths.push(Path {
                sweep: tone(Complex64::new(1.0, 0.0), delay),
                amplitude: amplitude * ray.amplitude,
                fixed: ray.central.then_some(-2.0 * PI * (turns - turns.floor())),
            });
        }
    }
    paths
}

#[cfg(test)]
mod tests {
    use super::*;

    fn powers(mode: ArMode, rho: f64, slots: usize) -> Vec<f64> {
        let scenario = Scenario {
            channel: crate::scenario::Channel { mode, ..Default::default() },
            ..Default::default()
        };
        let mut sums = vec![0.0; slots];
        for index in 0..300 {
            let mut random = Random::new(3, 0, 0, index);
            let mut room = RoomChannel::new(&scenario, rho, &mut random);
            sums.iter_mut().for_each(|sum| *sum += room.next(&mut random)[0].norm_sqr() / 300.0);
        }
        sums
    }

    #[test]
    fn variance_follows_each_mode() {
        let start = powers(ArMode::Paper, 0.9, 1)[0];
        // paper: the first response fades to (1 - rho) / (1 + rho) of its power
        let late: f64 = powers(ArMode::Paper, 0.9, 120)[60..].iter().sum::<f64>() / 60.0;
        assert!((late / start / (0.1 / 1.9) - 1.0).abs() < 0.15, "{}", late / start);
        let late: f64 = powers(ArMode::VariancePreserving, 0.9, 120)[60..].iter().sum::<f64>() / 60.0;
        assert!((late / start - 1.0).abs() < 0.15, "{}", late / start);
        assert!((start / mean_power_w(&Scenario::default()) - 1.0).abs() < 0.2);
    }

    #[test]
    fn full_memory_never_changes() {
        let mut random = Random::new(3, 0, 0, 0);
        let mut room = RoomChannel::new(&Scenario::default(), 1.0, &mut random);
        let first = room.next(&mut random);
        for _ in 0..10 {
            assert_eq!(room.next(&mut random), first);
        }
    }
}
