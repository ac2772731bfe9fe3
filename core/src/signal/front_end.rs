//! From raw slots to the network's image, as one object that works in bounded steps.
//!
//! Section IV-A of the paper: data cleaning (dechirp, truncated SVD) and data transformation (STFT, log magnitude). Slots of the
//! next recording may come while the image of the one before is being made.

use super::clutter::{
    ADAPTIVE, ClutterSolver, GRAM_SLOTS, Gram, Projection, SOLVER_STEPS, Sum, SvdRange, UNIT_PROJECTION,
    add_samples, largest_part, project, slow_time_shift,
};
use super::fast_time::FastTime;
use super::logarithm::FLOOR;
use super::spectrogram::{log_magnitudes, quantize};
use super::stft::{NativeStft, Stft, frames};
pub use super::workspace::{Clutter, FrontEndBuffers, workspace_len};
use super::workspace::{Parts, SPECTRUM, change_places, parts};
use crate::areas::{Area, range};
use crate::config::RadarConfig;
use crate::dims::{BEATS, Beat, Complex, ROWS};
use crate::probe::Probe;
use bytemuck::{must_cast_slice, must_cast_slice_mut};
use core::ops::Range;

/// How slow time becomes an image. Part of every model file: a network only understands the images it was trained on.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Preprocessing {
    /// Singular components kept; the first is at most the number of range samples.
    pub kept: SvdRange,
    /// Kaiser window length N_w, 2 to 256.
    pub window: u16,
    /// Kaiser window's beta, 0 to 40.
    pub beta: f32,
    /// Sensing slots between two frames, 1 to window.
    pub hop: u16,
    /// FFT bins summed into one row: 1, 2 or 4.
    pub bins_per_row: u8,
    /// Dynamic range in 1/64 octave of power (50 dB is 1063), 1 to 4095.
    pub range: u16,
}

impl Preprocessing {
    /// Frames of a recording of `slots` sensing slots.
    pub const fn frames(&self, slots: usize) -> usize {
        frames(slots, self.window as usize, self.hop as usize)
    }

    /// The first field that is outside its legal range for this sensor, by its name in a model file, and its value.
    pub fn illegal(&self, radar: &RadarConfig) -> Option<(&'static str, i64)> {
        let Preprocessing { kept, window, beta, hop, bins_per_row, range } = *self;
        let fields = [
            ("first_kept", i64::from(kept.first), kept.first <= radar.range_samples),
            ("last_kept", i64::from(kept.last), (kept.first.max(1)..=8).contains(&kept.last)),
            ("window_len", i64::from(window), (2..=256).contains(&window)),
            ("hop", i64::from(hop), (1..=window).contains(&hop)),
            ("bins_per_row", i64::from(bins_per_row), matches!(bins_per_row, 1 | 2 | 4)),
            ("range", i64::from(range), (1..=4095).contains(&range)),
            ("kaiser_beta", i64::from(beta.to_bits()), (0.0..=40.0).contains(&beta)),
        ];
        fields.into_iter().find(|(_, _, legal)| !legal).map(|(name, value, _)| (name, value))
    }
}

impl Default for Preprocessing {
    /// The paper's: d = 2, Kaiser 128 with beta 10, hop 8, the central 64 bins, 50 dB.
    fn default() -> Self {
        Preprocessing {
            kept: SvdRange { first: 2, last: 8 },
            window: 128,
            beta: 10.0,
            hop: 8,
            bins_per_row: 1,
            range: 1063,
        }
    }
}

/// Slots of one step over slow time, so that a step is short.
const SLOTS_A_STEP: usize = 128;
/// Rows of the image of one step.
const ROWS_A_STEP: usize = 16;

/// Steps of a recording's slow time.
pub(crate) const fn slow_time_steps(kept: SvdRange, slots: usize) -> usize {
    let passes = if kept.first == ADAPTIVE { 3 } else { 2 };
    SOLVER_STEPS + 2 + passes * slots.div_ceil(SLOTS_A_STEP)
}

