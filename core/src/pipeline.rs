//! The signal chain as one object that works in bounded steps: slots in, classes out at every early exit.
//!
//! [`PipelineMemory`] is the caller's, usually a `static`; its size is a constant of its parameters, which
//! [`pipeline_memory!`](crate::pipeline_memory) takes from a [`Shape`].

use crate::areas::{Area, range};
use crate::config::RadarConfig;
use crate::dims::{Beat, Complex, ZERO_BEAT};
use crate::dsn::winograd::{WinogradKernels, WinogradMemory};
use crate::dsn::{Classification, Kernels, Logits, Network, Shape};
use crate::early_exit::{EXITS, EarlyExit, Evidence, add_evidence, decide};
use crate::error::Error;
use crate::probe::Probe;
use crate::selftest;
use crate::signal::dechirp::WordAligned;
use crate::signal::fast_time::FastTime;
use crate::signal::front_end::{
    Clutter, FrontEnd, FrontEndBuffers, Preprocessing, image_steps, workspace_len,
};
use crate::signal::stft::{NativeStft, Stft};
use crate::simd::dual_mac::I16x8;
use bytemuck::must_cast_slice_mut;
use core::ops::Range;
use heapless::Vec;
use rand_core::Rng;

impl Shape {
    /// Bytes of all memory of a pipeline, [`PipelineMemory::BYTES`] of these sizes.
    pub const fn required_bytes(&self) -> usize {
        let kernels = self.winograd_sizes();
        let words = (kernels.words + self.radar.reference_len()) * size_of::<i32>();
        let sum = kernels.vectors * size_of::<I16x8>()
            + words
            + self.sensing_slots * size_of::<Beat>()
            + self.workspace_len() * size_of::<Complex<i32>>()
            + size_of::<Clutter>();
        sum.next_multiple_of(size_of::<I16x8>())
    }

    /// Words of 8 bytes of a pipeline's workspace: an image's, or its network's scratch, whichever is larger.
    pub const fn workspace_len(&self) -> usize {
        let image = workspace_len(self.sensing_slots, self.frames);
        let network = self.scratch_bytes().div_ceil(size_of::<Complex<i32>>());
        if image > network { image } else { network }
    }
}

/// All memory of a pipeline: `REFERENCE` samples of the sensor's references, range samples of `SLOTS` slots, a workspace of
/// [`Shape::workspace_len`], `I16X8S` and `WORDS` for the kernels.
#[derive(Debug)]
pub struct PipelineMemory<
    const REFERENCE: usize,
    const SLOTS: usize,
    const WORKSPACE: usize,
    const I16X8S: usize,
    const WORDS: usize,
> {
    vectors: [I16x8; I16X8S],
    words: [i32; WORDS],
    reference: WordAligned<REFERENCE>,
    beats: [Beat; SLOTS],
    workspace: [Complex<i32>; WORKSPACE],
    clutter: Clutter,
}

/// The [`PipelineMemory`] type for a constant [`Shape`](crate::dsn::Shape).
#[macro_export]
macro_rules! pipeline_memory {
    ($shape:expr) => {
        $crate::pipeline::PipelineMemory<
            { $shape.radar.reference_len() },
            { $shape.sensing_slots },
            { $shape.workspace_len() },
            { $shape.winograd_sizes().vectors },
            { $shape.winograd_sizes().words },
        >
    };
}

impl<
    const REFERENCE: usize,
    const SLOTS: usize,
    const WORKSPACE: usize,
    const I16X8S: usize,
    const WORDS: usize,
> PipelineMemory<REFERENCE, SLOTS, WORKSPACE, I16X8S, WORDS>
{
    /// Bytes of this memory.
    pub const BYTES: usize = size_of::<Self>();

    /// Memory for a `static`: all zeros.
    #[allow(clippy::new_without_default)] // a default would be made on the stack
    pub const fn new() -> Self {
        PipelineMemory {
            vectors: [[0; 4]; I16X8S],
            words: [0; WORDS],
            reference: WordAligned([[0; 2]; REFERENCE]),
            beats: [ZERO_BEAT; SLOTS],
            workspace: [Complex::new(0, 0); WORKSPACE],
            clutter: Clutter::new(),
        }
    }

    /// The buffers of a pipeline.
    pub fn view(&mut self) -> PipelineBuffers<'_> {
        PipelineBuffers {
            front_end: FrontEndBuffers {
                reference: &mut self.reference.0,
                beats: &mut self.beats,
                workspace: &mut self.workspace,
                clutter: &mut self.clutter,
            },
            kernels: WinogradMemory { vectors: &mut self.vectors, words: &mut self.words },
        }
    }
}

