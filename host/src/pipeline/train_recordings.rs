//! Networks from a user's labelled recordings: tested by cross-validation, then learned from all of them.
//!
//! A person, or where persons are not known a recording, is either learned from or tested with, never both. Windows to learn from overlap by
//! three quarters; windows to test with do not overlap, as those of `sdp3 classify` do not.

use super::learn::{How, Trained, class_names};
use super::train::Train;
use super::{Job, budget};
use crate::error::{Failure, Invalid};
use crate::experiments::score::{Predictions, balanced_accuracy};
use crate::formats::table;
use crate::network::evaluation::{confusion, test};
use crate::network::parameters::{Parameters, shuffled};
use crate::network::spectrograms::{Collected, sliding};
use crate::network::training::architecture;
use crate::recordings::labels::{self, Labelled};
use crate::recordings::{self, Expected, Stated};
use crate::results::{LearnedNetwork, LearnedRecording, LearnedRecordings};
use sdp3_core::dims::Beat;
use sdp3_core::dsn::head::MAX_CLASSES;
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

/// Windows to learn from begin a quarter of their length after one another.
const OVERLAP: usize = 4;
/// Least steps of a training, for a few recordings: more epochs are made where the scenario's have fewer.
const LEAST_STEPS: usize = 400;
/// Peak learning rate of fine-tuning over that of a training from random weights.
const FINE_TUNING_RATE: f64 = 0.1;

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
    pub folder: PathBuf,
    /// What was stated about the recordings.
    pub stated: Stated,
    pub method: Method,
    /// Parts of a cross-validation, at most.
    pub folds: usize,
}

/// A recording's beats and label.
struct Recording {
    labelled: Labelled,
    label: u8,
    fold: usize,
    beats: Vec<Beat>,
}

/// What networks that did not learn from a recording say of its windows.
#[derive(Debug, Clone, Default)]
struct Answers {
    float: Vec<u8>,
    int8: Vec<u8>,
}

