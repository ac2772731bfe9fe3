//! A sweep as a command: its shards here or on a cluster, where it stands, its cells joined.

use crate::dataset::Shard;
use crate::error::Failure;
use crate::experiments::RunContext;
use crate::experiments::sweep::plan::Sweep;
use crate::experiments::sweep::{kubernetes, merge, shard, slurm, status};
use crate::report;
use crate::report::paper::draw;
use crate::results::{Merged, Submitted, SweepStatus, Swept};
use crate::store::output::Output;
use std::path::Path;

/// Shards of a job where nobody says how many, unless there are fewer cells.
const SHARDS: u32 = 100;

/// What runs a sweep's shards on other machines.
#[derive(Debug, Clone, Copy)]
pub enum Cluster<'a> {
    /// With options of sbatch, submitted or only written.
    Slurm { options: &'a [String], submit: bool },
    /// With the image that has sdp3, and the volume claim for the results.
    Kubernetes { image: &'a str, claim: &'a str },
}

/// Writes the job's files, and submits them if asked to.
///
/// # Errors
///
/// More shards than cells; a folder that cannot be written; a scheduler that refuses.
pub fn hand_out(
    sweep: &Sweep,
    shards: Option<u32>,
    cluster: Cluster,
    out: &Path,
) -> Result<Submitted, Failure> {
    let shards = sweep.shards(shards, (sweep.cells.len() as u32).min(SHARDS))?;
    let output = &Output::create(out)?;
    match cluster {
        Cluster::Kubernetes { image, claim } => Ok(kubernetes::write(sweep, shards, (image, claim), output)?),
        Cluster::Slurm { options, submit } => {
            let jobs = slurm::write(sweep, shards, options, output)?;
            if submit { Ok(jobs.submit()?) } else { Ok(jobs.written()) }
        }
    }
}

/// Where a sweep stands, its shards counted apart.
///
/// # Errors
///
/// More shards than cells; a cell that cannot be read.
pub fn standing(sweep: &Sweep, shards: Option<u32>, out: &Path) -> Result<SweepStatus, Failure> {
    status::status(sweep, out, sweep.shards(shards, 1)?)
}

/// Makes the shard that is asked for, or else the environment's, or else all.
///
/// # Errors
///
/// An environment that names no shard; a folder of another sweep; whatever a cell says.
pub fn make(sweep: &Sweep, asked: Option<Shard>, out: &Path, context: RunContext) -> Result<Swept, Failure> {
    for text in sweep.warnings() {
        context.progress.note("sweep", &format!("warning: {text}"));
    }
    let choice = shard::choose(asked, |name| std::env::var(name).ok())?;
    if let Some(conflict) = &choice.conflict {
        context.progress.note("sweep", conflict);
    }
    #[cfg(feature = "train")]
    super::sweep_cost::check(sweep, choice.shard, context)?;
    run(sweep, choice.shard, out, context)
}

#[cfg(feature = "train")]
fn run(sweep: &Sweep, shard: Shard, out: &Path, context: RunContext) -> Result<Swept, Failure> {
    crate::experiments::sweep::run::run(sweep, shard, &Output::create(out)?, context)
}

#[cfg(not(feature = "train"))]
fn run(_: &Sweep, _: Shard, _: &Path, _: RunContext) -> Result<Swept, Failure> {
    super::untrained("train")
}

/// Joins the cells of a folder and draws them over the axes of the plan.
///
/// # Errors
///
/// Cells that cannot be used; a folder that cannot be written.
pub fn join(folder: &Path, partial: bool) -> Result<Merged, Failure> {
    let merged = merge::merge(folder, partial)?;
    let output = Output::create(folder)?;
    let prefix = if partial { "partial-" } else { "" };
    for (name, svg) in report::sweep::pictures(&merged) {
        draw(&output, &format!("{prefix}{name}"), &svg)?;
    }
    Ok(merged)
}
