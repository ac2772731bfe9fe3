//! Whole networks against the plain loops, operator for operator: all widths, odd sizes, extremes.

use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;
use sdp3_core::crc32::crc32;
use sdp3_core::dims::ROWS;
use sdp3_core::dsn::batch_norm::BatchNormRelu;
use sdp3_core::dsn::per_channel::PerChannelQuant;
use sdp3_core::dsn::winograd::{WinogradMemory, WinogradSizes};
use sdp3_core::dsn::{Kernels, Model, Network, Operator, Portable, WinogradKernels, infer};
use sdp3_core::fixed::requantize;
use sdp3_core::probe::Probe;
use sdp3_core::simd::dual_mac::{DualMac, I16x8, Plain};
use sdp3_testkit::random_model::{Numbers, Size, write};

#[derive(Default, PartialEq)]
struct Layers(Vec<Vec<i8>>);

impl Probe for Layers {
    fn layer(&mut self, index: usize, activations: &[i8]) {
        assert_eq!(index, self.0.len(), "operators come in their order");
        self.0.push(activations.to_vec());
    }
}

fn random_model(channels: usize, stride: u8, frames: u16, seed: u64, numbers: Numbers) -> Vec<u8> {
    random_blocks(2, channels, stride, frames, seed, numbers)
}

fn random_blocks(
    blocks: u8,
    channels: usize,
    stride: u8,
    frames: u16,
    seed: u64,
    numbers: Numbers,
) -> Vec<u8> {
    let size = Size { channels, stride, blocks, slots: 8 + 4 * (frames - 1), window: 8, hop: 4 };
    let mut bytes = vec![0; 1 << 17];
    let length = write(size, seed, numbers, crc32, &mut bytes);
    bytes.truncate(length);
    bytes
}

/// Memory of numbers that should not matter.
struct Memory(Vec<I16x8>, Vec<i32>);

impl Memory {
    fn new(sizes: WinogradSizes) -> Self {
        Memory(vec![[-1; 4]; sizes.vectors], vec![-1; sizes.words])
    }

    fn view(&mut self) -> WinogradMemory<'_> {
        WinogradMemory { vectors: &mut self.0, words: &mut self.1 }
    }
}

fn sizes(model: &Model<'_>, packed: usize) -> WinogradSizes {
    WinogradSizes::new(model.channels(), packed)
}

/// Counts the steps that were given to plain loops.
struct Counting<'b, P>(WinogradKernels<'b, P>, usize);

impl<P: DualMac> Kernels for Counting<'_, P> {
    fn run(&mut self, index: usize, operator: Operator<'_>, step: usize) -> bool {
        let average = matches!(operator, Operator::Average { .. });
        let done = self.0.run(index, operator, step);
        self.1 += usize::from(self.0.is_portable() && !average);
        done
    }
}

/// Compares all operators' outputs of some images, with memory for one to all convolutions and with memory that is shared;
/// whether plain loops computed anything.
fn compare<P: DualMac + Default>(
    channels: usize,
    stride: u8,
    frames: u16,
    seed: u64,
    numbers: Numbers,
) -> bool {
    let bytes = random_model(channels, stride, frames, seed, numbers);
    let model = Model::parse(&bytes).expect("a model");
    let mut random = Xoshiro128PlusPlus::seed_from_u64(seed);
    let mut plain = 0;
    for (round, counts) in [[1, 3, 0].as_slice(), &[2, 4]].into_iter().enumerate() {
        let image: Vec<i8> = (0..ROWS * model.frames())
            .map(|_| match round {
                0 => random.next_u32() as i8,
                _ => [-128, 127][random.next_u32() as usize % 2],
            })
            .collect();
        let (mut scratch, mut expected) = (vec![0; model.shape().scratch_bytes()], Layers::default());
        let answer = infer(&model, &image, &mut scratch, &mut Portable, &mut expected);
        for &packed in counts {
            let larger = WinogradSizes::new(32, 1);
            let mut memory = Memory::new(if packed == 0 { larger } else { sizes(&model, packed) });
            let kernels = match packed {
                0 => WinogradKernels::shared_with_mac(P::default(), memory.view()),
                _ => WinogradKernels::with_mac(&model, P::default(), memory.view()).expect("memory"),
            };
            let mut kernels = Counting(kernels, 0);
            let (mut scratch, mut found) = (vec![99; scratch.len()], Layers::default());
            let found_answer = infer(&model, &image, &mut scratch, &mut kernels, &mut found);
            plain += kernels.1;
            assert_eq!(found.0.len(), expected.0.len());
            for (index, (found, expected)) in found.0.iter().zip(&expected.0).enumerate() {
                let first = found.iter().zip(expected).position(|(f, e)| f != e);
                assert_eq!(
                    first, None,
                    "operator {index}, {channels} channels, stride {stride}, {frames} frames"
                );
            }
            assert_eq!(found_answer, answer);
        }
    }
    plain > 0
}

