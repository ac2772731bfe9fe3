//! An observer of every stage's values, for conformance tests and layer dumps.
//!
//! All methods do nothing by default; `()` observes nothing and costs nothing.

use crate::dims::{Beat, Complex, FixedBins, Spectrum};
use crate::signal::clutter::{Gram, Projection};

/// Sees the values of every stage as they are made.
pub trait Probe {
    /// The decimated beat of a slot, `[fast_time]`.
    fn beat(&mut self, _beat: &Beat) {}
    /// The Gram matrix of the recording.
    fn gram(&mut self, _gram: &Gram) {}
    /// The clutter projection in Q3.28, `[fast_time]`.
    fn projection(&mut self, _projection: &Projection) {}
    /// The scaled slow-time signal, `[slow_time]`.
    fn slow_time(&mut self, _slow_time: &[Complex<i32>]) {}
    /// The spectrum of frame `_k`, `[doppler]`.
    fn frame(&mut self, _k: usize, _spectrum: &Spectrum) {}
    /// The same in integers, from [`crate::signal::stft::FixedStft`].
    fn fixed_frame(&mut self, _k: usize, _spectrum: &FixedBins) {}
    /// The network's image, `[rows, frames]`.
    fn image(&mut self, _image: &[i8]) {}
    /// The output of a layer, `[height, width, channels]`; counted from the pooled stem, 0.
    fn layer(&mut self, _index: usize, _activations: &[i8]) {}
    /// The network's output before the softmax, `[classes]`.
    fn logits(&mut self, _logits: &[i8]) {}
    /// The network's own class, before several early exits are weighed.
    fn class(&mut self, _class: u8) {}
    /// Its probability by the network's own softmax.
    fn confidence(&mut self, _confidence: f32) {}
}

impl Probe for () {}
