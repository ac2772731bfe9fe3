//! The whole chain on a real model: every stage's digest is a known answer, by every kernel, on every processor.
//!
//! The answers are the core's own; that they are the reference's too, `tests/conformance` shows on two hundred other recordings.

mod support;

use rand_core::SeedableRng;
use rand_xoshiro::Xoshiro128PlusPlus;
use sdp3_core::digest::DigestProbe;
use sdp3_core::dsn::{Kernels, Model, Portable, Shape};
use sdp3_core::early_exit::EarlyExit;
use sdp3_core::pipeline::Pipeline;
use sdp3_core::pipeline_memory;
use sdp3_core::signal::stft::{FixedStft, FloatStft, Stft};
use sdp3_testkit::signals::noise;
use support::VALUES;

static MODEL: &[u8] = sdp3_testkit::models::DSN_200;
const SHAPE: Shape = match Shape::of(MODEL) {
    Some(shape) => shape,
    None => panic!("dsn-200.sdp3 is no model"),
};
type Memory = pipeline_memory!(SHAPE);

fn exit() -> EarlyExit<'static> {
    EarlyExit::single(Model::parse(MODEL).expect("a model"))
}

/// A static and a moving triangle wave in noise, the same on every processor.
fn slots() -> Vec<[i16; VALUES]> {
    let mut rng = Xoshiro128PlusPlus::seed_from_u64(11);
    let mut samples = [0; VALUES];
    let triangle = |n: i32| 20 * ((n.rem_euclid(400) - 200).abs() - 100);
    let mut one = |k: i32| {
        noise(&mut rng, &mut samples);
        for (n, pair) in samples.chunks_exact_mut(2).enumerate() {
            let wall = triangle(7 * n as i32);
            let moving = triangle(7 * n as i32 + 13 * k) / 4;
            pair[0] = pair[0] / 64 + (wall + moving) as i16;
            pair[1] = pair[1] / 64 + (wall - moving) as i16;
        }
        samples
    };
    (0..200).map(&mut one).collect()
}

/// Digest of every stage.
fn digests<K: Kernels, T: Stft>(mut pipeline: Pipeline<K, T>) -> Vec<(&'static str, u64)> {
    let mut probe = DigestProbe::new();
    for slot in slots() {
        assert_eq!(pipeline.push(&slot, &mut probe), Ok(()));
    }
    pipeline.classify(&mut probe).expect("complete");
    probe.stages().map(|(name, digest)| (name, digest.hash())).collect()
}

fn winograd<T: Stft>() -> Vec<(&'static str, u64)> {
    let mut memory = Box::new(Memory::new());
    digests(Pipeline::<_, T>::new([exit()], 2.0, memory.view()).expect("enough memory"))
}

fn portable<T: Stft>() -> Vec<(&'static str, u64)> {
    let mut memory = Box::new(Memory::new());
    digests(Pipeline::<_, T>::with_kernels([exit()], 2.0, memory.view(), Portable).expect("enough memory"))
}

/// Of [`FixedStft`]; [`FloatStft`], in floats, has another frame and here the same image.
const KNOWN: [(&str, u64); 10] = [
    ("beat", 0x5361_bd57_df9b_e99a),
    ("gram", 0x9eb2_f9f3_492e_c7d8),
    ("projection", 0x0c24_5ffa_10e5_e385),
    ("slow-time", 0x8408_b947_4b94_7571),
    ("frame", 0x2260_1590_17b6_c68e),
    ("image", 0xad3b_027d_f61e_ffe0),
    ("layer", 0x8bf3_2844_a6c5_4d97),
    ("logits", 0xc87f_1dd7_42a9_3d6a),
    ("class", 0xaf63_b94c_8601_b113),
    ("confidence", 0x25dd_5459_9ab9_303e),
];

#[test]
fn every_kernel_has_the_known_answers() {
    assert_eq!(winograd::<FixedStft>(), KNOWN);
    assert_eq!(portable::<FixedStft>(), KNOWN);
}

#[test]
fn the_transform_in_floats_has_the_known_answers() {
    let known =
        KNOWN.map(|(name, digest)| (name, if name == "frame" { 0x1023_0a7d_d749_714d } else { digest }));
    assert_eq!(winograd::<FloatStft>(), known);
}
