//! Any stream of slots, steps and resets: a pipeline classifies exactly the complete recordings, each as if it were the only one.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sdp3_core::Error;
use sdp3_core::config::RadarConfig;
use sdp3_core::dsn::{Classification, Model, Shape};
use sdp3_core::early_exit::EarlyExit;
use sdp3_core::pipeline::Pipeline;
use sdp3_core::pipeline_memory;
use sdp3_fuzz::{Bytes, Sizes, model};
use std::collections::VecDeque;

/// Memory for every model made here: at most 9 frames, 24 slots.
const LARGEST: Shape =
    Shape { sensing_slots: 24, frames: 9, channels: 4, stem_stride: 1, arena: 0, radar: RadarConfig::PAPER };
type Largest = pipeline_memory!(LARGEST);

/// A slot of constant, alternating, ramped or pseudo-random samples.
fn slot(bytes: &mut Bytes<'_>) -> Vec<i16> {
    let (kind, i, q) = (bytes.u8(), bytes.u16() as i16, bytes.u16() as i16);
    let mut state = u32::from(bytes.u16()) << 1 | 1;
    let pair = |n: usize| match kind % 5 {
        0 => [i, q],
        1 if n % 2 == 0 => [i16::MAX, i16::MIN],
        1 => [i16::MIN, i16::MAX],
        2 => [i.wrapping_mul(n as i16), q.wrapping_add(n as i16)],
        3 => [0; 2],
        _ => {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            [(state >> 16) as i16, state as i16]
        }
    };
    (0..usize::from(RadarConfig::PAPER.samples)).flat_map(pair).collect()
}

/// The only recording of a pipeline.
fn alone(model: Model<'_>, slots: &[Vec<i16>]) -> Classification {
    let mut memory = Largest::new();
    let mut pipeline: Pipeline<'_, '_> =
        Pipeline::new([EarlyExit::single(model)], 2.0, memory.view()).expect("enough memory");
    slots.iter().for_each(|slot| pipeline.push(slot, &mut ()).expect("there is room"));
    pipeline.classify(&mut ()).expect("a complete recording")
}

fuzz_target!(|data: &[u8]| {
    // a model would use up all bytes
    let (data, weights) = data.split_at(data.len() / 2);
    let (mut bytes, mut weights) = (Bytes(data), Bytes(weights));
    let sizes = Sizes { channels: 4, blocks: 1, ..Sizes::of(&mut weights) };
    let file = model(sizes, &mut weights);
    let parsed = Model::parse(&file).expect("a valid model");
    let need = parsed.sensing_slots();
    let mut memory = Largest::new();
    let mut pipeline: Pipeline<'_, '_> =
        Pipeline::new([EarlyExit::single(parsed)], 2.0, memory.view()).expect("enough memory");
    // slots of the recording, and the classifications to come: at most one of an earlier recording, and its own
    let (mut recording, mut due) = (Vec::new(), VecDeque::new());
    for _ in 0..96 {
        if bytes.is_empty() {
            break;
        }
        match bytes.u8() % 16 {
            0 => {
                pipeline.reset();
                recording.clear();
                due.truncate(1);
            }
            1 => assert_eq!(pipeline.classify(&mut ()), due.pop_front()),
            2 | 3 => {
                if let Some(classification) = pipeline.step(&mut ()) {
                    assert_eq!(Some(classification), due.pop_front());
                }
            }
            _ => {
                let slot = slot(&mut bytes);
                match pipeline.push(&slot, &mut ()) {
                    Ok(()) => {
                        assert!(recording.len() < need);
                        recording.push(slot);
                        if recording.len() == need {
                            due.push_back(alone(parsed, &recording));
                        }
                    }
                    Err(Error::Full) => assert_eq!(recording.len(), need),
                    Err(error) => assert!(error == Error::Busy && !due.is_empty()),
                }
            }
        }
        assert_eq!(pipeline.is_busy(), !due.is_empty());
    }
});
