//! The numbers that size a model's memory, readable from its file at compile time.
//!
//! ```
//! use sdp3_core::{dsn::Shape, receiver::Memory};
//!
//! // of a model in flash: `const SHAPE: Shape = Shape::of(include_bytes!("model.sdp3")).expect("a model");`
//! const SHAPE: Shape = Shape { sensing_slots: 200, frames: 10, channels: 8, stem_stride: 1 };
//! type Sized = Memory<{ SHAPE.sensing_slots }, { SHAPE.frames }, { SHAPE.scratch_bytes() }>;
//! const _: () = assert!(Sized::BYTES <= 64 * 1024, "the model does not fit this board");
//! assert_eq!(Sized::BYTES, SHAPE.required_bytes());
//! ```

use super::format::{HEADER_LEN, MAGIC};
use super::network::scratch_bytes;
use crate::frame::{BEATS, ROWS};

/// Sizes of a model.
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

    /// Bytes of scratch its network needs.
    pub const fn scratch_bytes(&self) -> usize {
        scratch_bytes(self.frames, self.channels, self.stem_stride)
    }

    /// Bytes of all memory that a receiver borrows, [`Memory::BYTES`](crate::receiver::Memory::BYTES) of these sizes:
    /// beats and slow time (72 bytes a slot), levels and image (192 bytes a frame), scratch, in whole words.
    pub const fn required_bytes(&self) -> usize {
        let slot = (BEATS + 1) * size_of::<crate::frame::Complex<i32>>();
        let cells = ROWS * self.frames * (size_of::<i16>() + size_of::<i8>());
        (self.sensing_slots * slot + cells + self.scratch_bytes()).next_multiple_of(4)
    }
}
