//! One number per stage: FNV-1a, 64 bits, over the little-endian bytes of its values.
//!
//! Equal digests on two processors mean equal values; floats go in by their bits.

use crate::clutter::{Gram, Weights};
use crate::frame::{Beat, Complex};
use crate::probe::Probe;
use crate::stft::Spectrum;

/// A running FNV-1a hash and the number of values it took.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Digest {
    hash: u64,
    count: u64,
}

impl Default for Digest {
    fn default() -> Self {
        Self::new()
    }
}

impl Digest {
    /// The digest of nothing.
    pub const fn new() -> Self {
        Digest { hash: 0xcbf2_9ce4_8422_2325, count: 0 }
    }

    /// Takes one value, given by its bytes.
    pub fn value<const N: usize>(&mut self, bytes: [u8; N]) {
        for byte in bytes {
            self.hash = (self.hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
        self.count = self.count.wrapping_add(1);
    }

    /// The hash so far.
    pub const fn hash(&self) -> u64 {
        self.hash
    }

    /// Values taken; a complex number is two.
    pub const fn count(&self) -> u64 {
        self.count
    }
}

/// The stages of the street in their order, by name.
pub const STAGES: [&str; 9] =
    ["beat", "gram", "weights", "slow-time", "frame", "image", "layer", "logits", "confidence"];

/// Digests every stage it sees.
#[derive(Debug, Clone, Default)]
pub struct DigestProbe {
    beat: Digest,
    gram: Digest,
    weights: Digest,
    slow_time: Digest,
    frame: Digest,
    image: Digest,
    layer: Digest,
    logits: Digest,
    confidence: Digest,
}

impl DigestProbe {
    /// A probe that has seen nothing.
    pub const fn new() -> Self {
        let none = Digest::new();
        DigestProbe {
            beat: none,
            gram: none,
            weights: none,
            slow_time: none,
            frame: none,
            image: none,
            layer: none,
            logits: none,
            confidence: none,
        }
    }

    /// Name and digest of every stage, in the order of [`STAGES`].
    pub fn stages(&self) -> impl Iterator<Item = (&'static str, Digest)> {
        let digests = [
            self.beat,
            self.gram,
            self.weights,
            self.slow_time,
            self.frame,
            self.image,
            self.layer,
            self.logits,
            self.confidence,
        ];
        STAGES.into_iter().zip(digests)
    }
}

fn complex_i32<'a>(digest: &mut Digest, values: impl IntoIterator<Item = &'a Complex<i32>>) {
    for z in values {
        digest.value(z.re.to_le_bytes());
        digest.value(z.im.to_le_bytes());
    }
}

fn bytes(digest: &mut Digest, values: &[i8]) {
    for value in values {
        digest.value(value.to_le_bytes());
    }
}

impl Probe for DigestProbe {
    fn beat(&mut self, beat: &Beat) {
        complex_i32(&mut self.beat, beat);
    }
    fn gram(&mut self, gram: &Gram) {
        for z in gram.upper() {
            self.gram.value(z.re.to_le_bytes());
            self.gram.value(z.im.to_le_bytes());
        }
    }
    fn weights(&mut self, weights: &Weights) {
        complex_i32(&mut self.weights, weights);
    }
    fn slow_time(&mut self, slow_time: &[Complex<i32>]) {
        complex_i32(&mut self.slow_time, slow_time);
    }
    fn frame(&mut self, _k: usize, spectrum: &Spectrum) {
        for z in spectrum {
            self.frame.value(z.re.to_bits().to_le_bytes());
            self.frame.value(z.im.to_bits().to_le_bytes());
        }
    }
    fn image(&mut self, image: &[i8]) {
        bytes(&mut self.image, image);
    }
    fn layer(&mut self, _index: usize, activations: &[i8]) {
        bytes(&mut self.layer, activations);
    }
    fn logits(&mut self, logits: &[i8]) {
        bytes(&mut self.logits, logits);
    }
    fn confidence(&mut self, confidence: f32) {
        self.confidence.value(confidence.to_bits().to_le_bytes());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fnv_matches_its_published_vectors() {
        // draft-eastlake-fnv, 64-bit FNV-1a: "", "a", "foobar"
        assert_eq!(Digest::new().hash(), 0xcbf2_9ce4_8422_2325);
        let mut a = Digest::new();
        a.value(*b"a");
        assert_eq!(a.hash(), 0xaf63_dc4c_8601_ec8c);
        let mut foobar = Digest::new();
        foobar.value(*b"foobar");
        assert_eq!((foobar.hash(), foobar.count()), (0x8594_4171_f739_67e8, 1));
    }
}
