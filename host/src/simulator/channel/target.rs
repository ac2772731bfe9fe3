//! Echoes of a person: sixteen primitives by the monostatic radar equation.
//!
//! Eq. (uit) with the radar equation's amplitude, sqrt(P G_t G_r) lambda sqrt(sigma) / ((4 pi)^1.5 D^2), the phase of the
//! exact distance and the delay 2 D / c.

use super::{Complex64, Sweep, accumulate, phasor, tone, wavelength};
use crate::scenario::{Radar, SPEED_OF_LIGHT};
use crate::simulator::body::motion::Person;
use crate::simulator::body::primitives::PRIMITIVES;
use crate::simulator::body::{norm, sub};
use crate::simulator::random::Random;
use std::f64::consts::PI;

/// A person seen by the radar.
#[derive(Debug, Clone)]
pub struct Echoes {
    person: Person,
    phases: [f64; PRIMITIVES],
}

impl Echoes {
    /// Initial phases are uniform and fixed for the recording.
    pub fn new(person: Person, random: &mut Random) -> Self {
        Echoes { person, phases: std::array::from_fn(|_| 2.0 * PI * random.uniform()) }
    }

    /// The person.
    pub fn person(&self) -> &Person {
        &self.person
    }

    /// Complex amplitude (sqrt W) and delay (s) of each primitive at `t` seconds.
    pub fn paths(&self, radar: &Radar, t: f64) -> [(Complex64, f64); PRIMITIVES] {
        let lambda = wavelength(radar.carrier_hz);
        let gain = libm::pow(10.0, radar.antenna_gain_db / 10.0);
        let front = radar.power_w.sqrt() * gain * lambda / libm::pow(4.0 * PI, 1.5);
        let primitives = self.person.primitives(t);
        std::array::from_fn(|b| {
            let primitive = &primitives[b];
            let distance = norm(sub(primitive.centre, radar.position_m)).max(0.1);
            let amplitude = front * primitive.cross_section(radar.position_m).sqrt() / (distance * distance);
            // whole wavelengths are taken off before the cosine
            let turns = 2.0 * distance / lambda;
            let phase = self.phases[b] - 2.0 * PI * (turns - turns.floor());
            (phasor(phase) * amplitude, 2.0 * distance / SPEED_OF_LIGHT)
        })
    }

    /// Their sum in the beat domain.
    pub fn sweep(&self, radar: &Radar, t: f64) -> Sweep {
        let mut sum = Sweep::default();
        for (amplitude, delay) in self.paths(radar, t) {
            accumulate(&mut sum, &tone(amplitude, delay));
        }
        sum
    }
}
