//! The deep spectrogram network as burn trains it.
//!
//! Paper, section V and figure of the DSN: convolution and pooling, blocks BN-ReLU-Conv-BN-ReLU-Conv with an identity
//! skip, mean over the image, fully connected classifier. Images are `[batch, 1, rows, frames]`.

use burn::module::{Module, Param, ParamId, RunningState};
use burn::nn::{BatchNorm, BatchNormConfig};
use burn::tensor::activation::relu;
use burn::tensor::module::{conv2d, max_pool2d};
use burn::tensor::ops::{ConvOptions, MaxPoolOptions};
use burn::tensor::{Device, Tensor, TensorData};

use super::backbone::operation::backbone;
use super::backbone::{BlockKind, Shape, Workspace};
use super::float_network::same_padding;
use super::parameters::{Architecture, BATCH_NORM_EPSILON, BlockParameters, Norm, Parameters, Weights};

/// A residual block of the network.
#[derive(Module, Debug)]
pub struct ResidualBlock {
    norm1: BatchNorm,
    conv1: Param<Tensor<4>>,
    norm2: BatchNorm,
    conv2: Param<Tensor<4>>,
    bias2: Param<Tensor<1>>,
}

/// The deep spectrogram network.
#[derive(Module, Debug)]
pub struct Network {
    stem: Param<Tensor<4>>,
    stem_bias: Param<Tensor<1>>,
    blocks: Vec<ResidualBlock>,
    head: Param<Tensor<2>>,
    head_bias: Param<Tensor<1>>,
    stride: usize,
}

/// Parameters by number, so that an optimiser's state finds its own again.
pub(super) struct ParameterBuilder<'a> {
    pub device: &'a Device,
    pub made: u64,
}

impl ParameterBuilder<'_> {
    pub fn parameter<const D: usize>(&mut self, values: &[f32], shape: [usize; D]) -> Param<Tensor<D>> {
        self.made += 1;
        let mut parameter = Param::from_data(TensorData::new(values.to_vec(), shape), self.device);
        parameter.id = ParamId::from(self.made);
        parameter
    }

    fn norm(&mut self, norm: &Norm) -> BatchNorm {
        let c = norm.gamma.len();
        let mut layer = BatchNormConfig::new(c).with_epsilon(BATCH_NORM_EPSILON).init(self.device);
        layer.gamma = self.parameter(&norm.gamma, [c]);
        layer.beta = self.parameter(&norm.beta, [c]);
        let state = |values: &[f32]| {
            RunningState::new(Tensor::from_data(TensorData::new(values.to_vec(), [c]), self.device))
        };
        layer.running_mean = state(&norm.mean);
        layer.running_var = state(&norm.variance);
        layer
    }
}

fn values<const D: usize>(tensor: Tensor<D>) -> Vec<f32> {
    tensor.into_data().iter::<f32>().collect()
}

fn norm_values(layer: &BatchNorm) -> Norm {
    Norm {
        gamma: values(layer.gamma.val()),
        beta: values(layer.beta.val()),
        mean: values(layer.running_mean.value_sync()),
        variance: values(layer.running_var.value_sync()),
    }
}

/// 3x3 convolution with TFLite's `SAME` padding.
pub(super) fn convolve(x: Tensor<4>, weight: Tensor<4>, bias: Option<Tensor<1>>, stride: usize) -> Tensor<4> {
    let [_, _, height, width] = x.dims();
    let pads = [height, width].map(|size| {
        let (out, before) = same_padding(size, stride);
        (before, ((out - 1) * stride + 3).saturating_sub(size + before))
    });
    conv2d(x, weight, bias, ConvOptions::new_with_padding([stride; 2], pads, [1, 1], 1))
}

impl ResidualBlock {
    fn forward(&self, x: Tensor<4>) -> Tensor<4> {
        let t = relu(self.norm1.forward(x.clone()));
        let t = convolve(t, self.conv1.val(), None, 1);
        let t = relu(self.norm2.forward(t));
        x + convolve(t, self.conv2.val(), Some(self.bias2.val()), 1)
    }
}

