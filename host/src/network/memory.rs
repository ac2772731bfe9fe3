//! The core's pipeline on this machine: memory of its own and the processor's fastest kernels.

use crate::network::inference::VectorKernels;
use sdp3_core::Error;
use sdp3_core::config::RadarConfig;
use sdp3_core::dims::{Beat, Complex, ZERO_BEAT};
use sdp3_core::dsn::winograd::WinogradMemory;
use sdp3_core::dsn::{Model, Portable};
use sdp3_core::early_exit::EarlyExit;
use sdp3_core::pipeline::{Pipeline, PipelineBuffers};
use sdp3_core::signal::front_end::{Clutter, FrontEndBuffers};
use sdp3_core::signal::stft::{NativeStft, Stft};

/// A pipeline that computes by this processor's vectors.
pub type HostPipeline<'m, 'b, T = NativeStft> = Pipeline<'m, 'b, VectorKernels, T>;

/// Owned memory for any model.
pub struct OwnedMemory {
    reference: Vec<[i16; 2]>,
    beats: Vec<Beat>,
    workspace: Vec<Complex<i32>>,
    clutter: Box<Clutter>,
}

impl OwnedMemory {
    /// Memory for `slots` slots of a sensor, and `workspace` words of 8 bytes.
    pub fn new(radar: &RadarConfig, slots: usize, workspace: usize) -> Self {
        OwnedMemory {
            reference: vec![[0; 2]; radar.reference_len()],
            beats: vec![ZERO_BEAT; slots],
            workspace: vec![Complex::new(0, 0); workspace],
            clutter: Box::new(Clutter::new()),
        }
    }

    /// Memory for a model.
    pub fn for_model(model: &Model) -> Self {
        Self::new(&model.radar(), model.sensing_slots(), model.shape().workspace_len())
    }

    /// A pipeline in it, made by [`OwnedMemory::for_model`] for this model, with this processor's fastest kernels.
    ///
    /// # Errors
    ///
    /// [`Error`] if the memory is another model's.
    pub fn pipeline<'m, T: Stft>(&mut self, model: Model<'m>) -> Result<HostPipeline<'m, '_, T>, Error> {
        let kernels = VectorKernels::fastest(&model);
        Pipeline::with_kernels([EarlyExit::single(model)], 2.0, self.view(), kernels)
    }

    /// A pipeline of several exits in it, made for the last one's model.
    ///
    /// # Errors
    ///
    /// [`Error`] if the memory is another model's or the exits do not go together.
    pub fn early_exits<'m>(
        &mut self,
        exits: Vec<EarlyExit<'m>>,
        threshold: f32,
    ) -> Result<Pipeline<'m, '_, Portable>, Error> {
        Pipeline::with_kernels(exits, threshold, self.view(), Portable)
    }

    /// The pipeline's view of it.
    pub fn view(&mut self) -> PipelineBuffers<'_> {
        PipelineBuffers {
            front_end: FrontEndBuffers {
                reference: &mut self.reference,
                beats: &mut self.beats,
                workspace: &mut self.workspace,
                clutter: &mut self.clutter,
            },
            kernels: WinogradMemory::default(),
        }
    }
}
