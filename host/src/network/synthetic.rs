//! Images and networks from a seed for the predictor's tests: chirped stripes in noise.
//!
//! The five classes differ in slope and curvature, which a mean over the image does not hide; nothing of the simulator.

use rand_core::Rng;

use super::parameters::{Architecture, Images, Norm, Parameters, Stream, stream};

/// `per_class` images of each of five classes, 64 rows.
pub fn stripes(frames: usize, per_class: usize, seed: u64) -> Images {
    let mut random = stream(seed, Stream::Shuffle, 1 << 40);
    let mut uniform = move || (random.next_u64() >> 40) as f32 / (1u64 << 24) as f32;
    let mut images = Images { rows: 64, frames, pixels: Vec::new(), labels: Vec::new() };
    for i in 0..5 * per_class {
        let class = i % 5;
        let jitter = 0.8 + 0.4 * uniform();
        let slope = [0.0, 0.5, 1.2, -0.5, -1.2][class] * jitter;
        let (offset, chirp) = (16.0 * uniform(), 0.02 * (uniform() - 0.5));
        for (row, frame) in (0..64).flat_map(|r| (0..frames).map(move |f| (r, f))) {
            let t = frame as f32;
            let distance = libm::remainderf(row as f32 - offset - (slope + chirp * t) * t, 16.0);
            let level = 200.0 * libm::expf(-distance * distance / 8.0) + 90.0 * uniform();
            images.pixels.push((level.min(255.0) as i16 - 128) as i8);
        }
        images.labels.push(class as u8);
    }
    images
}

/// Parameters with normalisations as training leaves them, none of them neutral.
pub fn trained_looking(architecture: Architecture, seed: u64) -> Parameters {
    let mut parameters = Parameters::initial(architecture, seed);
    let mut random = stream(seed, Stream::Shuffle, 1 << 41);
    let mut between =
        |low: f32, high: f32| low + (high - low) * (random.next_u64() >> 40) as f32 / (1u64 << 24) as f32;
    let mut stir = |norm: &mut Norm| {
        for c in 0..norm.gamma.len() {
            norm.gamma[c] = between(0.5, 1.5);
            norm.beta[c] = between(-0.3, 0.3);
            norm.mean[c] = between(-0.5, 0.5);
            norm.variance[c] = between(0.3, 2.0);
        }
    };
    for block in &mut parameters.blocks {
        stir(&mut block.norm1);
        stir(&mut block.norm2);
    }
    parameters.stem.biases.iter_mut().enumerate().for_each(|(i, b)| *b = 0.1 * i as f32 - 0.2);
    parameters.head.biases.iter_mut().enumerate().for_each(|(i, b)| *b = 0.2 * i as f32);
    parameters
}
