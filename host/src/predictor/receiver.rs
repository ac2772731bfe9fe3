//! The core's receiver on this machine: memory of its own and the processor's fastest kernels.

use sdp3_core::dims::{Beat, Complex, ROWS, ZERO_BEAT};
use sdp3_core::dsn::vector::{Vector, VectorMemory};
use sdp3_core::dsn::winograd::WinogradMemory;
use sdp3_core::dsn::{Model, Network, scratch_bytes};
use sdp3_core::pipeline::{Buffers, Receiver, ReceiverError};
use sdp3_core::signal::front_end::FrontEndBuffers;
use sdp3_core::signal::stft::{NativeStft, Stft};
use sdp3_core::simd::{Isa, Line};

/// A receiver that computes by this processor's vectors.
pub type HostReceiver<'m, 'b, T = NativeStft> = Receiver<'m, 'b, Vector<'b>, T>;

/// Owned memory for any model.
pub struct OwnedBuffers {
    beats: Vec<Beat>,
    slow_time: Vec<Complex<i32>>,
    levels: Vec<i16>,
    image: Vec<i8>,
    scratch: Vec<i8>,
    lines: Vec<Line>,
    words: Vec<i32>,
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
            lines: Vec::new(),
            words: Vec::new(),
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
        let (lines, words, buffers) = self.split(&model);
        let kernels = fastest(&model, lines, words)?;
        Receiver::with_kernels(model, buffers, kernels)
    }

    /// A network in it, as [`OwnedBuffers::receiver`].
    ///
    /// # Errors
    ///
    /// [`ReceiverError`] if the memory is another model's.
    pub fn network<'m>(&mut self, model: Model<'m>) -> Result<Network<'m, '_, Vector<'_>>, ReceiverError> {
        let need = scratch_bytes(model.frames(), model.channels(), model.stem_stride());
        let (lines, words, buffers) = self.split(&model);
        let (kernels, have) = (fastest(&model, lines, words)?, buffers.scratch.len());
        let network = Network::with_kernels(model, buffers.scratch, kernels);
        network.ok_or(ReceiverError::Memory { buffer: "scratch", need, have })
    }

    /// The kernels' memory, grown for a model, and the rest.
    fn split(&mut self, model: &Model) -> (&mut [Line], &mut [i32], Buffers<'_>) {
        self.lines.resize(Vector::lines(model), Line::ZERO);
        self.words.resize(Vector::words(model), 0);
        self.parts()
    }

    /// The receiver's view of it.
    pub fn view(&mut self) -> Buffers<'_> {
        self.parts().2
    }

    fn parts(&mut self) -> (&mut [Line], &mut [i32], Buffers<'_>) {
        let buffers = Buffers {
            front_end: FrontEndBuffers {
                beats: &mut self.beats,
                slow_time: &mut self.slow_time,
                levels: &mut self.levels,
                image: &mut self.image,
            },
            scratch: &mut self.scratch,
            tiles: WinogradMemory::default(),
        };
        (&mut self.lines, &mut self.words, buffers)
    }
}

/// This processor's fastest kernels for a model.
fn fastest<'b>(
    model: &Model,
    lines: &'b mut [Line],
    words: &'b mut [i32],
) -> Result<Vector<'b>, ReceiverError> {
    let (need, have) = (Vector::lines(model), lines.len());
    Vector::new(model, Isa::best(), VectorMemory { lines, words }).ok_or(ReceiverError::Memory {
        buffer: "lines",
        need,
        have,
    })
}