/// Steps of its image.
pub(crate) const fn image_steps(kept: SvdRange, slots: usize, frames: usize) -> usize {
    slow_time_steps(kept, slots) + frames + ROWS / ROWS_A_STEP
}

/// Where the making of an image stands.
#[derive(Debug, Clone)]
enum Stage {
    /// Rotations of the eigenvalue solver.
    Solve,
    /// The sum of the slots before this one.
    Sum { from: usize, sum: Sum },
    /// The largest part of slow time over the slots before this one.
    Scale { from: usize, largest: u64 },
    /// Slow time from this slot on; after the last the memory for frames.
    Project { from: usize, shift: u32 },
    /// Frames from this one on, and the largest level so far.
    Frames { next: usize, largest: i16 },
    /// Rows of the image before this one, the last of them first.
    Quantize { rows: usize, largest: i16 },
}

/// An image in the making.
#[derive(Debug, Clone)]
struct Job {
    slots: usize,
    frames: usize,
    projection: Projection,
    stage: Stage,
}

impl Job {
    fn project(&mut self, solver: &ClutterSolver, sum: &Sum, probe: &mut impl Probe) -> Stage {
        self.projection = solver.projection(self.slots, sum);
        probe.projection(&self.projection);
        Stage::Scale { from: 0, largest: 0 }
    }
}

/// Raw slots in, image out; `T` is the arithmetic of the transform.
pub struct FrontEnd<'b, T: Stft = NativeStft> {
    fast_time: FastTime<'b>,
    settings: Preprocessing,
    stft: T,
    clutter: &'b mut Clutter,
    taken: usize,
    /// Whether the recording's range samples wait in `slow_time`, because a job still needs those of the one before.
    waiting: bool,
    capacity: usize,
    job: Option<Job>,
    beats: &'b mut [Beat],
    workspace: &'b mut [Complex<i32>],
}

impl<'b, T: Stft> FrontEnd<'b, T> {
    /// A front end for a sensor with `settings`, or `None` if either is not valid, or the reference or slow time and a
    /// spectrum do not fit their memory.
    pub fn new(config: RadarConfig, settings: Preprocessing, buffers: FrontEndBuffers<'b>) -> Option<Self> {
        let FrontEndBuffers { reference, beats, workspace, clutter } = buffers;
        let fits = workspace.len() >= workspace_len(beats.len(), 0) && settings.illegal(&config).is_none();
        let fast_time = FastTime::new(config, reference).filter(|_| fits)?;
        Some(Self::with(fast_time, settings, beats, workspace, clutter))
    }

    /// [`FrontEnd::new`] of what has been checked: made where it stays.
    #[inline(always)]
    pub(crate) fn with(
        fast_time: FastTime<'b>,
        settings: Preprocessing,
        beats: &'b mut [Beat],
        workspace: &'b mut [Complex<i32>],
        clutter: &'b mut Clutter,
    ) -> Self {
        clutter.gram = Gram::new();
        FrontEnd {
            fast_time,
            settings,
            stft: T::new(settings.window, settings.beta, settings.hop),
            clutter,
            taken: 0,
            waiting: false,
            capacity: beats.len().min(GRAM_SLOTS),
            job: None,
            beats,
            workspace,
        }
    }

    /// Most slots a recording may have.
    pub fn capacity(&self) -> usize {
        self.capacity
    }

    /// Slots taken so far.
    pub fn taken(&self) -> usize {
        self.taken
    }

    /// The sensor's configuration.
    pub fn config(&self) -> &RadarConfig {
        self.fast_time.config()
    }

    /// Where some of its data lie; empty for those of others.
    pub(crate) fn area(&self, area: Area) -> Range<*const u8> {
        let part = match (area, &self.job) {
            (Area::SlowTime, Some(_)) => self.workspace.get(..self.beats.len()),
            (Area::LogMagnitudes, Some(_)) => self.workspace.get(self.beats.len() + SPECTRUM..),
            (Area::Activations, None) => Some(&*self.workspace),
            _ => None,
        };
        match area {
            Area::Beats => range(self.beats),
            Area::Gram => range(core::slice::from_ref(&self.clutter.gram)),
            _ => range(part.unwrap_or_default()),
        }
    }

