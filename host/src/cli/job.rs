//! The main job and what belongs to its results: `run`, `verify`, `report`.

use super::context::{Context, Preset, stored_models};
use super::simulator::MeasuredArgs;
use crate::conformance::qemu::MACHINES;
use crate::conformance::suite::ScheduleCase;
use crate::error::Failure;
use crate::pipeline::{Job, REFERENCE, TARGETS};
use crate::results::{Figures, Run, Verify};
use crate::store::output::OutputError;
use clap::Args;
use clap::builder::PossibleValuesParser;
use std::fmt::Write;
use std::path::PathBuf;

/// The main job.
#[derive(Debug, Clone, Args)]
pub struct RunArgs {
    /// Size of the job.
    #[arg(long, value_enum, default_value_t = Preset::Quick)]
    pub preset: Preset,
    /// Go on from the checkpoints in --out, with the same result as without the interruption.
    #[arg(long)]
    pub resume: bool,
    #[command(flatten)]
    pub measured: MeasuredArgs,
    #[command(flatten)]
    pub verify: VerifyArgs,
}

/// Targets of the comparison.
#[derive(Debug, Clone, Args)]
pub struct VerifyArgs {
    /// Targets to compare.
    #[arg(long, value_name = "NAMES", value_delimiter = ',', default_values = TARGETS,
        value_parser = PossibleValuesParser::new([REFERENCE].into_iter().chain(MACHINES)))]
    pub targets: Vec<String>,
    /// Folder of ready-built firmware; absent: firmware-sim/build makes it.
    #[arg(long, value_name = "DIR")]
    pub firmware: Option<PathBuf>,
}

/// Compares the core with reference and firmware on the models of a run.
pub fn verify(context: &Context, args: &VerifyArgs) -> Result<bool, Failure> {
    let job = context.job()?;
    let run = stored(&job)?;
    let job = Job { scenario: context.resolved(&job)?, seed: context.seed_of(run.seed, "run.json")?, ..job };
    let verify = compare(&job, &run, args)?;
    context.print(&verify, || table(&verify))?;
    Ok(verify.mismatches == 0)
}

/// Writes the page of a run again.
pub fn report(context: &Context) -> Result<bool, Failure> {
    let job = context.job()?;
    let run = stored(&job)?;
    let figures: Figures = job.output.read_json("figures.json", RUN_FIRST)?;
    let job = Job { scenario: context.resolved(&job)?, ..job };
    let page = page(&job, &run, &figures)?;
    context.print_files(&[page])?;
    Ok(true)
}

/// What makes the files a command reads from `--out`.
const RUN_FIRST: &str = "`sdp3 run` with the same --out makes it";

/// The results of `--out`'s run.
pub fn stored(job: &Job) -> Result<Run, OutputError> {
    job.output.read_json("run.json", RUN_FIRST)
}

fn compare(job: &Job, run: &Run, args: &VerifyArgs) -> Result<Verify, Failure> {
    let models = stored_models(job, RUN_FIRST)?;
    let suite = job.suite(run.rho, &models, schedule_case(run))?;
    job.verify(&suite, &args.targets, args.firmware.as_deref())
}

pub fn schedule_case(run: &Run) -> ScheduleCase {
    let p = &run.operating_point;
    ScheduleCase {
        period: p.period_slots,
        spacing: p.spacing_slots,
        sensing: p.sensing_slots,
        shares: p.communication_slots.clone(),
    }
}

/// Pictures and page of a run; the page's path.
pub fn page(job: &Job, run: &Run, figures: &Figures) -> Result<PathBuf, Failure> {
    let page = crate::report::page(run, figures, &job.scenario.to_toml());
    for (name, bytes) in crate::report::paper::files(run, figures)? {
        job.output.write(&format!("figures/{name}"), &bytes)?;
    }
    Ok(job.output.write("report.html", page.as_bytes())?)
}

/// The comparison in words.
pub fn table(verify: &Verify) -> String {
    let mut text = format!("{:<16}{:>12}{:>12}{:>16}", "target", "compared", "mismatches", "instructions");
    for t in &verify.targets {
        let instructions = t.instructions.map_or_else(|| "-".to_owned(), |n| n.to_string());
        let _ = write!(text, "\n{:<16}{:>12}{:>12}{:>16}", t.name, t.compared, t.mismatches, instructions);
        if let Some(detail) = &t.detail {
            let _ = write!(text, "\n  {detail}");
        }
    }
    text
}
