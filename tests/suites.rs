//! The inputs of the conformance suites: recordings of every class, random networks, three sensors, extreme samples.

use crate::networks::{Random, quantized};
use sdp3::conformance::suite::{Case, ScheduleCase, Suite, Transform, stimuli};
use sdp3::network::parameters::Architecture;
use sdp3::scenario::{Class, Scenario, builtin::named};
use sdp3::simulator::calibration::stored_rho;
use sdp3::simulator::dataset::{Set, recording};
use std::path::Path;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// The paper's two carriers in Hz.
const CARRIERS: [f64; 2] = [3.5e9, 60e9];
/// Networks that the main job trained: see `tests/testkit/README.md`.
const MODELS: [(&str, u32); 2] =
    [("tests/testkit/models/dsn-200.sdp3", 200), ("tests/testkit/models/dsn-1000.sdp3", 1000)];
/// `count` recordings of each class at a carrier, for the model in a file.
fn recordings(file: &str, slots: u32, carrier_hz: f64, count: u32) -> Result<Vec<Case>> {
    let model = std::fs::read(file).map_err(|error| format!("{file}: {error}"))?;
    let mut scenario = crate::printed_room();
    scenario.radar.carrier_hz = carrier_hz;
    let rho = stored_rho(&scenario).0;
    let take = |class: Class, index: u32| Case {
        name: format!("{} {index} at {} GHz, N_s = {slots}", class.name(), carrier_hz / 1e9),
        model: model.clone(),
        transform: if index.is_multiple_of(2) { Transform::Float } else { Transform::Fixed },
        slots: recording(&scenario, rho, 5, Set::Demo, class, index, slots).slots,
    };
    Ok((0..count).flat_map(|index| Class::ALL.map(|class| take(class, index))).collect())
}

/// Networks of random weights and shapes; each gets silence, full scale, saturation, noise and an echo.
fn random_networks(count: u64) -> Result<Vec<Case>> {
    let mut cases = Vec::new();
    for seed in 0..count {
        let mut random = Random::new(seed);
        let architecture = Architecture {
            channels: [4, 8, 12, 16, 32][random.below(5)],
            blocks: 1 + random.below(3),
            stem_stride: 1 + random.below(2),
            classes: 2 + random.below(6),
        };
        let mut network = quantized(architecture, 4 + random.below(3) as u16, seed);
        let p = &mut network.preprocessing;
        p.first_kept = 1 + random.below(3) as u8;
        p.last_kept = 8 - random.below(3) as u8;
        p.bins_per_row = [1, 2, 4][random.below(3)];
        p.range = 300 + random.below(2000) as u16;
        p.kaiser_beta = random.between(0.0, 14.0);
        let slots = usize::from(p.sensing_slots);
        let model = network.to_bytes()?;
        cases.extend(
            stimuli(&model, slots, seed)
                .into_iter()
                .map(|case| Case { name: format!("network {seed}, {}", case.name), ..case }),
        );
    }
    Ok(cases)
}

/// Random networks for other sensors: recordings of the scenarios of their names, and extreme inputs.
fn other_sensors() -> Result<Vec<Case>> {
    let mut cases = Vec::new();
    for (name, seed) in [("bgt60", 100), ("iwr", 101), ("doppler-24ghz", 102)] {
        let scenario = named(Path::new(name)).ok_or_else(|| format!("no scenario {name}"))?.scenario();
        let architecture = Architecture { channels: 8, blocks: 1, stem_stride: 2, classes: 5 };
        let mut network = quantized(architecture, 6, seed);
        network.preprocessing.radar = scenario.radar.config();
        // there are as many components as range samples
        network.preprocessing.first_kept = network.preprocessing.first_kept.min(scenario.radar.range_samples);
        let slots = u32::from(network.preprocessing.sensing_slots);
        let model = network.to_bytes()?;
        let take = |(index, class): (usize, Class)| Case {
            name: format!("{name}, {}", class.name()),
            model: model.clone(),
            transform: if index.is_multiple_of(2) { Transform::Float } else { Transform::Fixed },
            slots: recording(&scenario, stored_rho(&scenario).0, 5, Set::Demo, class, 0, slots).slots,
        };
        cases.extend(Class::ALL.into_iter().enumerate().map(take));
        let prefixed = |case: Case| Case { name: format!("{name}, {}", case.name), ..case };
        cases.extend(stimuli(&model, slots as usize, seed).into_iter().map(prefixed));
    }
    Ok(cases)
}

/// Random networks that decide which components are clutter: recordings of the default room at both carriers, who stands there with what is
/// static, and extreme inputs.
fn adaptive_clutter() -> Result<Vec<Case>> {
    let mut cases = Vec::new();
    for (carrier_hz, seed) in CARRIERS.into_iter().zip(200..) {
        let mut scenario = Scenario::default();
        scenario.radar.carrier_hz = carrier_hz;
        let architecture = Architecture { channels: 8, blocks: 1, stem_stride: 2, classes: 5 };
        let mut network = quantized(architecture, 6, seed);
        network.preprocessing.first_kept = 0;
        let slots = u32::from(network.preprocessing.sensing_slots);
        let model = network.to_bytes()?;
        let take = |(index, class): (usize, Class)| Case {
            name: format!("adaptive clutter, {} at {} GHz", class.name(), carrier_hz / 1e9),
            model: model.clone(),
            transform: if index.is_multiple_of(2) { Transform::Float } else { Transform::Fixed },
            slots: recording(&scenario, stored_rho(&scenario).0, 5, Set::Demo, class, 0, slots).slots,
        };
        cases.extend(Class::ALL.into_iter().enumerate().map(take));
        let named = |case: Case| Case { name: format!("adaptive clutter, {}", case.name), ..case };
        cases.extend(stimuli(&model, slots as usize, seed).into_iter().map(named));
    }
    Ok(cases)
}

/// The paper's radar with 200 recordings if `count = 200`, then other sensors and adaptive clutter.
pub fn suite(count: u32) -> Result<Suite> {
    let mut suite = paper_suite(count)?;
    suite.cases.extend(other_sensors()?);
    suite.cases.extend(adaptive_clutter()?);
    Ok(suite)
}

/// The cases of the paper's radar.
pub fn paper_suite(count: u32) -> Result<Suite> {
    let mut cases = Vec::new();
    for carrier in CARRIERS {
        let each = count.div_ceil((CARRIERS.len() * Class::ALL.len()) as u32);
        cases.extend(recordings(MODELS[0].0, MODELS[0].1, carrier, each)?);
        let long = recordings(MODELS[1].0, MODELS[1].1, carrier, 1)?;
        cases.extend(long.into_iter().skip(2).take(1));
    }
    cases.extend(random_networks(u64::from(count.div_ceil(20)))?);
    let schedule = ScheduleCase { period: 4000, spacing: 3, sensing: 600, shares: vec![1500, 1000, 900] };
    Ok(Suite { cases, schedule })
}