    /// Takes the samples of one slot: range samples and running Gram matrix. `false`, and nothing changes, if the recording is
    /// full, the range samples of the one before are still needed where this one's would lie, or the slot has another length
    /// than [`RadarConfig::values_per_slot`].
    pub fn push(&mut self, slot: &[i16], probe: &mut impl Probe) -> bool {
        self.fast_time.beat(slot).is_some_and(|beat| self.push_beat(beat, probe))
    }

    /// Whether [`FrontEnd::push`] would find room.
    pub fn has_room(&self) -> bool {
        let room = match &self.job {
            _ if self.waiting => self.beats.len() / BEATS,
            // a recording behind the job's takes the places that the job has left
            Some(Job { slots, stage: Stage::Project { from, .. }, .. }) if self.taken < *slots => *from,
            _ => self.capacity,
        };
        self.taken < room.min(self.capacity)
    }

    /// Takes the range samples of a slot, each below 2^25.5 in magnitude. `false` as [`FrontEnd::push`].
    #[cfg_attr(not(target_os = "none"), inline(always))] // for the caller's vector instructions
    pub fn push_beat(&mut self, beat: Beat, probe: &mut impl Probe) -> bool {
        if !self.has_room() {
            return false;
        }
        let (waiting, _) = self.workspace.as_chunks_mut();
        let places = if self.waiting { waiting } else { &mut *self.beats };
        let Some(place) = places.get_mut(self.taken) else { return false };
        probe.beat(&beat);
        // a turn of all range samples leaves b b^H as it is
        self.clutter.gram.add(&beat);
        *place = beat;
        if self.fast_time.config().one_sided() {
            turn(place, self.taken);
        }
        self.taken += 1;
        true
    }

    /// Begins the image of the slots taken so far; [`FrontEnd::step`] makes it. `false` if an image is in the making, the slots do
    /// not fill one window, or its log magnitudes do not fit the workspace.
    pub fn begin_image(&mut self, probe: &mut impl Probe) -> bool {
        let frames = self.stft.frames(self.taken);
        let fits = frames > 0 && workspace_len(self.beats.len(), frames) <= self.workspace.len();
        if !fits || self.job.is_some() || self.waiting {
            return false;
        }
        probe.gram(&self.clutter.gram);
        self.clutter.solver.begin(&self.clutter.gram, self.settings.kept);
        self.job = Some(Job { slots: self.taken, frames, projection: UNIT_PROJECTION, stage: Stage::Solve });
        true
    }

    /// One bounded step of the image; `true` when it is done: `[64, frames]` row-major, the last bytes of [`FrontEnd::workspace`].
    ///
    /// A step is seven rotations of the eigenvalue solver, 128 slots of slow time, one frame, or 16 rows.
    pub fn step(&mut self, probe: &mut impl Probe) -> bool {
        self.try_step(probe).is_some()
    }