#[test]
fn networks_have_the_bits_of_the_plain_loops() {
    for channels in [8, 16, 32] {
        for (stride, frames) in [(1, 5), (2, 5), (2, 67), (2, 60), (2, 64), (1, 21)] {
            let seed = channels as u64 + u64::from(frames);
            assert!(!compare::<Plain>(channels, stride, frames, seed, Numbers::Usual));
            assert!(!compare::<Plain<true>>(channels, stride, frames, seed, Numbers::Usual));
        }
    }
    for channels in [4, 12, 20, 24, 28] {
        for stride in [1, 2] {
            assert!(compare::<Plain>(channels, stride, 22, 1, Numbers::Usual));
        }
    }
}

#[test]
fn extremes_have_the_bits_of_the_plain_loops() {
    for seed in 0..8 {
        assert!(!compare::<Plain>(16, 1 + seed as u8 % 2, 33, seed, Numbers::Extreme));
        assert!(!compare::<Plain<true>>(32, 1 + seed as u8 % 2, 12, seed, Numbers::Extreme));
    }
}

#[test]
fn operators_that_are_not_covered_run_by_the_plain_loops() {
    let plain = (0..8).filter(|&seed| compare::<Plain>(8, 2, 20, seed, Numbers::Any)).count();
    assert!(plain > 4, "{plain}");
}

#[test]
fn one_memory_serves_models_in_turn_and_an_unfinished_image_is_given_up() {
    let files = [(16, 2, 40), (8, 1, 20), (32, 2, 12)]
        .map(|(channels, stride, frames)| random_model(channels, stride, frames, 3, Numbers::Usual));
    let models = files.each_ref().map(|file| Model::parse(file).expect("a model"));
    let most =
        models.iter().fold(WinogradSizes { vectors: 0, words: 0 }, |most, model| most.max(sizes(model, 1)));
    let mut memory = Memory::new(most);
    let mut kernels = Counting(WinogradKernels::shared_with_mac(Plain::<false>, memory.view()), 0);
    for unfinished in [0, 1, 2, 7, 30, 61] {
        for model in &models {
            let image = vec![unfinished as i8; ROWS * model.frames()];
            let mut scratch = vec![0; model.shape().scratch_bytes()];
            let mut network = Network::new();
            for _ in 0..unfinished {
                assert_eq!(network.step(model, &mut scratch, &mut kernels, &mut ()), None);
            }
            let found = infer(model, &image, &mut scratch, &mut kernels, &mut ());
            assert_eq!(found, infer(model, &image, &mut scratch, &mut Portable, &mut ()));
        }
    }
    assert_eq!(kernels.1, 0, "steps by plain loops");
    // memory of any size gives the same bits
    for less in [most.words / 2, 10, 0] {
        let mut memory = Memory::new(WinogradSizes { vectors: less, words: less });
        let mut kernels = Counting(WinogradKernels::shared_with_mac(Plain::<false>, memory.view()), 0);
        let image = vec![5; ROWS * models[0].frames()];
        let mut scratch = vec![0; models[0].shape().scratch_bytes()];
        let found = infer(&models[0], &image, &mut scratch, &mut kernels, &mut ());
        assert_eq!(found, infer(&models[0], &image, &mut scratch, &mut Portable, &mut ()));
        assert!(kernels.1 > 0);
    }
}

