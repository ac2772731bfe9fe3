//! The deep spectrogram network in int8: TFLite's arithmetic, NHWC, caller-owned memory.
//!
//! Section IV-A of the paper, "ResNet-32": input convolution and pooling, residual blocks of
//! BN-ReLU-Conv-BN-ReLU-Conv with an identity skip, global average pooling, fully connected layer, softmax.
//!
//! The first batch normalisation of a block sits before the skip's branch and cannot fold into a convolution: with
//! its ReLU it is a depthwise 1x1 layer ([`affine`]). The second folds into the first convolution.

pub mod add;
pub mod batch_norm;
pub mod conv;
pub mod format;
pub mod head;
pub mod kernels;
pub mod model;
pub mod network;
pub mod per_channel;
pub mod pool;
pub mod shape;
pub mod winograd;

pub use kernels::{Kernels, Portable};
pub use model::{Model, ModelError};
pub use network::{Network, scratch_bytes};
pub use shape::Shape;
pub use winograd::WinogradF2;
