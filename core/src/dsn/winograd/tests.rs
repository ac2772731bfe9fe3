//! Whole networks in tiles against the plain loops, layer for layer: all widths, odd sizes, extremes.

extern crate std;

use super::rescale::{MAX_ACCUMULATOR, Rescale};
use super::*;
use crate::dsn::Network;
use crate::dsn::model::crc32;
use crate::dsn::network::scratch_bytes;
use crate::dsn::per_channel::PerChannelQuant;
use crate::probe::Probe;
use crate::simd::dual_mac::Plain;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;
use sdp3_testkit::random_model::{Numbers, Size, write};
use std::vec;
use std::vec::Vec as List;

#[derive(Default, PartialEq)]
struct Layers(List<List<i8>>);

impl Probe for Layers {
    fn layer(&mut self, index: usize, activations: &[i8]) {
        assert_eq!(index, self.0.len(), "layers come in their order");
        self.0.push(activations.to_vec());
    }
}

/// Memory for so many places, of numbers that should not matter.
fn memory(model: &Model<'_>, places: usize) -> (List<I16x8>, List<i32>) {
    let sizes = WinogradSizes::new(model.frames(), model.channels(), model.stem_stride(), places);
    (vec![I16x8([-1; 8]); sizes.eights], vec![-1; sizes.words])
}

/// How many convolutions tiles refuse.
fn refused(model: &Model<'_>) -> usize {
    let (mut eights, mut words) = memory(model, 1);
    let convolutions = model.blocks.iter().flat_map(|block| &block.convs);
    convolutions.filter(|conv| packing::pack::<Plain>(conv, &mut eights, &mut words).is_none()).count()
}

/// Compares all layers of some images, with memory for one to all convolutions; returns how many tiles refused.
fn compare<P: DualMac + Default>(
    channels: usize,
    stride: u8,
    frames: u16,
    seed: u64,
    numbers: Numbers,
) -> usize {
    let size = Size { channels, stride, blocks: 2, slots: 8 + 4 * (frames - 1), window: 8, hop: 4 };
    let mut bytes = vec![0; 1 << 17];
    let length = write(size, seed, numbers, crc32, &mut bytes);
    let model = Model::parse(&bytes[..length]).expect("a model");
    let mut random = Xoshiro128PlusPlus::seed_from_u64(seed);
    let scratch_size = scratch_bytes(model.frames(), channels, model.stem_stride());
    for (round, places) in [(0, 1), (1, 2), (0, 3), (1, 4)] {
        let image: List<i8> = (0..ROWS * model.frames())
            .map(|_| match round {
                0 => random.next_u32() as i8,
                _ => [-128, 127][random.next_u32() as usize % 2],
            })
            .collect();
        let (mut scratch, mut expected) = (vec![0; scratch_size], Layers::default());
        let answer = Network::new(model.clone(), &mut scratch).expect("scratch").infer(&image, &mut expected);
        let (mut eights, mut words) = memory(&model, places);
        let memory = WinogradMemory { eights: &mut eights, words: &mut words };
        let mut kernels = WinogradF2::with_pairs(&model, P::default(), memory).expect("memory");
        let (mut scratch, mut found) = (vec![99; scratch_size], Layers::default());
        let network = Network::with_kernels(model.clone(), &mut scratch, &mut kernels); // borrowed, as exits borrow theirs
        let found_answer = network.expect("scratch").infer(&image, &mut found);
        assert_eq!(found.0.len(), expected.0.len());
        for (layer, (found, expected)) in found.0.iter().zip(&expected.0).enumerate() {
            let first = found.iter().zip(expected).position(|(f, e)| f != e);
            assert_eq!(first, None, "layer {layer}, {channels} channels, stride {stride}, {frames} frames");
        }
        assert_eq!(found_answer, answer);
    }
    refused(&model)
}

#[test]
fn tiles_have_the_bits_of_the_plain_loops() {
    for channels in (4..=32).step_by(4) {
        for (stride, frames) in [(1, 5), (2, 5), (1, 36), (2, 67), (1, 30), (1, 34)] {
            let seed = channels as u64 + u64::from(frames);
            let refused = if matches!(channels, 8 | 16 | 32) { 0 } else { 4 };
            assert_eq!(compare::<Plain>(channels, stride, frames, seed, Numbers::Usual), refused);
            assert_eq!(compare::<Plain<true>>(channels, stride, frames, seed, Numbers::Usual), refused);
        }
    }
}

