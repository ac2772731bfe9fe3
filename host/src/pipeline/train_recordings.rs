//! Networks from a user's labelled recordings: tested by cross-validation, then learned from all of them.
//!
//! A person, or where persons are not known a recording, is either learned from or tested with, never both. Windows to learn from overlap by
//! three quarters; windows to test with do not overlap, as those of `sdp3 classify` do not.

use super::expected::Work;
use super::folds::folds;
use super::labelled_recordings::Recording;
use super::learn::{How, Trained, class_names};
use super::train::Train;
use super::{Job, budget};
use crate::error::{Failure, Invalid};
use crate::formats::table;
use crate::network::evaluation::{Networks, confusion, test};
use crate::network::parameters::Parameters;
use crate::network::score::{Predictions, balanced_accuracy};
use crate::network::spectrograms::{Collected, sliding};
use crate::network::training::{FINE_TUNING_RATE, architecture};
use crate::network::unknown::unknown;
use crate::recordings::Stated;
use crate::recordings::labels::Labelled;
use crate::results::{LearnedNetwork, LearnedRecording, LearnedRecordings};
use sdp3_core::dims::Beat;
use sdp3_core::dsn::head::MAX_CLASSES;
use std::collections::BTreeSet;
use std::ops::RangeInclusive;

/// Legal numbers of parts of a cross-validation.
pub const FOLDS: RangeInclusive<u32> = 2..=1000;

/// Windows to learn from begin a quarter of their length after one another.
const OVERLAP: usize = 4;
/// Least steps of a training, for a few recordings: more epochs are made where the scenario's have fewer.
const LEAST_STEPS: usize = 400;

/// What a network learns from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// The recordings alone.
    Recordings,
    /// Simulated and measured recordings together.
    WithSimulation,
    /// Simulated recordings first, then the measured ones.
    FineTuning,
}

impl Method {
    fn name(self) -> &'static str {
        match self {
            Method::Recordings => "recordings",
            Method::WithSimulation => "with-simulation",
            Method::FineTuning => "fine-tuning",
        }
    }
}

/// Recordings to learn from.
#[derive(Debug, Clone)]
pub struct Source {
    pub labelled: Vec<Labelled>,
    /// Where they are from, for errors.
    pub origin: String,
    /// What was stated about the recordings.
    pub stated: Stated,
    pub method: Method,
    /// Parts of a cross-validation, at most.
    pub folds: usize,
    /// Whether each class is held out in turn too, to find the confidence of what is none of them.
    pub hold_out_classes: bool,
}

/// What networks that did not learn from a recording say of its windows.
#[derive(Debug, Clone, Default)]
struct Answers {
    float: Vec<u8>,
    int8: Vec<u8>,
    /// Of the int8 answers.
    confidences: Vec<f64>,
}

/// How many answers are the label.
fn correct(answers: &[u8], label: u8) -> usize {
    answers.iter().filter(|&&answer| answer == label).count()
}

/// Effective sample size of a share of correct answers, from the correct answers and the windows of every recording: windows of one recording are
/// correlated. p (1 - p) over the variance of a ratio estimator (Cochran, Sampling Techniques, 1977, chapter 6), at least the number of
/// recordings, at most that of windows.
fn effective_sample_size(each: &[(usize, usize)]) -> f64 {
    let (correct, windows) = each.iter().fold((0, 0), |sums, one| (sums.0 + one.0, sums.1 + one.1));
    let (count, windows) = (each.len() as f64, windows as f64);
    let share = correct as f64 / windows;
    let squares: f64 = each.iter().map(|one| (one.0 as f64 - share * one.1 as f64).powi(2)).sum();
    let variance = count / (count - 1.0) * squares / (windows * windows);
    // no recording differs from the others: nothing is known of the spread
    let found = if squares > 0.0 { share * (1.0 - share) / variance } else { count };
    found.max(count.min(windows)).min(windows)
}

/// The classes: the user's in the order of their names, or the simulator's where these are all among them and simulation takes part.
fn classes(labelled: &[Labelled], method: Method, origin: &str) -> Result<Vec<String>, Invalid> {
    let own: BTreeSet<&str> = labelled.iter().map(|l| l.class.as_str()).collect();
    let simulated = class_names();
    let foreign = own.iter().find(|class| !simulated.iter().any(|name| name == *class));
    let refuse = |field, value: String, legal: String| Err(Invalid::new(field, value, legal).at(origin));
    match (method, foreign) {
        (Method::WithSimulation, Some(class)) => {
            refuse("class", (*class).to_owned(), format!("one that is simulated: {}", simulated.join(", ")))
        }
        (Method::WithSimulation | Method::FineTuning, None) => Ok(simulated),
        _ if !(2..=MAX_CLASSES).contains(&own.len()) => {
            refuse("classes", own.len().to_string(), format!("2 to {MAX_CLASSES}"))
        }
        _ => Ok(own.into_iter().map(str::to_owned).collect()),
    }
}

