//! Bytes as numbers, and model files made of bytes, for the fuzz targets.

pub mod files;
#[cfg(feature = "parsers")]
pub mod parsed;

use sdp3_core::crc32::crc32;

/// Bytes read as numbers; zeros beyond the end.
#[derive(Debug)]
pub struct Bytes<'a>(pub &'a [u8]);

impl Bytes<'_> {
    /// The next byte.
    pub fn u8(&mut self) -> u8 {
        let Some((&first, rest)) = self.0.split_first() else { return 0 };
        self.0 = rest;
        first
    }

    /// The next two bytes.
    pub fn u16(&mut self) -> u16 {
        u16::from_le_bytes([self.u8(), self.u8()])
    }

    /// The next four bytes.
    pub fn u32(&mut self) -> u32 {
        u32::from(self.u16()) | u32::from(self.u16()) << 16
    }

    /// Whether nothing is left.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

/// Sizes of a made model.
#[derive(Debug, Clone, Copy)]
pub struct Sizes {
    /// Channels, a multiple of 4.
    pub channels: u8,
    /// Residual blocks.
    pub blocks: u8,
    /// Classes.
    pub classes: u8,
    /// Stride of the stem.
    pub stride: u8,
    /// Frames of the image.
    pub frames: u16,
}

impl Sizes {
    /// Small legal sizes.
    pub fn of(bytes: &mut Bytes<'_>) -> Self {
        Sizes {
            channels: 4 * (1 + bytes.u8() % 3),
            blocks: 1 + bytes.u8() % 2,
            classes: 2 + bytes.u8() % 3,
            stride: 1 + bytes.u8() % 2,
            frames: 4 + u16::from(bytes.u8() % 6),
        }
    }
}

/// Window and hop of every made model.
pub const WINDOW: u16 = 8;
/// See [`WINDOW`].
pub const HOP: u16 = 2;

/// A valid model file with weights, biases, zero points, multipliers and shifts from the bytes.
pub fn model(sizes: Sizes, bytes: &mut Bytes<'_>) -> Vec<u8> {
    let slots = WINDOW + HOP * (sizes.frames - 1);
    let mut file = b"SDP3".to_vec();
    let half = |file: &mut Vec<u8>, value: u16| file.extend(value.to_le_bytes());
    half(&mut file, 1);
    half(&mut file, 64);
    file.extend([0; 4]);
    half(&mut file, slots);
    let first = 1 + bytes.u8() % 3;
    file.extend([first, 8 - bytes.u8() % 3]);
    for value in [WINDOW, HOP, 64] {
        half(&mut file, value);
    }
    file.extend([1 << (bytes.u8() % 3), sizes.stride]);
    half(&mut file, 1 + bytes.u16() % 4095);
    half(&mut file, sizes.frames);
    file.extend((f32::from(bytes.u8()) / 8.0).to_le_bytes());
    file.extend([sizes.channels, sizes.blocks, sizes.classes, 0]);
    file.resize(64, 0);
    for class in 0..sizes.classes {
        file.push(b'a' + class);
        file.resize(file.len() + 23, 0);
    }
    let c = usize::from(sizes.channels);
    weighted(&mut file, 1, c, 9, bytes);
    for _ in 0..sizes.blocks {
        weighted(&mut file, 2, c, 1, bytes);
        weighted(&mut file, 1, c, 9 * c, bytes);
        weighted(&mut file, 1, c, 9 * c, bytes);
        prefix(&mut file, 3, bytes.u8(), bytes);
        [1.0_f32; 3].iter().for_each(|scale| file.extend(scale.to_le_bytes()));
        (0..3).for_each(|_| file.extend(multiplier(bytes).to_le_bytes()));
        // the inputs of an addition have 20 guard bits: to the right only, as in every trained network
        (0..3).for_each(|_| file.push(-((bytes.u8() % 20) as i8) as u8));
        file.push(0);
    }
    weighted(&mut file, 4, usize::from(sizes.classes), c, bytes);
    set_checksum(&mut file);
    file
}

/// Puts in the length and appends the checksum.
pub fn set_checksum(file: &mut Vec<u8>) {
    let length = file.len() as u32 + 4;
    file[8..12].copy_from_slice(&length.to_le_bytes());
    let checksum = crc32(file);
    file.extend(checksum.to_le_bytes());
}

fn multiplier(bytes: &mut Bytes<'_>) -> i32 {
    match bytes.u32() {
        0 => 0,
        word => (1 << 30) | (word >> 2) as i32,
    }
}

fn prefix(file: &mut Vec<u8>, kind: u8, second_zero: u8, bytes: &mut Bytes<'_>) {
    let (a, b) = (bytes.u8() as i8, bytes.u8() as i8);
    file.extend([kind, bytes.u8(), bytes.u8(), a.min(b) as u8, a.max(b) as u8, second_zero, 0, 0]);
}

fn weighted(file: &mut Vec<u8>, kind: u8, channels: usize, taps: usize, bytes: &mut Bytes<'_>) {
    prefix(file, kind, 0, bytes);
    [1.0_f32, 0.5].iter().for_each(|scale| file.extend(scale.to_le_bytes()));
    (0..channels).for_each(|_| file.extend(multiplier(bytes).to_le_bytes()));
    (0..channels).for_each(|_| file.extend(((bytes.u32() as i32) >> 12).to_le_bytes()));
    (0..channels).for_each(|_| file.push((7 - (bytes.u8() % 39) as i8) as u8));
    file.resize(file.len().next_multiple_of(4), 0);
    // a few bytes make many weights: each is used again, turned
    let pattern: Vec<u8> = (0..31).map(|_| bytes.u8()).collect();
    file.extend((0..channels * taps).map(|k| pattern[k % 31].rotate_left((k / 31) as u32)));
    file.resize(file.len().next_multiple_of(4), 0);
}
