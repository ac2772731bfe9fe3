//! The `sdp3` command: parses, executes, and sets the exit code.

mod cli;

use clap::Parser;
use cli::{Cli, execute};
use std::process::ExitCode;

fn main() -> ExitCode {
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
    match execute(cli) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(1),
        Err(error) => refused(&error.to_string()),
    }
}

fn refused(reason: &str) -> ExitCode {
    eprintln!("sdp3: {reason}");
    ExitCode::from(2)
}