impl Job {
    /// Trains networks on labelled recordings, with a cross-validation: networks, int8 models, `recordings.json` and `points.csv`. What
    /// was found is returned, and the models in the order of `frame.sensing_slots`.
    ///
    /// # Errors
    ///
    /// Recordings or labels that cannot be used; checkpoints of other trainings; a folder that cannot be written.
    pub fn train_recordings(
        mut self,
        ask: &Train,
        from: Source,
    ) -> Result<(LearnedRecordings, Vec<Vec<u8>>), Failure> {
        self.size(ask.quick)?;
        if let Some(recipe) = ask.recipe {
            recipe.apply(&mut self.scenario.learning);
        }
        let classes = classes(&from.labelled, from.method, &from.origin)?;
        if from.hold_out_classes && (from.method != Method::Recordings || classes.len() < 3) {
            let value = format!("{} classes, --method {}", classes.len(), from.method.name());
            let legal =
                "of at least 3 classes with --method recordings: simulation would show the class held out";
            return Err(Invalid::option("--hold-out-classes", value, legal).into());
        }
        if from.method != Method::Recordings {
            self.warn_of_rho();
            self.check_cost(Work::Train, self.rho())?;
        }
        let fold = folds(&from.labelled, from.folds, self.seed, &from.origin)?;
        self.budget.check_memory(&budget::training(&self.scenario, 0, self.workers))?;
        let recordings = self.read_recordings(from.labelled, &fold, &classes, &from.stated)?;
        self.lengthen(&recordings);
        let simulated = (from.method != Method::Recordings).then(|| self.simulated());
        let start = match (&simulated, from.method) {
            (Some(images), Method::FineTuning) => Some(self.pretrained(images, ask, &classes)?),
            _ => None,
        };
        let together = simulated.filter(|_| from.method == Method::WithSimulation);
        let learn = |of: &[&Recording], folder: &str| -> Result<(Trained, Vec<Vec<u8>>), Failure> {
            let mut images = self.windows(of, |length| length / OVERLAP);
            if let Some(simulated) = &together {
                images.extend(simulated);
            }
            let how = How {
                folder: folder.into(),
                start: start.as_deref(),
                ..How::new(ask.backend, ask.resume, &classes)
            };
            let mut job = self.clone();
            if start.is_some() {
                job.scenario.learning.learning_rate *= FINE_TUNING_RATE;
            }
            let trained = job.train(&images, &how)?;
            let models = job.quantize(&trained.parameters, &images, &how)?;
            Ok((trained, models))
        };
        let mut answers =
            vec![vec![Answers::default(); recordings.len()]; self.scenario.frame.sensing_slots.len()];
        for number in 0..=fold.iter().max().copied().unwrap_or(0) {
            let learned: Vec<&Recording> = recordings.iter().filter(|r| r.fold != number).collect();
            let (trained, models) = learn(&learned, &format!("folds/{}", number + 1))?;
            self.test_fold(number, &recordings, &trained.parameters, &models, &mut answers)?;
        }
        let foreign = match from.hold_out_classes {
            true => self.held_out(&recordings, &classes, ask)?,
            false => vec![Vec::new(); answers.len()],
        };
        let (trained, models) = learn(&recordings.iter().collect::<Vec<_>>(), "models")?;
        self.write_networks(&trained)?;
        self.write_models(&models)?;
        // fine-tuning's learning rate is its own
        self.output.write(crate::scenario::Scenario::FILE, self.scenario.to_toml().as_bytes())?;
        let tested = answers.iter().map(|answers| {
            let counts = |(r, a): (&Recording, &Answers)| (correct(&a.int8, r.label), a.int8.len());
            effective_sample_size(&recordings.iter().zip(answers).map(counts).collect::<Vec<_>>())
        });
        let tested: Vec<f64> = tested.collect();
        let found = LearnedRecordings {
            method: from.method.name().to_owned(),
            networks: self.scored(&recordings, &classes, &answers, &foreign),
            recordings: recordings.into_iter().map(|r| self.described(r)).collect(),
            classes,
        };
        let point = |(n, tested): (&LearnedNetwork, &f64)| {
            vec![n.sensing_slots.to_string(), n.int8.to_string(), tested.to_string()]
        };
        let points = found.networks.iter().zip(&tested).map(point);
        let points = table::csv(&["sensing_slots", "accuracy", "tested"], points);
        self.output.write("points.csv", points.as_bytes())?;
        self.output.write_result("recordings.json", &found)?;
        Ok((found, models))
    }

