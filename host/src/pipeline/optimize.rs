//! Predict and optimize: the learning curve, the accuracy-throughput region, the operating point, early exits.

#[cfg(feature = "train")]
use super::expected::Work;
use super::{Job, budget, stored};
use crate::error::{Failure, Invalid};
use crate::formats::{model_file::QUANTIZE_FIRST, points};
use crate::network::early_exits::Policy;
use crate::network::early_exits::calibration::weights;
use crate::network::evaluation::Networks;
use crate::network::retest::Retest;
use crate::network::spectrograms::Part;
use crate::optimizer::spacings::{Measured, spacings};
use crate::optimizer::sweep::{self, Axis, Sweep};
use crate::optimizer::{self, Outcome, Rule, early_exits, optimise};
use crate::predictor::bootstrap::replicates;
use crate::predictor::{Model, best_curve, fit_all, predict};
use crate::report::{self, figures, plot::Medium};
use crate::results::{Accuracy, Curve, CurvePoint, EarlyExitResult, Optimum, Prediction, Retested, SweepRow};
use crate::scenario::Class;
use crate::simulator::validity;
use sdp3_core::early_exit::EXITS;
use std::collections::BTreeMap;
use std::path::Path;

/// The curve of that name.
fn fitted(prediction: &Prediction, model: Model) -> Result<Curve, Failure> {
    let found = prediction.models.iter().find(|m| m.name == model.name());
    let m = found.ok_or_else(|| {
        format!("command line: --curve {}: it has no fit through these points", model.name())
    })?;
    Ok(Curve { model: m.name.clone(), parameters: m.parameters, rmse: m.rmse })
}

impl Job {
    /// The learning curve through accuracies.
    ///
    /// # Errors
    ///
    /// Too few points.
    pub(super) fn predict(&self, accuracy: &[Accuracy]) -> Result<(Prediction, Curve), Failure> {
        let prediction = predict(&stored::points(accuracy), self.seed)?;
        let curve = best_curve(&prediction);
        let text = format!("A(N_s) by {}, rmse {:.4}", curve.model, curve.rmse);
        self.progress.note("predict", &text);
        Ok((prediction, curve))
    }

    /// The curves through the points of a file, or else the accuracies of the run: `predict.json` and a figure.
    ///
    /// # Errors
    ///
    /// No points, or too few of them; a folder that cannot be written.
    pub fn prediction(self, file: Option<&Path>) -> Result<Prediction, Failure> {
        let (job, points, origin) = match file {
            Some(file) => (self, points::read_one_spacing(file)?, format!("{}: ", file.display())),
            None => self.with_points_of_run()?,
        };
        job.budget.check_time(&budget::fits(points.len())).map_err(|e| format!("{origin}{e}"))?;
        let prediction = predict(&points, job.seed).map_err(|e| format!("{origin}{e}"))?;
        job.output.write_result("predict.json", &prediction)?;
        job.draw("predict", &figures::learning_curve(&prediction, &[]).svg(Medium::SINGLE))?;
        Ok(prediction)
    }

    /// The accuracies of the run, with which the job goes on in the run's scenario and with its seed; and nothing for messages.
    fn with_points_of_run(self) -> Result<(Self, Vec<CurvePoint>, String), Failure> {
        let points = stored::points(&self.run()?.accuracy);
        Ok((self.of_folder()?, points, String::new()))
    }

    /// Tests the models in the output folder again, on test recordings simulated in the folder's scenario with what is set over it, and
    /// with the run's seed and rho unless others are given. Nothing is trained. The job that goes on, and what was found.
    ///
    /// # Errors
    ///
    /// Models that are not there, or of another radar; recordings beyond the budget.
    pub fn retest(self) -> Result<(Self, Retested), Failure> {
        let job = self.of_folder()?;
        let rho = job.rho();
        let models = job.models(QUANTIZE_FIRST)?;
        validity::check(&job.scenario)?;
        #[cfg(feature = "train")]
        job.check_cost(Work::Classify(job.scenario.learning.test_per_class), rho)?;
        let retest = Retest::new(&job.scenario, rho, job.seed, &models)?;
        let stage = job.progress.stage("run", "networks on test recordings");
        let found = retest.part(0..retest.recordings(), &|done, all| stage.at(done, all));
        let words: Vec<String> =
            found.accuracy.iter().map(|a| format!("{} {:.3}", a.sensing_slots, a.int8)).collect();
        stage.finish(&format!("int8 accuracy by N_s at rho = {rho}: {}", words.join(", ")));
        drop(retest);
        Ok((job, found))
    }

