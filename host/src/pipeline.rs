//! The main job: the floors of the house in their order.
//!
//! simulate, calibrate, learn, run, prove, trade, schedule, report. Every stage is also a command of its own and uses the
//! functions here.

use crate::conformance::compare::{CaseError, OwnedBuffers, verify_host};
use crate::conformance::digests::{compare, digests, not_run};
use crate::conformance::qemu;
use crate::conformance::suite::{Case, ScheduleCase, Suite, stimuli};
use crate::formats::measured;
use crate::optimizer::anytime;
use crate::optimizer::shares::integer_rates;
use crate::optimizer::{Rule, optimise, playback};
use crate::output::Output;
use crate::predictor::anytime::calibration::weights;
use crate::predictor::anytime::{Part, Policy, collect};
use crate::predictor::learning_curve::bootstrap::replicates;
use crate::predictor::learning_curve::{best_curve, predict};
use crate::predictor::spectrograms::{images_of, picture};
use crate::progress::Progress;
use crate::results::{
    Accuracy, AnytimeResult, Calibration, Confusion, Curve, CurvePoint, OperatingPoint, Prediction,
    Recognised, Schedule, Spectrogram, Training, Verify,
};
use crate::scenario::{Class, Scenario};
use crate::simulator::dataset::{Set, recording};
use crate::simulator::{calibration, dataset};
use sdp3_core::anytime::{Anytime, Exit};
use sdp3_core::dsn::{Model, Portable};
use sdp3_core::frame::Slot;
use sdp3_core::station::Station;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Any refusal or failure of a command: exit code 2.
pub type Failure = Box<dyn std::error::Error + Send + Sync>;

/// What every stage needs.
#[derive(Debug, Clone)]
pub struct Job {
    /// The checked scenario.
    pub scenario: Scenario,
    /// Seed of everything random.
    pub seed: u64,
    /// How to show progress.
    pub progress: Progress,
    /// Where results go.
    pub output: Output,
}

/// A measured signal to calibrate on.
#[derive(Debug, Clone)]
pub struct Measured {
    /// The file.
    pub file: PathBuf,
    /// What was stated about it.
    pub stated: measured::Stated,
    /// How the person in it moves.
    pub motion: Class,
}

/// The targets of `verify`, by name.
pub const TARGETS: [&str; 3] = ["host-reference", "cortex-m4f", "riscv32imac"];

/// Networks and how well they recognise.
pub struct Learned {
    /// Model files in the order of `frame.sensing_slots`.
    pub models: Vec<Vec<u8>>,
    /// Accuracies.
    pub accuracy: Vec<Accuracy>,
    /// Histories.
    pub training: Vec<Training>,
    /// Confusion matrices.
    pub confusion: Vec<Confusion>,
}

impl Job {
    /// Finds rho: from a measured signal, from the scenario, or from the stored table.
    ///
    /// # Errors
    ///
    /// An unreadable measurement.
    pub fn calibrate(&self, measured: Option<&Measured>) -> Result<Calibration, Failure> {
        let s = &self.scenario;
        if let Some(measured) = measured {
            let signal = measured::read(&measured.file, &measured.stated)?;
            let stage = self.progress.stage("calibrate", "rho on the measured signal");
            let found =
                calibration::calibrate_measured(s, &signal, measured.motion, self.seed, &|done, all| {
                    stage.at(done, all)
                })
                .map_err(|error| format!("{}: {error}", measured.file.display()))?;
            stage.finish(&format!(
                "rho = {} with KL {:.4}, {:.4} without uncertainty",
                found.rho,
                found.kl.unwrap_or(f64::NAN),
                found.kl_without_uncertainty.unwrap_or(f64::NAN)
            ));
            return Ok(found);
        }
        let (rho, source) = match s.channel.rho {
            Some(rho) => (rho, format!("scenario: channel.rho = {rho}")),
            None => calibration::stored_rho(s),
        };
        let stage = self.progress.stage("calibrate", "self-check of the stored rho");
        let found = calibration::recover(s, rho, &source, self.seed, &|done, all| stage.at(done, all));
        stage.finish(&format!("rho = {rho}: {source}"));
        Ok(found)
    }

    /// A warning if limbs alias.
    pub fn warn_of_aliasing(&self) {
        if let Some(a) = dataset::aliasing(&self.scenario) {
            let cure = match a.spacing_slots {
                Some(n) => format!("frame.spacing_slots = {n} would not"),
                None => "no spacing of these slots would not".to_owned(),
            };
            let text = format!(
                "warning: limbs at {:.1} m/s alias above {:.1} m/s at this carrier and spacing; {cure}",
                a.limb_m_s, a.unambiguous_m_s
            );
            self.progress.note("simulate", &text);
        }
    }

