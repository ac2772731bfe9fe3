//! The `sdp3` command: parses, calls one function per subcommand, prints, and sets the exit code.

mod cli;
mod trader;
#[cfg(feature = "train")]
mod trainer;
#[cfg(not(feature = "train"))]
#[path = "untrained.rs"]
mod trainer;

use clap::Parser;
use cli::{Cli, Command, MeasuredArgs, Preset, ProofArgs, Study};
use sdp3::conformance::qemu::MACHINES;
use sdp3::formats::dataset::{self, Shard};
use sdp3::formats::measured::Stated;
use sdp3::formats::model_file::Summary;
use sdp3::formats::model_file::signature::{new_key, read_key, sign};
use sdp3::output::{Output, to_json};
use sdp3::pipeline::{Failure, Job, Measured, REFERENCE, TARGETS};
use sdp3::predictor::interchange::{self, Exchange};
use sdp3::predictor::learning_curve::predict;
use sdp3::predictor::spectrograms::gallery;
use sdp3::progress::Progress;
use sdp3::report;
use sdp3::results::{Figures, Run, Verify};
use sdp3::scenario::{Class, Model, Scenario};
use sdp3::simulator::calibration;
use sdp3::simulator::channel::properties;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Default of `--targets`.
pub const TARGET_NAMES: [&str; 3] = TARGETS;

/// What makes the files a command reads from `--out`.
const RUN_FIRST: &str = "`sdp3 run` with the same --out makes it";

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            let _ = error.print();
            return ExitCode::from(if error.use_stderr() { 2 } else { 0 });
        }
    };
    if let Err(error) = rayon::ThreadPoolBuilder::new().num_threads(cli.common.threads).build_global() {
        eprintln!("sdp3: --threads: {error}");
        return ExitCode::from(2);
    }
    match execute(cli) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(1),
        Err(error) => {
            eprintln!("sdp3: {error}");
            ExitCode::from(2)
        }
    }
}

