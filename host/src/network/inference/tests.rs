//! Whole networks on every instruction set against the plain loops, layer for layer: all widths, odd sizes, extremes.

use super::*;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;
use sdp3_core::dims::ROWS;
use sdp3_testkit::models;
use sdp3_testkit::random_model::{Numbers, Size, write};

/// A model file of this shape with random weights.
fn model(channels: usize, stride: u8, frames: u16, seed: u64, numbers: Numbers) -> Vec<u8> {
    let size = Size { channels, stride, blocks: 2, slots: 8 + 4 * (frames - 1), window: 8, hop: 4 };
    let mut bytes = vec![0; 1 << 17];
    let length = write(size, seed, numbers, sdp3_core::crc32::crc32, &mut bytes);
    bytes.truncate(length);
    bytes
}

fn available() -> impl Iterator<Item = Isa> {
    Isa::ALL.into_iter().filter(|isa| isa.available())
}

#[derive(Default, PartialEq)]
struct Layers(Vec<Vec<i8>>);

impl Probe for Layers {
    fn layer(&mut self, _index: usize, activations: &[i8]) {
        self.0.push(activations.to_vec());
    }
    fn logits(&mut self, logits: &[i8]) {
        self.0.push(logits.to_vec());
    }
}

/// Compares all layers of some images; returns how many operators run by the plain loops.
fn compare(file: &[u8], seed: u64) -> usize {
    let mut random = Xoshiro128PlusPlus::seed_from_u64(seed);
    let model = Model::parse(file).expect("a model");
    let size = model.shape().scratch_bytes();
    let mut plain = 0;
    for round in 0..2 {
        let mut pixel = || match round {
            0 => random.next_u32() as i8,
            _ => [-128, 127][random.next_u32() as usize % 2],
        };
        let image: Vec<i8> = (0..ROWS * model.frames()).map(|_| pixel()).collect();
        let (mut scratch, mut expected) = (vec![0; size], Layers::default());
        let expected_class = infer(&model, &image, &mut scratch, &mut Portable, &mut expected);
        for isa in available() {
            let mut kernels = VectorKernels::new(&model, isa).expect("an available instruction set");
            plain = plain.max(kernels.operators.iter().filter(|packed| packed.is_none()).count());
            kernels.words.resize(1 << 10, -1);
            // the second image meets what the first has left in the kernels' memory
            for _ in 0..2 {
                let (mut scratch, mut found) = (vec![99; size], Layers::default());
                let class = infer(&model, &image, &mut scratch, &mut kernels, &mut found);
                assert_eq!(found.0.len(), expected.0.len());
                for (layer, (found, expected)) in found.0.iter().zip(&expected.0).enumerate() {
                    let first = found.iter().zip(expected).position(|(f, e)| f != e);
                    assert_eq!(first, None, "{isa:?}, layer {layer}, {} channels", model.channels());
                }
                assert_eq!(class, expected_class);
            }
        }
    }
    plain
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
fn trained_models_have_the_bits_of_the_plain_loops() {
    assert_eq!(compare(models::DSN_200, 1), 0);
    assert_eq!(compare(models::DSN_1000, 2), 0);
}

#[test]
fn extremes_have_the_bits_of_the_plain_loops() {
    for seed in 0..12 {
        let file = model(16, 1 + seed as u8 % 2, 33, seed, Numbers::Extreme);
        assert_eq!(compare(&file, seed), 0);
    }
}

#[test]
fn operators_that_vectors_cannot_compute_run_by_the_plain_loops() {
    let plain: usize = (0..8).map(|seed| compare(&model(8, 2, 20, seed, Numbers::Any), seed)).sum();
    assert!(plain > 8, "{plain}");
}

#[test]
fn one_step_does_a_whole_operator_and_the_plain_loops_keep_their_steps() {
    let file = model(8, 1, 16, 1, Numbers::Usual);
    let model = Model::parse(&file).expect("a model");
    let block = model.block(0).expect("a block");
    let input = vec![1; 32 * 8 * 8];
    for isa in available() {
        let mut kernels = VectorKernels::new(&model, isa).expect("an available instruction set");
        let mut output = vec![0; input.len()];
        let layer = &block.batch_norm;
        let operator = Operator::BatchNormRelu { layer, input: &input, output: &mut output };
        assert_eq!(kernels.run(1, operator, 0), isa != Isa::Scalar, "{isa:?}");
    }
}

#[test]
fn an_average_takes_one_step_where_its_channels_divide_a_vector() {
    let file = model(8, 1, 16, 1, Numbers::Usual);
    let model = Model::parse(&file).expect("a model");
    for (channels, divide) in [(4, true), (8, true), (16, true), (12, false), (32, false)] {
        // of so many pixels a step of the plain loops adds four channels
        let input = vec![3; 8192 * channels];
        for isa in available() {
            let mut kernels = VectorKernels::new(&model, isa).expect("an available instruction set");
            let mut output = vec![0; channels];
            let average = Operator::Average { input: &input, channels, output: &mut output };
            let whole = kernels.run(9, average, 0);
            assert_eq!(whole, divide && isa != Isa::Scalar || channels == 4, "{isa:?}, {channels} channels");
            let known = if whole { channels } else { 4 };
            assert!(output[..known].iter().all(|&mean| mean == 3), "{isa:?}, {channels} channels");
        }
    }
}

#[test]
fn values_that_fill_no_vector_have_the_bits_of_the_plain_loops() {
    let file = model(8, 1, 16, 1, Numbers::Usual);
    let model = Model::parse(&file).expect("a model");
    let block = model.block(0).expect("a block");
    let mut random = Xoshiro128PlusPlus::seed_from_u64(1);
    for pixels in [1, 13, 19] {
        let mut values = || (0..8 * pixels).map(|_| random.next_u32() as i8).collect::<Vec<_>>();
        let (input, branch) = (values(), values());
        // so few values are one step of the plain loops too
        let all = |kernels: &mut dyn Kernels| {
            let [mut normalised, mut sum, mut mean] = [vec![0; input.len()], input.clone(), vec![0; 8]];
            let layer = &block.batch_norm;
            let normalise = Operator::BatchNormRelu { layer, input: &input, output: &mut normalised };
            assert!(kernels.run(1, normalise, 0));
            assert!(kernels.run(4, Operator::Add { layer: &block.add, x: &mut sum, branch: &branch }, 0));
            for step in 0.. {
                if kernels.run(9, Operator::Average { input: &input, channels: 8, output: &mut mean }, step) {
                    break;
                }
            }
            [normalised, sum, mean]
        };
        let expected = all(&mut Portable);
        for isa in available() {
            let mut kernels = VectorKernels::new(&model, isa).expect("an available instruction set");
            assert_eq!(all(&mut kernels), expected, "{isa:?}, {pixels} pixels");
        }
    }
}

#[test]
fn sixteens_of_inputs_of_16_bits_run_by_winograd() {
    for (inputs, in_a_word, by_winograd) in [
        (16, 2, true),
        (32, 2, true),
        (1, 2, false),
        (8, 2, false),
        (24, 2, false),
        (16, 4, false),
        (32, 4, false),
    ] {
        assert_eq!(
            layer::by_winograd(inputs, in_a_word),
            by_winograd,
            "{inputs} inputs, {in_a_word} in a word"
        );
    }
}

#[test]
fn instruction_sets_have_the_names_that_commands_take() {
    let names = Isa::ALL.map(Isa::name);
    assert_eq!(names, ["scalar", "arrays", "avx2", "avx-vnni", "avx512-vnni"]);
}

#[cfg(all(target_arch = "x86_64", target_os = "linux"))]
#[test]
fn kernels_are_made_for_what_the_system_says_the_processor_has() {
    let cpuinfo = std::fs::read_to_string("/proc/cpuinfo").expect("the processor's flags");
    let flags: Vec<&str> =
        cpuinfo.lines().find(|l| l.starts_with("flags")).expect("flags").split(' ').collect();
    let has = |wanted: &[&str]| wanted.iter().all(|flag| flags.contains(flag));
    let model = Model::parse(models::DSN_200).expect("a model");
    for (isa, expected) in [
        (Isa::Scalar, true),
        (Isa::Arrays, true),
        (Isa::Avx2, has(&["avx2"])),
        (Isa::AvxVnni, has(&["avx2", "avx_vnni"])),
        (Isa::Avx512Vnni, has(&["avx2", "avx512f", "avx512bw", "avx512_vnni"])),
    ] {
        assert_eq!(VectorKernels::new(&model, isa).is_some(), expected, "{isa:?}");
    }
}

#[test]
fn a_classifier_gives_what_the_plain_loops_give() {
    let model = Model::parse(models::DSN_200).expect("a model");
    let mut scratch = vec![0; model.shape().scratch_bytes()];
    let mut classifier = Classifier::new(model);
    for k in 1..4 {
        let image: Vec<i8> = (0..ROWS * model.frames()).map(|n| (n * n * k) as i8).collect();
        let expected = infer(&model, &image, &mut scratch, &mut Portable, &mut ());
        assert_eq!(classifier.classify(&image, &mut ()), expected);
    }
}
