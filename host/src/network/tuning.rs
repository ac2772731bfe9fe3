//! Quantisation-aware tuning: a few passes over the training images in which weights and activations are rounded as int8
//! rounds them, for networks that lose too much when they are rounded only afterwards.
//!
//! Rounding passes its gradient on unchanged inside a grid's range and none beyond it (straight-through; Jacob et al., 2018,
//! section 3; Bengio et al., 2013). The normalisations are folded and stay as they were learned.

use burn::module::{Module, Param};
use burn::optim::{AdamConfig, GradientsParams};
use burn::tensor::activation::{log_softmax, relu};
use burn::tensor::module::max_pool2d;
use burn::tensor::ops::MaxPoolOptions;
use burn::tensor::{Device, Tensor, TensorData};

use super::burn_model::convolve;
use super::calibration::{ActivationQuant, QuantParams};
use super::float_network::{FloatNetwork, FoldedBlock, FoldedLayer};
use super::parameters::{Architecture, Images, Parameters, shuffled};
use super::quantization::{QuantizationReport, quantize, quantize_folded};
use super::training::batches::{Batch, batches};
use crate::error::Invalid;
use crate::formats::model_file::{Preprocessing, QuantizedNetwork};
use crate::scenario::Learning;

/// First learning rate; it falls linearly to nothing.
const LEARNING_RATE: f64 = 5e-4;

/// Quantises a trained network; where int8's cross entropy on training images exceeds the float network's by more than
/// `learning.qat_above` nats, tunes it and keeps what loses less.
///
/// The same bits for any number of threads. Cost of tuning: `learning.qat_images` images through burn's own convolutions.
///
/// # Errors
///
/// As [`quantize`].
pub fn quantize_tuned(
    parameters: &Parameters,
    preprocessing: Preprocessing,
    classes: &[String],
    images: &Images,
    learning: &Learning,
) -> Result<(QuantizedNetwork, QuantizationReport), Invalid> {
    let (network, report) = quantize(parameters, preprocessing, classes, images)?;
    if report.cost() <= learning.qat_above {
        return Ok((network, report));
    }
    let tuned = tune(&FloatNetwork::new(parameters), &report.activation_quant(), images, learning);
    let (better, mut second) = quantize_folded(&tuned, preprocessing, classes, images)?;
    second.loss_before_qat = Some(report.least_loss());
    if second.least_loss() < report.least_loss() { Ok((better, second)) } else { Ok((network, report)) }
}

/// The folded network after `learning.qat_images` images with every weight and activation rounded on the way.
fn tune(
    float: &FloatNetwork,
    activation_quant: &ActivationQuant,
    images: &Images,
    learning: &Learning,
) -> FloatNetwork {
    let device = Device::flex().autodiff();
    let mut network = Rounded::new(float, &device);
    let mut optimizer = AdamConfig::new().with_epsilon(1e-8).init();
    let Architecture { classes, .. } = float.architecture;
    let size = learning.batch as usize;
    let steps = (learning.qat_images as usize).div_ceil(size).max(1);
    let deck = (0..).flat_map(|epoch| {
        let order = shuffled(images.len(), 0, epoch);
        batches(images.len(), size).into_iter().map(move |range| order[range].to_vec())
    });
    for (step, batch) in deck.take(steps).enumerate() {
        let (input, truth) = Batch::of(images, &batch, classes).tensors(&device);
        let logits = network.forward(input, float.architecture, activation_quant);
        let loss = (log_softmax(logits, 1) * truth).sum() / -(batch.len() as f64);
        let gradients = GradientsParams::from_grads(loss.backward(), &network);
        let rate = LEARNING_RATE * (1.0 - step as f64 / steps as f64);
        network = optimizer.step(rate, network, gradients);
    }
    network.folded(float.architecture)
}

/// A folded layer: weights `[O, taps I]`, biases `[O]`.
#[derive(Module, Debug)]
struct Layer {
    weights: Param<Tensor<2>>,
    biases: Param<Tensor<1>>,
}