impl Network {
    /// The network with these parameters on this device; it trains where the device has autodiff.
    pub fn new(p: &Parameters, device: &Device) -> Network {
        let Architecture { channels: c, stem_stride, classes, .. } = p.architecture;
        let mut make = ParameterBuilder { device, made: 0 };
        let mut block = |b: &BlockParameters| ResidualBlock {
            norm1: make.norm(&b.norm1),
            conv1: make.parameter(&b.conv1, [c, c, 3, 3]),
            norm2: make.norm(&b.norm2),
            conv2: make.parameter(&b.conv2.weights, [c, c, 3, 3]),
            bias2: make.parameter(&b.conv2.biases, [c]),
        };
        Network {
            blocks: p.blocks.iter().map(&mut block).collect(),
            stem: make.parameter(&p.stem.weights, [c, 1, 3, 3]),
            stem_bias: make.parameter(&p.stem.biases, [c]),
            head: make.parameter(&p.head.weights, [classes, c]),
            head_bias: make.parameter(&p.head.biases, [classes]),
            stride: stem_stride,
        }
    }

    /// Logits `[batch, classes]` of images `[batch, 1, rows, frames]`.
    pub fn forward(&self, images: Tensor<4>) -> Tensor<2> {
        let x = convolve(images, self.stem.val(), Some(self.stem_bias.val()), self.stride);
        let mut x = max_pool2d(x, MaxPoolOptions::new([2, 2]));
        for block in &self.blocks {
            x = block.forward(x);
        }
        let [batch, channels, height, width] = x.dims();
        self.classify(x.reshape([batch, channels, height * width]).mean_dim(2).reshape([batch, channels]))
    }

    /// As [`Network::forward`] in training, through the backbone's own passes; images lie on the CPU.
    ///
    /// Normalises by the batch and moves the running statistics towards it.
    pub fn forward_batch(&self, images: Tensor<4>, workspace: &Workspace) -> Tensor<2> {
        let [batch, _, rows, frames] = images.dims();
        let [channels, ..] = self.stem.val().dims();
        let (blocks, stem_stride) = (self.blocks.len(), self.stride);
        let block_kind = BlockKind::Residual;
        let shape = Shape { batch, rows, frames, channels, blocks, stem_stride, block_kind };
        let mut parameters = vec![self.stem.val().flatten(0, 3), self.stem_bias.val()];
        for b in &self.blocks {
            parameters.extend([b.norm1.gamma.val(), b.norm1.beta.val(), b.conv1.val().flatten(0, 3)]);
            parameters.extend([b.norm2.gamma.val(), b.norm2.beta.val(), b.conv2.val().flatten(0, 3)]);
            parameters.push(b.bias2.val());
        }
        let (features, statistics) = backbone(images, Tensor::cat(parameters, 0), shape, workspace);
        let norms = self.blocks.iter().flat_map(|b| [&b.norm1, &b.norm2]);
        for (norm, batch) in norms.zip(statistics.split(2 * channels, 0)) {
            let [mean, variance] = [0, channels].map(|start| batch.clone().narrow(0, start, channels));
            for (running, found) in [(&norm.running_mean, mean), (&norm.running_var, variance)] {
                let kept = running.value_sync().mul_scalar(1.0 - norm.momentum);
                running.update((kept + found.mul_scalar(norm.momentum)).detach());
            }
        }
        self.classify(features)
    }

    fn classify(&self, features: Tensor<2>) -> Tensor<2> {
        features.matmul(self.head.val().transpose()) + self.head_bias.val().unsqueeze()
    }