    /// One spectrogram per class.
    pub fn gallery(&self, rho: f64) -> Vec<Spectrogram> {
        let s = &self.scenario;
        let slots = s.largest_sensing_slots();
        Class::ALL
            .iter()
            .map(|&class| {
                let recording = recording(s, rho, self.seed, Set::Demo, class, 0, slots);
                let image = images_of(s, &recording.slots).pop().unwrap_or_default();
                picture(s, class.name(), &image)
            })
            .collect()
    }

    /// The learning curve through accuracies.
    ///
    /// # Errors
    ///
    /// Too few points.
    pub fn predict(&self, accuracy: &[Accuracy]) -> Result<(Prediction, Curve), Failure> {
        let points: Vec<CurvePoint> = accuracy
            .iter()
            .map(|a| CurvePoint {
                sensing_slots: f64::from(a.sensing_slots),
                accuracy: a.int8,
                tested: Some(f64::from(a.tested)),
            })
            .collect();
        let prediction = predict(&points, self.seed)?;
        let curve = best_curve(&prediction);
        let text = format!("A(N_s) by {}, rmse {:.4}", curve.model, curve.rmse);
        self.progress.note("predict", &text);
        Ok((prediction, curve))
    }

    /// Region and operating point.
    ///
    /// # Errors
    ///
    /// See [`crate::optimizer::OptimizerError`].
    pub fn trade(
        &self,
        curve: &Curve,
        points: &[CurvePoint],
        rule: Rule,
    ) -> Result<crate::optimizer::Outcome, Failure> {
        let stage = self.progress.stage("trade", "accuracy against throughput");
        let replicates = replicates(curve, points, self.seed);
        let outcome = optimise(curve, &replicates, &self.scenario, rule, self.seed)?;
        let p = &outcome.operating_point;
        stage.finish(&format!(
            "N_s = {}: accuracy {:.3}, {:.0} bit per period to the worst receiver",
            p.sensing_slots, p.accuracy, p.throughput_bit
        ));
        Ok(outcome)
    }

    /// Fits anytime sensing on recordings behind those trained on and states what it reaches on the test recordings.
    ///
    /// # Errors
    ///
    /// Models the core refuses; more exits than it takes; a rule no point satisfies.
    pub fn anytime(
        &self,
        rho: f64,
        models: &[Vec<u8>],
        per_class: u32,
        rule: Rule,
    ) -> Result<AnytimeResult, Failure> {
        let s = &self.scenario;
        if models.len() > sdp3_core::anytime::EXITS {
            let most = sdp3_core::anytime::EXITS;
            return Err(format!("frame.sensing_slots: {} exits; legal are 1..={most}", models.len()).into());
        }
        let gather = |part: Part, per_class: u32, what: &str| {
            let stage = self.progress.stage("anytime", what);
            let found =
                collect(s, rho, self.seed, models, (part, per_class), &|done, all| stage.at(done, all))?;
            stage.finish(&format!("{what}: {per_class} of each class"));
            Ok::<_, Failure>(found)
        };
        let calibration = gather(Part::Calibration, per_class, "recordings to calibrate on")?;
        let test = gather(Part::Test, s.learning.test_per_class, "test recordings")?;
        let policy = Policy::new(&calibration.slots, weights(&calibration));
        Ok(anytime::outcome(s, self.seed, &policy, &calibration, &test, rule)?)
    }

    /// Plays one period, with simulated signals in the sensing slots if models are given.
    ///
    /// # Errors
    ///
    /// Numbers that are not a plan.
    pub fn play(&self, point: &OperatingPoint, rho: f64, models: &[Vec<u8>]) -> Result<Schedule, Failure> {
        let mut schedule = playback::play(point)?;
        schedule.recognised = self.recognise(point, rho, models);
        let text = format!(
            "{} sensing and {:?} communication slots, longest waits {:?}",
            schedule.sensing_slots, schedule.communication_slots, schedule.longest_wait_slots
        );
        self.progress.note("schedule", &text);
        Ok(schedule)
    }

