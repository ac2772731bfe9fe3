//! What the deep spectrogram network is compared with: a support vector machine and a plain convolutional network.
//!
//! Paper, section I: recognition by a support vector machine on spectrograms, then by a convolutional network in its place. Both
//! learn from the same images as the deep spectrogram network, and both have what they cannot know chosen for them on the
//! training images alone: the machine its penalty and kernel width, the network its learning rate.

pub(crate) mod cnn;
#[cfg(feature = "svm")]
pub(crate) mod features;
#[cfg(feature = "svm")]
pub(crate) mod svm;

use super::parameters::Images;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Penalty and kernel width of a support vector machine.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Settings {
    /// Cost C of an image on the wrong side.
    pub c: f64,
    /// gamma of the kernel `exp(-gamma |x - y|^2)`, features scaled.
    pub gamma: f64,
}

/// The fold of every image: each label's images are cut into `count` runs, so that windows of one recording stay together.
pub fn folds(labels: &[u8], count: usize) -> Vec<usize> {
    let mut total = [0; 256];
    labels.iter().for_each(|&label| total[usize::from(label)] += 1);
    let mut seen = [0; 256];
    labels
        .iter()
        .map(|&label| {
            let label = usize::from(label);
            seen[label] += 1;
            (seen[label] - 1) * count / total[label]
        })
        .collect()
}

/// The images outside a fold and those in it.
fn apart(images: &Images, folds: &[usize], fold: usize) -> (Images, Images) {
    let take = |inside: bool| {
        let chosen: Vec<usize> = (0..images.len()).filter(|&i| (folds[i] == fold) == inside).collect();
        Images {
            rows: images.rows,
            frames: images.frames,
            pixels: chosen.iter().flat_map(|&i| images.image(i).iter().copied()).collect(),
            labels: chosen.iter().map(|&i| images.labels[i]).collect(),
        }
    };
    (take(false), take(true))
}

/// How many answers are right.
fn right(answers: &[u8], images: &Images) -> usize {
    answers.iter().zip(&images.labels).filter(|(answer, label)| answer == label).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folds_take_their_share_of_every_label_in_runs() {
        let labels = [0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 2];
        assert_eq!(folds(&labels, 3), [0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 0]);
        let images = Images { rows: 1, frames: 2, pixels: (0..26).collect(), labels: labels.to_vec() };
        let (outside, inside) = apart(&images, &folds(&labels, 3), 2);
        assert_eq!((outside.len(), inside.labels.as_slice()), (9, &[0, 1, 0, 1][..]));
        assert_eq!(inside.pixels, [16, 17, 18, 19, 20, 21, 22, 23]);
        assert_eq!(right(&[0, 1, 1, 1], &inside), 3);
    }
}