/// Borrowed [`PipelineMemory`], or slices of the caller's own making.
#[derive(Debug)]
pub struct PipelineBuffers<'b> {
    /// Up to the image. The network's scratch is its workspace.
    pub front_end: FrontEndBuffers<'b>,
    /// Of the kernels of [`Pipeline::new`]; others bring their own.
    pub kernels: WinogradMemory<'b>,
}

/// At most [`EXITS`] exits.
fn collect<'m>(exits: impl IntoIterator<Item = EarlyExit<'m>>) -> Result<Vec<EarlyExit<'m>, EXITS>, Error> {
    let mut all = Vec::new();
    for exit in exits {
        all.push(exit).map_err(|_| Error::Exits)?;
    }
    Ok(all)
}

/// The first of these buffers that is too short, each with its name, what is needed and what there is.
fn check<const N: usize>(buffers: [(&'static str, usize, usize); N]) -> Result<(), Error> {
    match buffers.into_iter().find(|(_, need, have)| have < need) {
        Some((buffer, need, have)) => Err(Error::Memory { buffer, need, have }),
        None => Ok(()),
    }
}

/// The kernels of these exits in their memory.
pub(crate) fn shared_kernels<'b>(
    exits: &[EarlyExit<'_>],
    buffers: &mut PipelineBuffers<'b>,
) -> Result<WinogradKernels<'b>, Error> {
    let memory = core::mem::take(&mut buffers.kernels);
    for exit in exits {
        let sizes = exit.model.shape().winograd_sizes();
        check([
            ("vectors", sizes.vectors, memory.vectors.len()),
            ("words", sizes.words, memory.words.len()),
        ])?;
    }
    Ok(WinogradKernels::shared(memory))
}

/// The first stage of exits that go together and fit their memory, of which as much is left as a recording needs.
pub(crate) fn fast_time<'b>(
    exits: &[EarlyExit<'_>],
    buffers: &mut PipelineBuffers<'b>,
) -> Result<FastTime<'b>, Error> {
    let last = exits.last().filter(|_| exits.len() <= EXITS).ok_or(Error::Exits)?.model;
    let agrees = |exit: &EarlyExit<'_>| {
        let model = &exit.model;
        model.preprocessing() == last.preprocessing()
            && model.classes() == last.classes()
            && model.radar() == last.radar()
    };
    let ascending = exits.is_sorted_by(|a, b| a.model.sensing_slots() < b.model.sensing_slots());
    // the only exit's class is its network's, whatever a step is worth
    let weighs = |number: usize, exit: &EarlyExit<'_>| exits.len() == 1 || exit.is_valid(number);
    let valid = exits.iter().enumerate().all(|(number, exit)| weighs(number, exit) && agrees(exit));
    if !(ascending && valid) {
        return Err(Error::Exits);
    }
    let workspace = exits.iter().map(|exit| exit.model.shape().workspace_len()).max().unwrap_or(0);
    let slots = last.sensing_slots();
    let front_end = &mut buffers.front_end;
    check([
        ("reference", last.radar().reference_len(), front_end.reference.len()),
        ("beats", slots, front_end.beats.len()),
        ("workspace", workspace, front_end.workspace.len()),
    ])?;
    front_end.beats = core::mem::take(&mut front_end.beats).get_mut(..slots).unwrap_or_default();
    // valid: the parser has checked it
    FastTime::new(last.radar(), core::mem::take(&mut front_end.reference)).ok_or(Error::Exits)
}

/// A recognition under way.
#[derive(Debug, Clone, Copy)]
struct Recognition {
    exit: usize,
    period: u32,
    imaged: bool,
    outdated: bool,
}

/// Raw slots in, classes out: the networks by the kernels `K`, the spectrogram by the transform `T`; by default the fastest of
/// a microcontroller.
pub struct Pipeline<'m, 'b, K = WinogradKernels<'b>, T: Stft = NativeStft> {
    front_end: FrontEnd<'b, T>,
    kernels: K,
    network: Network,
    exits: Vec<EarlyExit<'m>, EXITS>,
    pub(crate) steps: Vec<u32, EXITS>,
    threshold: f32,
    next_exit: usize,
    /// Logits of the exits passed.
    logits: Vec<Logits, EXITS>,
    recognition: Option<Recognition>,
    stopped: bool,
    period: u32,
}

