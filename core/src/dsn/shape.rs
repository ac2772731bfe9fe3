//! The numbers that size a model's memory, readable from its file at compile time.
//!
//! ```
//! use sdp3_core::{config::RadarConfig, dsn::Shape, pipeline_memory};
//!
//! // of a model in flash: `const SHAPE: Shape = Shape::of(include_bytes!("model.sdp3")).expect("a model");`
//! const SHAPE: Shape =
//!     Shape { sensing_slots: 200, frames: 10, channels: 8, stem_stride: 1, arena: 0, radar: RadarConfig::PAPER };
//! type Sized = pipeline_memory!(SHAPE);
//! const _: () = assert!(Sized::BYTES <= 64 * 1024, "the model does not fit this board");
//! ```

use super::format::{ARENA_AT, HEADER_LEN, MAGIC};
use crate::config::RadarConfig;

/// Sizes of a model. What follows from them is stated elsewhere: its network's scratch, its kernels' memory, a pipeline's.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Shape {
    /// Sensing slots of a recording, N_s.
    pub sensing_slots: usize,
    /// Frames of its image.
    pub frames: usize,
    /// Channels of every convolution.
    pub channels: usize,
    /// Stride of the input convolution.
    pub stem_stride: usize,
    /// Bytes of the arena of a graph (module `graph`) in the place of the paper's network, which then has no channels; else 0.
    pub arena: usize,
    /// The sensor.
    pub radar: RadarConfig,
}

impl Shape {
    /// The sizes a model file states; `None` if it does not begin like one. Checks nothing else:
    /// [`Model::parse`](super::Model::parse) does.
    pub const fn of(model: &[u8]) -> Option<Self> {
        if model.len() < HEADER_LEN {
            return None;
        }
        let [m0, m1, m2, m3] = MAGIC;
        if model[0] != m0 || model[1] != m1 || model[2] != m2 || model[3] != m3 {
            return None;
        }
        let radar = [model[48], model[49], model[50], model[51], model[52], model[53], model[54], model[55]];
        let Some(radar) = RadarConfig::from_bytes(radar) else { return None };
        Some(Shape {
            radar,
            sensing_slots: u16::from_le_bytes([model[12], model[13]]) as usize,
            frames: u16::from_le_bytes([model[26], model[27]]) as usize,
            channels: model[32] as usize,
            stem_stride: model[23] as usize,
            arena: u32::from_le_bytes([
                model[ARENA_AT],
                model[ARENA_AT + 1],
                model[ARENA_AT + 2],
                model[ARENA_AT + 3],
            ]) as usize,
        })
    }
}
