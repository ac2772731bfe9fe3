//! One number per stage: FNV-1a, 64 bits, over the little-endian bytes of its values.
//!
//! Equal digests on two processors mean equal values; floats go in by their bits.

use crate::values::{Sink, Stage, Values};

/// A running FNV-1a hash and the number of values it took.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Digest {
    hash: u64,
    count: u64,
}

#[allow(clippy::new_without_default)] // there is one way to begin
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

impl Sink for [Digest; Stage::ALL.len()] {
    fn value<const N: usize>(&mut self, stage: Stage, bytes: [u8; N]) {
        self[stage as usize].value(bytes);
    }
}

/// Digests every stage it sees.
pub type DigestProbe = Values<[Digest; Stage::ALL.len()]>;

impl DigestProbe {
    /// A probe that has seen nothing.
    pub const fn new() -> Self {
        Values([Digest::new(); Stage::ALL.len()])
    }

    /// Name and digest of every stage, in the order of [`Stage::ALL`].
    pub fn stages(&self) -> impl Iterator<Item = (&'static str, Digest)> {
        Stage::ALL.into_iter().map(Stage::name).zip(self.0)
    }
}
