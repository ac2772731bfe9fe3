//! Networks trained in one room and tested in others.

use super::RunContext;
use crate::error::Failure;
use crate::network::checkpoint::Checkpoint;
use crate::network::evaluation::test;
use crate::network::interchange::header;
use crate::network::parameters::Parameters;
use crate::network::spectrograms::{Collected, Part, Recordings};
use crate::network::training::{self, EpochCallbacks, train_all};
use crate::network::tuning::quantize_tuned;
use crate::results::{Accuracy, Epoch};
use crate::scenario::{Class, Learning, Scenario};
use crate::simulator::calibration::rho_of;

/// Networks for every N_s of a scenario.
pub struct Trained {
    pub parameters: Vec<Parameters>,
    /// Their int8 model files.
    pub models: Vec<Vec<u8>>,
    /// Loss and accuracy of every network's epochs, on the images learned from.
    pub epochs: Vec<Vec<Epoch>>,
}

/// For every N_s a character a test recording: 1 if its class was recognised.
pub type Marked = Vec<String>;

/// Which test recordings the int8 networks of scenarios recognise, `[scenario][sensing_slots][recording]`. The scenarios may differ in
/// `spectrogram` alone: the recordings are simulated once for all of them. Those tested with begin at the range samples, as those learned
/// from do; a test of the radar holds them to raw slots.
///
/// # Errors
///
/// Whatever a training says.
pub fn marked(scenarios: &[Scenario], seed: u64, context: RunContext) -> Result<Vec<Marked>, Failure> {
    let learned = images_of_each(scenarios, seed, Part::Train, context);
    let shown = images_of_each(scenarios, seed, Part::Calibration, context);
    let each = scenarios.iter().zip(&learned).zip(&shown);
    each.map(|((scenario, learned), shown)| {
        let trained = train(scenario, seed, learned, context)?;
        let tested =
            test(&trained.parameters, &trained.models, &scenario.frame.sensing_slots, &shown.images)?;
        let each = tested.iter().zip(&shown.images);
        Ok(each.map(|(tested, images)| mark(&tested.int8, &images.labels)).collect())
    })
    .collect()
}

/// A character an answer: 1 if it is the label.
pub fn mark(answers: &[u8], labels: &[u8]) -> String {
    answers.iter().zip(labels).map(|(answer, label)| if answer == label { '1' } else { '0' }).collect()
}

/// The marks of several seeds at the n-th N_s, `[seed][recording]`.
pub fn marks(seeds: &[Marked], n: usize) -> Vec<Vec<bool>> {
    seeds.iter().map(|kept| kept[n].chars().map(|mark| mark == '1').collect()).collect()
}

/// Images of the recordings learned from or tested with, with a line of progress.
pub fn images(scenario: &Scenario, rho: f64, seed: u64, part: Part, context: RunContext) -> Collected {
    simulated(scenario, rho, seed, part, context, |recordings, progress| recordings.images(progress))
}

/// Images that scenarios make of the same recordings.
fn images_of_each(scenarios: &[Scenario], seed: u64, part: Part, context: RunContext) -> Vec<Collected> {
    let Some(first) = scenarios.first() else { return Vec::new() };
    simulated(first, rho_of(first), seed, part, context, |recordings, progress| {
        recordings.images_of_each(scenarios, progress)
    })
}

fn simulated<T>(
    scenario: &Scenario,
    rho: f64,
    seed: u64,
    part: Part,
    context: RunContext,
    make: impl FnOnce(Recordings<'_>, &(dyn Fn(u64, u64) + Sync)) -> T,
) -> T {
    let learning = &scenario.learning;
    let per_class = if part == Part::Train { learning.train_per_class } else { learning.test_per_class };
    let stage = context.progress.stage("simulate", &format!("{part:?}, seed {seed}"));
    let recordings = Recordings { scenario, rho, seed, part, per_class };
    let found = make(recordings, &|done, all| stage.at(done, all));
    stage.finish(&format!("{per_class} of each class, seed {seed}, rho {rho}"));
    found
}

/// Trains and quantises a network for every N_s.
///
/// # Errors
///
/// Images that do not fit the scenario's settings; weights that leave the format's range.
pub fn train(
    scenario: &Scenario,
    seed: u64,
    images: &Collected,
    context: RunContext,
) -> Result<Trained, Failure> {
    train_watched(scenario, seed, images, context, &|_, _, _| Ok(()))
}

/// As [`train`]; `watch` sees every network after each of its epochs.
///
/// # Errors
///
/// As [`train`], and what `watch` says.
pub fn train_watched(
    scenario: &Scenario,
    seed: u64,
    images: &Collected,
    context: RunContext,
    watch: &EpochCallbacks<'_>,
) -> Result<Trained, Failure> {
    let learning = &scenario.learning;
    let slots = &scenario.frame.sensing_slots;
    let jobs: Vec<_> = slots
        .iter()
        .map(|&n| training::Job { seed: seed ^ (u64::from(n) << 32), ..Default::default() })
        .collect();
    let stage = context.progress.stage("train", &format!("{} networks, seed {seed}", jobs.len()));
    let total = jobs.len() as u64 * u64::from(learning.epochs);
    let after_epoch = |job: usize, state: &dyn Fn() -> _, epochs: &[_]| {
        stage.step(total);
        watch(job, state, epochs)
    };
    let trained =
        train_all(&images.images, &jobs, learning, Class::ALL.len(), context.workers, &after_epoch)?;
    stage.finish(&format!("{} networks, seed {seed}", trained.len()));
    let names: Vec<String> = Class::ALL.iter().map(|class| class.name().to_owned()).collect();
    let mut models = Vec::new();
    for ((network, images), &n) in trained.iter().zip(&images.images).zip(slots) {
        let (quantized, _) =
            quantize_tuned(&network.parameters, header(scenario, n), &names, images, learning)?;
        models.push(quantized.to_bytes()?);
    }
    let (parameters, epochs) = trained.into_iter().map(|t| (t.parameters, t.epochs)).unzip();
    Ok(Trained { parameters, models, epochs })
}

/// A network as it is at a checkpoint.
///
/// # Errors
///
/// A checkpoint of another architecture.
pub fn parameters_of(checkpoint: &Checkpoint, learning: &Learning) -> Result<Parameters, String> {
    let architecture = training::architecture(learning, Class::ALL.len());
    checkpoint.parameters.parameters(architecture).map_err(|error| error.to_string())
}

impl Trained {
    /// Shares recognised of test images, in float and by the core's int8 network.
    ///
    /// # Errors
    ///
    /// A model that the core refuses.
    pub fn test(&self, scenario: &Scenario, images: &Collected) -> Result<Vec<Accuracy>, Failure> {
        let tested = test(&self.parameters, &self.models, &scenario.frame.sensing_slots, &images.images)?;
        Ok(tested.into_iter().map(|tested| tested.accuracy).collect())
    }
}
