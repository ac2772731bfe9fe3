//! What a person sees while work goes on: a bar per stage on a terminal, plain lines elsewhere, nothing when quiet.
//!
//! Everything goes to stderr; stdout belongs to results.

use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;

/// How to show progress.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Progress {
    /// Nothing.
    Quiet,
    /// Bars on a terminal, else one line when a stage begins.
    Shown,
}

impl Progress {
    /// Begins a stage of a known or unknown (0) length.
    pub fn stage(self, name: &'static str, what: &str) -> Stage {
        let bar = match self {
            Progress::Quiet => ProgressBar::hidden(),
            Progress::Shown if std::io::stderr().is_terminal() => {
                let bar = ProgressBar::new(0);
                let style = ProgressStyle::with_template("{prefix:>10} [{bar:30}] {pos}/{len} {msg} ({eta})");
                bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()).progress_chars("=> "));
                bar
            }
            Progress::Shown => {
                eprintln!("{name:>10}  {what}");
                ProgressBar::hidden()
            }
        };
        bar.set_prefix(name);
        bar.set_message(what.to_owned());
        Stage { bar, name, shown: self == Progress::Shown }
    }

    /// A line for people.
    pub fn note(self, name: &str, text: &str) {
        if self == Progress::Shown {
            eprintln!("{name:>10}  {text}");
        }
    }
}

/// A stage under way.
#[derive(Debug)]
pub struct Stage {
    bar: ProgressBar,
    name: &'static str,
    shown: bool,
}

impl Stage {
    /// `done` of `total` steps are done; may be called from any thread.
    pub fn at(&self, done: u64, total: u64) {
        self.bar.set_length(total);
        self.bar.set_position(self.bar.position().max(done));
    }

    /// One more of `total` steps is done.
    pub fn step(&self, total: u64) {
        self.bar.set_length(total);
        self.bar.inc(1);
    }

    /// What is being done right now.
    pub fn say(&self, text: &str) {
        self.bar.set_message(text.to_owned());
    }

    /// Ends the stage with one line that says what came out.
    pub fn finish(self, outcome: &str) {
        self.bar.finish_and_clear();
        if self.shown {
            eprintln!("{:>10}  {outcome}", self.name);
        }
    }
}