impl Layer {
    fn new(layer: &FoldedLayer, device: &Device) -> Layer {
        let [weights, biases] =
            [&layer.weights, &layer.biases].map(|v| v.iter().map(|&v| v as f32).collect::<Vec<_>>());
        let outputs = biases.len();
        let shape = [outputs, weights.len() / outputs];
        Layer {
            weights: Param::from_data(TensorData::new(weights, shape), device),
            biases: Param::from_data(TensorData::new(biases, [outputs]), device),
        }
    }

    fn folded(&self) -> FoldedLayer {
        let values = |data: TensorData| data.iter::<f32>().map(f64::from).collect();
        FoldedLayer {
            weights: values(self.weights.val().into_data()),
            biases: values(self.biases.val().into_data()),
        }
    }

    /// Weights on the grid of their output channel: the largest is 127 steps.
    fn rounded(&self) -> Tensor<2> {
        let weights = self.weights.val();
        let exact = weights.clone().detach();
        let step = exact.clone().abs().max_dim(1).clamp_min(f32::MIN_POSITIVE) / 127.0;
        let error = (exact.clone() / step.clone()).round() * step - exact;
        weights + error
    }

    fn convolve(&self, x: Tensor<4>, stride: usize) -> Tensor<4> {
        let [outputs, values] = self.weights.val().dims();
        let inputs = values / 9;
        let weights = self.rounded().reshape([outputs, 9, inputs]).swap_dims(1, 2);
        convolve(x, weights.reshape([outputs, inputs, 3, 3]), Some(self.biases.val()), stride)
    }
}

#[derive(Module, Debug)]
struct Block {
    affine: Layer,
    conv1: Layer,
    conv2: Layer,
}

/// The folded network with int8's rounding.
#[derive(Module, Debug)]
struct Rounded {
    stem: Layer,
    blocks: Vec<Block>,
    head: Layer,
}

/// The nearest value of the grid; its gradient is that of the clipping alone.
fn round<const D: usize>(x: Tensor<D>, grid: QuantParams) -> Tensor<D> {
    let (low, high) = grid.range();
    let x = x.clamp(low, high);
    let exact = x.clone().detach();
    let error = (exact.clone() / grid.scale).round() * grid.scale - exact;
    x + error
}

impl Rounded {
    fn new(float: &FloatNetwork, device: &Device) -> Rounded {
        let block = |b: &FoldedBlock| Block {
            affine: Layer::new(&b.affine, device),
            conv1: Layer::new(&b.conv1, device),
            conv2: Layer::new(&b.conv2, device),
        };
        Rounded {
            stem: Layer::new(&float.stem, device),
            blocks: float.blocks.iter().map(block).collect(),
            head: Layer::new(&float.head, device),
        }
    }

    /// Logits `[batch, classes]` of images `[batch, 1, rows, frames]`.
    fn forward(
        &self,
        images: Tensor<4>,
        architecture: Architecture,
        activation_quant: &ActivationQuant,
    ) -> Tensor<2> {
        let x = round(self.stem.convolve(images, architecture.stem_stride), activation_quant.stem);
        let mut x = max_pool2d(x, MaxPoolOptions::new([2, 2]));
        let mut last = activation_quant.stem;
        for (block, &[affine, conv1, conv2, add]) in self.blocks.iter().zip(&activation_quant.blocks) {
            let channel = |t: Tensor<1>| t.reshape([1, architecture.channels, 1, 1]);
            let weights = channel(block.affine.weights.val().flatten(0, 1));
            let t = round(relu(x.clone() * weights + channel(block.affine.biases.val())), affine);
            let t = round(relu(block.conv1.convolve(t, 1)), conv1);
            let t = round(block.conv2.convolve(t, 1), conv2);
            x = round(x + t, add);
            last = add;
        }
        let [batch, channels, height, width] = x.dims();
        let mean = x.reshape([batch, channels, height * width]).mean_dim(2).reshape([batch, channels]);
        let logits = round(mean, last).matmul(self.head.rounded().transpose());
        round(logits + self.head.biases.val().unsqueeze(), activation_quant.logits)
    }

