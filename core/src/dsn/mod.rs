//! The deep spectrogram network in int8: TFLite's arithmetic, NHWC, the caller's memory.
//!
//! Section IV-A of the paper, "ResNet-32": input convolution and pooling, residual blocks of
//! BN-ReLU-Conv-BN-ReLU-Conv with an identity skip, global average pooling, fully connected layer, softmax.
//!
//! The first batch normalisation of a block sits before the skip's branch and cannot fold into a convolution: with
//! its ReLU it is a depthwise 1x1 layer ([`batch_norm`]). The second folds into the first convolution.

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

pub use kernels::{Kernels, Operator, Portable};
pub use model::{Model, ModelError};
pub(crate) use network::Logits;
pub use network::{Classification, Network, image_mut, infer, scratch_bytes};
pub use shape::Shape;
pub use winograd::WinogradKernels;

/// What [`Model::parse`] or a check of memory sizes has established to exist: the one place for what cannot happen.
///
/// A debug build panics there. Firmware has no panic: it goes on with nothing, an empty slice or zero.
#[inline(always)]
pub(crate) fn established<T: Default>(value: Option<T>) -> T {
    debug_assert!(value.is_some(), "a size that was checked before does not hold");
    value.unwrap_or_default()
}
