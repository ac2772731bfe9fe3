//! Networks and images from a seed, and every layer of the core's answer: for oracles and exchange tests.
//!
//! Nothing of the simulator or of training: weights are He's, normalisations are shaken, images are chirped
//! stripes, noise and extremes.

use sdp3::formats::model_file::QuantizedNetwork;
use sdp3::network::interchange::header;
use sdp3::network::parameters::{Architecture, Images, Norm, Parameters};
use sdp3::network::quantization::quantize;
use sdp3_core::dsn::{Model, Portable, infer};
use sdp3_core::probe::Probe;

/// A linear congruential generator (Numerical Recipes' constants); its upper bits are used.
pub struct Random(u64);

impl Random {
    /// A generator of this seed.
    pub fn new(seed: u64) -> Self {
        let mut random = Random(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ 0x5DEE_CE66);
        (0..4).for_each(|_| {
            random.bits();
        });
        random
    }

    /// The next 32 bits.
    pub fn bits(&mut self) -> u32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 32) as u32
    }

    /// Below `n`.
    pub fn below(&mut self, n: usize) -> usize {
        ((u64::from(self.bits()) * n as u64) >> 32) as usize
    }

    /// Between two numbers.
    pub fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * (self.bits() >> 8) as f32 / (1u32 << 24) as f32
    }
}

/// Float parameters with normalisations as training leaves them, none of them neutral.
pub fn parameters(architecture: Architecture, seed: u64) -> Parameters {
    let mut parameters = Parameters::initial(architecture, seed);
    let mut random = Random::new(seed);
    let mut shake = |norm: &mut Norm| {
        for c in 0..norm.gamma.len() {
            norm.gamma[c] = random.between(0.5, 1.5);
            norm.beta[c] = random.between(-0.3, 0.3);
            norm.mean[c] = random.between(-0.5, 0.5);
            norm.variance[c] = random.between(0.3, 2.0);
        }
    };
    for block in &mut parameters.blocks {
        shake(&mut block.norm1);
        shake(&mut block.norm2);
    }
    parameters.stem.biases.iter_mut().for_each(|b| *b = random.between(-0.2, 0.2));
    parameters.head.biases.iter_mut().for_each(|b| *b = random.between(-0.5, 0.5));
    parameters
}

/// `count` images of 64 rows: stripes of changing slope in noise, every fourth plain noise, every sixteenth extreme.
pub fn images(frames: usize, count: usize, classes: usize, seed: u64) -> Images {
    let mut random = Random::new(seed ^ 0x1234_5678);
    let mut images = Images { rows: 64, frames, pixels: Vec::new(), labels: Vec::new() };
    for i in 0..count {
        let (slope, offset) = (random.between(-2.0, 2.0), random.between(0.0, 16.0));
        for (row, frame) in (0..64).flat_map(|r| (0..frames).map(move |f| (r, f))) {
            let distance = (row as f32 - offset - slope * frame as f32).rem_euclid(16.0) - 8.0;
            let noise = random.bits() >> 24;
            let pixel = match i % 16 {
                15 => {
                    if noise < 128 {
                        -128
                    } else {
                        127
                    }
                }
                k if k % 4 == 3 => noise as i32 - 128,
                _ => ((20.0 - 5.0 * distance.abs()).max(0.0) * 10.0) as i32 + (noise / 4) as i32 - 128,
            };
            images.pixels.push(pixel.clamp(-128, 127) as i8);
        }
        images.labels.push((i % classes) as u8);
    }
    images
}

/// An int8 network of this shape for images of `frames` frames, quantised on 16 images.
///
/// # Panics
///
/// If it cannot be quantised.
pub fn quantized(architecture: Architecture, frames: u16, seed: u64) -> QuantizedNetwork {
    let preprocessing = header(&crate::printed_room(), u32::from(128 + 8 * (frames - 1)));
    let names: Vec<String> = (0..architecture.classes).map(|k| format!("class {k}")).collect();
    let calibration = images(usize::from(frames), 16, architecture.classes, seed ^ 0xCA11);
    let found = quantize(&parameters(architecture, seed), preprocessing, &names, &calibration);
    found.expect("a network that can be quantised").0
}

#[derive(Default)]
struct Layers(Vec<Vec<i8>>);

impl Probe for Layers {
    fn layer(&mut self, _index: usize, activations: &[i8]) {
        self.0.push(activations.to_vec());
    }
    fn logits(&mut self, logits: &[i8]) {
        self.0.push(logits.to_vec());
    }
}

/// Every layer's output as the core computes it: pooled stem; per block affine, conv1, conv2, add; mean; logits.
///
/// # Panics
///
/// If the bytes are no model file.
pub fn layers(model_file: &[u8], image: &[i8]) -> Vec<Vec<i8>> {
    let model = Model::parse(model_file).expect("a model");
    let mut scratch = vec![0; model.shape().scratch_bytes()];
    let mut layers = Layers::default();
    infer(&model, image, &mut scratch, &mut Portable, &mut layers);
    layers.0
}
