//! The whole street as one object: push a slot, ask for a class.
//!
//! [`Memory`] is the caller's, usually a `static`; its size is a constant of its parameters, which
//! [`memory_for!`](crate::memory_for) takes from a [`Shape`].

use crate::dims::{BEATS, Beat, Complex, ROWS, Slot, ZERO_BEAT};
use crate::dsn::winograd::{WinogradF2, WinogradMemory, WinogradSizes};
use crate::dsn::{Classification, Kernels, Model, ModelError, Shape, infer, scratch_bytes};
use crate::probe::Probe;
use crate::signal::front_end::{FrontEnd, FrontEndBuffers};
use crate::signal::stft::{NativeStft, Stft};
use crate::simd::dual_mac::I16x8;

impl Shape {
    /// Bytes of all memory that a receiver borrows, [`Memory::BYTES`] of these sizes:
    /// beats and slow time (72 bytes a slot), levels and image (192 bytes a frame), scratch and kernels, in whole
    /// [`I16x8`]s.
    pub const fn required_bytes(&self) -> usize {
        let slot = (BEATS + 1) * size_of::<Complex<i32>>();
        let cells = ROWS * self.frames * (size_of::<i16>() + size_of::<i8>());
        let sum = self.sensing_slots * slot + cells + self.scratch_bytes() + self.winograd_sizes().total();
        sum.next_multiple_of(size_of::<I16x8>())
    }
}

/// All memory of a receiver: `SLOTS` sensing slots, `FRAMES` frames, `SCRATCH` bytes for the network ([`scratch_bytes`]),
/// `VECTORS` and `WORDS` for its kernels ([`WinogradSizes`]).
#[derive(Debug)]
pub struct Memory<
    const SLOTS: usize,
    const FRAMES: usize,
    const SCRATCH: usize,
    const VECTORS: usize,
    const WORDS: usize,
> {
    vectors: [I16x8; VECTORS],
    words: [i32; WORDS],
    beats: [Beat; SLOTS],
    slow_time: [Complex<i32>; SLOTS],
    levels: [[i16; FRAMES]; ROWS],
    image: [[i8; FRAMES]; ROWS],
    scratch: [i8; SCRATCH],
}

/// The [`Memory`] type for a constant [`Shape`](crate::dsn::Shape).
#[macro_export]
macro_rules! memory_for {
    ($shape:expr) => {
        $crate::pipeline::Memory<
            { $shape.sensing_slots },
            { $shape.frames },
            { $shape.scratch_bytes() },
            { $shape.winograd_sizes().vectors },
            { $shape.winograd_sizes().words },
        >
    };
}

/// The default network's: the paper's largest recording (N_s = 1000, 110 frames), 16 channels behind a stride of 2.
pub const STANDARD: Shape = Shape { sensing_slots: 1000, frames: 110, channels: 16, stem_stride: 2 };

/// Memory for [`STANDARD`].
pub type StandardMemory = memory_for!(STANDARD);

impl<const SLOTS: usize, const FRAMES: usize, const SCRATCH: usize, const VECTORS: usize, const WORDS: usize>
    Memory<SLOTS, FRAMES, SCRATCH, VECTORS, WORDS>
{
    /// Bytes of this memory.
    pub const BYTES: usize = size_of::<Self>();

    /// Memory for a `static`.
    pub const fn new() -> Self {
        Memory {
            vectors: [I16x8::ZERO; VECTORS],
            words: [0; WORDS],
            beats: [ZERO_BEAT; SLOTS],
            slow_time: [Complex::new(0, 0); SLOTS],
            levels: [[0; FRAMES]; ROWS],
            image: [[0; FRAMES]; ROWS],
            scratch: [0; SCRATCH],
        }
    }

    /// The buffers of a receiver.
    pub fn view(&mut self) -> Buffers<'_> {
        Buffers {
            front_end: FrontEndBuffers {
                beats: &mut self.beats,
                slow_time: &mut self.slow_time,
                levels: self.levels.as_flattened_mut(),
                image: self.image.as_flattened_mut(),
            },
            scratch: &mut self.scratch,
            tiles: WinogradMemory { vectors: &mut self.vectors, words: &mut self.words },
        }
    }
}

impl<const SLOTS: usize, const FRAMES: usize, const SCRATCH: usize, const VECTORS: usize, const WORDS: usize>
    Default for Memory<SLOTS, FRAMES, SCRATCH, VECTORS, WORDS>
{
    fn default() -> Self {
        Self::new()
    }
}

/// Borrowed [`Memory`], or slices of the caller's own making.
#[derive(Debug)]
pub struct Buffers<'b> {
    /// Up to the image.
    pub front_end: FrontEndBuffers<'b>,
    /// The network's.
    pub scratch: &'b mut [i8],
    /// Of the kernels of [`Receiver::new`]; others bring their own.
    pub tiles: WinogradMemory<'b>,
}

