//! The core on emulated processors against the core here and the reference: what `tests/conformance` runs.
//!
//! `conformance FIRMWARE RECORDINGS MACHINE...` compares RECORDINGS recordings (over all classes and both carriers),
//! random networks, and random and extreme inputs; prints the table of targets; exit code 1 if anything differs.
//! `conformance --changed FIRMWARE MACHINE` takes firmware with one rounding changed: exit code 1 unless that is found,
//! and named by stage and index.

use sdp3::conformance::compare::verify_host;
use sdp3::conformance::digests::digests;
use sdp3::conformance::qemu::{Firmware, machines};
use sdp3::conformance::verification::Verification;
use sdp3::results::TargetVerdict;
use sdp3_tests::suites::{paper_suite, suite};
use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// One emulator's time.
const LIMIT: Duration = Duration::from_secs(3000);

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
    let folder = tempfile::Builder::new().prefix("with a space ").tempdir()?;
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