impl<'m, 'b, T: Stft> Pipeline<'m, 'b, WinogradKernels<'b>, T> {
    /// Joins exits, fewest slots first, and memory for the largest; `threshold` is the confidence that stops, above 1 for never
    /// before the last exit.
    ///
    /// # Errors
    ///
    /// [`Error::Exits`], [`Error::Memory`].
    pub fn new(
        exits: impl IntoIterator<Item = EarlyExit<'m>>,
        threshold: f32,
        mut buffers: PipelineBuffers<'b>,
    ) -> Result<Self, Error> {
        let all = collect(exits)?;
        let kernels = shared_kernels(&all, &mut buffers)?;
        let fast_time = fast_time(&all, &mut buffers)?;
        Ok(Self::assemble(&all, threshold, fast_time, buffers, kernels))
    }

    /// Where some of its data lie; empty for those of others, and where there are none.
    pub(crate) fn area(&self, area: Area) -> Range<*const u8> {
        match area {
            Area::PackedWeights | Area::OperatorWords => self.kernels.area(area),
            Area::Weights(exit) => {
                range(self.exits.get(usize::from(exit)).map_or(&[][..], |exit| &exit.weights))
            }
            Area::Threshold => range(core::slice::from_ref(&self.threshold)),
            Area::Logits => range(self.logits.first().map_or(&[][..], |logits| logits)),
            _ => self.front_end.area(area),
        }
    }
}

impl<'m, 'b, K: Kernels, T: Stft> Pipeline<'m, 'b, K, T> {
    /// [`Pipeline::new`] with other kernels, made for these models.
    ///
    /// # Errors
    ///
    /// As [`Pipeline::new`].
    pub fn with_kernels(
        exits: impl IntoIterator<Item = EarlyExit<'m>>,
        threshold: f32,
        mut buffers: PipelineBuffers<'b>,
        kernels: K,
    ) -> Result<Self, Error> {
        let all = collect(exits)?;
        let fast_time = fast_time(&all, &mut buffers)?;
        Ok(Self::assemble(&all, threshold, fast_time, buffers, kernels))
    }

