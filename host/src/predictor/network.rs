//! The deep spectrogram network as burn trains it.
//!
//! Paper, section V and figure of the DSN: convolution and pooling, blocks BN-ReLU-Conv-BN-ReLU-Conv with an identity
//! skip, mean over the image, fully connected classifier. Images are `[batch, 1, rows, frames]`.

use burn::module::{Module, Param, RunningState};
use burn::nn::{BatchNorm, BatchNormConfig};
use burn::tensor::activation::relu;
use burn::tensor::module::{conv2d, max_pool2d};
use burn::tensor::ops::{ConvOptions, MaxPoolOptions};
use burn::tensor::{Device, Tensor, TensorData};

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

fn parameter<const D: usize>(values: &[f32], shape: [usize; D], device: &Device) -> Param<Tensor<D>> {
    Param::from_data(TensorData::new(values.to_vec(), shape), device)
}

fn values<const D: usize>(tensor: Tensor<D>) -> Vec<f32> {
    tensor.into_data().iter::<f32>().collect()
}

fn norm(norm: &Norm, device: &Device) -> BatchNorm {
    let c = norm.gamma.len();
    let mut layer = BatchNormConfig::new(c).with_epsilon(BATCH_NORM_EPSILON).init(device);
    layer.gamma = parameter(&norm.gamma, [c], device);
    layer.beta = parameter(&norm.beta, [c], device);
    let state =
        |values: &[f32]| RunningState::new(Tensor::from_data(TensorData::new(values.to_vec(), [c]), device));
    layer.running_mean = state(&norm.mean);
    layer.running_var = state(&norm.variance);
    layer
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
fn convolve(x: Tensor<4>, weight: &Param<Tensor<4>>, bias: Option<Tensor<1>>, stride: usize) -> Tensor<4> {
    let [_, _, height, width] = x.dims();
    let pads = [height, width].map(|size| {
        let (out, before) = same_padding(size, stride);
        (before, ((out - 1) * stride + 3).saturating_sub(size + before))
    });
    conv2d(x, weight.val(), bias, ConvOptions::new_with_padding([stride; 2], pads, [1, 1], 1))
}

impl ResidualBlock {
    fn forward(&self, x: Tensor<4>) -> Tensor<4> {
        let t = relu(self.norm1.forward(x.clone()));
        let t = convolve(t, &self.conv1, None, 1);
        let t = relu(self.norm2.forward(t));
        x + convolve(t, &self.conv2, Some(self.bias2.val()), 1)
    }
}

impl Network {
    /// The network with these parameters on this device; it trains where the device has autodiff.
    pub fn new(p: &Parameters, device: &Device) -> Network {
        let Architecture { channels: c, stem_stride, classes, .. } = p.architecture;
        let blocks = p.blocks.iter().map(|b| ResidualBlock {
            norm1: norm(&b.norm1, device),
            conv1: parameter(&b.conv1, [c, c, 3, 3], device),
            norm2: norm(&b.norm2, device),
            conv2: parameter(&b.conv2.weights, [c, c, 3, 3], device),
            bias2: parameter(&b.conv2.biases, [c], device),
        });
        Network {
            stem: parameter(&p.stem.weights, [c, 1, 3, 3], device),
            stem_bias: parameter(&p.stem.biases, [c], device),
            blocks: blocks.collect(),
            head: parameter(&p.head.weights, [classes, c], device),
            head_bias: parameter(&p.head.biases, [classes], device),
            stride: stem_stride,
        }
    }

    /// Logits `[batch, classes]` of images `[batch, 1, rows, frames]`.
    pub fn forward(&self, images: Tensor<4>) -> Tensor<2> {
        let x = convolve(images, &self.stem, Some(self.stem_bias.val()), self.stride);
        let mut x = max_pool2d(x, MaxPoolOptions::new([2, 2]));
        for block in &self.blocks {
            x = block.forward(x);
        }
        let [batch, channels, height, width] = x.dims();
        let mean = x.reshape([batch, channels, height * width]).mean_dim(2).reshape([batch, channels]);
        mean.matmul(self.head.val().transpose()) + self.head_bias.val().unsqueeze()
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
    use crate::predictor::float_network::FloatNetwork;
    use crate::predictor::parameters::Images;
    use crate::predictor::synthetic::{stripes, trained_looking};

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
}