/// The classes: the user's in the order of their names, or the simulator's where these are all among them and simulation takes part.
fn classes(labelled: &[Labelled], method: Method, folder: &str) -> Result<Vec<String>, Invalid> {
    let own: BTreeSet<&str> = labelled.iter().map(|l| l.class.as_str()).collect();
    let simulated = class_names();
    let foreign = own.iter().find(|class| !simulated.iter().any(|name| name == *class));
    let refuse = |field, value: String, legal: String| Err(Invalid::new(field, value, legal).at(folder));
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

/// The fold of every recording: groups in random order, those of the same classes spread over the folds.
fn folds(labelled: &[Labelled], most: usize, seed: u64, folder: &str) -> Result<Vec<usize>, Invalid> {
    let mut groups: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for l in labelled {
        groups.entry(l.group()).or_default().insert(&l.class);
    }
    let groups: Vec<_> = groups.into_iter().collect();
    let mut order = shuffled(groups.len(), seed, 0);
    order.sort_by_key(|&g| &groups[g].1);
    let count = most.min(groups.len());
    let fold_of: BTreeMap<&str, usize> =
        order.iter().enumerate().map(|(place, &g)| (groups[g].0, place % count.max(1))).collect();
    let fold_of = |l: &Labelled| fold_of.get(l.group()).copied().unwrap_or(0);
    for l in labelled {
        let of_class: BTreeSet<usize> =
            labelled.iter().filter(|other| other.class == l.class).map(fold_of).collect();
        let legal = "at least 2 recordings, or persons: one to learn from, one to test with";
        Invalid::unless(of_class.len() >= 2, format!("class {}", l.class), "1 recording or person", legal)
            .map_err(|invalid| invalid.at(folder))?;
    }
    Ok(labelled.iter().map(fold_of).collect())
}

/// A network for other classes: what leads to its classifier is kept.
fn with_classes(network: Parameters, fresh: Parameters, same: bool) -> Parameters {
    if same { network } else { Parameters { architecture: fresh.architecture, head: fresh.head, ..network } }
}

impl Job {
    /// Trains networks on labelled recordings, with a cross-validation: networks, int8 models, `recordings.json` and `points.csv`.
    ///
    /// # Errors
    ///
    /// Recordings or labels that cannot be used; checkpoints of other trainings; a folder that cannot be written.
    pub fn train_recordings(mut self, ask: &Train, from: &Source) -> Result<LearnedRecordings, Failure> {
        self.size(ask.quick)?;
        if let Some(recipe) = ask.recipe {
            recipe.apply(&mut self.scenario.learning);
        }
        let folder = from.folder.display().to_string();
        let (labelled, left_out) = labels::read(&from.folder)?;
        for path in left_out {
            self.progress.note("read", &format!("left out, it has no class: {}", path.display()));
        }
        let classes = classes(&labelled, from.method, &folder)?;
        let fold = folds(&labelled, from.folds, self.seed, &folder)?;
        self.budget.check_memory(&budget::training(&self.scenario, 0, self.workers))?;
        let recordings = self.read_recordings(labelled, &fold, &classes, &from.stated)?;
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
        let (trained, models) = learn(&recordings.iter().collect::<Vec<_>>(), "models")?;
        self.write_networks(&trained)?;
        self.write_models(&models)?;
        // fine-tuning's learning rate is its own
        self.output.write("scenario.toml", self.scenario.to_toml().as_bytes())?;
        let found = LearnedRecordings {
            method: from.method.name().to_owned(),
            networks: self.scored(&recordings, &classes, &answers),
            recordings: recordings.into_iter().map(|r| self.described(r)).collect(),
            classes,
        };
        let point =
            |n: &LearnedNetwork| vec![n.sensing_slots.to_string(), n.int8.to_string(), n.windows.to_string()];
        let points = table::csv(&["sensing_slots", "accuracy", "tested"], found.networks.iter().map(point));
        self.output.write("points.csv", points.as_bytes())?;
        self.output.write_result("recordings.json", &found)?;
        Ok(found)
    }

    /// The recordings' beats, of the scenario's radar and at least the longest window long.
    fn read_recordings(
        &self,
        labelled: Vec<Labelled>,
        folds: &[usize],
        classes: &[String],
        stated: &Stated,
    ) -> Result<Vec<Recording>, Failure> {
        let radar = self.scenario.radar.config();
        let expected = Expected {
            whose: "the scenario's",
            per_slot: radar.values_per_slot(),
            interval_us: 1e6 * self.scenario.interval_s(),
            carrier_hz: self.scenario.radar.carrier_hz,
        };
        let longest = self.scenario.largest_sensing_slots() as usize;
        let stage = self.progress.stage("read", "recordings");
        let (total, mut found) = (labelled.len() as u64, Vec::new());
        for (labelled, &fold) in labelled.into_iter().zip(folds) {
            let refuse = |invalid: Invalid| invalid.at(labelled.path.display());
            let signal = recordings::open(&labelled.path, stated)?;
            let slots = expected.slots(&signal, longest).map_err(refuse)?;
            let mut beats = slots.beats(radar).ok_or("a radar that the core refuses")?;
            if let Some((from_s, to_s)) = labelled.span_s {
                let slot = |t: f64| (t * signal.rate_hz).round() as usize;
                let (first, end) = (slot(from_s), slot(to_s));
                let length = signal.samples.len() as f64 / signal.rate_hz;
                Invalid::unless(end <= beats.len(), "to_s", to_s, format!("at most {length:.3}, its length"))
                    .map_err(refuse)?;
                let legal = format!("at least {longest}, the longest window");
                Invalid::unless(end - first >= longest, "slots from from_s to to_s", end - first, legal)
                    .map_err(refuse)?;
                beats = beats[first..end].to_vec();
            }
            let label = classes.iter().position(|class| *class == labelled.class).unwrap_or(0) as u8;
            found.push(Recording { labelled, label, fold, beats });
            stage.step(total);
        }
        stage.finish(&format!("{total} recordings of {} classes", classes.len()));
        Ok(found)
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
        let networks = self.train(images, &how)?.parameters.into_iter();
        Ok(networks.map(|network| with_classes(network, fresh.clone(), classes == simulated)).collect())
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
            for &r in &of_fold {
                let windows = recordings[r].beats.len() / slots[n] as usize;
                answers[n][r] = Answers {
                    float: float.by_ref().take(windows).collect(),
                    int8: int8.by_ref().take(windows).collect(),
                };
            }
        }
        Ok(())
    }

    /// How well every N_s recognises what it did not learn from.
    fn scored(
        &self,
        recordings: &[Recording],
        classes: &[String],
        answers: &[Vec<Answers>],
    ) -> Vec<LearnedNetwork> {
        let scored = |(&sensing_slots, answers): (&u32, &Vec<Answers>)| {
            let each = || recordings.iter().zip(answers);
            let truth: Vec<u8> = each().flat_map(|(r, a)| vec![r.label; a.int8.len()]).collect();
            let share = |of: &dyn Fn(&Answers) -> &Vec<u8>| {
                let correct =
                    each().flat_map(|(r, a)| of(a).iter().filter(move |&&answer| answer == r.label));
                correct.count() as f64 / truth.len().max(1) as f64
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
                confusion: confusion(&truth, &int8, classes.len()),
            }
        };
        self.scenario.frame.sensing_slots.iter().zip(answers).map(scored).collect()
    }

    fn described(&self, recording: Recording) -> LearnedRecording {
        let Recording { labelled, fold, beats, .. } = recording;
        LearnedRecording {
            file: labelled.name,
            class: labelled.class,
            person: labelled.person,
            fold: fold as u32 + 1,
            seconds: beats.len() as f64 * self.scenario.interval_s(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labelled(name: &str, class: &str, person: &str) -> Labelled {
        let person = Some(person.to_owned()).filter(|p| !p.is_empty());
        Labelled { name: name.into(), path: name.into(), class: class.into(), person, span_s: None }
    }

    #[test]
    fn a_person_is_in_one_fold_and_every_class_in_several() {
        let all: Vec<Labelled> = (0..24)
            .map(|n| labelled(&format!("{n}"), ["sit", "fall"][n % 2], ["a", "b", "c", "d", "e", "f"][n / 4]))
            .collect();
        for most in [2, 3, 5, 100] {
            let found = folds(&all, most, 1, "here").unwrap();
            for group in all.chunks(4).zip(found.chunks(4)) {
                assert!(group.1.iter().all(|fold| *fold == group.1[0]), "{group:?}");
            }
            assert_eq!(found.iter().collect::<BTreeSet<_>>().len(), most.min(6));
        }
        // two recordings of each of five classes, each class in two of the five folds
        let few: Vec<Labelled> =
            (0..10).map(|n| labelled(&format!("{n}"), &format!("class {}", n / 2), "")).collect();
        let found = folds(&few, 5, 1, "here").unwrap();
        assert!(found.chunks(2).all(|pair| pair[0] != pair[1]), "{found:?}");
        let lonely = [labelled("1", "sit", "a"), labelled("2", "sit", "b"), labelled("3", "fall", "a")];
        assert!(folds(&lonely, 5, 1, "here").unwrap_err().to_string().contains("class fall"));
    }

    #[test]
    fn classes_are_the_users_or_the_simulators() {
        let own = [labelled("1", "wave", ""), labelled("2", "sit", "")];
        assert_eq!(classes(&own, Method::Recordings, "").unwrap(), ["sit", "wave"]);
        assert_eq!(classes(&own, Method::FineTuning, "").unwrap(), ["sit", "wave"]);
        assert!(classes(&own, Method::WithSimulation, "here").unwrap_err().to_string().contains("class is"));
        let simulated = [labelled("1", &class_names()[0], ""), labelled("2", &class_names()[1], "")];
        assert_eq!(classes(&simulated, Method::FineTuning, "").unwrap(), class_names());
        assert!(classes(&own[..1], Method::Recordings, "").unwrap_err().to_string().contains("2 to 16"));
    }
}