    /// Takes as many epochs as make [`LEAST_STEPS`] of the largest N_s, unless the command line says how many.
    fn lengthen(&mut self, recordings: &[Recording]) {
        let longest = self.scenario.largest_sensing_slots() as usize;
        let windows: usize =
            recordings.iter().map(|r| (r.beats.len() - longest) / (longest / OVERLAP).max(1) + 1).sum();
        let learning = &mut self.scenario.learning;
        let epochs = LEAST_STEPS.div_ceil(windows.div_ceil(learning.batch as usize).max(1)) as u32;
        if epochs > learning.epochs && !self.given.set.iter().any(|set| set.sets("learning.epochs")) {
            let text = format!(
                "{windows} windows of {longest} slots: {epochs} epochs, not learning.epochs = {}; --set learning.epochs keeps a number",
                learning.epochs
            );
            learning.epochs = epochs;
            self.progress.note("train", &text);
        }
    }

    /// Images of recordings at every N_s, windows `step(N_s)` slots apart.
    fn windows(&self, recordings: &[&Recording], step: impl Fn(usize) -> usize + Sync) -> Collected {
        let labelled: Vec<(u8, &[Beat])> = recordings.iter().map(|r| (r.label, &r.beats[..])).collect();
        sliding(&self.scenario, &labelled, step)
    }

    /// Networks of simulated recordings, with a classifier for `classes`.
    fn pretrained(
        &self,
        images: &Collected,
        ask: &Train,
        classes: &[String],
    ) -> Result<Vec<Parameters>, Failure> {
        let simulated = class_names();
        let how = How { folder: "simulated".into(), ..How::new(ask.backend, ask.resume, &simulated) };
        let fresh = Parameters::initial(architecture(&self.scenario.learning, classes.len()), self.seed);
        let mut networks = self.train(images, &how)?.parameters;
        if classes != simulated {
            networks.iter_mut().for_each(|network| {
                (network.architecture, network.head) = (fresh.architecture, fresh.head.clone());
            });
        }
        Ok(networks)
    }

    /// Tests networks on the recordings of a fold.
    fn test_fold(
        &self,
        fold: usize,
        recordings: &[Recording],
        networks: &[Parameters],
        models: &[Vec<u8>],
        answers: &mut [Vec<Answers>],
    ) -> Result<(), Failure> {
        let slots = &self.scenario.frame.sensing_slots;
        let of_fold: Vec<usize> = (0..recordings.len()).filter(|&r| recordings[r].fold == fold).collect();
        let tested: Vec<&Recording> = of_fold.iter().map(|&r| &recordings[r]).collect();
        let images = self.windows(&tested, |length| length).images;
        // networks of one N_s at a time: the others have other windows
        for n in 0..slots.len() {
            let one = n..n + 1;
            let found =
                test(&networks[one.clone()], &models[one.clone()], &slots[one.clone()], &images[one])?;
            let Some(found) = found.into_iter().next() else { continue };
            let (mut float, mut int8) = (found.float.classes.into_iter(), found.int8.into_iter());
            let mut confidences = found.confidences.into_iter();
            for &r in &of_fold {
                let windows = recordings[r].beats.len() / slots[n] as usize;
                answers[n][r] = Answers {
                    float: float.by_ref().take(windows).collect(),
                    int8: int8.by_ref().take(windows).collect(),
                    confidences: confidences.by_ref().take(windows).collect(),
                };
            }
        }
        Ok(())
    }

    /// Confidences of windows of each class, `[N_s][window]`, by networks that learned the other classes.
    fn held_out(
        &self,
        recordings: &[Recording],
        classes: &[String],
        ask: &Train,
    ) -> Result<Vec<Vec<f64>>, Failure> {
        let slots = &self.scenario.frame.sensing_slots;
        let mut found = vec![Vec::new(); slots.len()];
        for held in 0..classes.len() {
            let mut others = classes.to_vec();
            let name = others.remove(held);
            let (foreign, learned): (Vec<_>, Vec<_>) = recordings
                .iter()
                .map(|r| (r.label, &r.beats[..]))
                .partition(|(label, _)| usize::from(*label) == held);
            let relabelled =
                |(label, beats): &(u8, _)| (label - u8::from(usize::from(*label) > held), *beats);
            let learned: Vec<(u8, &[Beat])> = learned.iter().map(relabelled).collect();
            let images = sliding(&self.scenario, &learned, |length| length / OVERLAP);
            let folder = format!("without/{}", held + 1);
            self.progress.note("train", &format!("without {name}"));
            let how = How { folder, ..How::new(ask.backend, ask.resume, &others) };
            let networks = self.train(&images, &how)?.parameters;
            let models = self.quantize(&networks, &images, &how)?;
            let shown = sliding(&self.scenario, &foreign, |length| length).images;
            for (n, found) in found.iter_mut().enumerate() {
                let logits = Networks::parse(&models[n..=n], &slots[n..=n])?.images(&shown[n..=n]);
                found.extend(logits.confidences(0));
            }
        }
        Ok(found)
    }

