//! Any stream of slots, questions and resets: a receiver answers exactly when its recording is complete.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sdp3_core::dsn::{Model, Shape};
use sdp3_core::dims::{Iq, Slot};
use sdp3_core::memory_for;
use sdp3_core::pipeline::{Receiver, ReceiverError};
use sdp3_fuzz::{Bytes, Sizes, model};

/// Memory for every model made here: at most 9 frames, 24 slots.
const LARGEST: Shape = Shape { sensing_slots: 24, frames: 9, channels: 4, stem_stride: 1 };
type Largest = memory_for!(LARGEST);

/// A slot of constant, alternating, ramped or pseudo-random samples.
fn slot(bytes: &mut Bytes<'_>) -> Slot {
    let (kind, i, q) = (bytes.u8(), bytes.u16() as i16, bytes.u16() as i16);
    let mut state = u32::from(bytes.u16()) << 1 | 1;
    core::array::from_fn(|n| match kind % 5 {
        0 => Iq { i, q },
        1 if n % 2 == 0 => Iq { i: i16::MAX, q: i16::MIN },
        1 => Iq { i: i16::MIN, q: i16::MAX },
        2 => Iq { i: i.wrapping_mul(n as i16), q: q.wrapping_add(n as i16) },
        3 => Iq { i: 0, q: 0 },
        _ => {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            Iq { i: (state >> 16) as i16, q: state as i16 }
        }
    })
}

fuzz_target!(|data: &[u8]| {
    let mut bytes = Bytes(data);
    let sizes = Sizes { channels: 4, blocks: 1, ..Sizes::of(&mut bytes) };
    let file = model(sizes, &mut bytes);
    let parsed = Model::parse(&file).expect("a sound model");
    let need = parsed.sensing_slots();
    let mut memory = Largest::new();
    let mut receiver = Receiver::new(parsed, memory.view()).expect("enough memory");
    let mut taken = 0;
    for _ in 0..96 {
        if bytes.is_empty() {
            break;
        }
        match bytes.u8() % 16 {
            0 => {
                receiver.reset();
                taken = 0;
            }
            1 => match receiver.classify(&mut ()) {
                Ok(answer) => {
                    assert_eq!(taken, need);
                    let again = receiver.classify(&mut ()).expect("as before");
                    assert_eq!(answer, again);
                }
                Err(error) => assert_eq!(error, ReceiverError::Incomplete { missing: need - taken }),
            },
            _ => match receiver.push(&slot(&mut bytes), &mut ()) {
                Ok(missing) => {
                    taken += 1;
                    assert_eq!(missing, need - taken);
                }
                Err(error) => assert_eq!((taken, error), (need, ReceiverError::Full)),
            },
        }
    }
});
