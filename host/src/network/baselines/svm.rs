//! A support vector machine with a Gaussian kernel on [`features`]: one against one, the majority's answer.
//!
//! The solver is linfa's. Penalty C and kernel width gamma are those that recognise most of the training images in
//! cross-validation.

use super::features::{Scaling, features};
use super::{Settings, apart, folds, right};
use crate::network::parameters::Images;
use linfa::Dataset;
use linfa::traits::{Fit, Predict};
use linfa_svm::SvmError;
use ndarray::{Array1, Array2, ArrayView1, ShapeError};
use rayon::prelude::*;

/// Penalties that are tried.
const PENALTIES: [f64; 4] = [4.0, 64.0, 1024.0, 16384.0];
/// Kernel widths that are tried, over one by the number of features.
const WIDTHS: [f64; 4] = [0.25, 0.0625, 0.015625, 0.00390625];
/// Parts of the training images that take turns in validating.
pub const FOLDS: usize = 3;
/// The solver stops where no pair violates its condition by more: libsvm's default.
const TOLERANCE: f64 = 1e-3;

/// Why no machine could be trained.
#[derive(Debug, thiserror::Error)]
pub enum MachineError {
    /// What the solver says.
    #[error("support vector machine: {0}")]
    Solver(#[from] SvmError),
    /// Images of different sizes.
    #[error("support vector machine: {0}")]
    Shape(#[from] ShapeError),
}

/// A machine for two classes: whether it is the first.
struct Pair {
    first: u8,
    second: u8,
    machine: linfa_svm::Svm<f64, bool>,
}

pub struct Machine {
    scaling: Scaling,
    pairs: Vec<Pair>,
}

impl Machine {
    /// Trains with these settings, one machine for every two labels there are.
    ///
    /// # Errors
    ///
    /// What the solver says.
    pub fn train(images: &Images, settings: Settings) -> Result<Self, MachineError> {
        let raw = features(images);
        let scaling = Scaling::new(&raw);
        let mut labels = images.labels.clone();
        labels.sort_unstable();
        labels.dedup();
        let pair = |first: u8, second: u8| {
            let chosen = || (0..images.len()).filter(|&i| [first, second].contains(&images.labels[i]));
            let part: Vec<Vec<f64>> = chosen().map(|i| raw[i].clone()).collect();
            let shape = (part.len(), part.first().map_or(0, Vec::len));
            let records = Array2::from_shape_vec(shape, scaling.apply(&part))?;
            let targets: Array1<bool> = chosen().map(|i| images.labels[i] == first).collect();
            let machine = linfa_svm::Svm::<f64, bool>::params()
                .pos_neg_weights(settings.c, settings.c)
                .gaussian_kernel(1.0 / settings.gamma)
                .eps(TOLERANCE)
                .fit(&Dataset::new(records, targets))?;
            Ok(Pair { first, second, machine })
        };
        let pairs =
            labels.iter().enumerate().flat_map(|(k, &a)| labels[k + 1..].iter().map(move |&b| (a, b)));
        let pairs = pairs.map(|(a, b)| pair(a, b)).collect::<Result<_, MachineError>>()?;
        Ok(Machine { scaling, pairs })
    }

    /// The class of every image: that of the most pairs, the first of equals.
    pub fn classify(&self, images: &Images) -> Vec<u8> {
        let raw = features(images);
        let answer = |features: &Vec<f64>| {
            let scaled = self.scaling.apply(std::slice::from_ref(features));
            let mut votes = [0_u32; 256];
            for pair in &self.pairs {
                let first: bool = pair.machine.predict(ArrayView1::from(&scaled));
                votes[usize::from(if first { pair.first } else { pair.second })] += 1;
            }
            (0..=255_u8).fold(0, |best, class| {
                if votes[usize::from(class)] > votes[usize::from(best)] { class } else { best }
            })
        };
        raw.par_iter().map(answer).collect()
    }
}

/// Settings to choose from, for images of `rows` rows.
pub fn candidates(rows: usize) -> Vec<Settings> {
    let width = features(&Images { rows, frames: 1, pixels: vec![0; rows], labels: vec![0] })[0].len();
    let gamma = |w: f64| w / width as f64;
    PENALTIES.iter().flat_map(|&c| WIDTHS.iter().map(move |&w| Settings { c, gamma: gamma(w) })).collect()
}

/// How many images are recognised by machines that were trained on the other folds.
///
/// # Errors
///
/// What the solver says.
pub fn cross_validate(images: &Images, settings: Settings) -> Result<usize, MachineError> {
    let folds = folds(&images.labels, FOLDS);
    let fold = |fold: usize| {
        let (train, test) = apart(images, &folds, fold);
        Ok(right(&Machine::train(&train, settings)?.classify(&test), &test))
    };
    (0..FOLDS).into_par_iter().map(fold).sum()
}

/// The settings that cross-validation likes best, the first of equals.
///
/// # Errors
///
/// What the solver says.
pub fn choose(images: &Images) -> Result<Settings, MachineError> {
    let candidates = candidates(images.rows);
    let scores: Vec<usize> =
        candidates.par_iter().map(|&s| cross_validate(images, s)).collect::<Result<_, _>>()?;
    let best = (0..scores.len()).fold(0, |best, k| if scores[k] > scores[best] { k } else { best });
    Ok(candidates[best])
}

#[cfg(test)]
mod tests {
    use super::*;
    use base64::Engine;
    use serde_json::Value;

    fn bytes(value: &Value) -> Vec<u8> {
        base64::engine::general_purpose::STANDARD.decode(value.as_str().unwrap()).unwrap()
    }

    fn images(set: &Value, rows: usize, frames: usize) -> Images {
        let pixels = bytes(&set["pixels"]).into_iter().map(|b| b as i8).collect();
        Images { rows, frames, pixels, labels: bytes(&set["labels"]) }
    }

    #[test]
    fn answers_and_cross_validation_are_scikit_learns() {
        let oracle: Value = serde_json::from_str(include_str!("../../../../tests/oracles/svm.json")).unwrap();
        let size = |name: &str| oracle[name].as_u64().unwrap() as usize;
        let set = |name: &str| images(&oracle[name], size("rows"), size("frames"));
        let (train, test) = (set("train"), set("test"));
        let machines = oracle["machines"].as_array().unwrap();
        assert_eq!(machines.len(), candidates(size("rows")).len());
        for (machine, settings) in machines.iter().zip(candidates(size("rows"))) {
            assert_eq!(machine["c"].as_f64(), Some(settings.c));
            assert_eq!(machine["gamma"].as_f64(), Some(settings.gamma));
            let found = Machine::train(&train, settings).unwrap();
            assert_eq!(found.classify(&test), bytes(&machine["answers"]), "{settings:?}");
            let right = machine["cross_validated"].as_u64().unwrap() as usize;
            assert_eq!(cross_validate(&train, settings).unwrap(), right, "{settings:?}");
        }
    }
}