#[test]
fn memory_is_asked_for_to_the_element() {
    let bytes = random_model(8, 1, 16, 1, Numbers::Usual);
    let model = Model::parse(&bytes).expect("a model");
    let exact = WinogradSizes::of(&model);
    for (vectors, words) in [(0, 0), (1, 0), (0, 1)] {
        let mut memory =
            Memory::new(WinogradSizes { vectors: exact.vectors - vectors, words: exact.words - words });
        assert_eq!(WinogradKernels::new(&model, memory.view()).is_some(), vectors + words == 0);
    }
    // four convolutions: packed ahead, but for those that share the last place with the other operators
    for (packed, ahead) in [(1, 0), (2, 1), (3, 2), (4, 3), (5, 4), (6, 4)] {
        let mut memory = Memory::new(sizes(&model, packed));
        let kernels = WinogradKernels::new(&model, memory.view()).expect("memory");
        assert_eq!(kernels.prepacked(), ahead, "{packed} packed");
    }
    // two of one block, six of three
    for (blocks, packed, ahead) in [(1, 1, 0), (1, 2, 1), (1, 3, 2), (3, 5, 4), (3, 6, 5), (3, 7, 6)] {
        let bytes = random_blocks(blocks, 8, 1, 16, 1, Numbers::Usual);
        let model = Model::parse(&bytes).expect("a model");
        let mut memory = Memory::new(sizes(&model, packed));
        let kernels = WinogradKernels::new(&model, memory.view()).expect("memory");
        assert_eq!(kernels.prepacked(), ahead, "{packed} packed of {blocks} blocks");
    }
    // weights, of few channels two tables; constants
    for (channels, packed, vectors, words, bytes) in [
        (16, 1, 960, 64, 15_616),
        (8, 3, 3 * 240, 3 * 32, 11_904),
        (32, 1, 3840, 128, 61_952),
        (12, 1, 128, 0, 2_048),
        (28, 2, 140, 0, 2_240),
    ] {
        let sizes = WinogradSizes::new(channels, packed);
        assert_eq!((sizes, sizes.total()), (WinogradSizes { vectors, words }, bytes), "{channels} channels");
    }
}

/// Counts the steps of every operator.
struct Steps<K>(K, Vec<usize>);

impl<K: Kernels> Kernels for Steps<K> {
    fn run(&mut self, index: usize, operator: Operator<'_>, step: usize) -> bool {
        self.1.resize(self.1.len().max(index + 1), 0);
        self.1[index] += 1;
        self.0.run(index, operator, step)
    }
}

#[test]
fn what_is_packed_ahead_is_not_packed_at_a_recognition() {
    let bytes = random_blocks(3, 16, 1, 16, 4, Numbers::Usual);
    let model = Model::parse(&bytes).expect("a model");
    let image = vec![3; ROWS * model.frames()];
    let steps = |packed: usize| {
        let mut memory = Memory::new(sizes(&model, packed));
        let kernels = WinogradKernels::new(&model, memory.view()).expect("memory");
        let mut kernels = Steps(kernels, Vec::new());
        let mut scratch = vec![0; model.shape().scratch_bytes()];
        infer(&model, &image, &mut scratch, &mut kernels, &mut ());
        kernels.1
    };
    // behind the stem come a normalisation, two convolutions and an addition for each block
    let convolutions = [2, 3, 6, 7, 10, 11];
    let (none, all) = (steps(1), steps(7));
    let packing = none[2] - all[2];
    assert!(packing > 0);
    for packed in 1..=7 {
        let mut expected = none.clone();
        let ahead = packed - 1;
        convolutions[..ahead].iter().for_each(|&index| expected[index] -= packing);
        assert_eq!(steps(packed), expected, "{packed}");
    }
}

#[test]
fn a_step_does_as_much_as_it_may() {
    for (channels, stride, frames) in
        [(8, 1, 21), (8, 2, 110), (16, 2, 67), (16, 1, 40), (32, 2, 67), (32, 1, 67)]
    {
        let bytes = random_model(channels, stride, frames, 5, Numbers::Usual);
        let model = Model::parse(&bytes).expect("a model");
        let image = vec![3; ROWS * model.frames()];
        let mut memory = Memory::new(sizes(&model, 1));
        let kernels = WinogradKernels::new(&model, memory.view()).expect("memory");
        let mut kernels = Steps(Counting(kernels, 0), Vec::new());
        let mut scratch = vec![0; model.shape().scratch_bytes()];
        infer(&model, &image, &mut scratch, &mut kernels, &mut ());
        assert_eq!(kernels.0.1, 0, "steps by plain loops");
        let pooled = |axis: usize| axis.div_ceil(stride.into()) / 2;
        let (height, width) = (pooled(ROWS), pooled(frames.into()));
        // a step packs the numbers of a layer, of a convolution 16 outputs; the other steps compute
        let stem_values = if stride == 1 { 512 } else { 256 };
        let stem = 1 + height * width.div_ceil(stem_values / channels);
        let normalised = 1 + (height * width).div_ceil(2560 / channels);
        // two tiles are three columns of eight rows; so many of them a step, or so many steps each
        let blocks = height.div_ceil(8) * width.div_ceil(3);
        let conv = match channels {
            8 => 1 + blocks.div_ceil(3),
            16 => 1 + blocks,
            _ => 2 + 4 * blocks,
        };
        let added = 1 + (height * width * channels).div_ceil(2560);
        let average = channels.div_ceil((16384 / (height * width) / 4).max(1) * 4);
        let block = [normalised, conv, conv, added];
        let expected = [&[stem][..], &block, &block, &[average]].concat();
        assert_eq!(kernels.1, expected, "{channels} channels, {frames} frames, stride {stride}");
    }
}

