//! A plain convolutional network: the deep spectrogram network's convolutions, as many and as wide, without skips and without
//! normalisation. Trained by the same recipe on the same images, through the backbone's own passes.

use super::{apart, folds, right};
use crate::network::backbone::operation::backbone;
use crate::network::backbone::{BlockKind, Shape, Workspace};
use crate::network::burn_model::ParameterBuilder;
use crate::network::float_network::first_maximum;
use crate::network::parameters::{Architecture, Images, Parameters, shuffled};
use crate::network::training::TrainingError;
use crate::network::training::augmentation::{augment, stream};
use crate::network::training::batches::{Batch, batches};
use crate::network::training::steps::{optimizer, rate};
use crate::scenario::Learning;
use burn::module::{Module, Param};
use burn::optim::GradientsParams;
use burn::tensor::activation::log_softmax;
use burn::tensor::{Device, Tensor};

/// Learning rates that are tried, as shares of the recipe's: nothing but the rate keeps a plain network from diverging.
const RATES: [f64; 4] = [1.0, 0.4, 0.2, 0.1];
/// Parts of the training images of which the last validates a rate.
const FOLDS: usize = 5;
/// Images answered at a time.
const PART: usize = 100;

/// Two convolutions, each behind a ReLU.
#[derive(Module, Debug)]
struct PlainBlock {
    conv1: Param<Tensor<4>>,
    bias1: Param<Tensor<1>>,
    conv2: Param<Tensor<4>>,
    bias2: Param<Tensor<1>>,
}

#[derive(Module, Debug)]
pub struct Cnn {
    stem: Param<Tensor<4>>,
    stem_bias: Param<Tensor<1>>,
    blocks: Vec<PlainBlock>,
    head: Param<Tensor<2>>,
    head_bias: Param<Tensor<1>>,
    stride: usize,
}

impl Cnn {
    /// Before training: He's normal weights, from the seed alone.
    fn new(architecture: Architecture, seed: u64, device: &Device) -> Cnn {
        let Architecture { channels: c, blocks, stem_stride, classes } = architecture;
        let initial = Parameters::initial(architecture, seed);
        let mut make = ParameterBuilder { device, made: 0 };
        // there is no skip beside which a branch would have to start small
        let whole = (blocks as f32).sqrt();
        let blocks = initial.blocks.iter().map(|b| {
            let conv2: Vec<f32> = b.conv2.weights.iter().map(|w| whole * w).collect();
            PlainBlock {
                conv1: make.parameter(&b.conv1, [c, c, 3, 3]),
                bias1: make.parameter(&vec![0.0; c], [c]),
                conv2: make.parameter(&conv2, [c, c, 3, 3]),
                bias2: make.parameter(&b.conv2.biases, [c]),
            }
        });
        Cnn {
            blocks: blocks.collect(),
            stem: make.parameter(&initial.stem.weights, [c, 1, 3, 3]),
            stem_bias: make.parameter(&initial.stem.biases, [c]),
            head: make.parameter(&initial.head.weights, [classes, c]),
            head_bias: make.parameter(&initial.head.biases, [classes]),
            stride: stem_stride,
        }
    }

    /// Logits `[batch, classes]` of images `[batch, 1, rows, frames]`.
    fn forward(&self, images: Tensor<4>, workspace: &Workspace) -> Tensor<2> {
        let [batch, _, rows, frames] = images.dims();
        let [channels, ..] = self.stem.val().dims();
        let (blocks, stem_stride) = (self.blocks.len(), self.stride);
        let shape =
            Shape { batch, rows, frames, channels, blocks, stem_stride, block_kind: BlockKind::Plain };
        let device = images.device();
        let (one, none) = (Tensor::<1>::ones([channels], &device), Tensor::<1>::zeros([channels], &device));
        let mut parameters = vec![self.stem.val().flatten(0, 3), self.stem_bias.val()];
        for b in &self.blocks {
            // the bias before the first ReLU is that of the convolution before it
            parameters.extend([one.clone(), none.clone(), b.conv1.val().flatten(0, 3)]);
            parameters.extend([one.clone(), b.bias1.val(), b.conv2.val().flatten(0, 3), b.bias2.val()]);
        }
        let (features, _) = backbone(images, Tensor::cat(parameters, 0), shape, workspace);
        features.matmul(self.head.val().transpose()) + self.head_bias.val().unsqueeze()
    }

    /// Trains on `threads` threads; the result does not depend on them.
    ///
    /// # Errors
    ///
    /// No thread.
    pub fn train(
        images: &Images,
        settings: &Learning,
        classes: usize,
        seed: u64,
        threads: usize,
        tick: &(dyn Fn() + Sync),
    ) -> Result<Cnn, TrainingError> {
        let architecture = Architecture {
            channels: usize::from(settings.channels),
            blocks: usize::from(settings.blocks),
            stem_stride: usize::from(settings.stem_stride),
            classes,
        };
        alone(threads, || {
            let device = Device::flex().autodiff();
            let mut network = Cnn::new(architecture, seed, &device);
            let mut optimizer = optimizer(settings);
            let workspace = Workspace::default();
            let batches = batches(images.len(), settings.batch as usize);
            let steps = batches.len() * settings.epochs as usize;
            for step in 0..steps {
                let (epoch, index) = (step / batches.len(), step % batches.len());
                let order = shuffled(images.len(), seed, epoch as u64);
                let batch = &order[batches[index].clone()];
                let mut augmented = Batch::of(images, batch, classes);
                augment(&mut augmented, settings, &mut stream(seed, epoch, index));
                let (input, truth) = augmented.tensors(&device);
                let logits = network.forward(input, &workspace);
                let loss = (log_softmax(logits, 1) * truth).sum() / -(batch.len() as f64);
                let gradients = GradientsParams::from_grads(loss.backward(), &network);
                network = optimizer.step(rate(settings, step, steps), network, gradients);
                if (step + 1) % batches.len() == 0 {
                    tick();
                }
            }
            network
        })
    }