    /// How well every N_s recognises what it did not learn from.
    fn scored(
        &self,
        recordings: &[Recording],
        classes: &[String],
        answers: &[Vec<Answers>],
        foreign: &[Vec<f64>],
    ) -> Vec<LearnedNetwork> {
        let scored = |((&sensing_slots, answers), foreign): ((&u32, &Vec<Answers>), &Vec<f64>)| {
            let known: Vec<f64> = answers.iter().flat_map(|a| a.confidences.iter().copied()).collect();
            let each = || recordings.iter().zip(answers);
            let truth: Vec<u8> = each().flat_map(|(r, a)| vec![r.label; a.int8.len()]).collect();
            let share = |of: &dyn Fn(&Answers) -> &Vec<u8>| {
                let correct: usize = each().map(|(r, a)| correct(of(a), r.label)).sum();
                correct as f64 / truth.len().max(1) as f64
            };
            let predictions =
                |(r, a): (&Recording, &Answers)| Predictions { label: r.label, each: vec![a.int8.clone()] };
            let int8: Vec<u8> = answers.iter().flat_map(|a| a.int8.iter().copied()).collect();
            let of_class = |class| truth.iter().filter(|&&label| usize::from(label) == class).count();
            let most = (0..classes.len()).map(of_class).max().unwrap_or(0);
            LearnedNetwork {
                sensing_slots,
                windows: truth.len() as u32,
                float: share(&|a| &a.float),
                int8: share(&|a| &a.int8),
                balanced: balanced_accuracy(&each().map(predictions).collect::<Vec<_>>(), self.seed),
                majority: most as f64 / truth.len().max(1) as f64,
                unknown: unknown(known, foreign.clone()),
                confusion: confusion(&truth, &int8, classes.len()),
            }
        };
        self.scenario.frame.sensing_slots.iter().zip(answers).zip(foreign).map(scored).collect()
    }

    fn described(&self, recording: Recording) -> LearnedRecording {
        let Recording { name, class, person, fold, beats, .. } = recording;
        LearnedRecording {
            file: name,
            class,
            person,
            fold: fold as u32 + 1,
            seconds: beats.len() as f64 * self.scenario.interval_s(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::random::Random;

    #[test]
    fn the_effective_sample_size_lies_between_recordings_and_windows() {
        // recordings with equal answers throughout count once each, also where all are correct
        let wholly: Vec<_> = (0..20).map(|n| (if n % 4 == 0 { 0 } else { 30 }, 30)).collect();
        assert!((effective_sample_size(&wholly) - 20.0).abs() < 1e-9, "{}", effective_sample_size(&wholly));
        assert_eq!(effective_sample_size(&[(7, 7), (9, 9), (8, 8)]), 3.0);
        // independent windows count as nearly all of them, in the mean of many draws
        let mut random = Random::new(1, 0, 0, 0);
        let mut draw = || (0..30).filter(|_| random.uniform() < 0.8).count();
        let mean = (0..400)
            .map(|_| effective_sample_size(&std::array::from_fn::<_, 40, _>(|_| (draw(), 30))))
            .sum::<f64>()
            / 400.0;
        assert!((900.0..=1200.0).contains(&mean), "{mean}");
    }

    #[test]
    fn classes_are_the_users_or_the_simulators() {
        let own = [Labelled::example("1", "wave", None), Labelled::example("2", "sit", None)];
        assert_eq!(classes(&own, Method::Recordings, "").unwrap(), ["sit", "wave"]);
        assert_eq!(classes(&own, Method::FineTuning, "").unwrap(), ["sit", "wave"]);
        assert!(classes(&own, Method::WithSimulation, "here").unwrap_err().to_string().contains("class is"));
        let simulated = [
            Labelled::example("1", &class_names()[0], None),
            Labelled::example("2", &class_names()[1], None),
        ];
        assert_eq!(classes(&simulated, Method::FineTuning, "").unwrap(), class_names());
        assert!(classes(&own[..1], Method::Recordings, "").unwrap_err().to_string().contains("2 to 16"));
    }
}
