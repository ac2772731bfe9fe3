//! Scenarios: `scenario list`, `show`, `new`, `check`.

use super::context::{Context, say};
use crate::error::Failure;
use crate::pipeline::scenario_errors;
use crate::results::{Checked, Listed};
use crate::scenario::{Scenario, builtin};
use crate::store::output::to_json;
use crate::text::printable_json;
use clap::{Args, Subcommand};
use std::io::Write;
use std::path::{Path, PathBuf};

/// What to do with scenarios.
#[derive(Debug, Clone, Args)]
pub struct ScenarioArgs {
    /// What to do.
    #[command(subcommand)]
    pub command: ScenarioCommand,
}

/// The commands about scenarios.
#[derive(Debug, Clone, Subcommand)]
pub enum ScenarioCommand {
    /// List the scenarios that come with the tool.
    #[command(after_help = "Examples:\n  sdp3 scenario list\n  sdp3 scenario list --json")]
    List,
    /// Print a scenario, every field with its meaning, unit and legal range.
    #[command(after_help = "Examples:
  sdp3 scenario show
  sdp3 scenario show small-radar
  sdp3 scenario show room.toml --set radar.carrier_hz=24e9 --json")]
    Show(ShowArgs),
    /// Write a scenario to a new file, every field with its meaning, unit and legal range. An existing file is kept.
    #[command(after_help = "Examples:
  sdp3 scenario new room.toml
  sdp3 scenario new cheap.toml --from small-radar --set name=cheap")]
    New(NewArgs),
    /// Report everything that is wrong with a scenario file: exit code 2 if anything is.
    #[command(
        after_help = "Examples:\n  sdp3 scenario check room.toml\n  sdp3 scenario check room.toml --json"
    )]
    Check(CheckArgs),
}

/// A scenario to print.
#[derive(Debug, Clone, Args)]
pub struct ShowArgs {
    /// A file, or the name of a scenario that comes with the tool; absent: that of --scenario, or else the paper's room.
    #[arg(value_name = "NAME|FILE")]
    pub scenario: Option<PathBuf>,
}

/// A scenario to write.
#[derive(Debug, Clone, Args)]
pub struct NewArgs {
    /// The file to make.
    #[arg(value_name = "FILE.toml")]
    pub file: PathBuf,
    /// A file, or the name of a scenario that comes with the tool, to begin with; absent: that of --scenario, or else the
    /// paper's room.
    #[arg(long, value_name = "NAME|FILE")]
    pub from: Option<PathBuf>,
}

/// A scenario to check.
#[derive(Debug, Clone, Args)]
pub struct CheckArgs {
    /// The file.
    #[arg(value_name = "FILE.toml")]
    pub file: PathBuf,
}

pub fn scenario(context: &Context, args: &ScenarioArgs) -> Result<bool, Failure> {
    match &args.command {
        ScenarioCommand::List => list(context),
        ScenarioCommand::Show(args) => {
            let scenario = named(context, args.scenario.as_deref())?;
            context.print(&scenario, || scenario.to_commented_toml().trim_end().to_owned())?;
            Ok(true)
        }
        ScenarioCommand::New(args) => new(context, args),
        ScenarioCommand::Check(args) => check(context, &args.file),
    }
}

fn list(context: &Context) -> Result<bool, Failure> {
    let listed: Vec<Listed> =
        builtin::ALL.iter().map(|one| Listed { name: one.name.into(), about: one.about() }).collect();
    context.print(&listed, || {
        let lines = listed.iter().map(|one| format!("{:<17}{}", one.name, one.about));
        lines.collect::<Vec<_>>().join("\n")
    })?;
    Ok(true)
}

fn named(context: &Context, name: Option<&Path>) -> Result<Scenario, Failure> {
    match name {
        Some(name) => Ok(Scenario::resolve(Some(name), &context.common.set)?),
        None => Ok(context.scenario.clone()),
    }
}

fn new(context: &Context, args: &NewArgs) -> Result<bool, Failure> {
    let scenario = named(context, args.from.as_deref())?;
    let file = &args.file;
    let refused = |error: std::io::Error| format!("{}: {error}; an existing file is kept", file.display());
    let mut made = std::fs::File::create_new(file).map_err(refused)?;
    let written = made.write_all(scenario.to_commented_toml().as_bytes());
    if let Err(error) = written {
        let _ = std::fs::remove_file(file);
        return Err(format!("{}: {error}", file.display()).into());
    }
    context.print_files(std::slice::from_ref(file))?;
    Ok(true)
}

fn check(context: &Context, file: &Path) -> Result<bool, Failure> {
    let errors = scenario_errors(file, &context.common.set)?;
    let checked = Checked { file: file.display().to_string(), errors };
    if context.common.json {
        say(&printable_json(&to_json(&checked)))?;
    }
    match checked.errors.len() {
        0 => {
            context.progress.note("scenario", &format!("{}: nothing is wrong", checked.file));
            Ok(true)
        }
        _ => Err(checked.errors.join("\nsdp3: ").into()),
    }
}