impl<'b> Buffers<'b> {
    /// [`WinogradF2`] kernels for a model, in the memory here that is theirs; nothing of it is left for others.
    ///
    /// # Errors
    ///
    /// [`ReceiverError::Memory`] names what is too small: `vectors` or `words`.
    pub fn take_kernels(&mut self, model: &Model<'_>) -> Result<WinogradF2<'b>, ReceiverError> {
        let sizes = WinogradSizes::of(model);
        let tiles = core::mem::take(&mut self.tiles);
        for (buffer, need, have) in
            [("vectors", sizes.vectors, tiles.vectors.len()), ("words", sizes.words, tiles.words.len())]
        {
            if have < need {
                return Err(ReceiverError::Memory { buffer, need, have });
            }
        }
        WinogradF2::new(model, tiles).ok_or(UNREADY)
    }

    /// Whether there is room for `slots` slots, `cells` cells of the image and `scratch` bytes for the network.
    pub(crate) fn check(&self, slots: usize, cells: usize, scratch: usize) -> Result<(), ReceiverError> {
        let f = &self.front_end;
        for (buffer, need, have) in [
            ("beats", slots, f.beats.len()),
            ("slow_time", slots, f.slow_time.len()),
            ("levels", cells, f.levels.len()),
            ("image", cells, f.image.len()),
            ("scratch", scratch, self.scratch.len()),
        ] {
            if have < need {
                return Err(ReceiverError::Memory { buffer, need, have });
            }
        }
        Ok(())
    }
}

/// Why a receiver cannot be made or asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ReceiverError {
    /// A buffer is too small for the model.
    Memory {
        /// Which: `beats`, `slow_time`, `levels`, `image`, `scratch`, `vectors` or `words`.
        buffer: &'static str,
        /// Elements the model needs.
        need: usize,
        /// Elements there are.
        have: usize,
    },
    /// The model's preprocessing is not valid.
    Model(ModelError),
    /// Exits of an anytime receiver that do not go together.
    Exits,
    /// The recording is complete: classify or reset first.
    Full,
    /// The recording is not complete yet.
    Incomplete {
        /// Slots still missing.
        missing: usize,
    },
}

impl core::fmt::Display for ReceiverError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match *self {
            ReceiverError::Memory { buffer, need, have } => {
                write!(f, "buffer {buffer} has {have} elements, the model needs {need}")
            }
            ReceiverError::Model(error) => write!(f, "{error}"),
            ReceiverError::Exits => {
                write!(
                    f,
                    "exits need ascending numbers of slots, one preprocessing, the same classes and weights of at most 8 nat"
                )
            }
            ReceiverError::Full => write!(f, "the recording is complete"),
            ReceiverError::Incomplete { missing } => write!(f, "{missing} sensing slots are missing"),
        }
    }
}

impl core::error::Error for ReceiverError {}

/// What a receiver recognised.
pub type Recognition = Classification;

/// Raw slots in, class out: the network by the kernels `K`, the spectrogram by the transform `T`; by default the fastest of
/// a microcontroller.
#[derive(Debug)]
pub struct Receiver<'m, 'b, K = WinogradF2<'b>, T = NativeStft> {
    front_end: FrontEnd<'b, T>,
    model: Model<'m>,
    scratch: &'b mut [i8],
    kernels: K,
}

impl<'m, 'b> Receiver<'m, 'b> {
    /// Joins a model and memory: [`WinogradF2`] kernels and the target's [`NativeStft`].
    ///
    /// # Errors
    ///
    /// [`ReceiverError::Memory`] names the buffer that is too small, what it needs and what it has.
    pub fn new(model: Model<'m>, buffers: Buffers<'b>) -> Result<Self, ReceiverError> {
        Self::with_transform(model, buffers)
    }
}

impl<'m, 'b, T: Stft> Receiver<'m, 'b, WinogradF2<'b>, T> {
    /// [`Receiver::new`] with the transform that `T` names.
    ///
    /// # Errors
    ///
    /// As [`Receiver::new`].
    pub fn with_transform(model: Model<'m>, mut buffers: Buffers<'b>) -> Result<Self, ReceiverError> {
        let kernels = buffers.take_kernels(&model)?;
        Self::with_kernels(model, buffers, kernels)
    }
}

/// What [`Model::parse`] has ruled out.
const UNREADY: ReceiverError = ReceiverError::Model(ModelError::Field { name: "preprocessing", value: 0 });

impl<'m, 'b, K: Kernels, T: Stft> Receiver<'m, 'b, K, T> {
    /// [`Receiver::with_transform`] with other kernels, made for this model.
    ///
    /// # Errors
    ///
    /// As [`Receiver::new`].
    pub fn with_kernels(model: Model<'m>, buffers: Buffers<'b>, kernels: K) -> Result<Self, ReceiverError> {
        let (slots, cells) = (model.sensing_slots(), ROWS * model.frames());
        let scratch = scratch_bytes(model.frames(), model.channels(), model.stem_stride());
        buffers.check(slots, cells, scratch)?;
        let front_end = FrontEnd::new(model.preprocessing(), buffers.front_end).ok_or(UNREADY)?;
        Ok(Receiver { front_end, model, scratch: buffers.scratch, kernels })
    }

    /// The model.
    pub fn model(&self) -> &Model<'m> {
        &self.model
    }

    /// Sensing slots still missing.
    pub fn missing(&self) -> usize {
        self.model().sensing_slots().saturating_sub(self.front_end.taken())
    }

    /// Takes one slot and returns how many are missing.
    ///
    /// # Errors
    ///
    /// [`ReceiverError::Full`] if none is missing.
    pub fn push(&mut self, slot: &Slot, probe: &mut impl Probe) -> Result<usize, ReceiverError> {
        if self.missing() == 0 || !self.front_end.push(slot, probe) {
            return Err(ReceiverError::Full);
        }
        Ok(self.missing())
    }

    /// Classifies a complete recording; [`Receiver::reset`] begins the next.
    ///
    /// # Errors
    ///
    /// [`ReceiverError::Incomplete`] if slots are missing.
    pub fn classify(&mut self, probe: &mut impl Probe) -> Result<Recognition, ReceiverError> {
        let missing = self.missing();
        let Some(image) = (missing == 0).then_some(()).and_then(|()| self.front_end.image(probe)) else {
            return Err(ReceiverError::Incomplete { missing });
        };
        Ok(infer(&self.model, image, self.scratch, &mut self.kernels, probe))
    }

    /// Forgets the recording.
    pub fn reset(&mut self) {
        self.front_end.reset();
    }
}
