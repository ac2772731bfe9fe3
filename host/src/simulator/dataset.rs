//! A recording: a function of (scenario, rho, seed, set, class, index) alone.
//!
//! Person, room and noise draw from streams of their own, slot after slot, so that the first n slots do not depend on
//! how many follow.

use super::body::motion::{Person, Truth};
use super::channel::autoregressive::RoomChannel;
use super::channel::target::Echoes;
use super::channel::{Sweep, accumulate, wavelength};
use super::radar::{Converter, slot};
use super::random::Random;
use crate::scenario::{Class, Scenario};
use sdp3_core::frame::Slot;

/// What a recording is for; recordings of different sets share nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Set {
    /// Learning.
    Train,
    /// Testing.
    Test,
    /// Simulated signals of the calibration.
    Calibration,
    /// Signals that stand for a measurement when none is given.
    Stand,
    /// Pictures and demonstrations.
    Demo,
}

/// Raw slots and what is true of them.
#[derive(Debug, Clone)]
pub struct Recording {
    /// Sensing slots, in order.
    pub slots: Vec<Slot>,
    /// The person.
    pub truth: Truth,
}

/// The channel of a recording, slot after slot.
pub struct Channel<'a> {
    scenario: &'a Scenario,
    echoes: Vec<Echoes>,
    room: RoomChannel,
    room_random: Random,
    taken: u32,
}

impl<'a> Channel<'a> {
    /// Draws the people and the room.
    pub fn new(scenario: &'a Scenario, rho: f64, seed: u64, set: Set, class: Class, index: u32) -> Self {
        let stream = |part: u64| Random::new(seed, set as u64 * 8 + part, class as u64, u64::from(index));
        let mut random = stream(0);
        let person = Person::draw(class, &scenario.target, scenario.radar.position_m, &mut random);
        let mut echoes = vec![Echoes::new(person, &mut random)];
        if scenario.channel.interferer {
            // a second adult walks at the other side of the room
            let mut target = scenario.target.clone();
            target.start_m = [scenario.room.size_m[0] - target.start_m[0], scenario.room.size_m[1] / 2.0];
            target.heading_spread_deg = 180.0;
            let other = Person::draw(Class::AdultWalking, &target, scenario.radar.position_m, &mut random);
            echoes.push(Echoes::new(other, &mut random));
        }
        let mut room_random = stream(1);
        let room = RoomChannel::new(scenario, rho, &mut room_random);
        Channel { scenario, echoes, room, room_random, taken: 0 }
    }

    /// What is true of the person.
    pub fn truth(&self) -> &Truth {
        &self.echoes[0].person().truth
    }

    /// h of the next sensing slot in the beat domain.
    pub fn advance(&mut self) -> Sweep {
        let t = f64::from(self.taken) * self.scenario.interval_s();
        self.taken += 1;
        let mut sweep = self.room.next(&mut self.room_random);
        for echoes in &self.echoes {
            accumulate(&mut sweep, &echoes.sweep(&self.scenario.radar, t));
        }
        sweep
    }
}

/// The recording with these coordinates.
pub fn recording(
    scenario: &Scenario,
    rho: f64,
    seed: u64,
    set: Set,
    class: Class,
    index: u32,
    slots: u32,
) -> Recording {
    let mut channel = Channel::new(scenario, rho, seed, set, class, index);
    let mut noise = Random::new(seed, set as u64 * 8 + 2, class as u64, u64::from(index));
    let converter = Converter::of(scenario);
    let slots = (0..slots).map(|_| slot(&channel.advance(), &converter, &mut noise)).collect();
    Recording { slots, truth: channel.truth().clone() }
}

/// A scenario whose limbs move faster than the sensing slots can follow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aliasing {
    /// Fastest limb in m/s.
    pub limb_m_s: f64,
    /// Fastest unambiguous speed in m/s.
    pub unambiguous_m_s: f64,
    /// Largest N_m that would not alias, if any.
    pub spacing_slots: Option<u32>,
}

/// Compares the toes, 4.9 times as fast as the body, with lambda PRF / 4.
pub fn aliasing(scenario: &Scenario) -> Option<Aliasing> {
    let limb_m_s = 4.9 * 0.5 * scenario.target.adult_height_m[1];
    let limit = |interval: f64| wavelength(scenario.radar.carrier_hz) / (4.0 * interval);
    let unambiguous_m_s = limit(scenario.interval_s());
    if limb_m_s <= unambiguous_m_s {
        return None;
    }
    let fits = |spacing: &u32| limb_m_s <= limit(scenario.frame.slot_s * f64::from(spacing + 1));
    let spacing_slots = (0..scenario.frame.spacing_slots).rev().find(fits);
    Some(Aliasing { limb_m_s, unambiguous_m_s, spacing_slots })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_recording_depends_on_its_coordinates_alone() {
        let scenario = Scenario::default();
        let take =
            |index, slots| recording(&scenario, 0.997, 5, Set::Train, Class::AdultWalking, index, slots);
        let (long, short) = (take(3, 40), take(3, 25));
        assert_eq!(long.slots[..25], short.slots[..]);
        assert_ne!(take(4, 25).slots, short.slots);
        assert_eq!(long.truth, short.truth);
    }

    #[test]
    fn the_converter_is_well_driven() {
        let scenario = Scenario::default();
        let mut loudest = 0;
        let mut clipped = 0;
        for index in 0..10 {
            let recording = recording(&scenario, 0.997, 1, Set::Test, Class::AdultWalking, index, 30);
            for s in recording.slots.iter().flatten() {
                loudest = loudest.max(s.i.unsigned_abs());
                clipped += u32::from(s.i.unsigned_abs() > 32766);
            }
        }
        assert!(loudest > 4_000 && clipped == 0, "{loudest}, clipped {clipped}");
    }

    #[test]
    fn high_carriers_alias_and_three_and_a_half_gigahertz_do_not() {
        let mut scenario = Scenario::default();
        assert_eq!(aliasing(&scenario), None);
        scenario.radar.carrier_hz = 60e9;
        // toes at 4.66 m/s: 5 m/s are unambiguous with every slot sensing
        assert_eq!(aliasing(&scenario).and_then(|a| a.spacing_slots), Some(0));
        scenario.radar.carrier_hz = 24e9;
        assert_eq!(aliasing(&scenario).and_then(|a| a.spacing_slots), Some(1));
    }
}
