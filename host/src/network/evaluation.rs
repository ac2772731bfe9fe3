//! Evaluation: what the networks of every N_s answer to recordings, or to images of them.
//!
//! The front end makes the images at every N_s in one pass, models are parsed once, and a thread packs each model's weights once.
//! The bits are those of the core's pipeline.

use super::float_network::{Evaluation, FloatNetwork};
use super::inference::Classifier;
use super::parameters::{Images, Parameters};
use super::spectrograms::Recordings;
use crate::results::Accuracy;
use rayon::prelude::*;
use sdp3_core::dsn::head::{arg_max, confidence};
use sdp3_core::dsn::{Model, ModelError};
use std::ops::Range;

/// Why the core would not take a model.
#[derive(Debug, thiserror::Error)]
#[error("model for {sensing_slots} sensing slots: {source}")]
pub struct RefusedModel {
    /// N_s of the model.
    pub sensing_slots: u32,
    pub source: ModelError,
}

/// The int8 networks of every N_s.
#[derive(Debug, Clone)]
pub struct Networks<'m> {
    slots: Vec<u32>,
    models: Vec<Model<'m>>,
}

/// What the int8 networks of every N_s say: early exits of one another.
#[derive(Debug, Clone, PartialEq)]
pub struct ExitLogits {
    /// Number of sensing slots of every network, ascending.
    pub slots: Vec<u32>,
    /// What a logit step is worth, in nat, for every network.
    pub scales: Vec<f64>,
    /// Label of every recording.
    pub truth: Vec<u8>,
    pub logits: Vec<Vec<Vec<i8>>>,
}

impl<'m> Networks<'m> {
    /// Of model files, one for each of `slots`.
    ///
    /// # Errors
    ///
    /// A model that the core refuses.
    pub fn parse(files: &'m [Vec<u8>], slots: &[u32]) -> Result<Self, RefusedModel> {
        let parse = |(bytes, &sensing_slots): (&'m Vec<u8>, &u32)| {
            Model::parse(bytes).map_err(|source| RefusedModel { sensing_slots, source })
        };
        let models = files.iter().zip(slots).map(parse).collect::<Result<_, _>>()?;
        Ok(Networks { slots: slots.to_vec(), models })
    }

    /// Their logits for recordings, each dropped as soon as it is classified.
    pub fn recordings(
        &self,
        recordings: &Recordings<'_>,
        progress: &(dyn Fn(u64, u64) + Sync),
    ) -> ExitLogits {
        self.some_recordings(recordings, 0..recordings.count(), progress)
    }

    /// As [`Self::recordings`], for those of these numbers.
    pub fn some_recordings(
        &self,
        recordings: &Recordings<'_>,
        items: Range<u32>,
        progress: &(dyn Fn(u64, u64) + Sync),
    ) -> ExitLogits {
        let answer = |networks: &mut Vec<Classifier<'m>>, images: Vec<Vec<i8>>| {
            logits(networks, images.iter().map(Vec::as_slice))
        };
        let answers = recordings.map_some(items, || self.classifiers(), answer, progress);
        let (truth, logits) = answers.into_iter().unzip();
        self.answered(truth, logits)
    }

    /// Their logits for images that are at hand, one set for each network.
    pub fn images(&self, images: &[Images]) -> ExitLogits {
        let truth = images.first().map_or_else(Vec::new, |images| images.labels.clone());
        let answer = |networks: &mut Vec<Classifier<'m>>, n: usize| {
            logits(networks, images.iter().map(|images| images.image(n)))
        };
        let logits = (0..truth.len()).into_par_iter().map_init(|| self.classifiers(), answer).collect();
        self.answered(truth, logits)
    }

    fn classifiers(&self) -> Vec<Classifier<'m>> {
        self.models.iter().copied().map(Classifier::new).collect()
    }

    fn answered(&self, truth: Vec<u8>, logits: Vec<Vec<Vec<i8>>>) -> ExitLogits {
        let scales = self.models.iter().map(|model| f64::from(model.logit_scale())).collect();
        ExitLogits { slots: self.slots.clone(), scales, truth, logits }
    }
}

/// Every network's logits for its own image of one recording.
fn logits<'i>(networks: &mut [Classifier<'_>], images: impl Iterator<Item = &'i [i8]>) -> Vec<Vec<i8>> {
    let each = networks.iter_mut().zip(images);
    each.map(|(network, image)| network.classify(image, &mut ()).logits.to_vec()).collect()
}

impl ExitLogits {
    /// The class that a network alone answers to every recording.
    pub fn classes(&self, network: usize) -> Vec<u8> {
        self.logits.iter().map(|logits| arg_max(&logits[network]) as u8).collect()
    }

    /// The confidence of a network alone in its class of every recording.
    pub fn confidences(&self, network: usize) -> Vec<f64> {
        let scale = self.scales[network] as f32;
        let of =
            |logits: &Vec<Vec<i8>>| f64::from(confidence(&logits[network], arg_max(&logits[network]), scale));
        self.logits.iter().map(of).collect()
    }

    /// How many of the recordings a network alone classifies correctly.
    pub fn right(&self, network: usize) -> usize {
        self.classes(network).into_iter().zip(&self.truth).filter(|(class, truth)| class == *truth).count()
    }

    /// Share of the recordings that a network alone classifies correctly.
    pub fn accuracy(&self, network: usize) -> f64 {
        self.right(network) as f64 / self.truth.len().max(1) as f64
    }
}

