//! Commands of experiments that may leave one machine: `sweep`, `merge`.

use super::context::{Context, count};
use super::trainer;
use clap::Args;
use sdp3::dataset::Shard;
use sdp3::error::{Failure, Invalid};
use sdp3::experiments::sweep::plan::Sweep;
use sdp3::experiments::sweep::{kubernetes, shard, slurm};
use sdp3::results::{Merged, Submitted, Swept};
use sdp3::store::output::Output;
use std::path::{Path, PathBuf};

/// Shards of a job where `--shards` does not say, unless there are fewer cells.
const SHARDS: u32 = 100;

/// A plan, and where it runs.
#[derive(Debug, Clone, Args)]
pub struct SweepArgs {
    /// The plan: name, scenarios, carrier_hz, rho, sensing_slots, seeds.
    #[arg(value_name = "PLAN.toml")]
    plan: PathBuf,
    /// Make only the I-th of N shards of the cells; overrides the environment.
    #[arg(long, value_name = "I/N", conflicts_with_all = ["slurm", "kubernetes"])]
    shard: Option<Shard>,
    /// Write a Slurm array job and the merge that depends on it, and submit both.
    #[arg(long)]
    slurm: bool,
    /// Only write them.
    #[arg(long, requires = "slurm")]
    dry_run: bool,
    /// An option of sbatch for both jobs, such as --sbatch=--partition=long; may be given several times.
    #[arg(long, value_name = "OPTION", requires = "slurm", allow_hyphen_values = true)]
    sbatch: Vec<String>,
    /// Write a Kubernetes Indexed Job with the plan in it, and the merge to apply after it.
    #[arg(long, conflicts_with = "slurm", requires = "image")]
    kubernetes: bool,
    /// Container image that has sdp3 as its entry point.
    #[arg(long, requires = "kubernetes")]
    image: Option<String>,
    /// Persistent volume claim, writable by many nodes, for the results.
    #[arg(long, value_name = "NAME", default_value = "sdp3", requires = "kubernetes")]
    claim: String,
    /// Shards of the job, at most one a cell; absent: one a cell, at most 100.
    #[arg(long, value_name = "N", value_parser = count(1..=u32::MAX))]
    shards: Option<u32>,
}

/// A sweep to merge.
#[derive(Debug, Clone, Args)]
pub struct MergeArgs {
    /// The folder that `sdp3 sweep` was given as --out.
    #[arg(value_name = "DIR")]
    folder: PathBuf,
}

pub fn sweep(context: &Context, args: &SweepArgs) -> Result<bool, Failure> {
    let common = &context.common;
    let scenario = (context.given() || !common.set.is_empty()).then_some(&context.scenario);
    let sweep = Sweep::load(&args.plan, scenario, common.seed)?;
    if args.slurm || args.kubernetes {
        let done = hand_out(args, &sweep, &common.out)?;
        context.print(&done, || written(&done))?;
        return Ok(true);
    }
    if args.shards.is_some() {
        return Err(
            "command line: --shards belongs to --slurm and --kubernetes; a share is --shard I/N".into()
        );
    }
    let choice = shard::choose(args.shard, |name| std::env::var(name).ok())?;
    if let Some(conflict) = &choice.conflict {
        context.progress.note("sweep", conflict);
    }
    let done = trainer::shard(context, &sweep, choice.shard)?;
    context.print(&done, || swept(&done, &common.out))?;
    Ok(true)
}

/// Writes the job's files, and submits them if asked to.
fn hand_out(args: &SweepArgs, sweep: &Sweep, out: &Path) -> Result<Submitted, Failure> {
    let cells = sweep.cells.len() as u32;
    let shards = args.shards.unwrap_or(cells.min(SHARDS));
    if shards > cells {
        return Err(Invalid::option("--shards", shards, format!("1 to {cells}, the plan's cells")).into());
    }
    let output = &Output::create(out)?;
    match &args.image {
        Some(image) => Ok(kubernetes::write(sweep, shards, (image, &args.claim), output)?),
        None => {
            let jobs = slurm::write(sweep, shards, &args.sbatch, output)?;
            if args.dry_run { Ok(jobs.written()) } else { Ok(jobs.submit()?) }
        }
    }
}

pub fn merge(context: &Context, args: &MergeArgs) -> Result<bool, Failure> {
    let merged = sdp3::experiments::sweep::merge::merge(&args.folder)?;
    context.print(&merged, || table(&merged))?;
    Ok(true)
}

fn swept(done: &Swept, out: &Path) -> String {
    let Swept { shard, cells, made, kept, missing, .. } = done;
    let next = match missing {
        0 => format!("`sdp3 merge {}` joins them", out.display()),
        _ => format!("{missing} are missing"),
    };
    format!("shard {shard}: {made} cells made, {kept} kept; of {cells} cells in all {next}")
}

fn written(done: &Submitted) -> String {
    let mut lines = vec![format!("{} shards", done.shards)];
    lines.extend(done.files.iter().cloned());
    if let (Some(array), Some(merge)) = (&done.array, &done.merge) {
        lines.push(format!("submitted: array {array}, merge {merge} after it"));
    }
    lines.join("\n")
}

/// Means over seeds, a line for every N_s.
fn table(merged: &Merged) -> String {
    let mut text = format!("{:<24}{:>10}{:>9}{:>7}  {:<17}float", "scenario", "GHz", "rho", "N_s", "int8");
    for group in &merged.groups {
        for p in &group.points {
            let (ghz, name) = (group.carrier_hz / 1e9, &group.scenario);
            text += &format!(
                "\n{name:<24}{ghz:>10.3}{:>9}{:>7}  {:<17}{}",
                group.rho,
                p.sensing_slots,
                p.int8.to_string(),
                p.float
            );
        }
    }
    text
}
