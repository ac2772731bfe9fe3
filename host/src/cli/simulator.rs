//! Commands that simulate and compare with measurements: `simulate`, `targets`, `calibrate`, `channels`, `gallery`.

use super::context::{Context, count, one_of};
use super::recordings::StatedArgs;
use crate::dataset::{PER_CLASS, Shard};
use crate::error::Failure;
use crate::pipeline::{Dataset, INDEX, Measured, Targets, calibrate_table};
use crate::report::tables;
use crate::scenario::budget::Budget;
use crate::scenario::{Class, Model};
use crate::simulator::targets::PointTargetFile;
use clap::Args;
use std::path::PathBuf;

/// A measured signal.
#[derive(Debug, Clone, Args)]
pub struct MeasuredArgs {
    /// A measured signal: a file or folder that `sdp3 inspect` reads.
    #[arg(long, value_name = "PATH")]
    pub measured: Option<PathBuf>,
    #[command(flatten)]
    pub stated: StatedArgs,
    /// How the person in it moves: rho is found for this motion, and a wrong one changes it.
    #[arg(long, value_name = "CLASS", requires = "measured", default_value = "adult-walking",
        value_parser = one_of(&Class::EVERY, Class::name))]
    pub motion: Class,
}

/// A dataset to simulate.
#[derive(Debug, Clone, Args)]
pub struct SimulateArgs {
    /// Recordings of each class.
    #[arg(long, default_value_t = 20, value_parser = count(PER_CLASS))]
    pub per_class: u32,
    /// Channel model; absent: the scenario's.
    #[arg(long, value_name = "NAME", value_parser = one_of(&Model::ALL, Model::name))]
    pub channel: Option<Model>,
    /// Classes; absent: the paper's five.
    #[arg(long, value_delimiter = ',', value_name = "NAMES", value_parser = one_of(&Class::EVERY, Class::name))]
    pub classes: Option<Vec<Class>>,
    /// Store the raw slots in the parts too.
    #[arg(long)]
    pub raw: bool,
    /// Write each recording's raw slots as SigMF too.
    #[arg(long)]
    pub sigmf: bool,
    /// Make only the I-th of N shards of the parts; whichever comes last writes the manifest.
    #[arg(long, value_name = "I/N", default_value = "1/1")]
    pub shard: Shard,
}

/// Point targets to write.
#[derive(Debug, Clone, Args)]
pub struct TargetsArgs {
    /// Classes; absent: the paper's five.
    #[arg(long, value_delimiter = ',', value_name = "NAMES", value_parser = one_of(&Class::EVERY, Class::name))]
    pub classes: Option<Vec<Class>>,
    /// Number of the recording within its class, from 0: the person is that of the recording which `sdp3 simulate` makes.
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = count(INDEX))]
    pub index: u32,
    /// Seconds between two instants; absent: from one sensing slot to the next.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub every_s: Option<f64>,
    /// Seconds in all; absent: those of a recording.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub duration_s: Option<f64>,
}

/// A measured signal to calibrate on, or the table.
#[derive(Debug, Clone, Args)]
pub struct CalibrateArgs {
    #[command(flatten)]
    pub measured: MeasuredArgs,
    /// Write the look-up table of rho again, to this file.
    #[arg(long, value_name = "FILE.toml", conflicts_with = "measured")]
    pub table: Option<PathBuf>,
}

pub fn simulate(context: &Context, args: SimulateArgs) -> Result<bool, Failure> {
    let mut job = context.job()?;
    let SimulateArgs { per_class, channel, classes, raw, sigmf, shard } = args;
    job.scenario.channel.model = channel.unwrap_or(job.scenario.channel.model);
    let written = job.simulate(Dataset { per_class, classes, raw, sigmf, shard })?;
    context.print(&written, String::new)?;
    Ok(true)
}

pub fn targets(context: &Context, args: TargetsArgs) -> Result<bool, Failure> {
    let TargetsArgs { classes, index, every_s, duration_s } = args;
    let job = context.job()?;
    let written = job.targets(Targets { classes, index, every_s, duration_s })?;
    context.print(&written, || {
        let path = |file: &PointTargetFile| job.output.path(&file.file).display().to_string();
        written.files.iter().map(path).collect::<Vec<_>>().join("\n")
    })?;
    Ok(true)
}

pub fn calibrate(context: &Context, args: CalibrateArgs) -> Result<bool, Failure> {
    if let Some(file) = args.table {
        let table = calibrate_table(&file, context.common.seed(), context.progress)?;
        context.print(&table, String::new)?;
        return Ok(true);
    }
    let (found, path) =
        context.job()?.calibration(measurement(args.measured, context.common.budget()).as_ref())?;
    context.print(&found, || {
        let room = found.room.as_ref().map(tables::room).unwrap_or_default();
        format!("rho = {} ({}); curve in {}{room}", found.rho, found.source, path.display())
    })?;
    Ok(true)
}

pub fn channels(context: &Context) -> Result<bool, Failure> {
    let table = context.job()?.channels()?;
    context.print(&table, || tables::channels(&table))?;
    Ok(true)
}

pub fn gallery(context: &Context) -> Result<bool, Failure> {
    let page = context.job()?.gallery_page()?;
    context.print_files(&[page])?;
    Ok(true)
}

/// The measured signal that the command line names.
pub fn measurement(args: MeasuredArgs, budget: Budget) -> Option<Measured> {
    let MeasuredArgs { measured, stated, motion } = args;
    Some(Measured { file: measured?, stated: stated.stated(budget), motion })
}
