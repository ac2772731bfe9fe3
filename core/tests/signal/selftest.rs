//! Tests of `selftest`.

use rand_core::SeedableRng;
use rand_xoshiro::Xoshiro128PlusPlus;
use sdp3_core::crc32::crc32;
use sdp3_core::dsn::winograd::{WinogradMemory, WinogradSizes};
use sdp3_core::dsn::{Kernels, Model};
use sdp3_core::dsn::{Operator, WinogradKernels};
use sdp3_core::selftest::*;
use sdp3_testkit::random_model::{Numbers, Size, write};
use std::vec;

#[test]
fn the_answers_are_known_and_another_signal_has_others() {
    let known = run(&mut Xoshiro128PlusPlus::seed_from_u64(3));
    assert_eq!(known, KNOWN_ANSWERS, "{known:x?}");
    let other = run(&mut Xoshiro128PlusPlus::seed_from_u64(4));
    assert!(known[0] != known[1] && known.iter().zip(other).all(|(known, other)| *known != other));
}

/// Other kernels, but one operator gives 3 everywhere.
struct Wrong<K>(K, usize);

impl<K: Kernels> Kernels for Wrong<K> {
    fn run(&mut self, index: usize, operator: Operator<'_>, step: usize) -> bool {
        if index != self.1 {
            return self.0.run(index, operator, step);
        }
        match operator {
            Operator::Stem { output, .. }
            | Operator::BatchNormRelu { output, .. }
            | Operator::Conv { output, .. }
            | Operator::Add { x: output, .. }
            | Operator::Average { output, .. } => output.fill(3),
        }
        true
    }
}

#[test]
fn the_first_operator_that_differs_is_named() {
    let size = Size { channels: 8, stride: 1, blocks: 2, slots: 68, window: 8, hop: 4 };
    let mut bytes = vec![0; 1 << 17];
    let length = write(size, 1, Numbers::Trained, crc32, &mut bytes);
    let model = Model::parse(&bytes[..length]).expect("a model");
    let mut scratch = vec![0; model.shape().scratch_bytes()];
    let sizes = WinogradSizes::of(&model);
    let (mut vectors, mut words) = (vec![[0; 4]; sizes.vectors], vec![0; sizes.words]);
    for wrong in 0..11 {
        let memory = WinogradMemory { vectors: &mut vectors, words: &mut words };
        let mut kernels = Wrong(WinogradKernels::shared(memory), wrong);
        let mut rng = Xoshiro128PlusPlus::seed_from_u64(5);
        let found = network(&model, &mut scratch, &mut kernels, &mut rng);
        assert_eq!(found, (wrong < 10).then_some(wrong)); // the eleventh does not exist
    }
}
