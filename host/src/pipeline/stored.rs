//! What an earlier command left in the output folder: its run, its scenario, its models.

use super::Job;
use crate::error::{Failure, Invalid};
use crate::formats::model_file::{self, QUANTIZE_FIRST, check_use};
use crate::report::{Live, paper::draw};
use crate::results::{Accuracy, CurvePoint, Figures, Run, TrainingHistory};
use crate::scenario::{Class, Scenario};
use crate::simulator::calibration::rho_of;
use crate::store::difference::difference;
use crate::store::digest::sha256;
use crate::store::limited;
use crate::store::output::{OutputError, Provenance};
use sdp3_core::dsn::Model;
use std::path::{Path, PathBuf};

/// The results of a run.
pub(super) const RUN: &str = "run.json";
/// File of what a run's figures show.
pub(super) const FIGURES: &str = "figures.json";

/// The page's program, for WebAssembly, beside the program that runs.
const PAGE_PROGRAM: &str = "sdp3-page.wasm";

/// What makes the files of a run.
pub const RUN_FIRST: &str = "`sdp3 run` with the same --out makes it";
/// What makes the networks.
pub(super) const TRAIN_FIRST: &str = "`sdp3 train` with the same --out makes it";

/// Accuracies as points of the learning curve.
pub fn points(accuracy: &[Accuracy]) -> Vec<CurvePoint> {
    let point = |a: &Accuracy| CurvePoint {
        sensing_slots: f64::from(a.sensing_slots),
        accuracy: a.int8,
        tested: Some(f64::from(a.tested)),
        std: None,
    };
    accuracy.iter().map(point).collect()
}

/// Refuses a model of other classes than simulated recordings have.
fn check_classes(model: &[u8]) -> Result<(), Failure> {
    let model = Model::parse(model)?;
    let names: Vec<&str> = (0..model.classes()).map(|class| model.class_name(class)).collect();
    let own = Class::ALL.map(Class::name);
    let legal = format!("{}, those of simulated recordings", own.join(", "));
    Ok(Invalid::unless(names == own, "classes", names.join(", "), legal)?)
}

impl Job {
    /// The run's results.
    ///
    /// # Errors
    ///
    /// No run, a file that is none, or a run of another scenario than the folder's.
    pub fn run(&self) -> Result<Run, OutputError> {
        Ok(self.run_and_provenance()?.0)
    }

    fn run_and_provenance(&self) -> Result<(Run, Provenance), OutputError> {
        let (run, made) = self.output.read_result(RUN, RUN_FIRST)?;
        if self.is_of_folder(&made) {
            return Ok((run, made));
        }
        let reason = format!("another scenario than {RUN} is of: a later command began with it; {RUN_FIRST}");
        Err(OutputError::Content { path: self.output.path(Scenario::FILE), reason })
    }

    /// The run of the folder's scenario, if there is one.
    ///
    /// # Errors
    ///
    /// A file that is no run.
    pub(super) fn own_run(&self) -> Result<Option<Run>, OutputError> {
        if !self.output.path(RUN).exists() {
            return Ok(None);
        }
        let (run, made) = self.output.read_result(RUN, RUN_FIRST)?;
        Ok(self.is_of_folder(&made).then_some(run))
    }

    /// Whether a result is of the folder's scenario.
    fn is_of_folder(&self, made: &Provenance) -> bool {
        let scenario = self.output.read(Scenario::FILE, RUN_FIRST);
        scenario.is_ok_and(|text| made.scenario_sha256 == Some(sha256([text.as_slice()])))
    }

    /// The seed of what was made with `own`: one that is given must be the same.
    ///
    /// # Errors
    ///
    /// Another one, in the words for `file`.
    pub(super) fn seed_of(&self, own: u64, file: &str) -> Result<u64, Failure> {
        match self.given.seed {
            Some(seed) if seed != own => {
                Err(Invalid::option("--seed", seed, format!("{own}, the seed of {file}")).into())
            }
            _ => Ok(own),
        }
    }

    /// The run's resolved scenario, which nothing changes any more: one that is given must be the same.
    ///
    /// # Errors
    ///
    /// The first field that differs; no scenario.
    pub(super) fn run_scenario(&self) -> Result<Scenario, Failure> {
        let made = self.output.path(Scenario::FILE);
        let found = Scenario::load(&made)?;
        let json = |scenario: &Scenario| serde_json::to_value(scenario).unwrap_or_default();
        let mut asked = self.trained_scenario()?;
        if self.given.scenario.is_some() && asked.learning != found.learning {
            // the run's preset may have been quick
            let (quick, _) = Scenario::quick(self.given.scenario.as_deref(), &self.given.set)?;
            asked = Some(quick).filter(|quick| quick.learning == found.learning).unwrap_or(asked);
        }
        match difference("", &json(&found), &json(&asked)) {
            None => Ok(found),
            Some((field, found, asked)) => Err(format!(
                "{}: {field} = {found}, but the command line says {asked}: what has been made is not changed; another --out takes \
                 another scenario",
                made.display()
            )
            .into()),
        }
    }

    /// The scenario that the folder's networks were trained in, or the one that is given; with what is set over it.
    ///
    /// # Errors
    ///
    /// A scenario that is missing or cannot be.
    pub(super) fn trained_scenario(&self) -> Result<Scenario, Failure> {
        if self.given.scenario.is_some() {
            return Ok(self.scenario.clone());
        }
        Ok(Scenario::resolve(Some(&self.output.path(Scenario::FILE)), &self.given.set)?)
    }

