//! Networks trained in one room and tested in others.

use super::RunContext;
use crate::error::Failure;
use crate::network::float_network::FloatNetwork;
use crate::network::inference::Classifier;
use crate::network::interchange::header;
use crate::network::parameters::{Images, Parameters};
use crate::network::spectrograms::{Collected, collect};
use crate::network::training::{self, train_all};
use crate::network::tuning::quantize_tuned;
use crate::results::Accuracy;
use crate::scenario::{Class, Scenario};
use crate::simulator::dataset::Set;
use rayon::prelude::*;
use sdp3_core::dsn::Model;

/// Images that one thread takes at a time.
const PART: usize = 50;

/// Networks for every N_s of a scenario.
pub struct Trained {
    /// Their float parameters.
    pub parameters: Vec<Parameters>,
    /// Their int8 model files.
    pub models: Vec<Vec<u8>>,
}

/// Images of a set, with a line of progress.
pub fn images(scenario: &Scenario, rho: f64, seed: u64, set: Set, context: RunContext) -> Collected {
    let learning = &scenario.learning;
    let count = if set == Set::Test { learning.test_per_class } else { learning.train_per_class };
    let stage = context.progress.stage("simulate", &format!("{set:?}, seed {seed}"));
    let found = collect(scenario, rho, seed, set, count, &|done, all| stage.at(done, all));
    stage.finish(&format!("{count} of each class, seed {seed}, rho {rho}"));
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
    let learning = &scenario.learning;
    let slots = &scenario.frame.sensing_slots;
    let jobs: Vec<_> = slots
        .iter()
        .map(|&n| training::Job { seed: seed ^ (u64::from(n) << 32), ..Default::default() })
        .collect();
    let stage = context.progress.stage("train", &format!("{} networks, seed {seed}", jobs.len()));
    let total = jobs.len() as u64 * u64::from(learning.epochs);
    let watch = |_: usize, _: &dyn Fn() -> _, _: &[_]| {
        stage.step(total);
        Ok(())
    };
    let trained = train_all(&images.images, &jobs, learning, Class::ALL.len(), context.workers, &watch)?;
    stage.finish(&format!("{} networks, seed {seed}", trained.len()));
    let names: Vec<String> = Class::ALL.iter().map(|class| class.name().to_owned()).collect();
    let mut models = Vec::new();
    for ((network, images), &n) in trained.iter().zip(&images.images).zip(slots) {
        let (quantized, _) =
            quantize_tuned(&network.parameters, header(scenario, n), &names, images, learning)?;
        models.push(quantized.to_bytes()?);
    }
    Ok(Trained { parameters: trained.into_iter().map(|t| t.parameters).collect(), models })
}

impl Trained {
    /// Shares recognised of test images, in float and by the core's int8 network.
    ///
    /// # Errors
    ///
    /// A model that the core refuses.
    pub fn test(&self, scenario: &Scenario, test: &Collected) -> Result<Vec<Accuracy>, Failure> {
        let networks = self.parameters.iter().zip(&self.models).zip(&test.images);
        let rows = networks.zip(&scenario.frame.sensing_slots).map(|(((parameters, model), images), &n)| {
            Ok(Accuracy {
                sensing_slots: n,
                float: FloatNetwork::new(parameters).classify(images).accuracy(),
                int8: int8(model, images)?,
                tested: images.len() as u32,
            })
        });
        rows.collect()
    }
}

/// Share of images that the core's network recognises.
fn int8(bytes: &[u8], images: &Images) -> Result<f64, Failure> {
    let answers = int8_answers(bytes, images)?;
    let right = answers.iter().zip(&images.labels).filter(|(answer, label)| answer == label).count();
    Ok(right as f64 / images.len().max(1) as f64)
}

/// The class that the core's network answers to every image.
///
/// # Errors
///
/// A model that the core refuses.
pub fn int8_answers(bytes: &[u8], images: &Images) -> Result<Vec<u8>, Failure> {
    let model = Model::parse(bytes).map_err(|e| e.to_string())?;
    let part = |part: &[usize]| {
        let mut classifier = Classifier::new(model);
        part.iter().map(|&n| classifier.classify(images.image(n), &mut ()).class).collect::<Vec<_>>()
    };
    let all: Vec<usize> = (0..images.len()).collect();
    Ok(all.par_chunks(PART).flat_map_iter(part).collect())
}