#[test]
fn the_larger_of_two_sizes_serves_both() {
    let [tall, long] = [(3, 20), (4, 10)].map(|(vectors, words)| WinogradSizes { vectors, words });
    let both = WinogradSizes { vectors: 4, words: 20 };
    assert_eq!((tall.max(long), long.max(tall)), (both, both));
}

/// The outputs of a normalisation of four channels with its biases as accumulators; `None` if it is left to the plain loops.
fn normalised(biases: [i32; 4], scales: [(i32, i8); 4], out_zp: i8) -> Option<[i8; 4]> {
    let quant = PerChannelQuant {
        in_zp: -128,
        out_zp,
        act_min: -128,
        act_max: 127,
        channels: 4,
        multipliers: &scales.map(|(multiplier, _)| multiplier.to_le_bytes()),
        biases: &biases.map(i32::to_le_bytes),
        shifts: &scales.map(|(_, shift)| shift as u8),
        weights: &[0; 4],
    };
    let mut memory = Memory::new(WinogradSizes { vectors: 128, words: 0 });
    let mut kernels = WinogradKernels::shared(memory.view());
    let (layer, mut output) = (&BatchNormRelu { quant }, [0; 4]);
    for step in 0..2 {
        kernels.run(1, Operator::BatchNormRelu { layer, input: &[1, 2, 3, 4], output: &mut output }, step);
    }
    (!kernels.is_portable()).then_some(output)
}

/// Accumulators and biases are smaller than this: 2^29 less the largest sum of a tap.
const LIMIT: i32 = (1 << 29) - 255 * 128;

#[test]
fn one_high_product_is_the_rule_with_two_roundings() {
    let mut random = Xoshiro128PlusPlus::seed_from_u64(17);
    for round in 0..100_000 {
        let words: [u32; 4] = core::array::from_fn(|_| random.next_u32());
        let zero = random.next_u32() as i8;
        let scales = words.map(|word| {
            let multiplier = [0, 1 << 30, i32::MAX, (1 << 30) + (word >> 2) as i32][word as usize % 4];
            (multiplier, -1 - ((word >> 8) % 20) as i8)
        });
        let mut k = 0;
        // at the halves of the output's steps, at both ends, and anywhere
        let biases = words.map(|word| {
            let shift = -i32::from(scales[k].1);
            k += 1;
            let half = ((word >> 9) as i32 % 300) << shift | 1 << (shift - 1);
            let near = half + round % 3;
            [near, word as i32 >> 3, LIMIT - 1, 1 - LIMIT, -near][word as usize / 4 % 5]
                .clamp(1 - LIMIT, LIMIT - 1)
        });
        let rule = |k: usize| {
            let value = requantize(biases[k], scales[k].0, scales[k].1).saturating_add(i32::from(zero));
            value.clamp(-128, 127) as i8
        };
        let expected = core::array::from_fn(rule);
        assert_eq!(normalised(biases, scales, zero), Some(expected), "{biases:?} {scales:?} {zero}");
    }
}

#[test]
fn numbers_beyond_the_stated_bounds_are_left_to_the_plain_loops() {
    let covered = |bias: i32, scale: (i32, i8)| normalised([bias, 0, 0, 0], [scale; 4], 0).is_some();
    for (bias, legal) in [(0, true), (LIMIT - 1, true), (1 - LIMIT, true), (LIMIT, false), (-LIMIT, false)] {
        assert_eq!(covered(bias, (1 << 30, -1)), legal, "{bias}");
    }
    for (shift, legal) in [(-1, true), (-20, true), (0, false), (-21, false), (7, false)] {
        assert_eq!(covered(0, (1 << 30, shift)), legal, "{shift}");
    }
}