    /// The seed that is given, or that of the folder's networks: of its run, or else of its training.
    ///
    /// # Errors
    ///
    /// A run or a training that is none.
    pub(super) fn folder_seed(&self) -> Result<u64, OutputError> {
        if self.given.seed.is_some() {
            return Ok(self.seed);
        }
        if let Some(run) = self.own_run()? {
            return Ok(run.seed);
        }
        if !self.output.path(TrainingHistory::FILE).exists() {
            return Ok(self.seed);
        }
        let (_, made) = self.output.read_result::<TrainingHistory>(TrainingHistory::FILE, TRAIN_FIRST)?;
        Ok(made.seed.unwrap_or(self.seed))
    }

    /// The job in the scenario of the output folder, with the seed of its networks and the rho of its run, unless others are given.
    ///
    /// # Errors
    ///
    /// A training or a run that is none; a scenario that is missing or cannot be.
    pub(super) fn of_folder(self) -> Result<Self, Failure> {
        let (seed, mut scenario) = (self.folder_seed()?, self.trained_scenario()?);
        if let Some(run) = self.own_run()?.filter(|_| scenario.channel.rho.is_none()) {
            // that of a measurement is in no scenario
            scenario.channel.rho = Some(run.rho).filter(|&rho| rho != rho_of(&scenario));
        }
        Ok(Job { scenario, seed, output: self.output.of_seed(seed), ..self })
    }

    /// The models of every N_s of the scenario, each for its radar; `hint` says what makes them.
    ///
    /// # Errors
    ///
    /// A model that is missing, of another radar, or of other classes than simulated recordings have.
    pub(super) fn models(&self, hint: &'static str) -> Result<Vec<Vec<u8>>, Failure> {
        let stored = |&slots: &u32| {
            let name = model_file::name(slots);
            let bytes = self.output.read(&name, hint)?;
            let path = self.output.path(&name);
            check_use(&bytes, &self.scenario, slots).map_err(|e| format!("{}: {e}", path.display()))?;
            check_classes(&bytes).map_err(|e| format!("{}: {e}", path.display()))?;
            Ok(bytes)
        };
        self.scenario.frame.sensing_slots.iter().map(stored).collect()
    }

    /// Writes the scenario that a command's results are of beside them: `COMMAND-scenario.toml`.
    pub(super) fn record(&self, command: &str) -> Result<(), OutputError> {
        self.output.write(&format!("{command}-scenario.toml"), self.scenario.to_toml().as_bytes())?;
        Ok(())
    }

    /// A picture beside the results.
    pub(super) fn draw(&self, name: &str, svg: &str) -> Result<(), Failure> {
        draw(&self.output, name, svg)
    }

    /// Draws the page and the figures of the run again; the page's path. The page computes if there is a program for it: this one, or
    /// [`PAGE_PROGRAM`] beside the program that runs.
    ///
    /// # Errors
    ///
    /// A run that is not there, of another scenario than the one given, or with files of several runs; a file that is no program.
    pub fn report(self, program: Option<&Path>) -> Result<PathBuf, Failure> {
        let (run, made) = self.run_and_provenance()?;
        let (figures, with) = self.output.read_result::<Figures>(FIGURES, RUN_FIRST)?;
        let scenario = self.run_scenario()?;
        let refuse = |file: &str, field: &str, found: &str, must: &str| {
            let legal = format!("{must}, as {RUN} has: the files of one run");
            Invalid::new(field, found, legal).at(self.output.path(file).display())
        };
        if let Some((field, found, must)) = with.other_run(&made) {
            return Err(refuse(FIGURES, &format!("provenance.{field}"), &found, &must).into());
        }
        let job = Job { scenario, ..self };
        job.page(&run, &figures, program)
    }

    /// The program of a page in WebAssembly with the run's models.
    fn live(&self, program: &Path) -> Result<Live, Failure> {
        let bytes = limited::read(program, limited::NETWORK);
        let bytes = bytes.map_err(|error| format!("{}: {error}", program.display()))?;
        if !bytes.starts_with(b"\0asm") {
            let found = format!("{:?}", bytes[..bytes.len().min(4)].escape_ascii().to_string());
            let legal = "\"\\x00asm\", a program in WebAssembly: sdp3-page.wasm";
            return Err(Invalid::new("first bytes", found, legal).at(program.display()).into());
        }
        let models = self.models(QUANTIZE_FIRST)?;
        let models = self.scenario.frame.sensing_slots.iter().copied().zip(models);
        Ok(Live::new(&bytes, models, &self.scenario)?)
    }

    /// Pictures and page of a run, as of [`Job::report`]; the page's path.
    pub(super) fn page(
        &self,
        run: &Run,
        figures: &Figures,
        program: Option<&Path>,
    ) -> Result<PathBuf, Failure> {
        let beside = std::env::current_exe().ok().map(|path| path.with_file_name(PAGE_PROGRAM));
        let beside = beside.filter(|path| path.is_file());
        let live = program.or(beside.as_deref()).map(|file| self.live(file)).transpose()?;
        let page = crate::report::page(run, figures, &self.scenario.to_toml(), live.as_ref());
        for (name, bytes) in crate::report::paper::files(run, figures)? {
            self.output.write(&format!("figures/{name}"), &bytes)?;
        }
        Ok(self.output.write("report.html", page.as_bytes())?)
    }
}
