//! The core's layers, by plain loops, by Winograd tiles and by every instruction set there is, against the reference, which is naive and
//! shares no code with them: the same bits for any weights, shapes, scales and images.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sdp3::conformance::reference;
use sdp3::network::inference::{Isa, VectorKernels};
use sdp3_core::dims::ROWS;
use sdp3_core::dsn::winograd::{WinogradKernels, WinogradMemory, WinogradSizes};
use sdp3_core::dsn::{Kernels, Model, Portable, infer};
use sdp3_core::probe::Probe;
use sdp3_fuzz::{Bytes, Sizes, model};

#[derive(Default, PartialEq, Debug)]
struct Layers(Vec<Vec<i64>>);

impl Probe for Layers {
    fn layer(&mut self, _index: usize, activations: &[i8]) {
        self.0.push(activations.iter().map(|&a| i64::from(a)).collect());
    }
    fn logits(&mut self, logits: &[i8]) {
        self.0.push(logits.iter().map(|&a| i64::from(a)).collect());
    }
}

fn layers(model: &Model<'_>, image: &[i8], mut kernels: impl Kernels) -> Layers {
    let mut found = Layers::default();
    let mut scratch = vec![0; model.shape().scratch_bytes()];
    infer(model, image, &mut scratch, &mut kernels, &mut found);
    found
}

fuzz_target!(|data: &[u8]| {
    let mut bytes = Bytes(data);
    let sizes = Sizes::of(&mut bytes);
    let file = model(sizes, &mut bytes);
    let mut state = bytes.u32() | 1;
    let image: Vec<i8> = (0..ROWS * usize::from(sizes.frames))
        .map(|k| match bytes.0.get(k) {
            Some(&byte) => byte as i8,
            None => {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                (state >> 24) as i8
            }
        })
        .collect();
    let reference = reference::infer(&file, &image);
    let expected = Layers(reference.layers.into_iter().chain([reference.logits]).collect());
    let model = Model::parse(&file).expect("a sound model");
    assert_eq!(layers(&model, &image, Portable), expected);
    for places in [1, 2 * model.blocks()] {
        let sizes = WinogradSizes::new(model.channels(), places);
        let (mut vectors, mut words) = (vec![[0; 4]; sizes.vectors], vec![0; sizes.words]);
        let memory = WinogradMemory { vectors: &mut vectors, words: &mut words };
        let kernels = WinogradKernels::new(&model, memory).expect("enough memory");
        assert_eq!(layers(&model, &image, kernels), expected, "tiles, {places} places");
    }
    for isa in Isa::ALL {
        let Some(kernels) = VectorKernels::new(&model, isa) else { continue };
        assert_eq!(layers(&model, &image, kernels), expected, "{}", isa.name());
    }
});
