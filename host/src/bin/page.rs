//! The program of the report page, for WebAssembly (WASI, preview 1): what `sdp3 classify`, `sdp3 inspect` and `sdp3
//! optimize` find, by the same code.
//!
//! It reads one request as JSON from standard input, and prints what the command prints with `--json`. Files that a request names
//! are those of the page. Exit code 2: standard error says why there is nothing.

use sdp3::error::Failure;
use sdp3::network::classify::Classify;
use sdp3::network::retest::Retest;
use sdp3::optimizer::{self, Rule};
use sdp3::predictor::bootstrap::replicates;
use sdp3::predictor::{best_curve, fit_all};
use sdp3::recordings::{self, Chirps, Stated};
use sdp3::results::{Optimum, Retested};
use sdp3::scenario::{Override, Scenario};
use sdp3::simulator::calibration::{doppler::of_signal, rho_of};
use serde::{Deserialize, Serialize};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// What the page says of a recording; fields have the names and meanings of the commands' options.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Recording {
    file: PathBuf,
    carrier_hz: Option<f64>,
    rate_hz: Option<f64>,
    antenna: Option<u32>,
    chirp: Option<u32>,
}

impl Recording {
    fn stated(&self) -> Stated {
        let Recording { carrier_hz, rate_hz, antenna, chirp, .. } = *self;
        Stated { carrier_hz, rate_hz, antenna, chirp: chirp.map(Chirps::One), ..Stated::default() }
    }
}

/// What the page asks for.
#[derive(Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum Request {
    /// The windows of a recording: `sdp3 classify`.
    Classify { model: PathBuf, recording: Recording, step: Option<u32>, least_confidence: f64 },
    /// Doppler over time of a recording, as `sdp3 inspect` draws it.
    Spectrogram { recording: Recording, scenario: PathBuf },
    /// A part of the test recordings of a scenario with fields set, by the models of every N_s: a part of `sdp3 optimize --retest`.
    Retest { models: Vec<PathBuf>, scenario: PathBuf, set: Vec<String>, seed: u64, first: u32, count: u32 },
    /// The region through the points of a file, in a scenario with fields set: `sdp3 optimize`; if there are parts of a
    /// test, through its accuracies: `sdp3 optimize --retest`.
    Optimize { points: PathBuf, retested: Vec<PathBuf>, scenario: PathBuf, set: Vec<String>, seed: u64 },
}

fn scenario_with(scenario: &Path, set: &[String]) -> Result<Scenario, Failure> {
    let set: Result<Vec<Override>, _> = set.iter().map(|one| one.parse()).collect();
    Ok(Scenario::resolve(Some(scenario), &set?)?)
}

fn retested(parts: &[PathBuf]) -> Result<Option<Retested>, Failure> {
    let read =
        |file: &PathBuf| -> Result<Retested, Failure> { Ok(serde_json::from_slice(&std::fs::read(file)?)?) };
    let parts = parts.iter().map(read).collect::<Result<Vec<_>, _>>()?;
    Ok(if parts.is_empty() { None } else { Some(Retested::joined(&parts)?) })
}

fn optimum(
    points: &Path,
    retested: Option<Retested>,
    scenario: &Scenario,
    seed: u64,
) -> Result<Optimum, Failure> {
    let points = match &retested {
        Some(retested) => retested.points(),
        None => sdp3::formats::points::read_one_spacing(points)?,
    };
    let curve = best_curve(&fit_all(&points)?);
    let rule = Rule::Weighted(scenario.optimizer.accuracy_weight);
    let replicates = replicates(&curve, &points, seed);
    let outcome = optimizer::optimise(&curve, &points, &replicates, scenario, rule, seed)?;
    Ok(Optimum { retested, ..outcome.optimum(curve, scenario) })
}

fn print(found: &impl Serialize) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    serde_json::to_writer_pretty(&mut out, found)?;
    Ok(writeln!(out)?)
}

fn execute() -> Result<(), Failure> {
    match serde_json::from_reader(std::io::stdin().lock())? {
        Request::Classify { model, recording, step, least_confidence } => {
            let (early_exits, guard, stated) = (None, false, recording.stated());
            let model = model.into();
            let request = Classify { model, early_exits, step, least_confidence, guard, stated };
            print(&request.files(&[recording.file])?)
        }
        Request::Spectrogram { recording, scenario } => {
            let stated = Stated { first: true, ..recording.stated() };
            let radar = Scenario::load(&scenario)?.radar;
            print(&of_signal("", &recordings::open(&recording.file, &stated)?, &radar)?)
        }
        Request::Retest { models, scenario, set, seed, first, count } => {
            let scenario = scenario_with(&scenario, &set)?;
            let models = models.iter().map(std::fs::read).collect::<Result<Vec<_>, _>>()?;
            let retest = Retest::new(&scenario, rho_of(&scenario), seed, &models)?;
            print(&retest.part(first..first.saturating_add(count), &|_, _| ()))
        }
        Request::Optimize { points, retested: parts, scenario, set, seed } => {
            let scenario = scenario_with(&scenario, &set)?;
            print(&optimum(&points, retested(&parts)?, &scenario, seed)?)
        }
    }
}

fn main() -> ExitCode {
    match execute() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let _ = writeln!(std::io::stderr(), "{error}");
            ExitCode::from(2)
        }
    }
}
