//! The main job: every stage once, each fed by the one before, then the files of the run: `run.json`, `figures.json`, the page.

use super::expected::Work;
use super::learn::{How, class_names};
use super::simulate::Measured;
use super::verify::{REFERENCE, Targets};
use super::{Job, budget};
use crate::error::{Failure, Invalid};
use crate::network::early_exits;
use crate::network::parameters::Images;
use crate::network::spectrograms::{Collected, Part, picture};
use crate::network::training::Backend;
use crate::results::{Calibration, EarlyExitGallery, Figures, OperatingPoint, Run, Schedule, Spectrogram};
use crate::scenario::{Class, Scenario};
use crate::scheduling::playback;
use crate::simulator::calibration::stored_rho;
use sdp3_core::early_exit::EXITS;
use std::path::PathBuf;

/// What is asked of the main job, beside the scenario.
#[derive(Debug, Clone)]
pub struct MainJob {
    /// Whether sizes that nobody stated are the quick ones.
    pub quick: bool,
    /// Whether to go on from the checkpoints that are there.
    pub resume: bool,
    /// `None`: rho is the scenario's or the stored one.
    pub measured: Option<Measured>,
    pub targets: Targets,
}

/// A measurement says nothing about carriers that differ by more than this share.
const SAME_CARRIER: f64 = 0.2;

impl Job {
    /// All stages; the run's results and the path of its page.
    ///
    /// # Errors
    ///
    /// Any of the stages'.
    pub fn main_job(mut self, ask: &MainJob) -> Result<(Run, PathBuf), Failure> {
        self.size(ask.quick)?;
        let slots = &self.scenario.frame.sensing_slots;
        let legal =
            "at least 2 numbers: a learning curve goes through their accuracies; `sdp3 train` takes 1";
        Invalid::unless(slots.len() > 1, "frame.sensing_slots", format!("{slots:?}"), legal)?;
        budget::regions(&self.scenario, self.budget, 1)?;
        self.warn_of_aliasing(&Class::ALL);
        self.note_near_field();
        self.warn_of_few_tests();
        self.note_room();
        let calibrates = ask.measured.is_none();
        if calibrates {
            self.warn_of_rho();
        }
        let emulated = ask.targets.names.iter().filter(|target| *target != REFERENCE).count();
        self.check_cost(Work::Run { calibrates, emulated }, self.rho())?;
        // a refused --resume leaves the folder's own; training writes it when it has checked its checkpoints
        if !ask.resume {
            self.output.write(Scenario::FILE, self.scenario.to_toml().as_bytes())?;
        }
        let calibration = self.calibrate(ask.measured.as_ref())?;
        let rho = self.rho_used(&calibration, ask.measured.is_some());
        let (shown, spectrograms) = self.gallery(rho);
        let (learned, training) =
            self.learn(rho, &How::new(Backend::default(), ask.resume, &class_names()))?;
        let models = &learned.models;
        self.write_models(models)?;
        let (prediction, curve) = self.predict(&learned.accuracy)?;
        let outcome = self.optimize(&curve, &prediction.points, None)?;
        let point = &outcome.operating_point;
        let schedule = self.play(point, rho, models)?;
        let plans = outcome.region.iter().map(|p| playback::plan(p, point)).collect::<Result<_, _>>()?;
        let early_exits = self.classify_gallery(rho, models, point, &shown)?;
        let run = Run {
            scenario: self.scenario.name.clone(),
            seed: self.seed,
            rho,
            accuracy: learned.accuracy,
            curve,
            verify: self.verify(rho, models, point, &ask.targets)?,
            region: outcome.region.clone(),
            operating_point: point.clone(),
            schedule,
            report: "report.html".into(),
        };
        let figures = Figures {
            classes: Class::ALL.iter().map(|c| c.name().to_owned()).collect(),
            spectrograms,
            calibration,
            training,
            confusion: learned.confusion,
            prediction,
            weighted: outcome.weighted,
            cases: outcome.cases,
            plans,
            early_exits,
        };
        let output = self.output.clone().of_scenario(&self.scenario.to_toml());
        output.write_result(super::stored::RUN, &run)?;
        output.write_result(super::stored::FIGURES, &figures)?;
        let page = self.page(&run, &figures, None)?;
        Ok((run, page))
    }

    /// The scenario's rho, or else the calibration's. That of a measurement is used only at its own carrier, brought to the scenario's interval.
    fn rho_used(&self, calibration: &Calibration, measured: bool) -> f64 {
        let other = (calibration.carrier_hz / self.scenario.radar.carrier_hz - 1.0).abs() >= SAME_CARRIER;
        let (rho, why) = match self.scenario.channel.rho {
            Some(rho) => (rho, "channel.rho states it".into()),
            None if measured && other => {
                self.warn_of_rho();
                (stored_rho(&self.scenario).0, "the measurement is at another carrier".into())
            }
            None => {
                let intervals_s = [calibration.interval_s, self.scenario.rho_interval_s()];
                let [from_ms, to_ms] = intervals_s.map(|s| 1e3 * s);
                (calibration.rho_at(intervals_s[1]), format!("that of {from_ms} ms, brought to {to_ms} ms"))
            }
        };
        if rho != calibration.rho {
            self.progress.note("calibrate", &format!("rho = {rho} is used: {why}"));
        }
        rho
    }

    /// The gallery: images of one recording per class, and the spectrograms at the largest N_s.
    fn gallery(&self, rho: f64) -> (Collected, Vec<Spectrogram>) {
        let shown = self.recordings(rho, Part::Demo, 1).images(&|_, _| ());
        let picture = |images: &Images| {
            let pictures = Class::ALL.iter().enumerate();
            pictures.map(|(n, class)| picture(&self.scenario, class.name(), images.image(n))).collect()
        };
        let spectrograms = shown.images.last().map(picture).unwrap_or_default();
        (shown, spectrograms)
    }

    /// Plays one period, with simulated signals in the sensing slots.
    fn play(&self, point: &OperatingPoint, rho: f64, models: &[Vec<u8>]) -> Result<Schedule, Failure> {
        let mut schedule = playback::play(point)?;
        schedule.recognised = playback::recognise(&self.scenario, self.seed, point, rho, models);
        let text = format!(
            "{} sensing and {:?} communication slots, longest waits {:?}",
            schedule.sensing_slots, schedule.communication_slots, schedule.longest_wait_slots
        );
        self.progress.note("schedule", &text);
        Ok(schedule)
    }

    /// The gallery with early exits at the operating point's accuracy, fitted on as many recordings as are tested.
    fn classify_gallery(
        &self,
        rho: f64,
        models: &[Vec<u8>],
        point: &OperatingPoint,
        shown: &Collected,
    ) -> Result<Option<EarlyExitGallery>, Failure> {
        let stage = self.progress.stage("early exits", "the gallery's recordings");
        let calibration = self.recordings(rho, Part::Calibration, self.scenario.learning.test_per_class);
        let found =
            early_exits::gallery::gallery(models, &calibration, point.accuracy, shown, &|done, all| {
                stage.at(done, all)
            })?;
        stage.finish(&match &found {
            Some(found) => {
                let slots: Vec<u32> = found.recordings.iter().map(|r| r.stops_after).collect();
                format!("the gallery's recordings stop after {slots:?} slots")
            }
            None => format!("no early exits: at most {EXITS} exits, {} networks", models.len()),
        });
        Ok(found)
    }
}
