//! The stages of the main job in their order.
//!
//! Simulate, calibrate, train, run, verify, optimize, schedule, report. Every stage is also a command of its own and uses the
//! functions here.

#[cfg(feature = "train")]
pub(crate) mod expected;
#[cfg(feature = "train")]
pub(crate) mod learn;

use crate::conformance::compare::verify_host;
use crate::conformance::digests::not_run;
use crate::conformance::qemu;
use crate::conformance::suite::{Case, ScheduleCase, Suite, Transform, stimuli};
use crate::conformance::verification::Verification;
use crate::error::{Failure, Invalid};
use crate::formats::slots::Slots;
use crate::network::early_exits::Policy;
use crate::network::early_exits::calibration::weights;
use crate::network::evaluation::Networks;
use crate::network::memory::OwnedMemory;
use crate::network::parameters::Images;
use crate::network::spectrograms::{Collected, Part, Recordings, picture};
use crate::optimizer::anytime;
use crate::optimizer::shares::integer_rates;
use crate::optimizer::{Rule, optimise};
use crate::predictor::bootstrap::replicates;
use crate::predictor::{best_curve, predict};
use crate::progress::Progress;
use crate::recordings;
use crate::results::{
    Accuracy, AnytimeResult, Calibration, Confusion, Curve, CurvePoint, OperatingPoint, Prediction,
    Recognised, Schedule, Spectrogram, Training, Verify,
};
use crate::scenario::{Class, Room, Scenario};
use crate::scheduling::campaign::radar::Station;
use crate::scheduling::playback;
use crate::simulator::channel::link::knows_walls;
use crate::simulator::dataset::{Set, recording};
use crate::simulator::{calibration, dataset};
use crate::store::output::Output;
use sdp3_core::dsn::Model;
use sdp3_core::early_exit::EarlyExit;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// What every stage needs.
#[derive(Debug, Clone)]
pub struct Job {
    pub scenario: Scenario,
    /// Seed of everything random.
    pub seed: u64,
    /// How to show progress.
    pub progress: Progress,
    pub output: Output,
}

/// A measured signal to calibrate on.
#[derive(Debug, Clone)]
pub struct Measured {
    pub file: PathBuf,
    /// What was stated about it.
    pub stated: recordings::Stated,
    /// How the person in it moves.
    pub motion: Class,
}

/// A standard deviation of an accuracy, in points, that needs no warning.
const MOST_UNCERTAIN_POINTS: f64 = 5.0;

/// The target of `verify` that needs no emulator: the core against its reference on this machine. The others are
/// [`qemu::MACHINES`].
pub const REFERENCE: &str = "host-reference";
/// The targets of `verify` unless others are named: the reference, a processor with an FPU and one without.
pub const TARGETS: [&str; 3] = [REFERENCE, "cortex-m4f", "riscv32imac"];

/// Networks and how well they recognise.
pub struct Learned {
    /// Model files in the order of `frame.sensing_slots`.
    pub models: Vec<Vec<u8>>,
    pub accuracy: Vec<Accuracy>,
    pub training: Vec<Training>,
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
            let signal = recordings::read(&measured.file, &measured.stated)?;
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

    /// A warning if the stored rho, which is used where the scenario states none, is of another carrier or slot interval.
    pub fn warn_of_rho(&self) {
        let stored =
            self.scenario.channel.rho.is_none().then(|| calibration::stored_elsewhere(&self.scenario));
        if let Some(text) = stored.flatten() {
            self.progress.note("calibrate", &format!("warning: {text}"));
        }
    }

    /// A note if the room was set to a size that the links do not depend on.
    pub fn note_room(&self) {
        let s = &self.scenario;
        let of_links = s.room != Room::default() && s.communication.slot_bit.is_none();
        if of_links && !knows_walls(s) {
            let text = format!(
                "room.size_m = {:?} does not change the throughput: links of channel.model = {} have no walls here; those of \
                 ray-tracing have, and those of dahc with channel.clusters = 80211ay",
                s.room.size_m,
                s.channel.model.name()
            );
            self.progress.note("optimize", &text);
        }
    }

    /// A warning if so few recordings are tested that an accuracy says little.
    pub fn warn_of_few_tests(&self) {
        let tested = self.scenario.learning.test_per_class * Class::ALL.len() as u32;
        // a share of n is uncertain by at most 0.5 / sqrt(n), one standard deviation
        let points = 50.0 / f64::from(tested).sqrt();
        if points > MOST_UNCERTAIN_POINTS {
            let text = format!(
                "warning: an accuracy over {tested} test recordings is uncertain by up to {points:.0} points; with \
                 learning.test_per_class = 100 by up to 2"
            );
            self.progress.note("test", &text);
        }
    }

