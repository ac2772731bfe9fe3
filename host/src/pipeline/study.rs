//! Studies as commands: cells that are kept, a table, figures.

use super::Job;
use super::expected::Work;
use crate::error::{Failure, Invalid};
use crate::experiments::ablation::effects::EFFECTS;
use crate::experiments::ablation::{self, Ablation};
use crate::experiments::baselines::{self, Baselines};
use crate::experiments::carriers::CARRIERS_HZ;
use crate::experiments::cells::Cells;
use crate::experiments::clutter::{self, Clutter};
use crate::experiments::fidelity::{self, Fidelity};
use crate::experiments::learning_curve::{self, LearningCurve};
use crate::experiments::robustness::{self, Robustness};
use crate::experiments::seeds::{DEVELOPMENT_SEED, FINAL_SEED};
use crate::experiments::selection::{self, Selection};
use crate::experiments::sim_to_real::{self, SimToReal};
use crate::experiments::{Request, RunContext, Study, labelled};
use crate::recordings::Stated;
use crate::report;
use crate::scenario::Scenario;
use serde::Serialize;
use std::path::Path;

/// What a study found.
#[derive(Debug, Clone, Serialize)]
#[serde(untagged)]
pub enum Found {
    LearningCurve(Box<LearningCurve>),
    Robustness(Robustness),
    Fidelity(Box<Fidelity>),
    SimToReal(Box<SimToReal>),
    Baselines(Baselines),
    Ablation(Box<Ablation>),
    Clutter(Clutter),
    Selection(Selection),
}

impl Found {
    /// The result in words.
    pub fn table(&self, request: &Request) -> String {
        match self {
            Found::LearningCurve(found) => learning_curve::table(request, found),
            Found::Robustness(found) => robustness::table(request, found),
            Found::Fidelity(found) => fidelity::table(request, found),
            Found::SimToReal(found) => sim_to_real::table(request, found),
            Found::Baselines(found) => baselines::table(request, found),
            Found::Ablation(found) => ablation::table(request, found),
            Found::Clutter(found) => clutter::table(request, found),
            Found::Selection(found) => selection::table(request, found),
        }
    }

    /// Its figures, by name.
    fn figures(&self) -> Vec<(String, String)> {
        match self {
            Found::LearningCurve(found) => {
                vec![("learning-curve".into(), report::studies::learning_curve(found))]
            }
            Found::Robustness(found) => vec![("robustness".into(), report::studies::robustness(found))],
            Found::Fidelity(found) => report::fidelity::pictures(found),
            Found::SimToReal(found) => vec![("sim-to-real".into(), report::fidelity::confusion(found))],
            Found::Baselines(found) => vec![("baselines".into(), report::studies::baselines(found))],
            // a table of differences with their intervals says it without a picture
            Found::Ablation(_) | Found::Clutter(_) | Found::Selection(_) => Vec::new(),
        }
    }
}

impl Job {
    /// A note of the time that a study will take, as if none of its cells were there yet.
    ///
    /// # Errors
    ///
    /// More memory or time than the budget has.
    fn say_study(&self, study: Study, seeds: u32) -> Result<(), Invalid> {
        let mut job = self.clone();
        let of_seed = match study {
            Study::LearningCurve => 1,
            Study::Baselines => baselines::METHODS.len(),
            Study::Fidelity => fidelity::DOMAINS.len(),
            // its seconds are not the scenario's recordings; about as much work
            Study::SimToReal => 1,
            Study::Robustness => {
                let conditions = robustness::conditions(self.scenario.radar.range_samples);
                conditions.iter().filter(|c| c.matched).count()
            }
            Study::Ablation => CARRIERS_HZ.len() * (EFFECTS.len() + 1),
            Study::Clutter => clutter::RATIOS_DB.len() * clutter::FIRST_KEPT.len(),
            Study::Selection => CARRIERS_HZ.len() * selection::CANDIDATES.len(),
        };
        if matches!(study, Study::Fidelity | Study::Robustness) {
            job.scenario.frame.sensing_slots = vec![self.scenario.largest_sensing_slots()];
        }
        job.check_cost(Work::Study(seeds * of_seed as u32), job.rho())?;
        if study == Study::Baselines && cfg!(feature = "svm") {
            self.progress.note(
                "expected",
                "the support vector machine's cross-validation takes longer than the networks",
            );
        }
        Ok(())
    }

