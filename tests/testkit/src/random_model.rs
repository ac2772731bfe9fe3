//! Model files with random weights, in the caller's memory.
//!
//! Layout: `sdp3_core::dsn::format`.

use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

/// How the parameters of a network are drawn.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Numbers {
    /// Scales and zero points that keep activations in range, as training leaves them.
    Trained,
    /// As trained, but any zero point and activation range.
    Usual,
    /// Every weight and zero point is -128 or 127.
    Extreme,
    /// Any legal multiplier, shift and bias.
    Any,
}

/// The size of a network.
#[derive(Clone, Copy, Debug)]
pub struct Size {
    /// Channels of every convolution.
    pub channels: usize,
    /// Stride of the input convolution.
    pub stride: u8,
    /// Residual blocks.
    pub blocks: u8,
    /// Sensing slots of a recording.
    pub slots: u16,
    /// Window of its spectrogram in sensing slots.
    pub window: u16,
    /// Sensing slots between two frames.
    pub hop: u16,
}

impl Size {
    /// Frames of the image.
    pub fn frames(&self) -> u16 {
        (self.slots - self.window) / self.hop + 1
    }
}

struct Writer<'a> {
    bytes: &'a mut [u8],
    at: usize,
    random: Xoshiro128PlusPlus,
    numbers: Numbers,
}

impl Writer<'_> {
    fn below(&mut self, n: u32) -> u32 {
        self.random.next_u32() % n
    }

    fn byte(&mut self) -> i8 {
        match self.numbers {
            Numbers::Extreme => [-128, 127][self.below(2) as usize],
            _ => self.random.next_u32() as i8,
        }
    }

    fn put(&mut self, bytes: &[u8]) {
        self.bytes[self.at..][..bytes.len()].copy_from_slice(bytes);
        self.at += bytes.len();
    }

    fn zeros(&mut self, count: usize) {
        (0..count).for_each(|_| self.put(&[0]));
    }

    /// Kind, zero points and activation range. [`Numbers::Trained`]: a `rectified` layer has the zero point -128.
    fn layer_header(&mut self, kind: u8, rectified: bool) {
        let (input, output, second) = (self.byte(), self.byte(), self.byte());
        let low = [-128, output, self.byte()][self.below(3) as usize];
        let high = if self.below(2) == 0 { 127 } else { self.byte().max(low) };
        if self.numbers == Numbers::Trained {
            let output = if rectified { -128_i8 } else { output / 16 };
            self.put(&[kind, (input / 16) as u8, output as u8, 128, 127, (second / 16) as u8, 0, 0]);
        } else {
            self.put(&[kind, input as u8, output as u8, low as u8, high as u8, second as u8, 0, 0]);
        }
    }

    fn scale(&mut self, gain: i8) -> (i32, i8) {
        let multiplier = (1 << 30) + self.below(1 << 30) as i32;
        match self.numbers {
            Numbers::Any => (multiplier, self.below(39) as i8 - 31),
            _ => (multiplier, -gain - self.below(3) as i8),
        }
    }

    fn scales(&mut self, count: usize, gain: i8) -> [(i32, i8); 32] {
        let mut scales = [(0, 0); 32];
        scales.iter_mut().take(count).for_each(|scale| *scale = self.scale(gain));
        scales
    }

    fn per_channel(&mut self, kind: u8, channels: usize, taps: usize, rectified: bool) {
        self.layer_header(kind, rectified);
        (0..2).for_each(|_| self.put(&1_f32.to_le_bytes()));
        let gain = if taps == 1 { 6 } else { 8 + taps.ilog2() as i8 / 2 };
        let scales = self.scales(channels, gain);
        scales[..channels].iter().for_each(|(multiplier, _)| self.put(&multiplier.to_le_bytes()));
        for _ in 0..channels {
            let bias = match self.numbers {
                Numbers::Any => self.random.next_u32() as i32 >> self.below(16),
                _ => self.below(20_001) as i32 - 10_000,
            };
            self.put(&bias.to_le_bytes());
        }
        scales[..channels].iter().for_each(|&(_, shift)| self.put(&[shift as u8]));
        self.zeros(channels.next_multiple_of(4) - channels);
        for _ in 0..(channels * taps).next_multiple_of(4) {
            let w = self.byte();
            self.put(&[w as u8]);
        }
    }

    fn add(&mut self) {
        self.layer_header(3, false);
        (0..3).for_each(|_| self.put(&1_f32.to_le_bytes()));
        let half = (1 << 30, 0);
        let scales = match self.below(3) {
            0 => [half, self.scale(1), self.scale(18)],
            1 => [self.scale(1), half, self.scale(18)],
            _ => [self.scale(1), self.scale(1), self.scale(18)],
        };
        scales.iter().for_each(|(multiplier, _)| self.put(&multiplier.to_le_bytes()));
        scales.iter().for_each(|&(_, shift)| self.put(&[shift as u8]));
        self.put(&[0]);
    }
}

/// Writes a model file to the start of `bytes` and returns its length; `crc32` is the checksum of the model format.
///
/// # Panics
///
/// If `bytes` is too short.
pub fn write(size: Size, seed: u64, numbers: Numbers, crc32: fn(&[u8]) -> u32, bytes: &mut [u8]) -> usize {
    let random = Xoshiro128PlusPlus::seed_from_u64(seed);
    let channels = size.channels;
    let mut w = Writer { bytes, at: 0, random, numbers };
    w.put(b"SDP3\x01\x00\x40\x00\0\0\0\0");
    w.put(&size.slots.to_le_bytes());
    w.put(&[2, 8]);
    for value in [size.window, size.hop, 64] {
        w.put(&value.to_le_bytes());
    }
    w.put(&[1, size.stride]);
    w.put(&1063_u16.to_le_bytes());
    w.put(&size.frames().to_le_bytes());
    w.put(&10_f32.to_le_bytes());
    w.put(&[channels as u8, size.blocks, 3, 0]);
    w.zeros(28);
    for name in [b"a", b"b", b"c"] {
        w.put(name);
        w.zeros(23);
    }
    w.per_channel(1, channels, 9, false);
    for _ in 0..size.blocks {
        w.per_channel(2, channels, 1, true);
        w.per_channel(1, channels, 9 * channels, true);
        w.per_channel(1, channels, 9 * channels, false);
        w.add();
    }
    w.per_channel(4, 3, channels, false);
    let (at, length) = (w.at, w.at as u32 + 4);
    bytes[8..12].copy_from_slice(&length.to_le_bytes());
    let checksum = crc32(&bytes[..at]);
    bytes[at..at + 4].copy_from_slice(&checksum.to_le_bytes());
    at + 4
}
