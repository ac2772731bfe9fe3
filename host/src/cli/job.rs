//! The main job and what belongs to its results: `run`, `verify`, `report`.

use super::context::{Context, Preset};
use super::simulator::MeasuredArgs;
use crate::conformance::qemu::MACHINES;
use crate::error::{Failure, Invalid};
use crate::pipeline::verify::{REFERENCE, TARGETS, Targets};
use crate::results::Verify;
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

impl VerifyArgs {
    /// # Errors
    ///
    /// A folder of firmware that is none.
    pub fn targets(self) -> Result<Targets, Invalid> {
        if let Some(folder) = self.firmware.as_ref().filter(|folder| !folder.is_dir()) {
            return Err(Invalid::option(
                "--firmware",
                folder.display(),
                "a folder that firmware-sim/build made",
            ));
        }
        Ok(Targets { names: self.targets, firmware: self.firmware })
    }
}

pub fn verify(context: &Context, args: VerifyArgs) -> Result<bool, Failure> {
    let verify = context.job()?.verify_run(&args.targets()?)?;
    context.print(&verify, || table(&verify))?;
    Ok(verify.mismatches == 0)
}

/// A page to write again.
#[derive(Debug, Clone, Args)]
pub struct ReportArgs {
    /// `sdp3-page` in WebAssembly, for the page to compute with: it classifies recordings that are dropped on it, and computes the region for
    /// other links. Without this option it is taken from the folder of `sdp3`, if it is there.
    #[arg(long, value_name = "FILE.wasm")]
    pub program: Option<PathBuf>,
}

pub fn report(context: &Context, args: &ReportArgs) -> Result<bool, Failure> {
    let page = context.job()?.report(args.program.as_deref())?;
    context.print_files(&[page])?;
    Ok(true)
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
