//! The deep spectrogram network as burn trains it.
//!
//! Paper, section V and figure of the DSN: convolution and pooling, blocks BN-ReLU-Conv-BN-ReLU-Conv with an identity
//! skip, mean over the image, fully connected classifier. Images are `[batch, 1, rows, frames]`.

use burn::module::{Module, Param};
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
    layer.running_mean.update(Tensor::from_data(TensorData::new(norm.mean.clone(), [c]), device));
    layer.running_var.update(Tensor::from_data(TensorData::new(norm.variance.clone(), [c]), device));
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