    /// Makes a study, or goes on with it; `measured` is a folder of recordings for [`Study::Fidelity`] and [`Study::SimToReal`]. Those
    /// on which settings are chosen, [`Study::Ablation`], [`Study::Clutter`] and [`Study::Selection`], have seeds from
    /// [`DEVELOPMENT_SEED`] on and below [`FINAL_SEED`].
    ///
    /// # Errors
    ///
    /// `measured` for another study, or none for [`Study::SimToReal`]; a seed of another set; a folder of another study; whatever a
    /// training or a recording says.
    pub fn study(
        mut self,
        study: Study,
        seeds: u32,
        measured: Option<(&Path, &Stated)>,
    ) -> Result<(Request, Found), Failure> {
        match (measured, study) {
            (None, Study::SimToReal) => {
                return Err("command line: sim-to-real needs --measured FOLDER".into());
            }
            (None, _) | (_, Study::Fidelity | Study::SimToReal) => (),
            _ => {
                return Err("command line: --measured belongs to the studies fidelity and sim-to-real".into());
            }
        }
        if matches!(study, Study::Ablation | Study::Clutter | Study::Selection) {
            self.seed = self.given.seed.unwrap_or(DEVELOPMENT_SEED);
            let last = self.seed + u64::from(seeds) - 1;
            if self.seed < DEVELOPMENT_SEED || last >= FINAL_SEED {
                let legal = format!(
                    "{DEVELOPMENT_SEED} to {}: smaller seeds are those of tests, larger ones of the final test",
                    FINAL_SEED - 1
                );
                let asked = match seeds {
                    1 => last.to_string(),
                    _ => format!("{} to {last}", self.seed),
                };
                return Err(Invalid::option("--seed", asked, legal).into());
            }
            self.output = self.output.of_seed(self.seed);
        }
        if matches!(study, Study::Ablation | Study::Clutter) {
            let (scenario, sizes) = Scenario::comparison(self.given.scenario.as_deref(), &self.given.set)?;
            self.scenario = scenario;
            if !sizes.is_empty() {
                self.progress.note("study", &format!("{sizes}; --set takes others"));
            }
        }
        let request =
            Request { study: study.name(), seed: self.seed, seeds, scenario: self.scenario.clone() };
        self.warn_of_few_tests();
        self.warn_of_rho();
        self.say_study(study, seeds)?;
        let cells = Cells::open(&self.output, &request)?;
        let context = RunContext { progress: self.progress, workers: self.workers, budget: self.budget };
        let recordings = measured.map(|(folder, stated)| labelled::read(folder, stated)).transpose()?;
        let recordings = recordings.unwrap_or_default();
        let found = match study {
            Study::LearningCurve => {
                Found::LearningCurve(Box::new(learning_curve::study(&request, &cells, context)?))
            }
            Study::Robustness => Found::Robustness(robustness::study(&request, &cells, context)?),
            Study::Fidelity => {
                Found::Fidelity(Box::new(fidelity::study(&request, &cells, recordings, context)?))
            }
            Study::SimToReal => {
                Found::SimToReal(Box::new(sim_to_real::study(&request, &cells, recordings, context)?))
            }
            Study::Baselines => Found::Baselines(baselines::study(&request, &cells, context)?),
            Study::Ablation => Found::Ablation(Box::new(ablation::study::study(&request, &cells, context)?)),
            Study::Clutter => Found::Clutter(clutter::study(&request, &cells, context)?),
            Study::Selection => Found::Selection(selection::study(&request, &cells, context)?),
        };
        for (name, svg) in found.figures() {
            self.draw(&name, &svg)?;
        }
        Ok((request, found))
    }
}
