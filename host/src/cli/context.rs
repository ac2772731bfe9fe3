//! What every command has: the common options, the scenario they give, and where results go.

use crate::error::Failure;
use crate::pipeline::{Given, Job};
use crate::progress::Progress;
use crate::results::Files;
use crate::scenario::budget::{Budget, Memory, Time};
use crate::scenario::{Override, Scenario};
use crate::store::output::{Output, OutputError, to_json};
use crate::text::{printable_json, shown};
use clap::builder::{PossibleValuesParser, RangedU64ValueParser, TypedValueParser};
use clap::{Args, ValueEnum};
use serde::Serialize;
use std::ops::RangeInclusive;
use std::path::PathBuf;

/// Size of the main job.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Preset {
    /// Minutes: fewer recordings and epochs, a smaller network. A size that the scenario's file or --set states is kept.
    Quick,
    /// The scenario's sizes; where it states none the paper's: 200 recordings per class to train, 500 to test.
    Paper,
}

/// Options of every command.
#[derive(Debug, Clone, Args)]
pub struct Common {
    /// Scenario in TOML, or the name of one that `sdp3 scenario list` lists; absent: the paper's conference room.
    #[arg(long, global = true, value_name = "FILE.toml|NAME")]
    pub scenario: Option<PathBuf>,
    /// Set a field over the scenario, such as radar.carrier_hz=24e9 or frame.sensing_slots=[200,300]. May be given several
    /// times; the resolved scenario beside the results has it.
    #[allow(rustdoc::broken_intra_doc_links)] // a list of numbers
    #[arg(long, global = true, value_name = "FIELD=VALUE")]
    pub set: Vec<Override>,
    /// Seed of everything random [default: 1]
    #[arg(long, global = true, value_parser = clap::value_parser!(u64).range(..1 << 53))]
    pub seed: Option<u64>,
    /// Folder for results.
    #[arg(long, global = true, default_value = "out", value_name = "DIR")]
    pub out: PathBuf,
    /// Threads, at most 1024; 0 takes all processors. Results do not depend on it.
    #[arg(long, global = true, default_value_t = 0, value_parser = RangedU64ValueParser::<usize>::new().range(..=1024))]
    pub threads: usize,
    /// Refuse what would need more memory by its estimate, before it begins; such as 500M or 8GiB.
    #[arg(long, global = true, value_name = "SIZE", default_value = "4GiB")]
    pub max_memory: Memory,
    /// Refuse what would take longer by its estimate, before it begins; such as 90s, 10m, 12h or 30d.
    #[arg(long, global = true, value_name = "TIME", default_value = "30d")]
    pub max_time: Time,
    /// Print results as JSON, and nothing else, on stdout.
    #[arg(long, global = true)]
    pub json: bool,
    /// Print more on stderr.
    #[arg(short, long, global = true)]
    pub verbose: bool,
    /// Print only errors on stderr.
    #[arg(short, long, global = true)]
    pub quiet: bool,
}

impl Common {
    /// The seed, 1 if none is given.
    pub fn seed(&self) -> u64 {
        self.seed.unwrap_or(1)
    }

    /// What the command may take.
    pub fn budget(&self) -> Budget {
        Budget { memory: self.max_memory, time: self.max_time }
    }
}

/// Options, scenario and progress of a command.
#[derive(Debug)]
pub struct Context {
    /// The common options.
    pub common: Common,
    /// The scenario they give, checked.
    pub scenario: Scenario,
    /// How to show progress.
    pub progress: Progress,
}

impl Context {
    /// Reads and checks the scenario.
    pub fn new(common: Common) -> Result<Self, Failure> {
        let progress = if common.quiet { Progress::Quiet } else { Progress::Shown };
        let scenario = Scenario::resolve(common.scenario.as_deref(), &common.set)?;
        if common.verbose {
            let file = common.scenario.as_ref().map_or("built in".into(), |file| file.display().to_string());
            progress.note("sdp3", &format!("scenario {} ({file}), seed {}", scenario.name, common.seed()));
            let threads = rayon::current_num_threads();
            progress.note("sdp3", &format!("{threads} threads, results in {}", common.out.display()));
        }
        crate::simulator::validity::check(&scenario)?;
        Ok(Context { common, scenario, progress })
    }

    /// The scenario and a writable output folder.
    pub fn job(&self) -> Result<Job, OutputError> {
        let Common { scenario, set, seed, out, .. } = &self.common;
        let output = Output::create(out)?.of_seed(self.common.seed());
        if let Some(leftover) = output.leftover() {
            self.progress.note(
                "sdp3",
                &format!(
                    "{}: left half-written, or being written: this file system has no locks",
                    leftover.display()
                ),
            );
        }
        Ok(Job {
            scenario: self.scenario.clone(),
            seed: self.common.seed(),
            progress: self.progress,
            output,
            budget: self.common.budget(),
            #[cfg(feature = "train")]
            workers: self.workers(),
            #[cfg(feature = "train")]
            stop: std::sync::Arc::default(),
            given: Given { scenario: scenario.clone(), set: set.clone(), seed: *seed },
        })
    }

    /// Threads to train on.
    pub fn workers(&self) -> usize {
        let all = std::thread::available_parallelism().map_or(1, usize::from);
        if self.common.threads == 0 { all } else { self.common.threads }
    }

    /// A result on stdout: as JSON, or in words if there are any.
    pub fn print(&self, value: &impl Serialize, words: impl FnOnce() -> String) -> Result<(), Failure> {
        let text = if self.common.json { to_json(value) } else { words() };
        // of both a terminal shows what a file or a name holds
        let text = if self.common.json { printable_json(&text) } else { shown(&text) };
        if text.is_empty() { Ok(()) } else { say(&text) }
    }

    /// One of several results on stdout: as a line of JSON, or in words.
    pub fn print_line(&self, value: &impl Serialize, words: impl FnOnce() -> String) -> Result<(), Failure> {
        let text = if self.common.json { serde_json::to_string(value)? } else { words() };
        say(&if self.common.json { printable_json(&text) } else { shown(&text) })
    }

    /// The files that were written, one on a line.
    pub fn print_files(&self, files: &[PathBuf]) -> Result<(), Failure> {
        let names = Files(files.iter().map(|file| file.display().to_string()).collect());
        self.print(&names, || names.0.join("\n"))
    }
}

/// A parser of a whole number within `range`.
pub fn count(
    range: RangeInclusive<u32>,
) -> impl Fn(&str) -> Result<u32, String> + Clone + Send + Sync + 'static {
    move |text| {
        let number: i64 = text.parse().map_err(|error: std::num::ParseIntError| error.to_string())?;
        let legal = u32::try_from(number).ok().filter(|number| range.contains(number));
        legal.ok_or_else(|| format!("{number} is not in {} to {}", range.start(), range.end()))
    }
}

/// A parser of a closed choice by its names, which clap lists, suggests and completes.
pub fn one_of<T: Copy + Send + Sync + 'static>(
    all: &'static [T],
    name: fn(T) -> &'static str,
) -> impl TypedValueParser<Value = T> {
    let find = move |text: String| all.iter().copied().find(|one| name(*one) == text).ok_or("unknown");
    PossibleValuesParser::new(all.iter().map(|one| name(*one))).try_map(find)
}

/// A line or more on stdout. A reader who has gone away has read enough.
pub fn say(text: &str) -> Result<(), Failure> {
    use std::io::{ErrorKind, Write, stdout};
    let written = writeln!(stdout(), "{text}").and_then(|()| stdout().flush());
    match written {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(format!("stdout: cannot be written: {error}").into())
        }
        _ => Ok(()),
    }
}
