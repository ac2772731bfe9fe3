//! The paper's items as a command: tasks that are kept, results with verdicts, figures, one page.

use super::{Job, budget};
use crate::dataset::Shard;
use crate::error::Failure;
use crate::experiments::cells::Cells;
use crate::experiments::seeds::{DEVELOPMENT_SEED, seed_set};
use crate::experiments::{Request, RunContext, labelled};
use crate::recordings::Stated;
use crate::reproduce::items::tasks;
use crate::reproduce::page::{PAGE, page, read, same};
use crate::reproduce::work::Work;
use crate::reproduce::{Item, Size};
use crate::results::Reproduction;
use crate::scenario::Scenario;
use clap::ValueEnum;
use std::path::PathBuf;

/// What is asked.
#[derive(Debug, Clone)]
pub struct Reproduce {
    pub items: Vec<Item>,
    pub size: Size,
    /// How many seeds; absent: one of a quick size, else five.
    pub seeds: Option<u32>,
    /// A folder of measured recordings, and what is stated of them.
    pub measured: Option<(PathBuf, Stated)>,
    /// With one, its part of the tasks is done and nothing is put together.
    pub shard: Option<Shard>,
}

impl Job {
    /// Makes items again, or goes on with them; nothing of a shard.
    ///
    /// # Errors
    ///
    /// Seeds of several sets; a folder of another size or seed; whatever a training says.
    pub fn reproduce(mut self, ask: &Reproduce) -> Result<Vec<Reproduction>, Failure> {
        let first = self.given.seed.unwrap_or(DEVELOPMENT_SEED);
        self.output = self.output.of_seed(first);
        if ask.size == Size::Quick {
            let (scenario, sizes) = Scenario::quick(self.given.scenario.as_deref(), &self.given.set)?;
            self.scenario = scenario;
            self.progress.note("reproduce", &format!("{sizes}; --set takes others"));
        }
        let tested = self.scenario.learning.test_per_class;
        self.budget.check_memory(&budget::training(&self.scenario, tested, self.workers))?;
        let seeds = ask.seeds.unwrap_or(if ask.size == Size::Quick { 1 } else { 5 });
        let study = format!("reproduce-{}", ask.size.name());
        let request = Request { study, seed: first, seeds, scenario: self.scenario.clone() };
        let all: Vec<u64> = request.each_seed().collect();
        seed_set(&all)?;
        let measured = match &ask.measured {
            Some((folder, stated)) => labelled::read(folder, stated)?.0,
            None => Vec::new(),
        };
        let work = Work {
            base: self.scenario.clone(),
            size: ask.size,
            seeds: all,
            cells: Cells::open(&self.output, &request)?,
            context: RunContext { progress: self.progress, workers: self.workers, budget: self.budget },
            measured,
        };
        let tasks = tasks(&ask.items, &work.seeds);
        if let Some(shard) = ask.shard {
            for (n, task) in tasks.iter().enumerate() {
                if shard.has(n as u32) {
                    work.run(*task)?;
                }
            }
            return Ok(Vec::new());
        }
        let found = ask.items.iter().map(|item| item.make(&work)).collect::<Result<Vec<_>, _>>()?;
        same(&found)?;
        let there = |item: &Item| self.output.path(&format!("{}.json", item.name())).is_file();
        if Item::value_variants().iter().all(there) {
            self.output.write(PAGE, page(&read(self.output.folder())?, ".").as_bytes())?;
        }
        Ok(found)
    }
}
