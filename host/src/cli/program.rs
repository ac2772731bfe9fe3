//! The program: from the command line to the exit code.

use super::{Cli, execute};
use crate::text::shown;
use clap::Parser;
use std::io::Write;
use std::process::ExitCode;

/// The program: parses the command line, executes it, and says the exit code.
pub fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return usage_error(error),
    };
    if let Err(error) = rayon::ThreadPoolBuilder::new().num_threads(cli.common.threads).build_global() {
        return refused(&format!("--threads: {error}"));
    }
    if let Err(error) = end_on_interrupt(cli.resumption()) {
        return refused(&format!("interrupts cannot be caught: {error}"));
    }
    if let Err(error) = catch_file_limit() {
        return refused(&format!("SIGXFSZ cannot be caught: {error}"));
    }
    match execute(cli) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(1),
        Err(error) => refused(&error.to_string()),
    }
}

/// Prints the parser's error, help or version. An error quotes arguments unescaped, so the escaped arguments are parsed again.
fn usage_error(error: clap::Error) -> ExitCode {
    let arguments = std::env::args_os().map(|argument| shown(&argument.to_string_lossy()).into_owned());
    let error = Cli::try_parse_from(arguments).err().unwrap_or(error);
    let _ = error.print();
    ExitCode::from(if error.use_stderr() { 2 } else { 0 })
}

fn refused(reason: &str) -> ExitCode {
    let _ = writeln!(std::io::stderr(), "sdp3: {}", shown(reason));
    ExitCode::from(2)
}

/// Ctrl-C leaves whole files only, says how to go on, and ends with the code of that signal.
fn end_on_interrupt(resumption: &'static str) -> Result<(), ctrlc::Error> {
    ctrlc::set_handler(move || {
        crate::store::partial::abandon();
        let _ = writeln!(std::io::stderr(), "\nsdp3: interrupted, nothing is half-written; {resumption}");
        std::process::exit(130);
    })
}

/// A file beyond the limit of the system is an error of its writing. Uncaught, the signal that comes first would end the program without a
/// word.
#[cfg(unix)]
fn catch_file_limit() -> std::io::Result<()> {
    let seen = std::sync::Arc::new(std::sync::atomic::AtomicBool::new(false));
    signal_hook::flag::register(signal_hook::consts::SIGXFSZ, seen).map(|_| ())
}

#[cfg(not(unix))]
fn catch_file_limit() -> std::io::Result<()> {
    Ok(())
}
