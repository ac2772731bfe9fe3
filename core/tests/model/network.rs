//! Tests of `dsn::network`, and of the steps of the plain loops.

use sdp3_core::crc32::crc32;
use sdp3_core::dims::ROWS;
use sdp3_core::dsn::network::*;
use sdp3_core::dsn::{Kernels, Model, Operator, Portable};
use sdp3_testkit::random_model::{Numbers, Size, write};

#[test]
fn the_scratch_is_a_convolutions_and_three_maps_or_one_and_the_image() {
    assert_eq!(scratch_bytes(110, 16, 2), 3 * (16 * 27 * 16) + 3155);
    assert_eq!(scratch_bytes(10, 8, 1), 3 * (32 * 5 * 8) + 1811);
    assert_eq!(scratch_bytes(9, 8, 2), 16 * 2 * 8 + 64 * 9 + 1811);
}

/// A network of one block.
fn random_model(channels: usize, stride: u8, frames: u16) -> Vec<u8> {
    let size = Size { channels, stride, blocks: 1, slots: 8 + 4 * (frames - 1), window: 8, hop: 4 };
    let mut bytes = vec![0; 1 << 16];
    let length = write(size, 2, Numbers::Trained, crc32, &mut bytes);
    bytes.truncate(length);
    bytes
}

/// The plain loops, and how many steps every operator took.
#[derive(Default)]
struct Counting(Vec<usize>);

impl Kernels for Counting {
    fn run(&mut self, index: usize, operator: Operator<'_>, step: usize) -> bool {
        self.0.resize(self.0.len().max(index + 1), 0);
        self.0[index] += 1;
        Portable.run(index, operator, step)
    }
}

#[test]
fn a_step_of_the_plain_loops_does_as_much_as_it_may_and_whole_pixels() {
    for (channels, stride, frames) in
        [(4, 1, 5), (8, 2, 67), (12, 1, 30), (16, 2, 110), (24, 1, 21), (32, 1, 5), (32, 1, 110)]
    {
        let file = random_model(channels, stride, frames);
        let model = Model::parse(&file).expect("a model");
        let image = vec![7; ROWS * model.frames()];
        let mut scratch = vec![0; model.shape().scratch_bytes()];
        let mut kernels = Counting::default();
        infer(&model, &image, &mut scratch, &mut kernels, &mut ());
        let pooled = |axis: usize| axis.div_ceil(stride.into()) / 2;
        let pixels = pooled(ROWS) * pooled(frames.into());
        // 7680 products a step, one pixel at least; an output costs another sixteen, in the stem four times nine and as many again
        let pixels_of = |products: usize| pixels.div_ceil((7680 / products).max(1));
        let (stem, conv) = (pixels_of(100 * channels), pixels_of((9 * channels + 16) * channels));
        // 256 values
        let normalised = pixels.div_ceil(256 / channels);
        let added = (pixels * channels).div_ceil(256);
        // 16384 summands, four channels at least
        let average = channels.div_ceil((16384 / pixels / 4).max(1) * 4);
        let expected = [stem, normalised, conv, conv, added, average];
        assert_eq!(kernels.0, expected, "{channels} channels, {frames} frames, stride {stride}");
    }
}

#[test]
fn behind_the_last_step_or_a_reset_the_next_image_begins() {
    let file = random_model(8, 2, 20);
    let model = Model::parse(&file).expect("a model");
    let images = [vec![-128; ROWS * 20], vec![127; ROWS * 20]];
    let mut scratch = vec![0; model.shape().scratch_bytes()];
    let alone =
        images.each_ref().map(|image| infer(&model, image, &mut scratch, &mut Portable, &mut ()).logits);
    assert_ne!(alone[0], alone[1]);
    let mut network = Network::new();
    for unfinished in [0, 1, 9, 0] {
        for (image, alone) in images.iter().zip(&alone) {
            for _ in 0..unfinished {
                assert_eq!(network.step(&model, &mut scratch, &mut Portable, &mut ()), None);
            }
            network.reset();
            assert_eq!(network, Network::new());
            image_mut(&mut scratch, 20).copy_from_slice(image);
            let found = loop {
                if let Some(logits) = network.step(&model, &mut scratch, &mut Portable, &mut ()) {
                    break logits;
                }
            };
            assert_eq!(&found, alone);
            assert_eq!(network, Network::new());
        }
    }
}

#[test]
fn too_short_a_scratch_gives_empty_logits_at_once() {
    let file = random_model(8, 2, 20);
    let model = Model::parse(&file).expect("a model");
    let mut scratch = vec![0; model.shape().scratch_bytes() - 1];
    for length in [0, 1, scratch.len()] {
        let mut network = Network::new();
        let logits = network.step(&model, &mut scratch[..length], &mut Portable, &mut ());
        assert_eq!((logits.as_deref(), network), (Some(&[][..]), Network::new()));
        let image = vec![7; ROWS * model.frames()];
        let found = infer(&model, &image, &mut scratch[..length], &mut Portable, &mut ());
        assert_eq!((found.class, found.confidence, found.logits.len()), (0, 0.0, 0));
    }
}
