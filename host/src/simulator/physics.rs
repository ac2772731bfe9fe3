//! Physics of a default recording, each statement with its number: `tests/physics` prints them.

use super::channel::antenna::Antenna;
use super::channel::dahc::Dahc;
use super::channel::room::{isotropic_power, received_power, static_paths};
use super::channel::target::{Target, mean_cross_section};
use super::channel::{BLOCKS, Blocks, ChannelModel, Scene, Sensor, model, wavelength};
use crate::numerics::random::Random;
use crate::scenario::{ArMode, Class, Model, Scenario, builtin};
use crate::simulator::body::motion::Person;
use crate::simulator::body::{norm, sub};
use crate::simulator::clutter_to_target::clutter_to_target_db;
use crate::simulator::dataset::{Set, Simulation};
use std::f64::consts::PI;

fn decibels(ratio: f64) -> f64 {
    10.0 * libm::log10(ratio)
}

/// The default room at the two carriers of the paper.
fn rooms() -> [Scenario; 2] {
    ["conference-room", "radar-60ghz"].map(|name| builtin::named(name.as_ref()).unwrap().scenario())
}

fn power(beats: &[Blocks]) -> f64 {
    beats.iter().flatten().map(|z| z.norm_sqr()).sum::<f64>() / (beats.len() * BLOCKS) as f64
}

/// Range samples of a room and of a person in it, apart.
fn apart(scenario: &Scenario, index: u64, slots: usize) -> [Vec<Blocks>; 2] {
    let radar = scenario.radar.position_m;
    let mut random = Random::new(101, 0, 0, index);
    let person =
        Person::draw(Class::AdultWalking, &scenario.target, scenario.room.size_m, radar, &mut random);
    let people = [Target::new(person, &mut random)];
    let of = |people: &[Target]| {
        let mut beats = vec![Blocks::default(); slots];
        let scene = Scene { slot: 0, time_s: 0.0, from: radar, to: radar, people };
        let mut channel = Dahc::new(scenario, (radar, radar), 0.997, random.clone());
        channel.beats(&scene, scenario.interval_s(), &Sensor::of(scenario), &mut beats);
        beats
    };
    let mut unobstructed = scenario.clone();
    unobstructed.channel.shadowing = false;
    let empty = of(&[]);
    let mut both = vec![Blocks::default(); slots];
    let scene = Scene { slot: 0, time_s: 0.0, from: radar, to: radar, people: &people };
    let mut channel = Dahc::new(&unobstructed, (radar, radar), 0.997, random.clone());
    channel.beats(&scene, scenario.interval_s(), &Sensor::of(scenario), &mut both);
    both.iter_mut().flatten().zip(empty.iter().flatten()).for_each(|(z, room)| *z -= room);
    [empty, both]
}

#[test]
fn the_power_of_the_room_is_constant_over_a_default_recording() {
    for scenario in rooms() {
        let slots = scenario.largest_sensing_slots() as usize;
        let mut ends = [0.0; 2];
        for index in 0..40 {
            let [room, _] = apart(&scenario, index, slots);
            ends[0] += power(&room[..100]);
            ends[1] += power(&room[slots - 100..]);
        }
        let change = decibels(ends[1] / ends[0]);
        println!(
            "{}: power of the room from the first to the last 100 slots {change:+.2} dB (limit 1)",
            scenario.name
        );
        assert!(change.abs() < 1.0);
    }
}

#[test]
fn clutter_to_target_is_what_the_radar_equation_and_the_rooms_paths_say() {
    for scenario in rooms() {
        let slots = scenario.largest_sensing_slots() as usize;
        let (mut simulated, people) = ([0.0; 2], 60);
        for index in 0..people {
            let [room, echo] = apart(&scenario, index, slots);
            simulated[0] += power(&room) / people as f64;
            simulated[1] += power(&echo) / people as f64;
        }
        let derived = clutter_to_target_db(&scenario);
        let found = decibels(simulated[0] / simulated[1]);
        println!(
            "{}: clutter to target derived {derived:.1} dB, simulated {found:.1} dB (limit 1 apart)",
            scenario.name
        );
        assert!((derived - found).abs() < 1.0);
    }
}

#[test]
fn the_fluctuation_is_the_k_factor_below_the_mean() {
    for scenario in rooms() {
        assert_eq!(scenario.channel.mode, ArMode::Rician, "{}", scenario.name);
        let radar = scenario.radar.position_m;
        let sensor = Sensor::of(&scenario);
        let power_of_mean = received_power(&static_paths(&scenario, radar, radar), &sensor.antenna);
        let (mut fluctuation, draws, slots) = (0.0, 200, 50);
        for index in 0..draws {
            let [room, _] = apart(&scenario, index, slots);
            let mean = static_paths(&scenario, radar, radar);
            let mut constant = Blocks::default();
            mean.iter().for_each(|one| sensor.add(&mut constant, &[one.path]));
            let rest: Vec<Blocks> =
                room.iter().map(|beat| std::array::from_fn(|b| beat[b] - constant[b])).collect();
            fluctuation += power(&rest) / draws as f64;
        }
        let found = decibels(power_of_mean / fluctuation);
        println!("{}: K factor {found:.1} dB (stated {})", scenario.name, scenario.channel.k_factor_db);
        assert!((found - scenario.channel.k_factor_db).abs() < 0.7);
    }
}