    /// The best learning curve, or `model`'s, at every N_m: through what was tested again, else the points of a file, else the
    /// accuracies of the run; and the job that goes on.
    ///
    /// # Errors
    ///
    /// No points; too few of them for that curve.
    pub fn learning_curves(
        self,
        retested: Option<&Retested>,
        file: Option<&Path>,
        model: Option<Model>,
    ) -> Result<(Self, Vec<Measured>), Failure> {
        let (job, stated, origin) = match (retested, file) {
            (Some(retested), _) => (self, [(None, retested.points())].into(), String::new()),
            (None, Some(file)) => (self, points::read(file)?, format!("{}: ", file.display())),
            (None, None) => {
                let (job, points, origin) = self.with_points_of_run()?;
                (job, [(None, points)].into(), origin)
            }
        };
        let own = job.scenario.frame.spacing_slots;
        let mut by_spacing: BTreeMap<u32, Vec<CurvePoint>> = BTreeMap::new();
        for (spacing, points) in stated {
            by_spacing.entry(spacing.unwrap_or(own)).or_default().extend(points);
        }
        if by_spacing.is_empty() {
            by_spacing.insert(own, Vec::new());
        }
        let count = by_spacing.values().map(Vec::len).sum();
        job.budget.check_time(&budget::fits(count)).map_err(|e| format!("{origin}{e}"))?;
        let several = by_spacing.len() > 1;
        let measured = |(spacing_slots, points): (u32, Vec<CurvePoint>)| -> Result<Measured, Failure> {
            let of = if several { format!("N_m = {spacing_slots}: ") } else { String::new() };
            let prediction = fit_all(&points).map_err(|e| format!("{origin}{of}{e}"))?;
            let curve = match model {
                None => best_curve(&prediction),
                Some(model) => fitted(&prediction, model)?,
            };
            Ok(Measured { spacing_slots, curve, points })
        };
        let measured = by_spacing.into_iter().map(measured).collect::<Result<Vec<_>, _>>()?;
        Ok((job, measured))
    }

    /// Region and operating point.
    ///
    /// # Errors
    ///
    /// See [`crate::optimizer::OptimizerError`].
    pub(super) fn optimize(
        &self,
        curve: &Curve,
        points: &[CurvePoint],
        rule: Option<Rule>,
    ) -> Result<Outcome, Failure> {
        let stage = self.progress.stage("optimize", "accuracy against throughput");
        let replicates = replicates(curve, points, self.seed);
        let outcome = optimise(curve, points, &replicates, &self.scenario, self.rule(rule), self.seed)?;
        let p = &outcome.operating_point;
        stage.finish(&format!(
            "N_s = {}: accuracy {:.3}, {:.0} bit per period ({:.3} Mbit/s) to the worst user. {}",
            p.sensing_slots,
            p.accuracy,
            p.throughput_bit,
            p.throughput_bit / p.period_s / 1e6,
            p.channels
        ));
        Ok(outcome)
    }

    /// Region and operating point as files, of the best N_m where there are several: `boundary.csv`, `optimize.json`, a figure.
    ///
    /// # Errors
    ///
    /// As [`Self::optimize`]; a folder that cannot be written.
    pub fn optimum(
        mut self,
        measured: Vec<Measured>,
        rule: Option<Rule>,
        retested: Option<Retested>,
    ) -> Result<Optimum, Failure> {
        for one in &measured {
            budget::regions(&one.scenario(&self.scenario), self.budget, 1)?;
        }
        let (best, spacings) = match measured.len() {
            0 | 1 => (0, Vec::new()),
            _ => spacings(&self.scenario, &measured, self.rule(rule), self.seed)?,
        };
        let best = measured.into_iter().nth(best).ok_or("points: none given")?;
        self.scenario = best.scenario(&self.scenario);
        let Measured { curve, points, .. } = best;
        let points = points.as_slice();
        self.warn_of_aliasing(&Class::ALL);
        self.note_room();
        let outcome = self.optimize(&curve, points, rule)?;
        self.record("optimize")?;
        self.output.fill("boundary.csv", |file| {
            optimizer::write_boundary(file, &curve, points, &self.scenario, &outcome.cases)
        })?;
        let found = Optimum { retested, spacings, ..outcome.optimum(curve, &self.scenario) };
        self.output.write_result("optimize.json", &found)?;
        let region = figures::region(&found.region, &found.operating_point, &found.cases, points);
        self.draw("optimize", &region.svg(Medium::SINGLE))?;
        Ok(found)
    }

