//! The memory that a pipeline asks for is the memory that it uses: measured by what a recognition leaves of a pattern.

mod support;

use sdp3_core::crc32::crc32;
use sdp3_core::dims::Complex;
use sdp3_core::dsn::{Kernels, Model, Portable};
use sdp3_core::early_exit::EarlyExit;
use sdp3_core::pipeline::Pipeline;
use sdp3_core::signal::stft::FixedStft;
use sdp3_testkit::models::{DSN_200, DSN_1000};
use sdp3_testkit::random_model::{Numbers, Size, write};
use support::{Memory, VALUES, noise_slots};

const BUFFERS: [&str; 4] = ["beats", "workspace", "vectors", "words"];

/// Of every buffer in the order of [`BUFFERS`], which elements are as in `before`.
fn same(after: &Memory, before: &Memory) -> [Vec<bool>; 4] {
    fn each<T: PartialEq>(a: &[T], b: &[T]) -> Vec<bool> {
        a.iter().zip(b).map(|(a, b)| a == b).collect()
    }
    [
        each(&after.beats, &before.beats),
        each(&after.workspace, &before.workspace),
        each(&after.vectors, &before.vectors),
        each(&after.words, &before.words),
    ]
}

fn logits<K: Kernels>(pipeline: &mut Pipeline<'_, '_, K, FixedStft>, slots: &[[i16; VALUES]]) -> Vec<i8> {
    slots.iter().for_each(|slot| assert_eq!(pipeline.push(slot, &mut ()), Ok(())));
    pipeline.classify(&mut ()).expect("complete").logits.to_vec()
}

/// Recognises noise by Winograd or plain kernels in memory full of `pattern`: the logits, and what is left of the pattern.
fn recognise(model: &Model<'_>, winograd: bool, pattern: i8) -> (Vec<i8>, [Vec<bool>; 4]) {
    let word = i32::from_ne_bytes([pattern as u8; 4]);
    let complex = Complex::new(word, word);
    let mut memory = Memory::of(model);
    memory.beats.fill([complex; 8]);
    memory.workspace.fill(complex);
    memory.vectors.fill([word; 4]);
    memory.words.fill(word);
    let before = memory.clone();
    let slots = noise_slots(model.sensing_slots(), 7);
    let exit = [EarlyExit::single(*model)];
    let logits = if winograd {
        logits(&mut Pipeline::<_, FixedStft>::new(exit, 2.0, memory.view()).expect("enough memory"), &slots)
    } else {
        logits(
            &mut Pipeline::<_, FixedStft>::with_kernels(exit, 2.0, memory.view(), Portable)
                .expect("enough memory"),
            &slots,
        )
    };
    (logits, same(&memory, &before))
}

/// Every element is written by the kernels it is for, and none is read before.
fn all_is_used(file: &[u8]) {
    let model = Model::parse(file).expect("a model");
    let (logits, mut unused) = recognise(&model, true, 0x55);
    for (winograd, pattern) in [(true, -0x33), (false, 0x55), (false, -0x33)] {
        let (others, left) = recognise(&model, winograd, pattern);
        assert_eq!(others, logits, "{:?}, by Winograd: {winograd}, pattern {pattern}", model.shape());
        for (unused, left) in unused.iter_mut().zip(left) {
            unused.iter_mut().zip(left).for_each(|(unused, left)| *unused &= left);
        }
    }
    for (name, unused) in BUFFERS.iter().zip(unused) {
        let count = unused.iter().filter(|&&unused| unused).count();
        assert_eq!(count, 0, "{name}, of {} elements: {:?}", unused.len(), model.shape());
    }
}

/// For the numbers of channels that the Winograd kernels cover; others need no scratch.
#[test]
fn every_element_of_the_memory_is_used() {
    for (channels, stride, slots) in [(8, 1, 200), (8, 2, 144), (16, 1, 152), (16, 2, 200), (32, 1, 160)] {
        let size = Size { channels, stride, blocks: 2, slots, window: 128, hop: 8 };
        let mut bytes = vec![0; 1 << 17];
        let length = write(size, 5, Numbers::Trained, crc32, &mut bytes);
        all_is_used(&bytes[..length]);
    }
    all_is_used(DSN_200);
    all_is_used(DSN_1000);
}
