//! What describes the tool itself: `completions`, `man`, `schema`.

use super::Cli;
use super::context::{Context, say};
use crate::error::Failure;
use crate::schemas::PUBLISHED;
use clap::builder::PossibleValuesParser;
use clap::{Args, CommandFactory};
use clap_complete::{Shell, generate};
use std::path::PathBuf;

/// A shell to complete in.
#[derive(Debug, Clone, Args)]
pub struct CompletionsArgs {
    /// The shell.
    #[arg(value_enum)]
    pub shell: Shell,
}

/// Where manual pages go.
#[derive(Debug, Clone, Args)]
pub struct ManArgs {
    /// The folder, which is created if it does not exist.
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
}

/// A schema to print.
#[derive(Debug, Clone, Args)]
pub struct SchemaArgs {
    /// A command, with hyphens between its words, or `scenario`; absent: the names there are.
    #[arg(value_name = "COMMAND", value_parser = PossibleValuesParser::new(PUBLISHED.map(|(name, _)| name)))]
    pub name: Option<String>,
}

pub fn completions(args: &CompletionsArgs) -> Result<bool, Failure> {
    let mut script = Vec::new();
    generate(args.shell, &mut Cli::command(), "sdp3", &mut script);
    say(String::from_utf8_lossy(&script).trim_end())?;
    Ok(true)
}

/// A page for the tool and for every command and command's command.
pub fn man(context: &Context, args: &ManArgs) -> Result<bool, Failure> {
    let folder = &args.folder;
    let refused = |error: std::io::Error| format!("{}: cannot be written: {error}", folder.display());
    std::fs::create_dir_all(folder).map_err(refused)?;
    let mut command = Cli::command();
    command.build();
    let mut files = Vec::new();
    pages(&command, &mut |page| {
        files.push(page.generate_to(folder)?);
        Ok(())
    })
    .map_err(refused)?;
    context.print_files(&files)?;
    Ok(true)
}

fn pages(
    command: &clap::Command,
    write: &mut impl FnMut(clap_mangen::Man) -> std::io::Result<()>,
) -> std::io::Result<()> {
    write(clap_mangen::Man::new(command.clone()))?;
    let mut below = command.get_subcommands().filter(|command| command.get_name() != "help");
    below.try_for_each(|command| pages(command, write))
}

pub fn schema(context: &Context, args: &SchemaArgs) -> Result<bool, Failure> {
    let names = || PUBLISHED.map(|(name, _)| name);
    let Some(asked) = &args.name else {
        context.print(&names().to_vec(), || names().join("\n"))?;
        return Ok(true);
    };
    if let Some((_, text)) = PUBLISHED.iter().find(|(name, _)| name == asked) {
        say(text.trim_end())?;
    }
    Ok(true)
}
