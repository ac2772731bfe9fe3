//! Commands of experiments that may leave one machine: `sweep`, `merge`.

use super::context::{Context, count};
use crate::dataset::Shard;
use crate::error::Failure;
use crate::experiments::RunContext;
use crate::experiments::sweep::plan::Sweep;
use crate::pipeline::sweep::{self, Cluster};
use crate::results::{Merged, Submitted, SweepStatus, Swept};
use clap::Args;
use indicatif::HumanDuration;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::Duration;

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
    /// Say where the sweep of --out stands and compute nothing: cells that are there, missing and unusable, of every shard with
    /// --shards, and the time that is left at the pace of the last 20 cells.
    #[arg(long, conflicts_with_all = ["slurm", "kubernetes", "shard"])]
    status: bool,
    /// Shards of the job, at most one a cell; absent: one a cell, at most 100. With --status, shards to count apart.
    #[arg(long, value_name = "N", value_parser = count(1..=u32::MAX))]
    shards: Option<u32>,
}

/// A sweep to merge.
#[derive(Debug, Clone, Args)]
pub struct MergeArgs {
    /// The folder that `sdp3 sweep` was given as --out.
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Join the cells that are there and list those that are not: partial.csv, partial.json.
    #[arg(long)]
    partial: bool,
}

pub fn sweep(context: &Context, args: &SweepArgs) -> Result<bool, Failure> {
    let common = &context.common;
    let scenario = (common.scenario.is_some() || !common.set.is_empty()).then_some(&context.scenario);
    let plan = Sweep::load(&args.plan, scenario, common.seed)?;
    let cluster = match &args.image {
        Some(image) if args.kubernetes => Some(Cluster::Kubernetes { image, claim: &args.claim }),
        _ => args.slurm.then_some(Cluster::Slurm { options: &args.sbatch, submit: !args.dry_run }),
    };
    if let Some(cluster) = cluster {
        let done = sweep::hand_out(&plan, args.shards, cluster, &common.out)?;
        context.print(&done, || written(&done))?;
        return Ok(true);
    }
    if args.status {
        let found = sweep::standing(&plan, args.shards, &common.out)?;
        context.print(&found, || standing(&found))?;
        return Ok(true);
    }
    if args.shards.is_some() {
        return Err(
            "command line: --shards belongs to --slurm, --kubernetes and --status; a share is --shard I/N"
                .into(),
        );
    }
    let run_context =
        RunContext { progress: context.progress, workers: context.workers(), budget: common.budget() };
    let done = sweep::make(&plan, args.shard, &common.out, run_context)?;
    context.print(&done, || swept(&done, &common.out))?;
    Ok(true)
}

pub fn merge(context: &Context, args: &MergeArgs) -> Result<bool, Failure> {
    let merged = sweep::join(&args.folder, args.partial)?;
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

fn standing(found: &SweepStatus) -> String {
    let mut text = format!("{:<9}{:>8}{:>8}{:>9}{:>10}", "shard", "cells", "done", "missing", "unusable");
    for s in &found.shards {
        text += &format!("\n{:<9}{:>8}{:>8}{:>9}{:>10}", s.shard, s.cells, s.done, s.missing, s.unusable);
    }
    text += &format!("\n{} of {} cells are there", found.done, found.cells);
    if let Some(left) = found.left_s.filter(|left| *left > 0.0) {
        text += &format!(", about {} left", HumanDuration(Duration::from_secs_f64(left)));
    }
    found.faults.iter().for_each(|fault| text += &format!("\n{fault}"));
    text
}

fn written(done: &Submitted) -> String {
    let mut lines = vec![format!("{} shards", done.shards)];
    lines.extend(done.files.iter().cloned());
    if let (Some(array), Some(merge)) = (&done.array, &done.merge) {
        lines.push(format!("submitted: array {array}, merge {merge} after it"));
    }
    lines.join("\n")
}

/// Means over seeds, a line for every N_s; throughput in Mbit/s of every case.
fn table(merged: &Merged) -> String {
    let cases = merged.groups.iter().flat_map(|g| &g.points).map(|p| p.throughput.len()).max().unwrap_or(0);
    let mut text = format!(
        "{:<24}{:>10}{:>9}{:>7}  {:<17}{:<17}{:>7}",
        "scenario", "GHz", "rho", "N_s", "int8", "float", "tested"
    );
    (1..=cases).for_each(|case| text += &format!("{:>16}", format!("case {case}, Mbit/s")));
    for group in &merged.groups {
        for p in &group.points {
            let (ghz, name) = (group.carrier_hz / 1e9, &group.scenario);
            let (int8, float) = (p.int8.to_string(), p.float.to_string());
            text += &format!(
                "\n{name:<24}{ghz:>10.3}{:>9}{:>7}  {int8:<17}{float:<17}{:>7}",
                group.rho, p.sensing_slots, p.tested
            );
            p.throughput.iter().for_each(|t| text += &format!("{:>16.3}", t.throughput_bit_s / 1e6));
        }
    }
    text += &format!("\nby guessing: {:.3}", merged.chance);
    let sentences: BTreeSet<&str> = merged.groups.iter().map(|group| group.channels.as_str()).collect();
    sentences.into_iter().filter(|one| !one.is_empty()).for_each(|one| text += &format!("\n{one}"));
    if !merged.missing.is_empty() {
        let (missing, whole) = (merged.missing.len(), merged.missing.len() + merged.cells.len());
        let indices: Vec<String> = merged.missing.iter().map(|cell| cell.index.to_string()).collect();
        text += &format!("\n{missing} of {whole} cells are missing: {}", indices.join(", "));
    }
    text
}