    /// The operating points of other links: `sweep.csv`.
    ///
    /// # Errors
    ///
    /// Points of several N_m; links that are stated, not computed; a value no scenario has; a folder that cannot be written.
    pub fn vary_links(
        mut self,
        measured: &[Measured],
        rule: Option<Rule>,
        axes: &[Sweep],
    ) -> Result<Vec<SweepRow>, Failure> {
        let [one] = measured else {
            return Err("command line: --sweep takes points of one N_m".into());
        };
        self.scenario = one.scenario(&self.scenario);
        if self.scenario.communication.slot_bit.is_some() {
            return Err(
                "command line: --sweep varies channels; communication.slot_bit states links without one"
                    .into(),
            );
        }
        budget::regions(&self.scenario, self.budget, sweep::combinations(axes))?;
        self.progress.note("optimize", self.scenario.communication.channels());
        if axes.iter().any(|axis| axis.axis == Axis::Carrier) {
            let text = "warning: the accuracies are those of the points at every carrier; a sweep shows what a carrier does to the links";
            self.progress.note("optimize", text);
        }
        let rows = sweep::rows(&self.scenario, (&one.curve, &one.points), self.rule(rule), axes, self.seed)?;
        self.record("optimize")?;
        let table = report::tables::sweep(&rows, self.scenario.period_s(), b',');
        self.output.write("sweep.csv", table.as_bytes())?;
        Ok(rows)
    }

    /// The rule that is given, or else the scenario's weight.
    fn rule(&self, given: Option<Rule>) -> Rule {
        given.unwrap_or(Rule::Weighted(self.scenario.optimizer.accuracy_weight))
    }

    /// Early exits of the models in the output folder, in the scenario that they were trained in: `early-exits.json` and a figure. The
    /// period of that scenario in s is returned too.
    ///
    /// # Errors
    ///
    /// As [`Self::fit_exits`]; models that are not there.
    pub fn early_exits(
        mut self,
        per_class: u32,
        rule: Option<Rule>,
    ) -> Result<(EarlyExitResult, f64), Failure> {
        self = self.of_folder()?;
        budget::regions(&self.scenario, self.budget, 1)?;
        #[cfg(feature = "train")]
        self.check_cost(Work::Classify(per_class + self.scenario.learning.test_per_class), self.rho())?;
        let found = self.fit_exits(self.rho(), &self.models(QUANTIZE_FIRST)?, per_class, self.rule(rule))?;
        self.record("early-exits")?;
        self.output.write_result("early-exits.json", &found)?;
        let period_s = self.scenario.period_s();
        self.draw("early-exits", &report::early_exits::region(&found, period_s).svg(Medium::SINGLE))?;
        Ok((found, period_s))
    }

    /// Fits early exits on recordings that follow those trained on, and states what they reach on the test recordings.
    ///
    /// # Errors
    ///
    /// Models the core refuses; more exits than it takes; a rule no point satisfies.
    fn fit_exits(
        &self,
        rho: f64,
        models: &[Vec<u8>],
        per_class: u32,
        rule: Rule,
    ) -> Result<EarlyExitResult, Failure> {
        let s = &self.scenario;
        if models.len() > EXITS {
            let most = EXITS;
            return Err(
                Invalid::new("frame.sensing_slots (exits)", models.len(), format!("1 to {most}")).into()
            );
        }
        let networks = Networks::parse(models, &s.frame.sensing_slots)?;
        let gather = |part: Part, per_class: u32, what: &str| {
            let stage = self.progress.stage("early exits", what);
            let recordings = self.recordings(rho, part, per_class);
            let found = networks.recordings(&recordings, &|done, all| stage.at(done, all));
            stage.finish(&format!("{what}: {per_class} of each class"));
            found
        };
        let calibration = gather(Part::Calibration, per_class, "recordings to calibrate on");
        let test = gather(Part::Test, s.learning.test_per_class, "test recordings");
        let policy = Policy::new(&calibration.slots, weights(&calibration));
        Ok(early_exits::outcome(s, self.seed, &policy, &calibration, &test, rule)?)
    }
}