    /// The parameters as plain numbers.
    pub fn parameters(&self) -> Parameters {
        let [channels, ..] = self.stem.val().dims();
        let [classes, _] = self.head.val().dims();
        let weights = |w: &Param<Tensor<4>>, b: &Param<Tensor<1>>| Weights {
            weights: values(w.val()),
            biases: values(b.val()),
        };
        let blocks = self.blocks.iter().map(|b| BlockParameters {
            norm1: norm_values(&b.norm1),
            conv1: values(b.conv1.val()),
            norm2: norm_values(&b.norm2),
            conv2: weights(&b.conv2, &b.bias2),
        });
        Parameters {
            architecture: Architecture {
                channels,
                blocks: self.blocks.len(),
                stem_stride: self.stride,
                classes,
            },
            stem: weights(&self.stem, &self.stem_bias),
            blocks: blocks.collect(),
            head: Weights { weights: values(self.head.val()), biases: values(self.head_bias.val()) },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::float_network::FloatNetwork;
    use crate::network::parameters::Images;
    use crate::network::synthetic::{stripes, trained_looking};

    fn input(images: &Images, device: &Device) -> Tensor<4> {
        let pixels: Vec<f32> = images.pixels.iter().map(|&p| (f32::from(p) + 128.0) / 255.0).collect();
        let shape = [images.len(), 1, images.rows, images.frames];
        Tensor::from_data(TensorData::new(pixels, shape), device)
    }

    #[test]
    fn burn_and_the_folded_network_agree() {
        for (stem_stride, frames) in [(1, 10), (2, 10), (2, 35), (1, 7)] {
            let architecture = Architecture { channels: 8, blocks: 2, stem_stride, classes: 5 };
            let parameters = trained_looking(architecture, 11);
            let images = stripes(frames, 1, 5);
            let device = Device::flex();
            let burn = values(Network::new(&parameters, &device).forward(input(&images, &device)));
            let folded = FloatNetwork::new(&parameters);
            for (i, logits) in burn.chunks(5).enumerate() {
                let plain = folded.forward(images.image(i), images.rows, &mut |_, _| {});
                for (a, b) in logits.iter().zip(&plain) {
                    assert!((a - b).abs() < 1e-4 * (1.0 + b.abs()), "{logits:?} {plain:?}");
                }
            }
        }
    }

    #[test]
    fn parameters_pass_through_unchanged() {
        let architecture = Architecture { channels: 4, blocks: 3, stem_stride: 2, classes: 3 };
        let parameters = trained_looking(architecture, 2);
        assert_eq!(Network::new(&parameters, &Device::flex().autodiff()).parameters(), parameters);
    }

    #[test]
    fn the_gradient_of_the_padded_stem_is_the_difference_quotient() {
        let images = stripes(10, 1, 3);
        let device = Device::flex().autodiff();
        for stem_stride in [1, 2] {
            let architecture = Architecture { channels: 4, blocks: 1, stem_stride, classes: 5 };
            let parameters = trained_looking(architecture, 4);
            let loss = |p: &Parameters| {
                let network = Network::new(p, &device);
                (network.forward(input(&images, &device)).powi_scalar(2).sum(), network)
            };
            let (value, network) = loss(&parameters);
            let gradients = value.backward();
            let gradient = values(network.stem.val().grad(&gradients).unwrap());
            for tap in 0..9 {
                let step = 1e-3;
                let at = |sign: f32| {
                    let mut p = parameters.clone();
                    p.stem.weights[tap] += sign * step;
                    f64::from(values(loss(&p).0)[0])
                };
                let quotient = (at(1.0) - at(-1.0)) / (2.0 * f64::from(step));
                let largest = gradient.iter().fold(0.0f32, |m, g| m.max(g.abs()));
                let error = (quotient - f64::from(gradient[tap])).abs();
                assert!(error < 0.03 * f64::from(largest), "{tap}: {quotient} {}", gradient[tap]);
            }
        }
    }

    /// Logits, parameters with their running statistics, and gradients after a pass in training.
    fn pass(
        parameters: &Parameters,
        images: &Images,
        forward: impl Fn(&Network, Tensor<4>) -> Tensor<2>,
    ) -> (Vec<f32>, Parameters, Vec<Vec<f32>>) {
        let device = Device::flex().autodiff();
        let network = Network::new(parameters, &device);
        let logits = forward(&network, input(images, &device));
        let pull: Vec<f32> = (0..logits.shape().num_elements()).map(|i| (i as f32 * 0.7).sin()).collect();
        let pull = Tensor::<2>::from_data(TensorData::new(pull, logits.dims()), &device);
        let gradients = (logits.clone() * pull).sum().backward();
        let four = |p: &Param<Tensor<4>>| values(p.val().grad(&gradients).unwrap());
        let one = |p: &Param<Tensor<1>>| values(p.val().grad(&gradients).unwrap());
        let mut all = vec![four(&network.stem), one(&network.stem_bias), one(&network.head_bias)];
        for b in &network.blocks {
            all.extend([one(&b.norm1.gamma), one(&b.norm1.beta), four(&b.conv1)]);
            all.extend([one(&b.norm2.gamma), one(&b.norm2.beta), four(&b.conv2), one(&b.bias2)]);
        }
        (values(logits), network.parameters(), all)
    }

    #[test]
    fn the_backbones_passes_are_burns() {
        for (channels, stem_stride, frames) in [(4, 1, 10), (8, 2, 35), (16, 1, 7), (12, 2, 24)] {
            let architecture = Architecture { channels, blocks: 3, stem_stride, classes: 5 };
            let parameters = trained_looking(architecture, 11);
            let images = stripes(frames, 6, 5);
            let burns = pass(&parameters, &images, |n, x| n.forward(x));
            let ours = pass(&parameters, &images, |n, x| n.forward_batch(x, &Workspace::default()));
            let near = |a: &[f32], b: &[f32], what: &str| {
                let largest = b.iter().fold(1e-3f32, |m, v| m.max(v.abs()));
                assert_eq!(a.len(), b.len());
                for (a, b) in a.iter().zip(b) {
                    assert!((a - b).abs() < 2e-4 * largest, "{architecture:?} {what}: {a} {b}");
                }
            };
            near(&ours.0, &burns.0, "logits");
            for (ours, burns) in ours.1.blocks.iter().zip(&burns.1.blocks) {
                for (ours, burns) in [(&ours.norm1, &burns.norm1), (&ours.norm2, &burns.norm2)] {
                    near(&ours.mean, &burns.mean, "means");
                    near(&ours.variance, &burns.variance, "variances");
                }
            }
            for (i, (ours, burns)) in ours.2.iter().zip(&burns.2).enumerate() {
                near(ours, burns, &format!("gradient {i}"));
            }
        }
    }

    #[test]
    fn the_backbones_gradient_is_the_difference_quotient() {
        let images = stripes(20, 2, 3);
        let device = Device::flex().autodiff();
        for stem_stride in [1, 2] {
            let architecture = Architecture { channels: 4, blocks: 2, stem_stride, classes: 5 };
            let parameters = trained_looking(architecture, 4);
            let loss = |p: &Parameters| {
                let network = Network::new(p, &device);
                let logits = network.forward_batch(input(&images, &device), &Workspace::default());
                (logits.powi_scalar(2).sum(), network)
            };
            let (value, network) = loss(&parameters);
            let gradients = value.backward();
            type Pick = fn(&mut Parameters) -> &mut Vec<f32>;
            let checks: [(Vec<f32>, Pick); 5] = [
                (values(network.stem.val().grad(&gradients).unwrap()), |p| &mut p.stem.weights),
                (values(network.blocks[0].conv1.val().grad(&gradients).unwrap()), |p| &mut p.blocks[0].conv1),
                (values(network.blocks[0].norm1.gamma.val().grad(&gradients).unwrap()), |p| {
                    &mut p.blocks[0].norm1.gamma
                }),
                (values(network.blocks[1].norm2.beta.val().grad(&gradients).unwrap()), |p| {
                    &mut p.blocks[1].norm2.beta
                }),
                (values(network.blocks[1].conv2.val().grad(&gradients).unwrap()), |p| {
                    &mut p.blocks[1].conv2.weights
                }),
            ];
            for (which, (gradient, pick)) in checks.iter().enumerate() {
                let largest = gradient.iter().fold(0.0f32, |m, g| m.max(g.abs()));
                for k in (0..gradient.len()).step_by(gradient.len().div_ceil(12)) {
                    let step = 1e-3;
                    let at = |sign: f32| {
                        let mut p = parameters.clone();
                        pick(&mut p)[k] += sign * step;
                        f64::from(values(loss(&p).0)[0])
                    };
                    let quotient = (at(1.0) - at(-1.0)) / (2.0 * f64::from(step));
                    let error = (quotient - f64::from(gradient[k])).abs();
                    assert!(error < 0.03 * f64::from(largest), "{which} {k}: {quotient} {}", gradient[k]);
                }
            }
        }
    }
}