    /// The first `per_class` recordings of every class of a part.
    pub fn recordings(&self, rho: f64, part: Part, per_class: u32) -> Recordings<'_> {
        Recordings { scenario: &self.scenario, rho, seed: self.seed, part, per_class }
    }

    /// The gallery: images of one recording per class, and the spectrograms at the largest N_s.
    pub fn gallery(&self, rho: f64) -> (Collected, Vec<Spectrogram>) {
        let shown = self.recordings(rho, Part::Demo, 1).images(&|_, _| ());
        let picture = |images: &Images| {
            let pictures = Class::ALL.iter().enumerate();
            pictures.map(|(n, class)| picture(&self.scenario, class.name(), images.image(n))).collect()
        };
        let spectrograms = shown.images.last().map(picture).unwrap_or_default();
        (shown, spectrograms)
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
                std: None,
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
    pub fn optimize(
        &self,
        curve: &Curve,
        points: &[CurvePoint],
        rule: Rule,
    ) -> Result<crate::optimizer::Outcome, Failure> {
        let stage = self.progress.stage("optimize", "accuracy against throughput");
        let replicates = replicates(curve, points, self.seed);
        let outcome = optimise(curve, points, &replicates, &self.scenario, rule, self.seed)?;
        let p = &outcome.operating_point;
        stage.finish(&format!(
            "N_s = {}: accuracy {:.3}, {:.0} bit per period ({:.3} Mbit/s) to the worst user",
            p.sensing_slots,
            p.accuracy,
            p.throughput_bit,
            p.throughput_bit / p.period_s / 1e6
        ));
        Ok(outcome)
    }

    /// Fits early exits on recordings that follow those trained on, and states what they reach on the test recordings.
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
        if models.len() > sdp3_core::early_exit::EXITS {
            let most = sdp3_core::early_exit::EXITS;
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
        use sdp3_core::scheduler::{Scheduler, SensingLayout, SlotUse, USERS};
        let parsed = models.iter().filter_map(|bytes| Model::parse(bytes).ok());
        let model = parsed
            .filter(|m| m.sensing_slots() <= point.sensing_slots as usize)
            .max_by_key(Model::sensing_slots)?;
        let class = Class::AdultWalking;
        let slots = recording(&self.scenario, rho, self.seed, Set::Demo, class, 1, point.sensing_slots).slots;
        let mut memory = OwnedMemory::for_model(&model);
        let pipeline = memory.early_exits(vec![EarlyExit::single(model)], 2.0).ok()?;
        let sensing =
            SensingLayout::new(point.period_slots, point.spacing_slots, point.sensing_slots).ok()?;
        let mut rates = [0; USERS];
        rates.iter_mut().zip(integer_rates(&point.slot_bit)).for_each(|(rate, own)| *rate = own);
        let mut station = Station::new(Scheduler::new(sensing, rates), pipeline);
        let mut signal = slots.iter();
        let mut found = None;
        for _ in 0..point.period_slots {
            if station.begin() == SlotUse::Sensing {
                found = station.sensed(signal.next()?).or(found);
            }
        }
        let found = found?;
        Some(Recognised {
            truth: class.name().to_owned(),
            class: model.class_name(usize::from(found.class)).to_owned(),
            confidence: f64::from(found.confidence),
        })
    }

    /// The suite for these models: one recording of every class for the largest, one for each other, and stimuli.
    pub fn suite(&self, rho: f64, models: &[Vec<u8>], schedule: ScheduleCase) -> Result<Suite, Failure> {
        let mut cases = Vec::new();
        for (index, bytes) in models.iter().enumerate() {
            let model = Model::parse(bytes).map_err(|e| format!("model {index}: {e}"))?;
            let slots = model.sensing_slots();
            let take = |class: Class, n: u32| -> Slots {
                recording(&self.scenario, rho, self.seed, Set::Demo, class, n, slots as u32).slots
            };
            let largest = index + 1 == models.len();
            let classes = if largest { &Class::ALL[..] } else { &Class::ALL[index % 5..=index % 5] };
            cases.extend(classes.iter().map(|&class| Case {
                name: format!("{} N_s={slots}", class.name()),
                model: bytes.clone(),
                transform: Transform::Fixed, // a microcontroller's
                slots: take(class, 2),
            }));
            if index == 0 {
                cases.extend(stimuli(bytes, slots, self.seed));
            }
        }
        Ok(Suite { cases, schedule })
    }

    /// Compares the core with the reference and the firmware with the core.
    ///
    /// # Errors
    ///
    /// A suite that cannot be run at all; a target that cannot run counts as a mismatch instead.
    pub fn verify(
        &self,
        suite: &Suite,
        targets: &[String],
        firmware: Option<&Path>,
    ) -> Result<Verify, Failure> {
        let mut verdicts = Vec::new();
        let wanted = |name: &str| targets.iter().any(|t| t == name);
        if wanted(REFERENCE) {
            let stage = self.progress.stage("verify", "the core against the reference");
            let verdict = verify_host(suite)?;
            stage.finish(&format!("{} values, {} mismatches", verdict.compared, verdict.mismatches));
            verdicts.push(verdict);
        }
        let names: Vec<&str> = qemu::MACHINES.into_iter().filter(|name| wanted(name)).collect();
        if !names.is_empty() {
            let folder = qemu::folder(firmware);
            let built = match firmware {
                Some(_) => Ok(()),
                None => qemu::build(&folder, "conformance", &names, &mut |line| {
                    self.progress.note("verify", line)
                }),
            };
            let stage = self.progress.stage("verify", "firmware under QEMU");
            let found = match built {
                Err(error) => names.iter().map(|name| not_run(name, error.to_string())).collect(),
                Ok(()) => {
                    let machines = qemu::machines(&folder, "conformance");
                    let machines: Vec<_> = machines.into_iter().filter(|m| wanted(m.name)).collect();
                    let verification =
                        Verification::new(suite, self.output.folder(), Duration::from_secs(240))?;
                    verification.firmware(&machines, &|_| ())?
                }
            };
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