#[test]
fn extremes_have_the_bits_of_the_plain_loops() {
    for seed in 0..12 {
        assert_eq!(compare::<Plain>(16, 1 + seed as u8 % 2, 33, seed, Numbers::Extreme), 0);
        assert_eq!(compare::<Plain<true>>(32, 1 + seed as u8 % 2, 12, seed, Numbers::Extreme), 0);
    }
}

#[test]
fn layers_that_tiles_cannot_hold_run_by_the_plain_loops() {
    let refused: usize = (0..8).map(|seed| compare::<Plain>(8, 2, 20, seed, Numbers::Any)).sum();
    assert!(refused > 8, "{refused}");
}

#[test]
fn too_little_memory_is_refused() {
    let size = Size { channels: 8, stride: 1, blocks: 2, slots: 68, window: 8, hop: 4 };
    let mut bytes = vec![0; 1 << 17];
    let length = write(size, 1, Numbers::Usual, crc32, &mut bytes);
    let model = Model::parse(&bytes[..length]).expect("a model");
    let sizes = WinogradSizes::of(&model);
    for short in 0..3 {
        let less = |k: usize, size: usize| size - usize::from(short == k);
        let (mut eights, mut words) =
            (vec![I16x8::ZERO; less(0, sizes.eights)], vec![0; less(1, sizes.words)]);
        let memory = WinogradMemory { eights: &mut eights, words: &mut words };
        assert_eq!(WinogradF2::new(&model, memory).is_some(), short == 2);
    }
}

#[test]
fn every_layer_runs_in_tiles_where_there_is_memory_for_one() {
    assert_eq!([2, 3, 6, 7, 10, 11].map(convolution_number), [0, 1, 2, 3, 4, 5]);
    for channels in [8, 16, 32] {
        let size = Size { channels, stride: 2, blocks: 3, slots: 8 + 4 * 19, window: 8, hop: 4 };
        let mut bytes = vec![0; 1 << 17];
        let length = write(size, 1, Numbers::Usual, crc32, &mut bytes);
        let model = Model::parse(&bytes[..length]).expect("a model");
        // six convolutions: packed ahead, but for those that share the last place
        for (places, ahead) in [(1, 0), (2, 1), (5, 4), (6, 6), (7, 6)] {
            let (mut eights, mut words) = memory(&model, places);
            let memory = WinogradMemory { eights: &mut eights, words: &mut words };
            let mut tiled = WinogradF2::with_pairs(&model, Plain::<false>, memory).expect("memory");
            assert_eq!((tiled.ahead, tiled.plain), (ahead, 0), "{places} places");
            let (height, width) = (16, 5);
            let (input, mut output) =
                (vec![1; height * width * channels], vec![0; height * width * channels]);
            let mut border = vec![0; 2 * 10 * channels];
            for (number, conv) in model.blocks.iter().flat_map(|block| &block.convs).enumerate() {
                let ran = tiled.convolve(number, conv, &input, width, &mut border, &mut output);
                assert_eq!(ran, Some(()), "{channels} channels, {places} places");
            }
            let image = vec![3; ROWS * model.frames()];
            assert!(stem::pooled(&model.stem, tiled.spare, &image, (ROWS, model.frames()), &mut output));
            for block in &model.blocks {
                assert!(pointwise::affine(&block.batch_norm, tiled.spare, &input, &mut output));
                assert!(pointwise::add(&block.add, tiled.spare, &mut output, &input));
            }
        }
    }
}

#[test]
fn accumulators_have_the_bound_that_is_stated() {
    let fits = |bias: i64| {
        let biases = (bias as i32).to_le_bytes();
        let (multipliers, shifts) = ((1_i32 << 30).to_le_bytes(), [(-1_i8) as u8]);
        let layer = PerChannelQuant {
            in_zp: -128,
            out_zp: 0,
            act_min: -128,
            act_max: 127,
            channels: 1,
            multipliers: &multipliers,
            biases: &biases,
            shifts: &shifts,
            weights: &[],
        };
        Rescale::of(&layer, 0, 0, 9).is_some()
    };
    let most = MAX_ACCUMULATOR - 9 * 255 * 128;
    assert!(fits(0) && fits(most - 1) && fits(1 - most));
    assert!(!fits(most) && !fits(-most));
}