    fn folded(&self, architecture: Architecture) -> FloatNetwork {
        let block = |b: &Block| FoldedBlock {
            affine: b.affine.folded(),
            conv1: b.conv1.folded(),
            conv2: b.conv2.folded(),
        };
        FloatNetwork {
            architecture,
            stem: self.stem.folded(),
            blocks: self.blocks.iter().map(block).collect(),
            head: self.head.folded(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::calibration::calibrate;
    use crate::network::float_network::Activation;
    use crate::network::parameters::Images;
    use crate::network::quantization::fake_quantize;
    use crate::network::synthetic::{stripes, trained_looking};
    use crate::network::training::{Job, train};

    fn input(images: &Images, device: &Device) -> Tensor<4> {
        Batch::of(images, &(0..images.len()).collect::<Vec<_>>(), 5).tensors(device).0
    }

    #[test]
    fn the_rounded_network_is_the_fake_quantized_one() {
        let device = Device::flex();
        for (stem_stride, frames) in [(1, 10), (2, 35)] {
            let architecture = Architecture { channels: 8, blocks: 2, stem_stride, classes: 5 };
            let float = FloatNetwork::new(&trained_looking(architecture, 21));
            let images = stripes(frames, 2, 1);
            let [_, (_, activation_quant)] = calibrate(&float, &images);
            let fake_quantised = fake_quantize(&float, &activation_quant).unwrap();
            let found = Rounded::new(&float, &device).forward(
                input(&images, &device),
                architecture,
                &activation_quant,
            );
            let found: Vec<f32> = found.into_data().iter::<f32>().collect();
            for (i, found) in found.chunks(5).enumerate() {
                let expected = fake_quantised.forward(images.image(i), images.rows, &mut |a, v| {
                    if a != Activation::Input {
                        v.iter_mut().for_each(|v| *v = activation_quant.of(a).round(*v));
                    }
                });
                // a sum that falls between two steps may go either way
                for (a, b) in found.iter().zip(&expected) {
                    assert!((a - b).abs() <= 3.01 * activation_quant.logits.scale, "{found:?} {expected:?}");
                }
            }
        }
    }

    #[test]
    fn rounding_passes_the_gradient_inside_its_range_only() {
        let device = Device::flex().autodiff();
        let x = Tensor::<1>::from_data(TensorData::new(vec![-3.0f32, 0.3, 0.7, 9.0], [4]), &device)
            .require_grad();
        let y = round(x.clone(), QuantParams::covering(-1.0, 2.0));
        let gradient: Vec<f32> = x.grad(&y.sum().backward()).unwrap().into_data().iter::<f32>().collect();
        assert_eq!(gradient, [0.0, 1.0, 1.0, 0.0]);
    }

    #[test]
    fn tuning_wins_back_what_a_coarse_grid_lost() {
        let settings = Learning {
            epochs: 10,
            batch: 20,
            channels: 4,
            blocks: 2,
            stem_stride: 2,
            qat_images: 4000,
            ..Learning::default()
        };
        let images = stripes(24, 40, 1);
        let job = Job { seed: 7, ..Job::default() };
        let trained = train(&images, &settings, 5, &job, 2, &|_, _| Ok(())).unwrap();
        let float = FloatNetwork::new(&trained.parameters);
        // int8's ranges, made sixteen times coarser: 16 levels for every activation but the answer
        let [(_, mut activation_quant), _] = calibrate(&float, &images);
        let coarse = |g: QuantParams| {
            let (low, high) = g.range();
            QuantParams { scale: (high - low) / 15.0, zero: g.zero }
        };
        activation_quant.stem = coarse(activation_quant.stem);
        activation_quant.blocks.iter_mut().flatten().for_each(|g| *g = coarse(*g));
        let loss = |network: &FloatNetwork| {
            let fake_quantised = fake_quantize(network, &activation_quant).unwrap();
            let round = |(): &mut (), a: Activation, v: &mut [f32]| {
                v.iter_mut().for_each(|v| *v = activation_quant.of(a).round(*v));
            };
            fake_quantised.evaluate(&images, round).0.loss
        };
        let (before, after) = (loss(&float), loss(&tune(&float, &activation_quant, &images, &settings)));
        assert!(after < 0.9 * before, "{before} {after}");
    }
}
