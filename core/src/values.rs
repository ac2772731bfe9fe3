//! Every value of every stage as little-endian bytes, in the order of the signal chain: what digests fold and dumps store.
//!
//! Floats go by their bits; a complex number is two values, the real part first.

use crate::dims::{Beat, Complex, FixedBins, Spectrum};
use crate::probe::Probe;
use crate::signal::clutter::{Gram, Projection};

/// A stage of the signal chain.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Stage {
    /// Decimated beats, i32.
    Beat,
    /// Gram matrix, i64.
    Gram,
    /// Clutter projection, i32.
    Projection,
    /// Slow-time signal, i32.
    SlowTime,
    /// Spectra, f32, or i32 from [`crate::signal::stft::FixedStft`].
    Frame,
    /// Image, i8.
    Image,
    /// Outputs of the network's layers, i8.
    Layer,
    /// Logits, i8.
    Logits,
    /// The network's own class, u8: of several early exits before they are weighed.
    Class,
    /// Its probability, f32.
    Confidence,
}

impl Stage {
    /// All stages, in their order.
    pub const ALL: [Stage; 10] = {
        use Stage::*;
        [Beat, Gram, Projection, SlowTime, Frame, Image, Layer, Logits, Class, Confidence]
    };

    /// Name, as reports give it.
    pub const fn name(self) -> &'static str {
        NAMES[self as usize]
    }

    /// The stage of this name.
    pub fn named(name: &str) -> Option<Stage> {
        Stage::ALL.into_iter().find(|stage| stage.name() == name)
    }

    /// Bytes of one value.
    pub const fn width(self) -> usize {
        WIDTHS[self as usize]
    }
}

/// In the order of the stages.
const NAMES: [&str; 10] =
    ["beat", "gram", "projection", "slow-time", "frame", "image", "layer", "logits", "class", "confidence"];
const WIDTHS: [usize; 10] = [4, 8, 4, 4, 4, 1, 1, 1, 1, 4];

/// Takes values one by one.
pub trait Sink {
    /// One value of a stage; `N` is its [`Stage::width`].
    fn value<const N: usize>(&mut self, stage: Stage, bytes: [u8; N]);
}

/// A [`Probe`] that hands every value to a sink.
#[derive(Debug, Clone, Default)]
pub struct Values<S>(pub S);

impl<S: Sink> Values<S> {
    fn complex(&mut self, stage: Stage, values: &[Complex<i32>]) {
        for z in values {
            self.0.value(stage, z.re.to_le_bytes());
            self.0.value(stage, z.im.to_le_bytes());
        }
    }

    fn bytes(&mut self, stage: Stage, values: &[i8]) {
        for value in values {
            self.0.value(stage, value.to_le_bytes());
        }
    }
}

impl<S: Sink> Probe for Values<S> {
    fn beat(&mut self, beat: &Beat) {
        self.complex(Stage::Beat, beat);
    }
    fn gram(&mut self, gram: &Gram) {
        for z in gram.upper() {
            self.0.value(Stage::Gram, z.re.to_le_bytes());
            self.0.value(Stage::Gram, z.im.to_le_bytes());
        }
    }
    fn projection(&mut self, projection: &Projection) {
        self.complex(Stage::Projection, projection);
    }
    fn slow_time(&mut self, slow_time: &[Complex<i32>]) {
        self.complex(Stage::SlowTime, slow_time);
    }
    fn frame(&mut self, _k: usize, spectrum: &Spectrum) {
        for z in spectrum {
            self.0.value(Stage::Frame, z.re.to_bits().to_le_bytes());
            self.0.value(Stage::Frame, z.im.to_bits().to_le_bytes());
        }
    }
    fn fixed_frame(&mut self, _k: usize, spectrum: &FixedBins) {
        self.complex(Stage::Frame, spectrum);
    }
    fn image(&mut self, image: &[i8]) {
        self.bytes(Stage::Image, image);
    }
    fn layer(&mut self, _index: usize, activations: &[i8]) {
        self.bytes(Stage::Layer, activations);
    }
    fn logits(&mut self, logits: &[i8]) {
        self.bytes(Stage::Logits, logits);
    }
    fn class(&mut self, class: u8) {
        self.0.value(Stage::Class, [class]);
    }
    fn confidence(&mut self, confidence: f32) {
        self.0.value(Stage::Confidence, confidence.to_bits().to_le_bytes());
    }
}