/// Runs the command; `false` if a check failed.
fn execute(cli: Cli) -> Result<bool, Failure> {
    let common = &cli.common;
    let progress = if common.quiet { Progress::Quiet } else { Progress::Shown };
    let scenario = match &common.scenario {
        Some(file) => Scenario::load(file)?,
        None => Scenario::default(),
    };
    if common.verbose {
        let file = common.scenario.as_ref().map_or("built in".into(), |file| file.display().to_string());
        progress.note("sdp3", &format!("scenario {} ({file}), seed {}", scenario.name, common.seed));
        let threads = rayon::current_num_threads();
        progress.note("sdp3", &format!("{threads} threads, results in {}", common.out.display()));
    }
    sdp3::simulator::dataset::check(&scenario)?;
    let json = common.json;
    let command = cli.command.unwrap_or(Command::Run {
        preset: Preset::Quick,
        measured: MeasuredArgs {
            measured: None,
            carrier: None,
            rate: None,
            gain: None,
            dataset: None,
            motion: Class::AdultWalking.name().into(),
        },
        proof: ProofArgs { targets: TARGETS.map(String::from).to_vec(), firmware: None },
    });
    if let Command::Predict { points: Some(file) } = &command {
        // needs no output folder
        return trader::predict_file(file, common.seed, json);
    }
    match &command {
        // need no output folder
        Command::Export { from, to } => {
            let done = interchange::export(from, to)?;
            print(json, &done, || done.describe());
            return Ok(true);
        }
        Command::Model { file, key } => {
            let found = Summary::read(file, key.as_deref())?;
            print(json, &found, || found.describe());
            return Ok(found.signature_holds != Some(false));
        }
        Command::Sign { file, key, to } => {
            let model = std::fs::read(file).map_err(|e| format!("{}: {e}", file.display()))?;
            let signed = sign(&model, read_key(key)?).map_err(|e| format!("{}: {e}", file.display()))?;
            Output::create(&folder_of(to))?.write(&name_of(to), &signed)?;
            return Ok(true);
        }
        Command::Key { name } => {
            let [secret, public] = new_key(name)?;
            print(json, &[&secret, &public], || format!("{}, {}", secret.display(), public.display()));
            return Ok(true);
        }
        Command::Import { from, to, slots } => {
            let exchange =
                Exchange { scenario: &scenario, seed: common.seed, sensing_slots: *slots, progress };
            let done = exchange.import(from, to)?;
            print(json, &done, || done.describe());
            return Ok(true);
        }
        _ => (),
    }
    let mut job = Job { scenario, seed: common.seed, progress, output: Output::create(&common.out)? };
    if let Command::Run { preset, .. } | Command::Train { preset, .. } = &command {
        apply(*preset, &mut job, common.scenario.is_some());
    }
    match command {
        Command::Run { measured, proof, .. } => trainer::run(&job, measured, &proof, common.threads, json),
        Command::Simulate { per_class, channel, classes, raw, sigmf, shard } => {
            with_channel(&mut job.scenario, channel.as_deref())?;
            let classes = match classes {
                Some(names) => names.iter().map(|name| class(name, "--classes")).collect::<Result<_, _>>()?,
                None => Class::ALL.to_vec(),
            };
            simulate(&job, per_class, classes, (raw, sigmf), shard, json)
        }
        Command::Channels => {
            let stage = job.progress.stage("channels", "models through the property tests");
            let table = properties::table(&job.scenario, job.seed, &|done, all| stage.at(done, all));
            stage.finish(&format!("{} models", table.models.len()));
            job.output.write_json("channels.json", &table)?;
            print(json, &table, || report::tables::channels(&table));
            Ok(true)
        }
        Command::Gallery => {
            let stage = job.progress.stage("gallery", "spectrograms");
            let shown = gallery(&job.scenario, job.seed, &|done, all| stage.at(done, all));
            let path = job.output.write("gallery.html", report::gallery::page(&shown).as_bytes())?;
            stage.finish(&path.display().to_string());
            Ok(true)
        }
        Command::Calibrate { table: Some(file), .. } => {
            let stage = job.progress.stage("calibrate", "the table of rho");
            let table = calibration::stored::regenerate(job.seed, &|done, all| stage.at(done, all));
            let text = format!("{}{}", calibration::stored::HEADER, toml::to_string(&table)?);
            Output::create(&folder_of(&file))?.write(&name_of(&file), text.as_bytes())?;
            stage.finish(&format!("{} entries in {}", table.entry.len(), file.display()));
            print(json, &table, String::new);
            Ok(true)
        }
        Command::Calibrate { measured, table: None } => {
            let found = job.calibrate(measurement(measured)?.as_ref())?;
            let path = job.output.write_json("calibration.json", &found)?;
            if json {
                println!("{}", to_json(&found));
            } else {
                println!("rho = {} ({}); curve in {}", found.rho, found.source, path.display());
            }
            Ok(true)
        }
        Command::Train { how, .. } => {
            trainer::train(job, how, (common.scenario.is_some(), common.threads), json)
        }
        Command::Study { name, seeds, measured, carrier, rate } => {
            if measured.is_some() && name != Study::Fidelity {
                return Err("command line: --measured belongs to the study fidelity".into());
            }
            let stated = Stated { carrier_hz: carrier, rate_hz: rate, ..Stated::default() };
            trainer::study(
                &job,
                (name, seeds),
                measured.as_deref().map(|folder| (folder, stated)),
                common.threads,
                json,
            )
        }
        Command::Quantize { data } => trainer::quantize(&job, data.as_deref(), json),
        Command::Verify { proof } => {
            let run: Run = job.output.read_json("run.json", RUN_FIRST)?;
            job.scenario = resolved(&job)?;
            job.seed = run.seed;
            let verify = prove(&job, &run, &proof)?;
            if json {
                println!("{}", to_json(&verify));
            } else {
                print_verify(&verify);
            }
            Ok(verify.mismatches == 0)
        }
        // answered above
        Command::Export { .. }
        | Command::Import { .. }
        | Command::Model { .. }
        | Command::Sign { .. }
        | Command::Key { .. } => Ok(true),
        Command::Predict { .. } => {
            let prediction = predict(&trader::stored_points(&job)?, job.seed)?;
            print(json, &prediction, || report::tables::prediction(&prediction));
            Ok(true)
        }
        Command::Optimize { points, curve, rule, sweep } => {
            let ask = trader::Question { points, curve, rule: trader::rule(&rule, &job.scenario)?, sweep };
            trader::optimize(&job, ask, json)
        }
        Command::Anytime { calibrate_per_class, rule } => {
            job.scenario = trader::trained(&job, common.scenario.is_some())?;
            let rule = trader::rule(&rule, &job.scenario)?;
            trader::anytime(&job, calibrate_per_class, rule, json)
        }
        Command::Schedule { world } => trader::schedule(&mut job, &world, common.scenario.is_some(), json),
        Command::Report => {
            let run: Run = job.output.read_json("run.json", RUN_FIRST)?;
            let figures: Figures = job.output.read_json("figures.json", RUN_FIRST)?;
            job.scenario = resolved(&job)?;
            let path = report(&job, &run, &figures)?;
            println!("{path}");
            Ok(true)
        }
    }
}

/// A result as JSON, or in words if there are any.
fn print(json: bool, value: &impl serde::Serialize, words: impl FnOnce() -> String) {
    let text = if json { to_json(value) } else { words() };
    if !text.is_empty() {
        println!("{text}");
    }
}

fn folder_of(file: &Path) -> PathBuf {
    file.parent().filter(|folder| !folder.as_os_str().is_empty()).map_or(".".into(), Path::to_path_buf)
}

