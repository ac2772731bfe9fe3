//! Whole networks on every instruction set against the plain loops, layer for layer: all widths, odd sizes, extremes.

extern crate std;

use super::*;
use crate::dsn::Network;
use crate::dsn::model::crc32;
use crate::dsn::network::scratch_bytes;
use crate::probe::Probe;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;
use std::vec::Vec as List;
use std::{format, vec};

/// How a network's numbers are drawn.
#[derive(Clone, Copy, PartialEq, Debug)]
enum Numbers {
    /// Scales that keep values in range, as training leaves them.
    Usual,
    /// All weights and zero points at an end of their range.
    Extreme,
    /// Any legal multiplier, shift and bias.
    Any,
}

struct Writer {
    bytes: List<u8>,
    random: Xoshiro128PlusPlus,
    numbers: Numbers,
}

impl Writer {
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
        self.bytes.extend_from_slice(bytes);
    }

    /// Zero points and range; some with a ReLU.
    fn begin(&mut self, kind: u8) {
        let (input, output, second) = (self.byte(), self.byte(), self.byte());
        let low = [-128, output, self.byte()][self.below(3) as usize];
        let high = if self.below(2) == 0 { 127 } else { self.byte().max(low) };
        self.put(&[kind, input as u8, output as u8, low as u8, high as u8, second as u8, 0, 0]);
    }

    fn scale(&mut self, gain: i8) -> (i32, i8) {
        let multiplier = (1 << 30) + self.below(1 << 30) as i32;
        match self.numbers {
            Numbers::Any => (multiplier, self.below(39) as i8 - 31),
            _ => (multiplier, -gain - self.below(3) as i8),
        }
    }

    fn channelwise(&mut self, kind: u8, channels: usize, taps: usize) {
        self.begin(kind);
        (0..2).for_each(|_| self.put(&1_f32.to_le_bytes()));
        let gain = if taps == 1 { 6 } else { 8 + taps.ilog2() as i8 / 2 };
        let scales: List<(i32, i8)> = (0..channels).map(|_| self.scale(gain)).collect();
        scales.iter().for_each(|(multiplier, _)| self.put(&multiplier.to_le_bytes()));
        for _ in 0..channels {
            let bias = match self.numbers {
                Numbers::Any => self.random.next_u32() as i32 >> self.below(16),
                _ => self.below(20_001) as i32 - 10_000,
            };
            self.put(&bias.to_le_bytes());
        }
        scales.iter().for_each(|&(_, shift)| self.put(&[shift as u8]));
        (channels..channels.next_multiple_of(4)).for_each(|_| self.put(&[0]));
        let length = (channels * taps).next_multiple_of(4);
        for _ in 0..length {
            let w = self.byte();
            self.put(&[w as u8]);
        }
    }

    fn add(&mut self) {
        self.begin(3);
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

/// A model file of this shape with random numbers.
fn model(channels: usize, stride: u8, frames: u16, seed: u64, numbers: Numbers) -> List<u8> {
    let random = Xoshiro128PlusPlus::seed_from_u64(seed);
    let mut w = Writer { bytes: vec![], random, numbers };
    w.put(b"SDP3\x01\x00\x40\x00\0\0\0\0");
    w.put(&(8 + 4 * (frames - 1)).to_le_bytes());
    w.put(&[2, 8]);
    for value in [8_u16, 4, 64] {
        w.put(&value.to_le_bytes());
    }
    w.put(&[1, stride]);
    w.put(&1063_u16.to_le_bytes());
    w.put(&frames.to_le_bytes());
    w.put(&10_f32.to_le_bytes());
    w.put(&[channels as u8, 2, 3, 0]);
    w.put(&[0; 28]);
    for name in ["a", "b", "c"] {
        w.put(format!("{name:\0<24}").as_bytes());
    }
    w.channelwise(1, channels, 9);
    for _ in 0..2 {
        w.channelwise(2, channels, 1);
        w.channelwise(1, channels, 9 * channels);
        w.channelwise(1, channels, 9 * channels);
        w.add();
    }
    w.channelwise(4, 3, channels);
    let length = w.bytes.len() as u32 + 4;
    w.bytes[8..12].copy_from_slice(&length.to_le_bytes());
    let checksum = crc32(&w.bytes);
    w.put(&checksum.to_le_bytes());
    w.bytes
}

#[derive(Default, PartialEq)]
struct Layers(List<List<i8>>);

impl Probe for Layers {
    fn layer(&mut self, _index: usize, activations: &[i8]) {
        self.0.push(activations.to_vec());
    }
    fn logits(&mut self, logits: &[i8]) {
        self.0.push(logits.to_vec());
    }
}

/// Compares all layers of some images; returns how many layers vectors refused.
fn compare(file: &[u8], seed: u64) -> usize {
    let mut random = Xoshiro128PlusPlus::seed_from_u64(seed);
    let model = Model::parse(file).expect("a model");
    let size = scratch_bytes(model.frames(), model.channels(), model.stem_stride());
    let mut plain_layers = 0;
    for round in 0..2 {
        let image: List<i8> = (0..ROWS * model.frames())
            .map(|_| {
                if round == 0 { random.next_u32() as i8 } else { [-128, 127][random.next_u32() as usize % 2] }
            })
            .collect();
        let (mut scratch, mut expected) = (vec![0; size], Layers::default());
        let answer = Network::new(model.clone(), &mut scratch).expect("scratch").infer(&image, &mut expected);
        for isa in Isa::ALL.into_iter().filter(|isa| isa.available()) {
            let mut lines = vec![Line([-1; 16]); Vector::lines(&model)];
            let mut words = vec![-1; Vector::words(&model)];
            let memory = VectorMemory { lines: &mut lines, words: &mut words };
            let kernels = Vector::new(&model, isa, memory).expect("memory");
            assert_eq!(kernels.isa(), isa);
            plain_layers = kernels.plain_layers().max(plain_layers);
            let mut scratch = vec![99; size];
            let mut found = Layers::default();
            let network = Network::with_kernels(model.clone(), &mut scratch, kernels);
            let found_answer = network.expect("scratch").infer(&image, &mut found);
            assert_eq!(found.0.len(), expected.0.len());
            for (layer, (found, expected)) in found.0.iter().zip(&expected.0).enumerate() {
                let first = found.iter().zip(expected).position(|(f, e)| f != e);
                assert_eq!(first, None, "{isa:?}, layer {layer}, {} channels", model.channels());
            }
            assert_eq!(found_answer, answer);
        }
    }
    plain_layers
}

#[test]
fn every_width_has_the_bits_of_the_plain_loops() {
    for channels in (4..=32).step_by(4) {
        for (stride, frames) in [(1, 5), (2, 5), (1, 36), (2, 67)] {
            let seed = channels as u64 + u64::from(frames);
            let file = model(channels, stride, frames, seed, Numbers::Usual);
            assert_eq!(compare(&file, seed), 0);
        }
    }
}

#[test]
fn extremes_have_the_bits_of_the_plain_loops() {
    for seed in 0..12 {
        let file = model(16, 1 + seed as u8 % 2, 33, seed, Numbers::Extreme);
        assert_eq!(compare(&file, seed), 0);
    }
}

#[test]
fn layers_that_vectors_cannot_hold_run_by_the_plain_loops() {
    let refused: usize = (0..8).map(|seed| compare(&model(8, 2, 20, seed, Numbers::Any), seed)).sum();
    assert!(refused > 8, "{refused}");
}

#[test]
fn too_little_memory_is_refused() {
    let file = model(8, 1, 16, 1, Numbers::Usual);
    let model = Model::parse(&file).expect("a model");
    let (mut lines, mut words) = (vec![Line::ZERO; Vector::lines(&model)], vec![0; Vector::words(&model)]);
    let short = VectorMemory { lines: &mut lines[1..], words: &mut words };
    assert!(Vector::new(&model, Isa::Arrays, short).is_none());
    let short = VectorMemory { lines: &mut lines, words: &mut words[1..] };
    assert!(Vector::new(&model, Isa::Arrays, short).is_none());
}
