//! The core on emulated processors against the core here and the reference: what `tests/conformance` runs.
//!
//! `conformance FIRMWARE RECORDINGS MACHINE...` compares RECORDINGS recordings (over all classes and both carriers),
//! random networks, and random and extreme inputs; prints the table of targets; exit code 1 if anything differs.
//! `conformance --changed FIRMWARE MACHINE` takes firmware with one rounding changed: exit code 1 unless that is found,
//! and named by stage and index.

use sdp3::conformance::compare::verify_host;
use sdp3::conformance::proof::Proof;
use sdp3::conformance::qemu::{Firmware, machines};
use sdp3::conformance::suite::{Case, ScheduleCase, Suite, Transform, stimuli};
use sdp3::predictor::parameters::Architecture;
use sdp3::results::TargetVerdict;
use sdp3::scenario::{Class, Scenario};
use sdp3::simulator::calibration::stored_rho;
use sdp3::simulator::dataset::{Set, recording};
use sdp3_tests::networks::{Random, quantized};
use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// The paper's two carriers in Hz.
const CARRIERS: [f64; 2] = [3.5e9, 60e9];
/// Networks that the main job trained: see `tests/testkit/README.md`.
const MODELS: [(&str, u32); 2] =
    [("tests/testkit/models/dsn-200.sdp3", 200), ("tests/testkit/models/dsn-1000.sdp3", 1000)];
/// One emulator's time.
const LIMIT: Duration = Duration::from_secs(3000);

/// `count` recordings of each class at a carrier, for the model in a file.
fn recordings(file: &str, slots: u32, carrier_hz: f64, count: u32) -> Result<Vec<Case>> {
    let model = std::fs::read(file).map_err(|error| format!("{file}: {error}"))?;
    let mut scenario = Scenario::default();
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

/// Networks of random weights and shapes; each hears silence, full scale, saturation, noise and an echo.
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

/// 200 recordings need `count = 200`.
fn suite(count: u32) -> Result<Suite> {
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

fn print(verdict: &TargetVerdict) {
    let instructions = verdict.instructions.map_or_else(|| "-".to_owned(), |n| n.to_string());
    println!("{:<16}{:>12}{:>12}{:>16}", verdict.name, verdict.compared, verdict.mismatches, instructions);
    if let Some(detail) = &verdict.detail {
        println!("  {detail}");
    }
}

fn compare(firmware: &str, count: u32, wanted: &[String]) -> Result<bool> {
    let suite = suite(count)?;
    let programs: Vec<Firmware> = machines(Path::new(firmware), "conformance")
        .into_iter()
        .filter(|m| wanted.iter().any(|w| w == m.name))
        .collect();
    if programs.len() != wanted.len() {
        return Err(format!("{wanted:?}: a machine that is not in firmware-sim/machines").into());
    }
    println!(
        "{count} recordings, {} cases in all; instructions of the largest recognition",
        suite.cases.len()
    );
    println!("{:<16}{:>12}{:>12}{:>16}", "target", "compared", "mismatches", "instructions");
    let reference = verify_host(&suite)?;
    print(&reference);
    let folder = tempfile::tempdir()?;
    let proof = Proof::new(&suite, folder.path(), LIMIT)?;
    let verdicts = proof.firmware(&programs, &print)?;
    let mismatches: u64 = verdicts.iter().chain([&reference]).map(|verdict| verdict.mismatches).sum();
    println!("{} targets, {mismatches} mismatches", verdicts.len() + 1);
    Ok(mismatches == 0)
}

fn changed(firmware: &str, machine: &str) -> Result<bool> {
    let suite = suite(10)?;
    let folder = tempfile::tempdir()?;
    let programs: Vec<Firmware> =
        machines(Path::new(firmware), "conformance").into_iter().filter(|m| m.name == machine).collect();
    let verdicts = Proof::new(&suite, folder.path(), LIMIT)?.firmware(&programs, &|_| ())?;
    for verdict in &verdicts {
        let detail = verdict.detail.as_deref().unwrap_or("nothing found");
        println!(
            "one rounding changed: {} of {} digests differ; {detail}",
            verdict.mismatches, verdict.compared
        );
    }
    let found = |v: &TargetVerdict| {
        let detail = v.detail.as_deref().unwrap_or_default();
        v.compared > 0
            && v.mismatches > 0
            && ["stage ", "index", "expected", "found"].iter().all(|w| detail.contains(w))
    };
    Ok(!verdicts.is_empty() && verdicts.iter().all(found))
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let done = match &arguments[..] {
        [flag, firmware, machine] if flag == "--changed" => changed(firmware, machine),
        [firmware, count, machines @ ..] if !machines.is_empty() => match count.parse() {
            Ok(count) => compare(firmware, count, machines),
            Err(_) => Err(format!("{count} is no number of recordings").into()),
        },
        _ => Err("usage: conformance FIRMWARE RECORDINGS MACHINE... | --changed FIRMWARE MACHINE".into()),
    };
    match done {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(1),
        Err(error) => {
            eprintln!("conformance: {error}");
            ExitCode::from(2)
        }
    }
}