    /// Of what has been checked: made where it stays.
    #[inline(always)]
    pub(crate) fn assemble(
        exits: &[EarlyExit<'m>],
        threshold: f32,
        fast_time: FastTime<'b>,
        buffers: PipelineBuffers<'b>,
        kernels: K,
    ) -> Self {
        let FrontEndBuffers { beats, workspace, clutter, .. } = buffers.front_end;
        let settings = exits.last().map_or_else(Preprocessing::default, |last| last.model.preprocessing());
        let mut pipeline = Pipeline {
            front_end: FrontEnd::with(fast_time, settings, beats, workspace, clutter),
            kernels,
            network: Network::new(),
            exits: Vec::new(),
            steps: Vec::new(),
            threshold,
            next_exit: 0,
            logits: Vec::new(),
            recognition: None,
            stopped: false,
            period: 0,
        };
        pipeline.exits.extend(exits.iter().copied()); // collected, or checked: as many as there are places
        pipeline
    }

    /// The exits.
    pub fn exits(&self) -> &[EarlyExit<'m>] {
        &self.exits
    }

    /// Sensing slots that the first exit needs.
    pub fn first_exit_slots(&self) -> usize {
        self.exits.first().map_or(0, |exit| exit.model.sensing_slots())
    }

    /// Whether a classification has stopped this recording: further slots are not used.
    pub fn stopped(&self) -> bool {
        self.stopped
    }

    /// Slots of the recording taken so far.
    pub fn taken(&self) -> usize {
        self.front_end.taken()
    }

    /// Whether a recognition is under way or due.
    pub fn is_busy(&self) -> bool {
        self.recognition.is_some() || self.exit_due()
    }

    /// Stops from the next classification on at this confidence.
    pub fn set_threshold(&mut self, threshold: f32) {
        self.threshold = threshold;
    }

    /// The sensor's configuration.
    pub fn config(&self) -> &RadarConfig {
        self.front_end.config()
    }

    /// Period of the recording that is being recognised, or is the next to be.
    pub(crate) fn recognition_period(&self) -> u32 {
        self.recognition.map_or(self.period, |recognition| recognition.period)
    }

    /// Whether [`Pipeline::push`] would not find the pipeline busy.
    pub(crate) fn has_room(&self) -> bool {
        self.next_exit >= self.exits.len() || !self.exit_due() && self.front_end.has_room()
    }

    fn exit_due(&self) -> bool {
        let due = |exit: &EarlyExit<'_>| self.front_end.taken() == exit.model.sensing_slots();
        !self.stopped && self.exits.get(self.next_exit).is_some_and(due)
    }

    /// Takes the samples of one slot. Cost: see [`FastTime::beat`](crate::signal::fast_time::FastTime::beat), and 36 complex
    /// multiply-accumulates of 32 bits.
    ///
    /// # Errors
    ///
    /// [`Error::Busy`], [`Error::Full`], [`Error::Length`]: nothing has changed.
    pub fn push(&mut self, slot: &[i16], probe: &mut impl Probe) -> Result<(), Error> {
        if self.stopped || self.next_exit >= self.exits.len() {
            return Err(Error::Full);
        }
        if !self.has_room() {
            return Err(Error::Busy);
        }
        if !self.front_end.push(slot, probe) {
            return Err(Error::Length);
        }
        self.begin_recognition(probe);
        Ok(())
    }

    /// Begins the recognition that is due, if none is under way.
    fn begin_recognition(&mut self, probe: &mut impl Probe) {
        if self.recognition.is_none() && self.exit_due() && self.front_end.begin_image(probe) {
            self.recognition = Some(Recognition {
                exit: self.next_exit,
                period: self.period,
                imaged: false,
                outdated: false,
            });
            self.next_exit += 1;
            self.network = Network::new();
        }
    }

    /// One bounded step of a recognition; the classification after the last.
    pub fn step(&mut self, probe: &mut impl Probe) -> Option<Classification> {
        self.begin_recognition(probe);
        let recognition = self.recognition.as_mut()?;
        let exit = self.exits.get(recognition.exit)?;
        if !recognition.imaged {
            recognition.imaged = self.front_end.step(probe);
            return None;
        }
        let scratch = must_cast_slice_mut(self.front_end.workspace());
        let logits = self.network.step(&exit.model, scratch, &mut self.kernels, probe)?;
        let mut classification = Classification::new(&exit.model, logits, probe);
        let Recognition { exit: number, outdated, .. } = *recognition;
        if self.exits.len() > 1 {
            let mut evidence = Evidence::new();
            let _ = evidence.resize(classification.logits.len(), 0); // at most MAX_CLASSES: the parser has checked
            let passed = self.logits.iter().chain([&classification.logits]);
            passed
                .zip(&exit.weights)
                .for_each(|(logits, &weight)| add_evidence(&mut evidence, logits, weight));
            (classification.class, classification.confidence) = decide(&evidence);
        }
        classification.exit = number as u8;
        let stop = number + 1 >= self.exits.len() || classification.confidence >= self.threshold;
        classification.stop = stop;
        self.recognition = None;
        if outdated {
            self.logits.clear();
        } else if stop {
            self.stopped = true;
        } else {
            let _ = self.logits.push(classification.logits.clone()); // fewer than there are exits
        }
        Some(classification)
    }

    /// Counts the steps of a recognition by each exit, by running its network once on the image that lies in memory.
    pub(crate) fn count_steps(&mut self) {
        for EarlyExit { model, .. } in &self.exits {
            let (mut network, kept) = (Network::new(), model.preprocessing().kept);
            let mut steps = image_steps(kept, model.sensing_slots(), model.frames()) as u32 + 1;
            let scratch = must_cast_slice_mut(self.front_end.workspace());
            while network.step(model, scratch, &mut self.kernels, &mut ()).is_none() {
                steps += 1;
            }
            let _ = self.steps.push(steps); // as many places as exits
        }
    }

    /// [`selftest::run`] in the memory of this pipeline, before the first slot: 9 kB of stack less. Zeros where that is smaller than 40 slots
    /// and two frames.
    pub fn test_signal_chain(&mut self, rng: &mut impl Rng) -> [u64; 2] {
        let known = selftest::run_in(&mut self.front_end.buffers(), rng);
        self.front_end.reset();
        known
    }

    /// Whether every operator of every exit's network gives what the plain loops give: [`selftest::network`]. Before the first slot.
    pub fn self_test(&mut self, rng: &mut impl Rng) -> bool {
        let (scratch, kernels) = (must_cast_slice_mut(self.front_end.workspace()), &mut self.kernels);
        self.exits.iter().all(|exit| selftest::network(&exit.model, scratch, kernels, rng).is_none())
    }

    /// Finishes the recognition that is under way.
    pub fn classify(&mut self, probe: &mut impl Probe) -> Option<Classification> {
        while self.is_busy() {
            if let Some(classification) = self.step(probe) {
                return Some(classification);
            }
        }
        None
    }

    /// Begins a recording.
    pub fn reset(&mut self) {
        self.begin_recording(self.period);
    }

    /// Begins a recording of a period. A recognition under way goes on, with the exits that its own recording has passed.
    pub(crate) fn begin_recording(&mut self, period: u32) {
        self.period = period;
        self.front_end.reset();
        self.next_exit = 0;
        self.stopped = false;
        match &mut self.recognition {
            Some(recognition) => recognition.outdated = true,
            None => self.logits.clear(),
        }
    }
}
