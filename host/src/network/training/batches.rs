//! From labelled images to batches of tensors.

use burn::tensor::{Device, Tensor, TensorData};

use crate::network::parameters::Images;

/// Cuts images into those to learn from and, of every label's, the last share, which validates: whole recordings of `windows` images
/// each where there are as many, so that no recording is on both sides. Of recordings with other numbers of windows one of each label may
/// be on both.
pub fn split(labels: &[u8], share: f64, windows: usize) -> (Vec<usize>, Vec<usize>) {
    let mut left = [0_usize; 256];
    labels.iter().for_each(|&label| left[usize::from(label)] += 1);
    let validate = left.map(|all| {
        let images = (all as f64 * share + 1e-9) as usize;
        if images < windows { images } else { images / windows * windows }
    });
    (0..labels.len()).partition(|&i| {
        let label = usize::from(labels[i]);
        left[label] -= 1;
        left[label] >= validate[label]
    })
}

/// What one step learns from.
#[derive(Debug, Clone, PartialEq)]
pub struct Batch {
    /// Intensities 0 to 1, `[image, row, frame]`.
    pub pixels: Vec<f32>,
    /// Share of every class, `[image, class]`.
    pub truth: Vec<f32>,
    /// Rows of an image.
    pub rows: usize,
    /// Frames of an image.
    pub frames: usize,
    pub classes: usize,
}

impl Batch {
    /// These images, each of the class of its label.
    pub fn of(images: &Images, batch: &[usize], classes: usize) -> Batch {
        let levels = batch.iter().flat_map(|&i| images.image(i));
        let pixels = levels.map(|&p| (f32::from(p) + 128.0) / 255.0).collect();
        let mut truth = vec![0.0; batch.len() * classes];
        for (row, &i) in batch.iter().enumerate() {
            truth[row * classes + usize::from(images.labels[i])] = 1.0;
        }
        Batch { pixels, truth, rows: images.rows, frames: images.frames, classes }
    }

    /// As tensors `[batch, 1, rows, frames]` and `[batch, classes]`.
    pub fn tensors(self, device: &Device) -> (Tensor<4>, Tensor<2>) {
        let count = self.truth.len() / self.classes.max(1);
        let pixels = TensorData::new(self.pixels, [count, 1, self.rows, self.frames]);
        let truth = TensorData::new(self.truth, [count, self.classes]);
        (Tensor::from_data(pixels, device), Tensor::from_data(truth, device))
    }
}

/// Cuts `count` images into batches that differ by at most one image, as near to `size` as possible.
pub fn batches(count: usize, size: usize) -> Vec<std::ops::Range<usize>> {
    let number = ((count + size / 2) / size.max(1)).max(1);
    (0..number).map(|b| b * count / number..(b + 1) * count / number).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::parameters::shuffled;

    #[test]
    fn every_epoch_takes_every_image_once() {
        let mut order = shuffled(500, 3, 1);
        assert_ne!(order, shuffled(500, 3, 2));
        assert_eq!(order, shuffled(500, 3, 1));
        order.sort();
        assert!(order.into_iter().eq(0..500));
        let sizes = |count, size| batches(count, size).iter().map(|b| b.len()).collect::<Vec<_>>();
        assert_eq!(sizes(500, 50), vec![50; 10]);
        assert_eq!(sizes(103, 50), vec![51, 52]);
        assert_eq!(sizes(3, 50), vec![3]);
    }

    #[test]
    fn validation_takes_its_share_of_every_label() {
        let labels = [0, 0, 1, 0, 1, 1, 0, 1];
        let (train, validate) = split(&labels, 0.25, 1);
        assert_eq!(validate, [6, 7]);
        assert_eq!(train, [0, 1, 2, 3, 4, 5]);
        assert_eq!(split(&labels, 0.0, 1).1.len(), 0);
        // recordings of three images: 0.2 of five recordings is one
        let labels: Vec<u8> = (0..30).map(|image| (image / 3 % 2) as u8).collect();
        let (train, validate) = split(&labels, 0.2, 3);
        assert_eq!((train.len(), validate), (24, vec![24, 25, 26, 27, 28, 29]));
    }
}
