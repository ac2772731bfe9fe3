//! The core's receiver on this machine: memory of its own and the processor's fastest kernels.

use crate::inference::VectorKernels;
use sdp3_core::dims::{Beat, Complex, ROWS, ZERO_BEAT};
use sdp3_core::dsn::winograd::WinogradMemory;
use sdp3_core::dsn::{Model, scratch_bytes};
use sdp3_core::pipeline::{Buffers, Receiver, ReceiverError};
use sdp3_core::signal::front_end::FrontEndBuffers;
use sdp3_core::signal::stft::{NativeStft, Stft};

/// A receiver that computes by this processor's vectors.
pub type HostReceiver<'m, 'b, T = NativeStft> = Receiver<'m, 'b, VectorKernels, T>;

/// Owned memory for any model.
pub struct OwnedBuffers {
    beats: Vec<Beat>,
    slow_time: Vec<Complex<i32>>,
    levels: Vec<i16>,
    image: Vec<i8>,
    scratch: Vec<i8>,
}

impl OwnedBuffers {
    /// Memory for `slots` slots and `frames` frames, and `scratch` bytes for a network.
    pub fn new(slots: usize, frames: usize, scratch: usize) -> Self {
        OwnedBuffers {
            beats: vec![ZERO_BEAT; slots],
            slow_time: vec![Complex::new(0, 0); slots],
            levels: vec![0; ROWS * frames],
            image: vec![0; ROWS * frames],
            scratch: vec![0; scratch],
        }
    }

    /// Memory for a model.
    pub fn for_model(model: &Model) -> Self {
        let scratch = scratch_bytes(model.frames(), model.channels(), model.stem_stride());
        Self::new(model.sensing_slots(), model.frames(), scratch)
    }

    /// A receiver in it, made by [`OwnedBuffers::for_model`] for this model, with this processor's fastest kernels.
    ///
    /// # Errors
    ///
    /// [`ReceiverError`] if the memory is another model's.
    pub fn receiver<'m>(&mut self, model: Model<'m>) -> Result<HostReceiver<'m, '_>, ReceiverError> {
        self.receiver_by(model)
    }

    /// [`OwnedBuffers::receiver`] with a transform of another arithmetic.
    ///
    /// # Errors
    ///
    /// As [`OwnedBuffers::receiver`].
    pub fn receiver_by<'m, T: Stft>(
        &mut self,
        model: Model<'m>,
    ) -> Result<HostReceiver<'m, '_, T>, ReceiverError> {
        let kernels = VectorKernels::fastest(&model);
        Receiver::with_kernels(model, self.view(), kernels)
    }

    /// The receiver's view of it.
    pub fn view(&mut self) -> Buffers<'_> {
        Buffers {
            front_end: FrontEndBuffers {
                beats: &mut self.beats,
                slow_time: &mut self.slow_time,
                levels: &mut self.levels,
                image: &mut self.image,
            },
            scratch: &mut self.scratch,
            tiles: WinogradMemory::default(),
        }
    }
}