    fn try_step(&mut self, probe: &mut impl Probe) -> Option<()> {
        let job = self.job.as_mut()?;
        let (cells, solver) = (ROWS * job.frames, &mut self.clutter.solver);
        let Parts { slow_time, spectrum, levels } = parts(self.workspace, self.beats.len(), job.frames)?;
        job.stage = match job.stage {
            Stage::Solve => {
                if solver.step() {
                    return None;
                }
                match self.settings.kept.first {
                    ADAPTIVE => Stage::Sum { from: 0, sum: Sum::default() },
                    _ => job.project(solver, &Sum::default(), probe),
                }
            }
            Stage::Sum { from, mut sum } => {
                let end = job.slots.min(from + SLOTS_A_STEP);
                let (beats, turned) = (self.beats.get(from..end)?, self.fast_time.config().one_sided());
                sum.iter_mut().enumerate().for_each(|(k, sum)| add_samples(sum, k, beats, turned));
                if end < job.slots { Stage::Sum { from: end, sum } } else { job.project(solver, &sum, probe) }
            }
            Stage::Scale { from, largest } => {
                let end = job.slots.min(from + SLOTS_A_STEP);
                let largest = largest.max(largest_part(self.beats.get(from..end)?, &job.projection));
                if end < job.slots {
                    Stage::Scale { from: end, largest }
                } else {
                    Stage::Project { from: 0, shift: slow_time_shift(largest) }
                }
            }
            Stage::Project { from, shift } if from < job.slots => {
                let end = job.slots.min(from + SLOTS_A_STEP);
                let beats = self.beats.get_mut(from..end)?;
                if self.waiting {
                    // in place: each slot's first range sample becomes its slow time
                    for beat in beats {
                        let mut value = [beat[0]];
                        project(core::slice::from_ref(beat), &job.projection, shift, &mut value);
                        [beat[0]] = value;
                    }
                } else {
                    project(beats, &job.projection, shift, slow_time.get_mut(from..end)?);
                }
                Stage::Project { from: end, shift }
            }
            Stage::Project { .. } => {
                if core::mem::take(&mut self.waiting) {
                    change_places(self.beats, slow_time);
                }
                probe.slow_time(slow_time.get(..job.slots)?);
                spectrum.as_flattened_mut().fill(Complex::new(0, 0)); // bins that become no row are never written
                Stage::Frames { next: 0, largest: FLOOR }
            }
            Stage::Frames { next, largest } => {
                let bins = self.settings.bins_per_row;
                let spectrum = T::spectrum(spectrum);
                self.stft.frame(slow_time.get(..job.slots)?, next, bins, spectrum);
                T::probe(spectrum, next, probe);
                let levels = must_cast_slice_mut(levels);
                let largest = largest.max(log_magnitudes::<T>(spectrum, bins, next, job.frames, levels));
                if next + 1 < job.frames {
                    Stage::Frames { next: next + 1, largest }
                } else {
                    Stage::Quantize { rows: ROWS, largest }
                }
            }
            Stage::Quantize { rows, largest } => {
                let left = rows.saturating_sub(ROWS_A_STEP);
                let part = left * job.frames..rows * job.frames;
                quantize(must_cast_slice_mut(levels), part, largest, self.settings.range)?;
                if left == 0 {
                    self.job = None;
                    probe.image(must_cast_slice(levels).get(cells..)?);
                    return Some(());
                }
                Stage::Quantize { rows: left, largest }
            }
        };
        None
    }

    /// The image of the slots taken so far, at once; `None` as [`FrontEnd::begin_image`] says. More slots may be taken afterwards.
    pub fn image(&mut self, probe: &mut impl Probe) -> Option<&[i8]> {
        if !self.begin_image(probe) {
            return None;
        }
        while !self.step(probe) {}
        let bytes: &[i8] = must_cast_slice(self.workspace);
        bytes.get(bytes.len().checked_sub(ROWS * self.stft.frames(self.taken))?..)
    }

    /// Its memory but the reference, for [`selftest`](crate::selftest) before the first slot.
    pub(crate) fn buffers(&mut self) -> FrontEndBuffers<'_> {
        self.reset();
        FrontEndBuffers {
            reference: &mut [],
            beats: self.beats,
            workspace: self.workspace,
            clutter: self.clutter,
        }
    }

    /// What others may use while no image is in the making; the last one lies in its last bytes.
    pub fn workspace(&mut self) -> &mut [Complex<i32>] {
        self.workspace
    }

    /// Begins a recording. An image in the making goes on.
    pub fn reset(&mut self) {
        self.clutter.gram = Gram::new();
        self.taken = 0;
        self.waiting = self.job.as_ref().is_some_and(|job| match job.stage {
            Stage::Solve | Stage::Sum { .. } | Stage::Scale { .. } | Stage::Project { from: 0, .. } => true,
            Stage::Project { .. } => self.waiting,
            Stage::Frames { .. } | Stage::Quantize { .. } => false,
        });
    }
}

/// Multiplies range samples by (-j)^n.
fn turn(beat: &mut Beat, n: usize) {
    for value in beat {
        for _ in 0..n & 3 {
            *value = Complex::new(value.im, value.re.wrapping_neg());
        }
    }
}

const _: () = assert!(ROWS.is_multiple_of(ROWS_A_STEP), "steps are whole");
