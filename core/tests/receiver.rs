//! A receiver asks for exactly the memory it uses, counts its slots, and says what is wrong.

mod support;

use sdp3_core::dsn::{Model, Portable, Shape};
use sdp3_core::memory_for;
use sdp3_core::pipeline::{Receiver, ReceiverError, STANDARD, StandardMemory};
use sdp3_core::signal::stft::NativeStft;
use support::{Memory, SHORTER, noise_slots, random_model};

static MODEL: &[u8] = include_bytes!("../../firmware-sim/models/dsn-1000.sdp3");
const SHAPE: Shape = match Shape::of(MODEL) {
    Some(shape) => shape,
    None => panic!("dsn-1000.sdp3 is no model"),
};
const SMALL: Shape = Shape { sensing_slots: 144, frames: 3, channels: 4, stem_stride: 1 };

#[test]
fn the_bytes_stated_are_the_bytes_of_the_type() {
    assert_eq!(SHAPE, Model::parse(MODEL).expect("a model").shape());
    assert_eq!(SHAPE.required_bytes(), <memory_for!(SHAPE)>::BYTES);
    assert_eq!(SMALL.required_bytes(), <memory_for!(SMALL)>::BYTES);
    assert_eq!(STANDARD.required_bytes(), StandardMemory::BYTES);
    // 72 bytes a slot and 192 a frame, as documented, are the greater part
    assert!((72_000 + 192 * 110..200_000).contains(&StandardMemory::BYTES));
    let mut standard = Box::new(StandardMemory::default());
    assert!(Receiver::new(Model::parse(MODEL).expect("a model"), standard.view()).is_ok());
}

#[test]
fn memory_is_asked_for_to_the_element() {
    let file = random_model(144, 1);
    let model = Model::parse(&file).expect("a model");
    let exact = Memory::of(&model);
    assert!(Receiver::new(model.clone(), exact.clone().view()).is_ok());
    for (wanted, shorten) in SHORTER {
        let mut memory = exact.clone();
        shorten(&mut memory);
        let error = Receiver::new(model.clone(), memory.view())
            .err()
            .unwrap_or_else(|| panic!("{wanted} is not asked for"));
        let ReceiverError::Memory { buffer, need, have } = error else { panic!("{wanted}: {error}") };
        assert_eq!((buffer, need), (wanted, have + 1));
        assert_eq!(error.to_string(), format!("buffer {wanted} has {have} elements, the model needs {need}"));
    }
    // kernels that bring their own memory need none here
    let mut memory = exact.clone();
    (memory.vectors, memory.words) = (Vec::new(), Vec::new());
    assert!(Receiver::<_, NativeStft>::with_kernels(model, memory.view(), Portable).is_ok());
}

#[test]
fn a_recording_is_complete_once_and_begins_anew() {
    let file = random_model(144, 1);
    let model = Model::parse(&file).expect("a model");
    // room for more slots than the model wants
    let mut memory = Memory::of(&Model::parse(&random_model(200, 1)).expect("a model"));
    let mut receiver = Receiver::new(model, memory.view()).expect("enough memory");
    let slots = noise_slots(144, 4);
    let mut answers = Vec::new();
    for _ in 0..2 {
        assert_eq!(receiver.missing(), 144);
        for (n, slot) in slots.iter().enumerate() {
            assert_eq!(receiver.classify(&mut ()), Err(ReceiverError::Incomplete { missing: 144 - n }));
            assert_eq!(receiver.push(slot, &mut ()), Ok(143 - n));
        }
        assert_eq!(receiver.push(&slots[0], &mut ()), Err(ReceiverError::Full));
        answers.push(receiver.classify(&mut ()).expect("complete"));
        receiver.reset();
    }
    assert_eq!(answers[0], answers[1]);
    for (error, words) in [
        (ReceiverError::Full, "the recording is complete"),
        (ReceiverError::Incomplete { missing: 3 }, "3 sensing slots are missing"),
        (
            ReceiverError::Exits,
            "exits need ascending numbers of slots, one preprocessing, the same classes and weights of at most 8 nat",
        ),
    ] {
        assert_eq!(error.to_string(), words);
    }
}
