//! Clutter to target: the power that the radar receives from the room over that from a person, by the radar equation.
//!
//! The room has |sum of the mean's paths|^2, which interfere, and the fluctuation K below the sum of their powers. The person has
//! lambda^2 / (4 pi)^3 times the sum over its primitives of sigma G^2 / D^4. `tests/physics` holds it to the simulation.

use super::body::motion::Person;
use super::body::{norm, sub};
use super::channel::room::{received_power, static_paths};
use super::channel::{BLOCKS, Blocks, Sensor, wavelength};
use crate::numerics::random::Random;
use crate::scenario::{Class, Scenario};
use std::f64::consts::PI;

/// Walks averaged over, and moments of each.
const WALKS: u64 = 60;
const MOMENTS: u32 = 50;

/// Clutter to target in dB of an adult who walks through the longest recording, in a room with a mean (`channel.mode = "rician"`).
pub fn clutter_to_target_db(scenario: &Scenario) -> f64 {
    let (radar, lambda) = (scenario.radar.position_m, wavelength(scenario.radar.carrier_hz));
    let sensor = Sensor::of(scenario);
    let mean = static_paths(scenario, radar, radar);
    let mut sum = Blocks::default();
    mean.iter().for_each(|one| sensor.add(&mut sum, &[one.path]));
    let k = libm::pow(10.0, -scenario.channel.k_factor_db / 10.0);
    let interfering = sum.iter().map(|z| z.norm_sqr()).sum::<f64>() / BLOCKS as f64;
    let clutter = interfering + k * received_power(&mean, &sensor.antenna);
    let duration_s = f64::from(scenario.largest_sensing_slots()) * scenario.interval_s();
    let mut target = 0.0;
    for index in 0..WALKS {
        let mut random = Random::new(101, 0, 0, index);
        let size = scenario.room.size_m;
        let person = Person::draw(Class::AdultWalking, &scenario.target, size, radar, &mut random);
        for n in 0..MOMENTS {
            for primitive in person.primitives(f64::from(n) / f64::from(MOMENTS) * duration_s) {
                let offset = sub(primitive.centre, radar);
                let sigma = primitive.cross_section(radar) * sensor.antenna.amplitude(offset).powi(4);
                target += lambda * lambda * sigma / (libm::pow(4.0 * PI, 3.0) * norm(offset).powi(4));
            }
        }
    }
    10.0 * libm::log10(clutter * f64::from(MOMENTS) * WALKS as f64 / target)
}