    /// The class of every image.
    ///
    /// # Errors
    ///
    /// No thread.
    pub fn classify(&self, images: &Images, threads: usize) -> Result<Vec<u8>, TrainingError> {
        let [classes, _] = self.head.val().dims();
        alone(threads, || {
            let (device, workspace) = (Device::flex().autodiff(), Workspace::default());
            let all: Vec<usize> = (0..images.len()).collect();
            let part = |part: &[usize]| {
                let (input, _) = Batch::of(images, part, classes).tensors(&device);
                let logits: Vec<f32> = self.forward(input, &workspace).to_data().iter::<f32>().collect();
                logits.chunks(classes).map(first_maximum).collect::<Vec<_>>()
            };
            all.chunks(PART).flat_map(part).collect()
        })
    }
}

/// Runs on threads of its own: work of another network would wait for burn's locks that this one holds.
fn alone<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> Result<T, TrainingError> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.max(1)).build();
    Ok(pool.map_err(|e| TrainingError::Thread(e.to_string()))?.install(work))
}

/// Learning rates to choose from.
pub fn rates(settings: &Learning) -> [f64; RATES.len()] {
    RATES.map(|share| share * settings.learning_rate)
}

/// How many of the last fifth of every class's training images a network recognises that learned from the others.
///
/// # Errors
///
/// No thread.
pub fn validate(
    images: &Images,
    settings: &Learning,
    classes: usize,
    seed: u64,
    threads: usize,
    tick: &(dyn Fn() + Sync),
) -> Result<usize, TrainingError> {
    let (train, test) = apart(images, &folds(&images.labels, FOLDS), FOLDS - 1);
    let network = Cnn::train(&train, settings, classes, seed, threads, tick)?;
    Ok(right(&network.classify(&test, threads)?, &test))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::burn_model::convolve;
    use crate::network::synthetic::stripes;
    use burn::tensor::activation::relu;
    use burn::tensor::module::max_pool2d;
    use burn::tensor::ops::MaxPoolOptions;

    const SMALL: Architecture = Architecture { channels: 4, blocks: 2, stem_stride: 2, classes: 5 };

    /// The network by burn's own operations.
    fn burns(n: &Cnn, images: Tensor<4>) -> Tensor<2> {
        let x = convolve(images, n.stem.val(), Some(n.stem_bias.val()), n.stride);
        let mut x = max_pool2d(x, MaxPoolOptions::new([2, 2]));
        for b in &n.blocks {
            x = convolve(relu(x), b.conv1.val(), Some(b.bias1.val()), 1);
            x = convolve(relu(x), b.conv2.val(), Some(b.bias2.val()), 1);
        }
        let [batch, channels, height, width] = x.dims();
        let x = x.reshape([batch, channels, height * width]).mean_dim(2).reshape([batch, channels]);
        x.matmul(n.head.val().transpose()) + n.head_bias.val().unsqueeze()
    }

    fn values<const D: usize>(tensor: Tensor<D>) -> Vec<f32> {
        tensor.to_data().iter::<f32>().collect()
    }

    #[test]
    fn logits_and_gradients_are_those_of_burns_operations() {
        let device = Device::flex().autodiff();
        for stem_stride in [1, 2] {
            let network = Cnn::new(Architecture { stem_stride, ..SMALL }, 3, &device);
            let images = stripes(19, 2, 5);
            let all: Vec<usize> = (0..images.len()).collect();
            let pass = |forward: &dyn Fn(Tensor<4>) -> Tensor<2>| {
                let logits = forward(Batch::of(&images, &all, 5).tensors(&device).0);
                let gradients = logits.clone().powi_scalar(2).sum().backward();
                let four = |p: &Param<Tensor<4>>| values(p.val().grad(&gradients).unwrap());
                let one = |p: &Param<Tensor<1>>| values(p.val().grad(&gradients).unwrap());
                let mut found = vec![values(logits), four(&network.stem), one(&network.stem_bias)];
                for b in &network.blocks {
                    found.extend([four(&b.conv1), one(&b.bias1), four(&b.conv2), one(&b.bias2)]);
                }
                found
            };
            let ours = pass(&|x| network.forward(x, &Workspace::default()));
            let theirs = pass(&|x| burns(&network, x));
            for (k, (ours, theirs)) in ours.iter().zip(&theirs).enumerate() {
                let largest = theirs.iter().fold(1e-3_f32, |m, v| m.max(v.abs()));
                assert_eq!(ours.len(), theirs.len());
                for (a, b) in ours.iter().zip(theirs) {
                    assert!((a - b).abs() < 2e-4 * largest, "stride {stem_stride}, {k}: {a} {b}");
                }
            }
        }
    }

    #[test]
    fn it_learns_the_same_on_any_number_of_threads() {
        let learning =
            Learning { epochs: 12, batch: 20, channels: 4, blocks: 2, stem_stride: 2, ..Learning::default() };
        let (train, test) = (stripes(24, 40, 1), stripes(24, 20, 2));
        let answers = |threads| {
            Cnn::train(&train, &learning, 5, 7, threads, &|| ()).unwrap().classify(&test, threads).unwrap()
        };
        let found = answers(1);
        let known = right(&found, &test);
        assert!(known >= 18, "{known} of 20");
        assert_eq!(answers(2), found);
        let right = validate(&train, &learning, 5, 7, 2, &|| ()).unwrap();
        assert!(right >= 30, "{right} of 40");
    }
}
