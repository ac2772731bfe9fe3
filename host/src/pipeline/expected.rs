//! How long trainings, studies and the main job will take, said before they begin: rough, a factor of two either way.
//!
//! Simulation is timed on a short recording of the scenario's own channel. Training is counted in products of the networks' forward
//! passes, at the speed per processor that docs/benchmarks.md has.

use super::{Job, budget};
use crate::error::Invalid;
use crate::network::spectrograms::{images_of, images_of_beats};
use crate::progress::Progress;
use crate::scenario::budget::Need;
use crate::scenario::{Class, Scenario};
use crate::simulator::calibration::PEOPLE;
use crate::simulator::calibration::divergence::EVALUATIONS;
use crate::simulator::calibration::sensor::SETTLE_SLOTS;
use crate::simulator::dataset::{Set, beats, recording};
use indicatif::HumanDuration;
use sdp3_core::dims::ROWS;
use std::time::{Duration, Instant};

/// Products that a processor trains in a second: 27e9 with AVX-512 (docs/benchmarks.md), fewer in narrow networks.
const TRAINED_PER_S: f64 = 2e10;
/// The same of the tuning with int8's rounding, which is not vectorised as well.
const TUNED_PER_S: f64 = 1e9;
/// Time of one emulated target in s, its build aside.
const EMULATED_S: f64 = 5.0;

/// What is still to be done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Work {
    /// Simulate training recordings and train.
    Train,
    /// So many trainings of a study, each with its test.
    Study(u32),
    /// Simulate so many recordings of each class and classify them by every network.
    Classify(u32),
    /// The main job, with a self-check of rho or not, and so many emulated targets.
    Run {
        /// Whether rho is calibrated on simulated recordings.
        calibrates: bool,
        emulated: usize,
    },
}

/// Seconds that a sensing slot takes on one processor.
#[derive(Debug, Clone, Copy)]
pub(super) struct Slot {
    beats_s: f64,
    /// Simulated as raw samples, and made an image.
    raw_s: f64,
    /// Beats made an image.
    image_s: f64,
}

impl Job {
    /// Notes the time that `work` will take, and refuses what is beyond the budget.
    ///
    /// # Errors
    ///
    /// More memory or time than the budget has.
    pub(super) fn check_cost(&self, work: Work, rho: f64) -> Result<(), Invalid> {
        let l = &self.scenario.learning;
        let tested = match work {
            Work::Train => 0,
            Work::Classify(per_class) => per_class,
            _ => l.test_per_class,
        };
        if !matches!(work, Work::Classify(_)) {
            self.budget.check_memory(&budget::training(&self.scenario, tested, self.workers))?;
        }
        let workers = self.workers;
        let seconds = seconds(&self.scenario, work, slot(&self.scenario, rho, self.seed), workers);
        let (classes, networks) = (Class::ALL.len() as u32, self.scenario.frame.sensing_slots.len());
        let training = format!(
            "{} recordings to train, {} to test, {} epochs of {} images for each of {networks} networks",
            classes * l.train_per_class,
            classes * tested,
            l.epochs,
            classes * l.train_per_class * l.windows,
        );
        let what = match work {
            Work::Classify(per_class) => format!("{} recordings", classes * per_class),
            Work::Study(trainings) => format!("{trainings} trainings, each of {training}"),
            Work::Train | Work::Run { .. } => training,
        };
        say(self.progress, seconds, workers, &what);
        self.budget.check_time(&[need(work, &self.scenario, seconds)])
    }
}

/// The time that work takes, by the fields that it follows from.
fn need(work: Work, scenario: &Scenario, seconds: f64) -> Need {
    let l = &scenario.learning;
    let training =
        format!("{} x {} x {} x {:?}", l.train_per_class, l.windows, l.epochs, scenario.frame.sensing_slots);
    let fields = "learning.train_per_class x learning.windows x learning.epochs x frame.sensing_slots";
    match work {
        Work::Study(trainings) if trainings > 1 => {
            Need::new("trainings of the study or sweep", trainings, seconds)
        }
        Work::Classify(per_class) => Need::new("recordings of each class", per_class, seconds),
        _ => Need::new(fields, training, seconds),
    }
}

pub(super) fn say(progress: Progress, seconds: f64, workers: usize, what: &str) {
    let time = HumanDuration(Duration::from_secs_f64(seconds.ceil()));
    progress.note("expected", &format!("about {time} on {workers} processors, a rough estimate: {what}"));
}

