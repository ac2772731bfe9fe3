//! The core on emulated processors against the core here and the reference: what `tests/conformance` runs.
//!
//! `conformance FIRMWARE RECORDINGS MACHINE...` compares RECORDINGS recordings (over all classes and both carriers),
//! random networks, and random and extreme inputs; prints the table of targets; exit code 1 if anything differs.
//! `conformance --changed FIRMWARE MACHINE` takes firmware with one rounding changed: exit code 1 unless that is found,
//! and named by stage and index.

use sdp3::conformance::compare::verify_host;
use sdp3::conformance::digests::digests;
use sdp3::conformance::qemu::{Firmware, machines};
use sdp3::conformance::suite::{Case, ScheduleCase, Suite, Transform, stimuli};
use sdp3::conformance::verification::Verification;
use sdp3::network::parameters::Architecture;
use sdp3::results::TargetVerdict;
use sdp3::scenario::{Class, Scenario, builtin::named};
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
    let mut scenario = sdp3_tests::printed_room();
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

/// Random networks for the wide-band sensors: recordings of the scenarios of their names, and extreme inputs.
fn wide_band_sensors() -> Result<Vec<Case>> {
    let mut cases = Vec::new();
    for (name, seed) in [("bgt60", 100), ("iwr", 101)] {
        let scenario = named(Path::new(name)).ok_or_else(|| format!("no scenario {name}"))?.scenario();
        let architecture = Architecture { channels: 8, blocks: 1, stem_stride: 2, classes: 5 };
        let mut network = quantized(architecture, 6, seed);
        network.preprocessing.radar = scenario.radar.config();
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

/// The paper's radar with 200 recordings if `count = 200`, then the wide-band sensors and adaptive clutter.
fn suite(count: u32) -> Result<Suite> {
    let mut suite = paper_suite(count)?;
    suite.cases.extend(wide_band_sensors()?);
    suite.cases.extend(adaptive_clutter()?);
    Ok(suite)
}

/// The cases of the paper's radar.
fn paper_suite(count: u32) -> Result<Suite> {
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

/// Every stage of the paper's radar, as one line for each and the case's name before them.
fn digest_lines(count: u32) -> Result<Vec<String>> {
    let suite = paper_suite(count)?;
    let found = digests(&suite)?;
    let mut lines = Vec::new();
    for (case, stages) in suite.cases.iter().zip(&found.cases) {
        lines.push(format!("# {}", case.name));
        lines.extend(stages.iter().map(|(stage, n, digest)| format!("{stage} {n} {digest:016x}")));
    }
    lines.push("# schedule".to_owned());
    lines.push(format!("schedule {} {:016x}", found.schedule.0, found.schedule.1));
    Ok(lines)
}

/// Holds this machine's digests to those in a file; its lines before the first case say where they are from.
fn known(file: &str) -> Result<bool> {
    let text = std::fs::read_to_string(file).map_err(|error| format!("{file}: {error}"))?;
    let found = digest_lines(30)?;
    let expected: Vec<&str> =
        text.lines().skip_while(|line| Some(*line) != found.first().map(String::as_str)).collect();
    let mut case = "";
    for (expected, found) in expected.iter().zip(&found) {
        if let Some(name) = expected.strip_prefix("# ") {
            case = name;
        }
        if expected != found {
            println!("{file}: {case}: expected {expected:?}, found {found:?}");
            return Ok(false);
        }
    }
    println!("{} lines of digests, {} known", found.len(), expected.len());
    Ok(!expected.is_empty() && expected.len() == found.len())
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
    let verification = Verification::new(&suite, folder.path(), LIMIT)?;
    let verdicts = verification.firmware(&programs, &print)?;
    let mismatches: u64 = verdicts.iter().chain([&reference]).map(|verdict| verdict.mismatches).sum();
    println!("{} targets, {mismatches} mismatches", verdicts.len() + 1);
    Ok(mismatches == 0)
}

fn changed(firmware: &str, machine: &str) -> Result<bool> {
    let suite = suite(10)?;
    let folder = tempfile::tempdir()?;
    let programs: Vec<Firmware> =
        machines(Path::new(firmware), "conformance").into_iter().filter(|m| m.name == machine).collect();
    let verdicts = Verification::new(&suite, folder.path(), LIMIT)?.firmware(&programs, &|_| ())?;
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
        [flag, file] if flag == "--digests" => known(file),
        [flag, firmware, machine] if flag == "--changed" => changed(firmware, machine),
        [firmware, count, machines @ ..] if !machines.is_empty() => match count.parse() {
            Ok(count) => compare(firmware, count, machines),
            Err(_) => Err(format!("{count} is no number of recordings").into()),
        },
        _ => Err(
            "usage: conformance FIRMWARE RECORDINGS MACHINE... | --changed FIRMWARE MACHINE | --digests FILE"
                .into(),
        ),
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