/// A float network and the int8 network made of it, tested on the same images.
#[derive(Debug, Clone, PartialEq)]
pub struct Tested {
    pub accuracy: Accuracy,
    pub float: Evaluation,
    /// Answers in int8.
    pub int8: Vec<u8>,
    /// Confidences in them.
    pub confidences: Vec<f64>,
}

/// Tests the networks of every N_s.
///
/// # Errors
///
/// A model that the core refuses.
pub fn test(
    parameters: &[Parameters],
    files: &[Vec<u8>],
    slots: &[u32],
    images: &[Images],
) -> Result<Vec<Tested>, RefusedModel> {
    let int8 = Networks::parse(files, slots)?.images(images);
    let tested = |(n, &sensing_slots): (usize, &u32)| {
        let float = FloatNetwork::new(&parameters[n]).classify(&images[n]);
        let tested = images[n].len() as u32;
        let accuracy = Accuracy { sensing_slots, float: float.accuracy(), int8: int8.accuracy(n), tested };
        Tested { accuracy, float, int8: int8.classes(n), confidences: int8.confidences(n) }
    };
    Ok(slots.iter().enumerate().map(tested).collect())
}

/// How often a class `[truth]` was answered with another `[answer]`.
pub fn confusion(truth: &[u8], answers: &[u8], classes: usize) -> Vec<Vec<u32>> {
    let mut counts = vec![vec![0; classes]; classes];
    for (&truth, &answer) in truth.iter().zip(answers) {
        counts[usize::from(truth)][usize::from(answer)] += 1;
    }
    counts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::early_exits::Policy;
    use crate::network::memory::OwnedMemory;
    use crate::network::spectrograms::{Part, item};
    use crate::scenario::Class;
    use crate::scenario::Scenario;
    use crate::simulator::dataset::{Set, recording};
    use sdp3_core::early_exit::{EXITS, EarlyExit};
    use sdp3_testkit::models::{DSN_200, DSN_1000};

    #[test]
    fn networks_answer_what_the_cores_pipeline_answers() {
        let mut scenario = Scenario::default();
        scenario.frame.sensing_slots = vec![200, 1000];
        // as the models have it
        (scenario.spectrogram.first_kept, scenario.spectrogram.range_db) = (2, 50.0);
        let (rho, seed, part, per_class) = (0.997, 4, Part::Test, 2);
        let recordings = Recordings { scenario: &scenario, rho, seed, part, per_class };
        let files = [DSN_200.to_vec(), DSN_1000.to_vec()];
        let networks = Networks::parse(&files, &scenario.frame.sensing_slots).expect("models");
        let found = networks.recordings(&recordings, &|_, _| ());
        assert_eq!(found, networks.images(&recordings.images(&|_, _| ()).images));
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
        assert_eq!(found, one.install(|| networks.recordings(&recordings, &|_, _| ())));

        let weights = vec![vec![2000], vec![700, 1500]];
        let exit = |(&model, own): (&Model<'static>, &Vec<i32>)| {
            let mut weights = [0; EXITS];
            weights[..own.len()].copy_from_slice(own);
            EarlyExit { model, weights }
        };
        let models = [DSN_200, DSN_1000].map(|bytes| Model::parse(bytes).expect("a model"));
        let exits: Vec<_> = models.iter().zip(&weights).map(exit).collect();
        let exit_classes = Policy::new(&found.slots, weights).exit_classes(&found);
        let mut memory = OwnedMemory::for_model(&models[1]);
        for (index, (logits, of_exits)) in found.logits.iter().zip(exit_classes).enumerate() {
            let (class, n) = item(index as u32);
            assert_eq!(found.truth[index], class as u8);
            let mut pipeline = memory.early_exits(exits.clone(), 2.0).expect("exits that go together");
            let mut answers = Vec::new();
            for slot in &recording(&scenario, rho, seed, Set::Test, class, n, 1000).slots {
                pipeline.push(slot, &mut ()).expect("room");
                answers.extend(pipeline.classify(&mut ()));
            }
            let said: Vec<_> = answers.iter().map(|answer| (answer.class, answer.confidence)).collect();
            assert_eq!(said, of_exits);
            let said: Vec<_> = answers.iter().map(|answer| answer.logits.to_vec()).collect();
            assert_eq!(&said, logits);
        }
        let distinct: std::collections::BTreeSet<_> = found.logits.iter().collect();
        assert!(distinct.len() > 5, "recordings differ: {distinct:?}");
    }

    #[test]
    fn shares_and_confusion_count_the_same_answers() {
        let logits = [[3, 9, 1], [7, 7, -2], [0, 1, 2], [-5, -6, -7]].map(|l: [i8; 3]| vec![l.to_vec()]);
        let found = ExitLogits {
            slots: vec![200],
            scales: vec![0.1],
            truth: vec![1, 1, 2, 0],
            logits: logits.to_vec(),
        };
        assert_eq!(found.classes(0), [1, 0, 2, 0]);
        assert_eq!(found.accuracy(0), 0.75);
        let counts = confusion(&found.truth, &found.classes(0), Class::ALL.len());
        assert_eq!(counts.len(), Class::ALL.len());
        assert_eq!([&counts[0][..3], &counts[1][..3], &counts[2][..3]], [[1, 0, 0], [1, 1, 0], [0, 0, 1]]);
    }

    #[test]
    fn a_refused_model_is_named_by_its_sensing_slots() {
        let files = [DSN_200.to_vec(), DSN_1000[..100].to_vec()];
        let refused = Networks::parse(&files, &[200, 1000]).expect_err("a file that is cut off");
        assert!(refused.to_string().starts_with("model for 1000 sensing slots: "), "{refused}");
    }
}