#[test]
fn the_printed_room_settles_further_below_a_person_than_the_default_fluctuates() {
    let [default, _] = rooms();
    let printed = builtin::named("as-printed".as_ref()).unwrap().scenario();
    let (settled, slots, people) = (2500, 3000, 60);
    let (mut room, mut echo) = (0.0, 0.0);
    for index in 0..people {
        room += power(&apart(&printed, index, slots)[0][settled..]);
        echo += power(&apart(&printed, index, 1000)[1]);
    }
    let found = decibels(room / echo);
    let radar = default.radar.position_m;
    let mean = received_power(&static_paths(&default, radar, radar), &Sensor::of(&default).antenna);
    let echo: f64 = (0..people).map(|index| power(&apart(&default, index, 1000)[1]) / people as f64).sum();
    let k = decibels(mean / echo) - found;
    println!(
        "as printed and settled: the room {found:.1} dB of a person, as with a K factor of {k:.1} dB (18.3)"
    );
    assert!((k - 18.3).abs() < 0.5 && k > default.channel.k_factor_db);
}

#[test]
fn energy_is_each_models_own() {
    // of the radar's room, relative to the mean losses of all reflections between isotropic antennas
    for name in [Model::Ieee80211ax, Model::Quadriga, Model::Statistical] {
        let mut scenario = Scenario::default();
        scenario.channel.model = name;
        let radar = scenario.radar.position_m;
        let scene = Scene { slot: 0, time_s: 0.0, from: radar, to: radar, people: &[] };
        // in dB where the model has shadow fading, so that its mean is the median
        let (mut sum, draws) = (0.0, 1500);
        for index in 0..draws {
            let mut channel = model(&scenario, radar, radar, 1.0, Random::new(101, 1, 0, index));
            let mut paths = Vec::new();
            channel.paths(&scene, &mut paths);
            sum += decibels(paths.iter().map(|p| p.gain.norm_sqr()).sum::<f64>()) / draws as f64;
        }
        let off = sum - decibels(isotropic_power(&scenario));
        println!("{}: median power of the room {off:+.2} dB of its law (limit 1.5)", name.name());
        assert!(off.abs() < 1.5, "{name:?}: {off}");
    }
}

#[test]
fn recordings_at_60_gigahertz_have_80211ays_clusters() {
    for one in &builtin::ALL {
        let scenario = one.scenario();
        let share = scenario.channel.clusters.share_80211ay(scenario.radar.carrier_hz);
        println!("{}: {:.1} GHz, share of 802.11ay {share:.2}", one.name, scenario.radar.carrier_hz / 1e9);
        let high = scenario.radar.carrier_hz >= 57e9;
        assert!(!high || share == 1.0 || scenario.channel.model != Model::Dahc, "{}", one.name);
    }
    // wherever a carrier alone is set
    let mut scenario = Scenario::default();
    for (carrier_hz, share) in [(3.5e9, 0.0), (6e9, 0.0), (57e9, 1.0), (60e9, 1.0), (77e9, 1.0)] {
        scenario.radar.carrier_hz = carrier_hz;
        assert_eq!(scenario.channel.clusters.share_80211ay(carrier_hz), share);
    }
    let middle = scenario.channel.clusters.share_80211ay(18.493e9);
    assert!((middle - 0.5).abs() < 1e-3, "{middle}");
}

#[test]
fn a_person_is_as_bright_as_its_mean_cross_section() {
    for mut scenario in rooms() {
        scenario.channel.occlusion = false;
        let (radar, lambda) = (scenario.radar.position_m, wavelength(scenario.radar.carrier_hz));
        let antenna = Antenna::of(&scenario);
        let (mut expected, mut found, people) = (0.0, 0.0, 60);
        for index in 0..people {
            let [_, echo] = apart(&scenario, index, 20);
            found += power(&echo);
            let mut random = Random::new(101, 0, 0, index);
            let size = scenario.room.size_m;
            let person = Person::draw(Class::AdultWalking, &scenario.target, size, radar, &mut random);
            let offset = sub(person.primitives(0.0)[1].centre, radar);
            let sigma = mean_cross_section(person.truth.height_m, 0.0) * antenna.amplitude(offset).powi(4);
            expected += lambda * lambda * sigma / (libm::pow(4.0 * PI, 3.0) * norm(offset).powi(4));
        }
        let off = decibels(found / expected);
        println!(
            "{}: echo of an adult {off:+.1} dB of 38.901's mean cross section at its torso (limit 4)",
            scenario.name
        );
        assert!(off.abs() < 4.0);
    }
}

#[test]
fn a_recording_and_its_prefix_agree_in_the_default_room() {
    for scenario in rooms() {
        let take = |slots| {
            Simulation::new(&scenario, 0.997, 101, Set::Train, Class::ChildWalking, 3).advance_blocks(slots)
        };
        let (long, short) = (take(43), take(21));
        let error: f64 =
            long.iter().zip(&short).flat_map(|(a, b)| a.iter().zip(b)).map(|(a, b)| (a - b).norm_sqr()).sum();
        assert!(error == 0.0, "{}: {error:e}", scenario.name);
    }
}
