//! Networks from labelled recordings in files or in memory: what `sdp3 train --recordings` does, as a function.

pub use crate::pipeline::train_recordings::{FOLDS, Method};
pub use crate::recordings::labels::{Held, Labelled};

use crate::error::{Failure, Invalid};
use crate::network::training::Backend;
use crate::pipeline::train::Train;
use crate::pipeline::train_recordings::Source;
use crate::pipeline::{Given, Job};
use crate::progress::Progress;
use crate::recordings::Stated;
use crate::results::LearnedRecordings;
use crate::scenario::{Override, Scenario};
use crate::simulator::validity;
use crate::store::output::Output;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, atomic::AtomicBool};

/// How to learn from recordings, beside the recordings themselves.
#[derive(Debug, Clone)]
pub struct Training {
    /// The scenario of the recordings' radar, as TOML; empty: the paper's.
    pub scenario: String,
    /// Whether sizes that the scenario does not state are the quick ones.
    pub quick: bool,
    /// Slots of a window, a network for each; absent: the scenario's.
    pub sensing_slots: Option<Vec<u32>>,
    /// Epochs; absent: the scenario's, and more where these make few steps.
    pub epochs: Option<u32>,
    /// Seed of everything random.
    pub seed: u64,
    /// What networks learn from.
    pub method: Method,
    /// Parts of the cross-validation at most, within [`FOLDS`].
    pub folds: u32,
    /// Whether each class is held out in turn too.
    pub hold_out_classes: bool,
    /// What was stated about the recordings; slots in memory are of the scenario's rate and carrier where nothing else is.
    pub stated: Stated,
    /// Folder for checkpoints and results.
    pub out: PathBuf,
    /// Whether to go on from the checkpoints in it.
    pub resume: bool,
    /// Whether progress is shown on stderr.
    pub progress: bool,
    /// Set from elsewhere to end the training, with an error, after the epochs that are under way.
    pub stop: Arc<AtomicBool>,
}

impl Training {
    /// What the cross-validation found, and the model files of networks that learned from all recordings, by their slots of a window.
    ///
    /// The same bits for any number of threads.
    ///
    /// # Errors
    ///
    /// A field outside its range; recordings or labels that cannot be used; checkpoints of other trainings; a folder that cannot be
    /// written.
    pub fn learn(
        self,
        labelled: Vec<Labelled>,
    ) -> Result<(LearnedRecordings, BTreeMap<u32, Vec<u8>>), Failure> {
        let legal = format!("{} to {}", FOLDS.start(), FOLDS.end());
        Invalid::unless(FOLDS.contains(&self.folds), "folds", self.folds, legal)?;
        let slots = self.sensing_slots.map(|slots| format!("frame.sensing_slots={slots:?}"));
        let epochs = self.epochs.map(|epochs| format!("learning.epochs={epochs}"));
        let set: Vec<Override> =
            slots.into_iter().chain(epochs).map(|field| field.parse()).collect::<Result<_, _>>()?;
        let file = Path::new("scenario");
        let scenario = if self.quick {
            Scenario::quick_text(&self.scenario, file, &set)?.0
        } else {
            Scenario::parse_with(&self.scenario, file, &set)?
        };
        validity::check(&scenario)?;
        let slots = scenario.frame.sensing_slots.clone();
        let job = Job {
            scenario,
            seed: self.seed,
            progress: if self.progress { Progress::Shown } else { Progress::Quiet },
            output: Output::create(&self.out)?.of_seed(self.seed),
            budget: self.stated.budget,
            workers: std::thread::available_parallelism().map_or(1, usize::from),
            stop: self.stop,
            given: Given { scenario: None, set, seed: Some(self.seed) },
        };
        // the scenario has its sizes
        let ask = Train {
            quick: false,
            data: None,
            recipe: None,
            resume: self.resume,
            backend: Backend::default(),
        };
        let source = Source {
            labelled,
            origin: "recordings".into(),
            stated: self.stated,
            method: self.method,
            folds: self.folds as usize,
            hold_out_classes: self.hold_out_classes,
        };
        let (found, models) = job.train_recordings(&ask, source)?;
        Ok((found, slots.into_iter().zip(models).collect()))
    }
}
