//! The numbers that size a model's memory, readable from its file at compile time.
//!
//! ```
//! use sdp3_core::{dsn::Shape, memory_for};
//!
//! // of a model in flash: `const SHAPE: Shape = Shape::of(include_bytes!("model.sdp3")).expect("a model");`
//! const SHAPE: Shape = Shape { sensing_slots: 200, frames: 10, channels: 8, stem_stride: 1 };
//! type Sized = memory_for!(SHAPE);
//! const _: () = assert!(Sized::BYTES <= 64 * 1024, "the model does not fit this board");
//! assert_eq!(Sized::BYTES, SHAPE.required_bytes());
//! ```

use super::format::{HEADER_LEN, MAGIC};

/// Sizes of a model. What follows from them stands where it belongs: its network's scratch, its kernels' memory, a receiver's.
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
        Some(Shape {
            sensing_slots: u16::from_le_bytes([model[12], model[13]]) as usize,
            frames: u16::from_le_bytes([model[26], model[27]]) as usize,
            channels: model[32] as usize,
            stem_stride: model[23] as usize,
        })
    }
}