fn name_of(file: &Path) -> String {
    file.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// The quick preset makes an untouched scenario small; one from a file is taken as it is.
fn apply(preset: Preset, job: &mut Job, from_file: bool) {
    if preset == Preset::Quick && !from_file {
        let learning = &mut job.scenario.learning;
        learning.train_per_class = 100;
        learning.test_per_class = 60;
        learning.windows = 4;
        learning.epochs = 12;
        learning.channels = 8;
        // so few passes have nothing to forget
        learning.mask_rows = 0;
    }
}

fn measurement(args: MeasuredArgs) -> Result<Option<Measured>, Failure> {
    let Some(file) = args.measured else { return Ok(None) };
    let motion = class(&args.motion, "--motion")?;
    let stated =
        Stated { carrier_hz: args.carrier, rate_hz: args.rate, gain_db: args.gain, dataset: args.dataset };
    Ok(Some(Measured { file, stated, motion }))
}

/// A class by its name.
fn class(name: &str, flag: &str) -> Result<Class, Failure> {
    Class::EVERY.into_iter().find(|class| class.name() == name).ok_or_else(|| {
        let names = Class::EVERY.map(Class::name).join(", ");
        format!("command line: {flag} = {name} is outside its legal range: one of {names}").into()
    })
}

/// The scenario with the channel model of this name.
fn with_channel(scenario: &mut Scenario, name: Option<&str>) -> Result<(), Failure> {
    let Some(name) = name else { return Ok(()) };
    let found = Model::ALL.into_iter().find(|model| model.name() == name);
    scenario.channel.model = found.ok_or_else(|| {
        let names = Model::ALL.map(Model::name).join(", ");
        format!("command line: --channel = {name} is outside its legal range: one of {names}")
    })?;
    Ok(())
}

/// The resolved scenario of `--out`'s run.
fn resolved(job: &Job) -> Result<Scenario, Failure> {
    Ok(Scenario::load(&job.output.path("scenario.toml"))?)
}

fn prove(job: &Job, run: &Run, proof: &ProofArgs) -> Result<Verify, Failure> {
    check_targets(proof)?;
    let models = job
        .scenario
        .frame
        .sensing_slots
        .iter()
        .map(|n| job.output.read(&model_name(*n), RUN_FIRST))
        .collect::<Result<Vec<_>, _>>()?;
    for (bytes, n) in models.iter().zip(&job.scenario.frame.sensing_slots) {
        let path = job.output.path(&model_name(*n));
        sdp3_core::dsn::Model::parse(bytes).map_err(|e| format!("{}: {e}", path.display()))?;
    }
    let suite = job.suite(run.rho, &models, schedule_case(run))?;
    job.prove(&suite, &proof.targets, proof.firmware.as_deref())
}

fn check_targets(proof: &ProofArgs) -> Result<(), Failure> {
    let legal = || [REFERENCE].into_iter().chain(MACHINES);
    match proof.targets.iter().find(|target| legal().all(|name| name != *target)) {
        Some(unknown) => {
            let names: Vec<&str> = legal().collect();
            Err(format!("command line: --targets = {unknown} is none of {}", names.join(", ")).into())
        }
        None => Ok(()),
    }
}

fn schedule_case(run: &Run) -> sdp3::conformance::suite::ScheduleCase {
    let p = &run.operating_point;
    sdp3::conformance::suite::ScheduleCase {
        period: p.period_slots,
        spacing: p.spacing_slots,
        sensing: p.sensing_slots,
        shares: p.communication_slots.clone(),
    }
}

fn model_name(sensing_slots: u32) -> String {
    format!("models/dsn-{sensing_slots}.sdp3")
}

fn simulate(
    job: &Job,
    per_class: u32,
    classes: Vec<Class>,
    (raw, sigmf): (bool, bool),
    shard: Shard,
    json: bool,
) -> Result<bool, Failure> {
    job.warn_of_aliasing();
    let rho = job.scenario.channel.rho.unwrap_or_else(|| calibration::stored_rho(&job.scenario).0);
    let stage = job.progress.stage("simulate", "recordings");
    let work = dataset::Work::new(&job.scenario, rho, job.seed, per_class, classes, raw, sigmf);
    let written = work.write(shard, &job.output, &|done, all| stage.at(done, all))?;
    let state = if written.manifest.is_some() { "complete" } else { "not yet complete" };
    stage.finish(&format!(
        "{} parts made, {} kept; {} recordings in {}, {state}",
        written.made,
        written.kept,
        written.recordings,
        job.output.folder().display()
    ));
    if json {
        println!("{}", to_json(&written));
    }
    Ok(true)
}

fn report(job: &Job, run: &Run, figures: &Figures) -> Result<String, Failure> {
    let page = sdp3::report::page(run, figures, &job.scenario.to_toml());
    for (name, svg) in sdp3::report::svgs(run, figures) {
        job.output.write(&format!("figures/{name}"), svg.as_bytes())?;
    }
    Ok(job.output.write("report.html", page.as_bytes())?.display().to_string())
}

fn print_verify(verify: &Verify) {
    println!("{:<16}{:>12}{:>12}{:>16}", "target", "compared", "mismatches", "instructions");
    for t in &verify.targets {
        let instructions = t.instructions.map_or_else(|| "-".to_owned(), |n| n.to_string());
        println!("{:<16}{:>12}{:>12}{:>16}", t.name, t.compared, t.mismatches, instructions);
        if let Some(detail) = &t.detail {
            println!("  {detail}");
        }
    }
}
