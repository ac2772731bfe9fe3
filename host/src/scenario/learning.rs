//! How networks are trained and tested.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How a training takes its steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Optimizer {
    /// Adam with decoupled weight decay (Loshchilov and Hutter, 2019).
    Adamw,
    /// Adam (Kingma and Ba, 2015); no weight decay.
    Adam,
    /// Gradient descent with momentum 0.9, without dampening or weight decay.
    Momentum,
}

/// How a training's learning rate goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Schedule {
    /// Up to the peak and down to nothing (Smith and Topin, 2019).
    OneCycle,
    /// The same for every step.
    Constant,
}

/// Training and testing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Learning {
    /// Training recordings per class.
    pub train_per_class: u32,
    /// Sensing slots of a training recording; the largest N_s if that is more, or if it has one window. The paper's have 1000, one
    /// scheduling period at 3.5 GHz.
    pub recording_slots: u32,
    /// Windows of N_s slots of every training recording, each an image of its own, evenly spaced from its beginning to its end.
    pub windows: u32,
    /// Test recordings per class, never trained on.
    pub test_per_class: u32,
    /// Passes over the training set.
    pub epochs: u32,
    /// Recordings per step.
    pub batch: u32,
    /// How steps are taken.
    pub optimizer: Optimizer,
    /// How the learning rate goes.
    pub schedule: Schedule,
    /// Learning rate: the peak of the one-cycle schedule, or the constant.
    pub learning_rate: f64,
    /// AdamW's weight decay.
    pub weight_decay: f64,
    /// Images of a batch are mixed in pairs by a share drawn from Beta(mixup, mixup), 0 to 1; 0: never.
    pub mixup: f64,
    /// Widest band of rows that goes dark in an image learned from; 0: none.
    pub mask_rows: u32,
    /// Share of the training recordings kept for validation, 0 to 0.5; the best epoch on them is kept.
    pub validation: f64,
    /// Epochs without a better loss on the validation recordings before training stops; 0: never.
    pub patience: u32,
    /// Cross entropy in nats that int8 may add on training images; above it the network is tuned with int8's rounding.
    pub qat_above: f64,
    /// Images, counted as often as they are shown, of such a tuning.
    pub qat_images: u32,
    /// Channels of every convolution: a multiple of 4, 4 to 32.
    pub channels: u8,
    /// Residual blocks.
    pub blocks: u8,
    /// Stride of the input convolution: 1 or 2.
    pub stem_stride: u8,
}

impl Learning {
    /// Sensing slots of a training recording in which the longest window has `slots`.
    pub fn training_slots(&self, slots: u32) -> u32 {
        if self.windows > 1 { slots.max(self.recording_slots) } else { slots }
    }
}
