//! What a person sees while work goes on: a bar per stage on a terminal, plain lines elsewhere, nothing when quiet.
//!
//! Everything goes to stderr; stdout belongs to results. A terminal that has gone away is not missed.

use crate::text::shown;
use indicatif::{HumanDuration, ProgressBar, ProgressStyle};
use std::io::{IsTerminal, Write, stderr};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// How to show progress.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Progress {
    Quiet,
    /// Bars on a terminal; else a line when a stage begins, one every 1.5 s (less often in long stages), and one at its end.
    Shown,
}

/// Time between two plain lines of a stage: at least this, and this part of the time that the stage has taken.
const PLAIN: Duration = Duration::from_millis(1500);
const PLAIN_PART: u32 = 20;

impl Progress {
    /// Begins a stage of a known or unknown (0) length.
    pub fn stage(self, name: &'static str, what: &str) -> Stage {
        let terminal = stderr().is_terminal();
        let bar = match self {
            Progress::Shown if terminal => {
                let bar = ProgressBar::no_length();
                bar.set_style(style("{prefix:>10} {spinner} {msg}"));
                bar.enable_steady_tick(Duration::from_millis(200));
                bar
            }
            Progress::Shown => {
                line(name, what);
                ProgressBar::hidden()
            }
            Progress::Quiet => ProgressBar::hidden(),
        };
        bar.set_prefix(name);
        bar.set_message(shown(what).into_owned());
        let started = Instant::now();
        let plain = (self == Progress::Shown && !terminal).then(|| Mutex::new(started));
        Stage { bar, name, shown: self == Progress::Shown, started, plain }
    }

    /// A line for people.
    pub fn note(self, name: &str, text: &str) {
        if self == Progress::Shown {
            line(name, text);
        }
    }
}

fn line(name: &str, text: &str) {
    let _ = writeln!(stderr(), "{name:>10}  {}", shown(text));
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template)
        .unwrap_or_else(|_| ProgressStyle::default_bar())
        .progress_chars("=> ")
}

/// A stage under way.
#[derive(Debug)]
pub struct Stage {
    bar: ProgressBar,
    name: &'static str,
    shown: bool,
    started: Instant,
    /// When the last plain line was, where there is no terminal.
    plain: Option<Mutex<Instant>>,
}

impl Stage {
    /// `done` of `total` steps are done; may be called from any thread.
    pub fn at(&self, done: u64, total: u64) {
        self.set_length(total);
        self.bar.set_position(self.bar.position().max(done));
        self.report();
    }

    /// One more of `total` steps is done.
    pub fn step(&self, total: u64) {
        self.set_length(total);
        self.bar.inc(1);
        self.report();
    }

    /// What is being done right now.
    pub fn say(&self, text: &str) {
        self.bar.set_message(shown(text).into_owned());
    }

    /// Ends the stage with one line that says what came out.
    pub fn finish(self, outcome: &str) {
        self.bar.finish_and_clear();
        if self.shown {
            line(self.name, outcome);
        }
    }

    /// With the first length the spinner becomes a bar.
    fn set_length(&self, total: u64) {
        if self.bar.length().is_none() {
            self.bar.set_style(style("{prefix:>10} [{bar:30}] {pos}/{len} {msg} ({eta} left)"));
        }
        self.bar.set_length(total);
    }

    /// A plain line, if the last one is long ago.
    fn report(&self) {
        let Some(last) = &self.plain else { return };
        let mut last = last.lock().unwrap_or_else(PoisonError::into_inner);
        if last.elapsed() >= PLAIN.max(self.started.elapsed() / PLAIN_PART) {
            *last = Instant::now();
            let (bar, left) = (&self.bar, HumanDuration(self.bar.eta()));
            let total = bar.length().unwrap_or(0);
            line(self.name, &format!("{}/{total} {} ({left} left)", bar.position(), bar.message()));
        }
    }
}
