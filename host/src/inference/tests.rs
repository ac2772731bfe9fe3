//! Whole networks on every instruction set against the plain loops, layer for layer: all widths, odd sizes, extremes.

extern crate std;

use super::*;
use crate::dsn::Network;
use crate::dsn::model::crc32;
use crate::dsn::network::scratch_bytes;
use crate::probe::Probe;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;
use sdp3_testkit::random_model::{Numbers, Size, write};
use std::vec;
use std::vec::Vec as List;

/// A model file of this shape with random numbers.
fn model(channels: usize, stride: u8, frames: u16, seed: u64, numbers: Numbers) -> List<u8> {
    let size = Size { channels, stride, blocks: 2, slots: 8 + 4 * (frames - 1), window: 8, hop: 4 };
    let mut bytes = vec![0; 1 << 17];
    let length = write(size, seed, numbers, crc32, &mut bytes);
    bytes.truncate(length);
    bytes
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

#[test]
fn memory_is_as_worked_out_by_hand() {
    // two blocks; words are the stem's rows, or the map with its border and six rows
    for (channels, stride, frames, lines, words) in [
        (8, 1, 30, 12 + 2 * (2 * (6 + 9 * 4) + 7 + 17), 66 * 32 * 2),
        (12, 1, 30, 12 + 2 * (2 * (6 + 9 * 6) + 21 + 17), 40 * 18 * 6),
        (16, 2, 110, 12 + 2 * (2 * (6 + 36 * 8) + 7 + 17), 65 * 56 * 2),
        (32, 1, 67, 24 + 2 * (4 * (6 + 36 * 16) + 14 + 17), 40 * 50 * 16),
    ] {
        let file = model(channels, stride, frames, 1, Numbers::Usual);
        let model = Model::parse(&file).expect("a model");
        assert_eq!((Vector::lines(&model), Vector::words(&model)), (lines, words), "{channels} channels");
    }
}

#[test]
fn every_layer_runs_on_vectors_where_there_are_any() {
    let file = model(8, 1, 16, 1, Numbers::Usual);
    let model = Model::parse(&file).expect("a model");
    for isa in Isa::ALL.into_iter().filter(|isa| isa.available()) {
        let (mut lines, mut words) =
            (vec![Line::ZERO; Vector::lines(&model)], vec![0; Vector::words(&model)]);
        let memory = VectorMemory { lines: &mut lines, words: &mut words };
        let vector = Vector::new(&model, isa, memory).expect("enough memory");
        let layers = 1 + 4 * model.blocks();
        let packed = (0..layers + 1).filter(|&at| vector.packed(at).is_some()).count();
        assert_eq!(packed, if isa == Isa::Scalar { 0 } else { layers }, "{isa:?}");
        assert_eq!((vector.isa(), vector.plain_layers()), (isa, 0));
    }
}
