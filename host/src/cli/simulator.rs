//! Commands that simulate and compare with measurements: `simulate`, `calibrate`, `channels`, `gallery`.

use super::context::{Context, count, folder_of, name_of, one_of};
use crate::dataset::{self, PER_CLASS, Shard};
use crate::error::Failure;
use crate::pipeline::Measured;
use crate::recordings::Stated;
use crate::report;
use crate::scenario::{Class, Model, Scenario};
use crate::simulator::calibration;
use crate::simulator::channel::properties;
use crate::store::output::Output;
use clap::Args;
use std::path::{Path, PathBuf};

/// A measured signal.
#[derive(Debug, Clone, Args)]
pub struct MeasuredArgs {
    /// A measured signal: WAV (CW Doppler), NPY, NPZ, SigMF, HDF5.
    #[arg(long, value_name = "FILE")]
    pub measured: Option<PathBuf>,
    /// Its carrier in Hz, if the file does not say.
    #[arg(long, value_name = "HZ", requires = "measured")]
    pub carrier: Option<f64>,
    /// Its sampling or slow-time rate in Hz, if the file does not say.
    #[arg(long, value_name = "HZ", requires = "measured")]
    pub rate: Option<f64>,
    /// Gain of the sensor in dB, which is subtracted.
    #[arg(long, value_name = "DB", requires = "measured", allow_negative_numbers = true)]
    pub gain: Option<f64>,
    /// Which array of an NPZ or which dataset of an HDF5 file.
    #[arg(long, value_name = "NAME", requires = "measured")]
    pub dataset: Option<String>,
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
    let classes = classes.unwrap_or_else(|| Class::ALL.to_vec());
    job.warn_of_aliasing();
    job.warn_of_rho();
    let rho = rho(&job.scenario);
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
    context.print(&written, String::new)?;
    Ok(true)
}

pub fn calibrate(context: &Context, args: CalibrateArgs) -> Result<bool, Failure> {
    let CalibrateArgs { measured, table } = args;
    if let Some(file) = table {
        return calibrate_table(context, &file);
    }
    let job = context.job()?;
    let measured = measurement(measured);
    if measured.is_none() {
        job.warn_of_rho();
    }
    let found = job.calibrate(measured.as_ref())?;
    context.record(&job, "calibrate")?;
    let path = job.output.write_result("calibration.json", &found)?;
    context
        .print(&found, || format!("rho = {} ({}); curve in {}", found.rho, found.source, path.display()))?;
    Ok(true)
}

fn calibrate_table(context: &Context, file: &Path) -> Result<bool, Failure> {
    let stage = context.progress.stage("calibrate", "the table of rho");
    let table = calibration::stored::regenerate(context.common.seed(), &|done, all| stage.at(done, all));
    let text = format!("{}{}", calibration::stored::HEADER, toml::to_string(&table)?);
    Output::create(&folder_of(file))?.write(&name_of(file), text.as_bytes())?;
    stage.finish(&format!("{} entries in {}", table.entry.len(), file.display()));
    context.print(&table, String::new)?;
    Ok(true)
}

pub fn channels(context: &Context) -> Result<bool, Failure> {
    let job = context.job()?;
    let stage = job.progress.stage("channels", "models through the property tests");
    let table = properties::table(&job.scenario, job.seed, &|done, all| stage.at(done, all));
    stage.finish(&format!("{} models", table.models.len()));
    context.record(&job, "channels")?;
    job.output.write_result("channels.json", &table)?;
    context.print(&table, || report::tables::channels(&table))?;
    Ok(true)
}

pub fn gallery(context: &Context) -> Result<bool, Failure> {
    let job = context.job()?;
    let stage = job.progress.stage("gallery", "spectrograms");
    let shown =
        crate::network::spectrograms::gallery(&job.scenario, job.seed, &|done, all| stage.at(done, all));
    context.record(&job, "gallery")?;
    let page = job.output.write("gallery.html", report::gallery::page(&shown).as_bytes())?;
    stage.finish(&format!("{} of them", shown.len()));
    context.print_files(&[page])?;
    Ok(true)
}

/// The scenario's rho, or the stored one.
pub fn rho(scenario: &Scenario) -> f64 {
    scenario.channel.rho.unwrap_or_else(|| calibration::stored_rho(scenario).0)
}

/// The measured signal that the command line names.
pub fn measurement(args: MeasuredArgs) -> Option<Measured> {
    let MeasuredArgs { measured, carrier, rate, gain, dataset, motion } = args;
    let stated = Stated { carrier_hz: carrier, rate_hz: rate, gain_db: gain, dataset };
    Some(Measured { file: measured?, stated, motion })
}
