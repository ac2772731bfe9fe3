//! The program: from the command line to the exit code.

use super::{Cli, execute};
use clap::Parser;
use std::io::Write;
use std::process::ExitCode;

/// The program: parses the command line, executes it, and says the exit code.
pub fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            let _ = error.print();
            return ExitCode::from(if error.use_stderr() { 2 } else { 0 });
        }
    };
    if let Err(error) = rayon::ThreadPoolBuilder::new().num_threads(cli.common.threads).build_global() {
        return refused(&format!("--threads: {error}"));
    }
    if let Err(error) = end_on_interrupt(cli.resumption()) {
        return refused(&format!("interrupts cannot be caught: {error}"));
    }
    match execute(cli) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(1),
        Err(error) => refused(&error.to_string()),
    }
}

fn refused(reason: &str) -> ExitCode {
    let _ = writeln!(std::io::stderr(), "sdp3: {reason}");
    ExitCode::from(2)
}

/// Ctrl-C leaves whole files only, says how to go on, and ends with the code of that signal.
fn end_on_interrupt(resumption: &'static str) -> Result<(), ctrlc::Error> {
    ctrlc::set_handler(move || {
        crate::store::output::abandon();
        let _ = writeln!(std::io::stderr(), "\nsdp3: interrupted, nothing is half-written; {resumption}");
        std::process::exit(130);
    })
}