    /// The core's station on an adult walking, with the largest model that fits the point's sensing slots.
    fn recognise(&self, point: &OperatingPoint, rho: f64, models: &[Vec<u8>]) -> Option<Recognised> {
        use sdp3_core::schedule::{RECEIVERS, Scheduler, Sensing, SlotUse};
        let parsed = models.iter().filter_map(|bytes| Model::parse(bytes).ok());
        let model = parsed
            .filter(|m| m.sensing_slots() <= point.sensing_slots as usize)
            .max_by_key(Model::sensing_slots)?;
        let class = Class::AdultWalking;
        let slots = recording(&self.scenario, rho, self.seed, Set::Demo, class, 1, point.sensing_slots).slots;
        let mut buffers = OwnedBuffers::for_model(&model);
        let receiver = Anytime::new([Exit::alone(model.clone(), Portable)], 2.0, buffers.view()).ok()?;
        let sensing = Sensing::new(point.period_slots, point.spacing_slots, point.sensing_slots).ok()?;
        let mut rates = [0; RECEIVERS];
        rates.iter_mut().zip(integer_rates(&point.slot_bit)).for_each(|(rate, own)| *rate = own);
        let mut station = Station::new(Scheduler::new(sensing, rates), receiver);
        let mut signal = slots.iter();
        let mut verdict = None;
        for _ in 0..point.period_slots {
            if station.begin() == SlotUse::Sensing {
                verdict = station.sensed(signal.next()?).or(verdict);
            }
        }
        let verdict = verdict?;
        Some(Recognised {
            truth: class.name().to_owned(),
            class: model.class_name(usize::from(verdict.class)).to_owned(),
            confidence: f64::from(verdict.confidence),
        })
    }

    /// The suite for these models: one recording of every class for the largest, one for each other, and stimuli.
    pub fn suite(&self, rho: f64, models: &[Vec<u8>], schedule: ScheduleCase) -> Result<Suite, Failure> {
        let mut cases = Vec::new();
        for (index, bytes) in models.iter().enumerate() {
            let model = Model::parse(bytes).map_err(|e| format!("model {index}: {e}"))?;
            let slots = model.sensing_slots();
            let take = |class: Class, n: u32| -> Vec<Slot> {
                recording(&self.scenario, rho, self.seed, Set::Demo, class, n, slots as u32).slots
            };
            let largest = index + 1 == models.len();
            let classes = if largest { &Class::ALL[..] } else { &Class::ALL[index % 5..=index % 5] };
            cases.extend(classes.iter().map(|&class| Case {
                name: format!("{} N_s={slots}", class.name()),
                model: bytes.clone(),
                slots: take(class, 2),
            }));
            if index == 0 {
                cases.extend(stimuli(bytes, slots, self.seed));
            }
        }
        Ok(Suite { cases, schedule })
    }

    /// Holds the core to the reference and the firmware to the core.
    ///
    /// # Errors
    ///
    /// A suite that cannot be run at all; a target that cannot run counts as a mismatch instead.
    pub fn prove(
        &self,
        suite: &Suite,
        targets: &[String],
        firmware: Option<&Path>,
    ) -> Result<Verify, Failure> {
        let mut verdicts = Vec::new();
        let wanted = |name: &str| targets.iter().any(|t| t == name);
        if wanted(TARGETS[0]) {
            let stage = self.progress.stage("prove", "the core against the reference");
            let verdict = verify_host(suite)?;
            stage.finish(&format!("{} values, {} mismatches", verdict.compared, verdict.mismatches));
            verdicts.push(verdict);
        }
        if TARGETS[1..].iter().any(|name| wanted(name)) {
            let folder = qemu::folder(firmware);
            let built = match firmware {
                Some(_) => Ok(()),
                None => qemu::build(&folder, &mut |line| self.progress.note("prove", line)),
            };
            let here = digests(suite).map_err(|e: CaseError| e.to_string())?;
            // a name of its own: another process may prove in the same folder
            let name = format!("conformance-{}.sdps", std::process::id());
            let file = self.output.write(&name, &suite.to_bytes())?;
            let run = |machine: &qemu::Firmware| match &built {
                Err(error) => not_run(machine.name, error.to_string()),
                Ok(()) => match qemu::run(machine, &file, Duration::from_secs(240)) {
                    Err(error) => not_run(machine.name, error.to_string()),
                    Ok(report) => {
                        let cases: Vec<_> = report.cases.iter().map(|case| case.stages.clone()).collect();
                        let most = report.cases.iter().filter_map(|case| case.instructions).max();
                        compare(machine.name, &here, &cases, report.schedule, most)
                    }
                },
            };
            let machines: Vec<_> = qemu::targets(&folder).into_iter().filter(|m| wanted(m.name)).collect();
            let stage = self.progress.stage("prove", "firmware under QEMU");
            let found: Vec<_> = std::thread::scope(|scope| {
                let running: Vec<_> = machines.iter().map(|m| scope.spawn(|| run(m))).collect();
                running.into_iter().filter_map(|thread| thread.join().ok()).collect()
            });
            let _ = std::fs::remove_file(&file);
            let words: Vec<String> =
                found.iter().map(|v| format!("{} {}/{} differ", v.name, v.mismatches, v.compared)).collect();
            stage.finish(&words.join(", "));
            verdicts.extend(found);
        }
        Ok(Verify {
            compared: verdicts.iter().map(|v| v.compared).sum(),
            mismatches: verdicts.iter().map(|v| v.mismatches).sum(),
            targets: verdicts,
        })
    }
}