/// Timed on one short recording; the faster of two, as the first one fills caches.
pub(super) fn slot(scenario: &Scenario, rho: f64, seed: u64) -> Slot {
    let mut short = scenario.clone();
    short.frame.sensing_slots.truncate(1);
    let slots = short.largest_sensing_slots();
    let class = Class::AdultWalking;
    let timed = |work: &dyn Fn()| {
        let once = || {
            let begun = Instant::now();
            work();
            begun.elapsed().as_secs_f64() / f64::from(slots)
        };
        once().min(once())
    };
    let simulated = beats(&short, rho, seed, Set::Demo, class, 0, slots).0;
    Slot {
        beats_s: timed(&|| drop(beats(&short, rho, seed, Set::Demo, class, 0, slots))),
        raw_s: timed(&|| {
            drop(images_of(&short, &recording(&short, rho, seed, Set::Demo, class, 0, slots).slots))
        }),
        image_s: timed(&|| drop(images_of_beats(&short, &simulated))),
    }
}

pub(super) fn seconds(scenario: &Scenario, work: Work, slot: Slot, workers: usize) -> f64 {
    let l = &scenario.learning;
    let classes = Class::ALL.len() as f64;
    let largest = scenario.largest_sensing_slots();
    let recordings = classes * f64::from(l.train_per_class);
    let images = recordings * f64::from(l.windows);
    let slots: u32 = scenario.frame.sensing_slots.iter().sum();
    let products: f64 = scenario.frame.sensing_slots.iter().map(|&n| products(scenario, n)).sum();
    let train = recordings * f64::from(l.training_slots(largest)) * slot.beats_s
        + images * f64::from(slots) * slot.image_s
        + images * f64::from(l.epochs) * products / TRAINED_PER_S;
    let raw = |recordings: u32| classes * f64::from(recordings) * f64::from(largest) * slot.raw_s;
    let rest = match work {
        Work::Train => 0.0,
        Work::Study(trainings) => {
            return f64::from(trainings) * (train + raw(l.test_per_class)) / workers as f64;
        }
        Work::Classify(per_class) => return raw(per_class) / workers as f64,
        Work::Run { calibrates, emulated } => {
            let tested = classes * f64::from(l.test_per_class) * f64::from(largest);
            let compared = if calibrates { EVALUATIONS as f64 * f64::from(PEOPLE) } else { 0.0 };
            compared * f64::from(SETTLE_SLOTS + largest) * slot.beats_s
                + f64::from(l.qat_images) * products / TUNED_PER_S
                // tested in float and through the core; as many recordings fit the early exits
                + tested * (2.0 * slot.raw_s + slot.beats_s)
                + emulated as f64 * EMULATED_S * workers as f64
        }
    };
    (train + rest) / workers as f64
}

/// Products of the network for `slots` sensing slots on one image: stem and blocks of two convolutions behind its pooling.
fn products(scenario: &Scenario, slots: u32) -> f64 {
    let l = &scenario.learning;
    let frames = scenario.spectrogram.preprocessing().frames(slots as usize);
    let stem = (ROWS.div_ceil(l.stem_stride.into()) * frames.div_ceil(l.stem_stride.into())) as f64;
    let channels = f64::from(l.channels);
    9.0 * stem * channels + f64::from(l.blocks) * 2.0 * 9.0 * channels * channels * stem / 4.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_network_of_the_benchmarks_has_the_products_they_state() {
        let mut scenario = Scenario::default();
        (scenario.learning.channels, scenario.learning.blocks, scenario.learning.stem_stride) = (16, 5, 1);
        // 64 frames: 24.2 million products
        let slots = (128 + 63 * 8) as u32;
        assert!((products(&scenario, slots) / 24.2e6 - 1.0).abs() < 0.01, "{}", products(&scenario, slots));
    }

    #[test]
    fn time_grows_with_what_is_done_and_falls_with_processors() {
        let slot = Slot { beats_s: 1e-6, raw_s: 1e-5, image_s: 1e-6 };
        let run = Work::Run { calibrates: true, emulated: 2 };
        let scenario = Scenario::default();
        let of = |scenario: &Scenario, work, workers| seconds(scenario, work, slot, workers);
        let mut twice = scenario.clone();
        twice.learning.epochs *= 2;
        assert!(of(&scenario, Work::Train, 1) < of(&scenario, run, 1));
        assert!(of(&scenario, Work::Train, 1) < of(&twice, Work::Train, 1));
        assert!(of(&scenario, Work::Train, 1) < of(&scenario, Work::Study(1), 1));
        assert_eq!(of(&scenario, Work::Study(3), 1), 3.0 * of(&scenario, Work::Study(1), 1));
        // five classes of 10 recordings, 1000 slots each
        assert!((of(&scenario, Work::Classify(10), 1) / (50_000.0 * slot.raw_s) - 1.0).abs() < 1e-9);
        assert!((of(&scenario, Work::Train, 1) / of(&scenario, Work::Train, 4) - 4.0).abs() < 1e-9);
        let (quick, _) = Scenario::quick(None, &[]).unwrap();
        assert!(of(&quick, run, 2) < 0.3 * of(&scenario, run, 2));
        let timed = super::slot(&quick, 0.997, 1);
        assert!(timed.beats_s > 0.0 && timed.raw_s > timed.beats_s && timed.image_s > 0.0, "{timed:?}");
    }
}
