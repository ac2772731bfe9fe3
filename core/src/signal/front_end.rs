//! The street from raw slots to the network's image, as one object.
//!
//! Section IV-A of the paper: data cleaning (dechirp, truncated SVD) and data transformation (STFT, grey levels).

use crate::dims::{Beat, Complex, ROWS, Slot};
use crate::probe::Probe;
use crate::signal::clutter::{GRAM_SLOTS, Gram, SvdRange, project, weights};
use crate::signal::dechirp::dechirp;
use crate::signal::logarithm::EMPTY;
use crate::signal::spectrogram::{levels, pixel};
use crate::signal::stft::{NativeStft, Stft, frames};

/// How slow time becomes an image. Part of every model file: a network only understands the images it was
/// trained on.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Preprocessing {
    /// Singular components kept.
    pub kept: SvdRange,
    /// Kaiser window length N_w, 2..=256.
    pub window: u16,
    /// Kaiser window's beta, 0..=40.
    pub beta: f32,
    /// Sensing slots between two frames, 1..=window.
    pub hop: u16,
    /// FFT bins summed into one row: 1, 2 or 4.
    pub bins_per_row: u8,
    /// Dynamic range in 1/64 octave of power (50 dB is 1063), 1..=4095.
    pub range: u16,
}

impl Preprocessing {
    /// Frames of a recording of `slots` sensing slots.
    pub const fn frames(&self, slots: usize) -> usize {
        frames(slots, self.window as usize, self.hop as usize)
    }

    /// Whether every field is within its legal range.
    pub fn is_valid(&self) -> bool {
        (1..=8).contains(&self.kept.first)
            && (self.kept.first..=8).contains(&self.kept.last)
            && (2..=256).contains(&self.window)
            && (0.0..=40.0).contains(&self.beta)
            && (1..=self.window).contains(&self.hop)
            && matches!(self.bins_per_row, 1 | 2 | 4)
            && (1..=4095).contains(&self.range)
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

/// Memory the front end works in; the caller's.
#[derive(Debug)]
pub struct FrontEndBuffers<'b> {
    /// Beats of the recording, `[slow_time]`; its length is the most slots a recording may have.
    pub beats: &'b mut [Beat],
    /// The slow-time signal, as long as `beats`.
    pub slow_time: &'b mut [Complex<i32>],
    /// Level units of the image, at least 64 x frames.
    pub levels: &'b mut [i16],
    /// The image, at least 64 x frames.
    pub image: &'b mut [i8],
}

/// Raw slots in, image out; `T` is the arithmetic of the transform.
#[derive(Debug)]
pub struct FrontEnd<'b, T = NativeStft> {
    settings: Preprocessing,
    stft: T,
    gram: Gram,
    taken: usize,
    buffers: FrontEndBuffers<'b>,
}

impl<'b, T: Stft> FrontEnd<'b, T> {
    /// A front end with `settings`, or `None` if they are not valid.
    pub fn new(settings: Preprocessing, buffers: FrontEndBuffers<'b>) -> Option<Self> {
        if !settings.is_valid() {
            return None;
        }
        let stft = T::new(settings.window, settings.beta, settings.hop);
        Some(FrontEnd { settings, stft, gram: Gram::new(), taken: 0, buffers })
    }

    /// Most slots a recording may have.
    pub fn capacity(&self) -> usize {
        self.buffers.beats.len().min(self.buffers.slow_time.len()).min(GRAM_SLOTS)
    }

    /// Slots taken so far.
    pub fn taken(&self) -> usize {
        self.taken
    }

    /// Takes one slot: dechirp and running Gram matrix. `false`, and nothing changes, if the recording is full.
    pub fn push(&mut self, slot: &Slot, probe: &mut impl Probe) -> bool {
        self.taken < self.capacity() && self.push_beat(dechirp(slot), probe)
    }

    /// Takes a slot that was dechirped elsewhere, in the units of [`dechirp`] (|re|, |im| < 2^25). `false`, and nothing
    /// changes, if the recording is full.
    pub fn push_beat(&mut self, beat: Beat, probe: &mut impl Probe) -> bool {
        if self.taken >= self.capacity() {
            return false;
        }
        let Some(place) = self.buffers.beats.get_mut(self.taken) else { return false };
        probe.beat(&beat);
        self.gram.add(&beat);
        *place = beat;
        self.taken += 1;
        true
    }

    /// The image of the slots taken so far, `[64, frames]` row-major, or `None` if they do not fill one window or
    /// the image does not fit its memory. More slots may be taken afterwards.
    pub fn image(&mut self, probe: &mut impl Probe) -> Option<&[i8]> {
        let frames = self.stft.frames(self.taken);
        let cells = ROWS * frames;
        if frames == 0 {
            return None;
        }
        let beats = self.buffers.beats.get(..self.taken)?;
        let slow_time = self.buffers.slow_time.get_mut(..self.taken)?;
        let grid = self.buffers.levels.get_mut(..cells)?;
        let image = self.buffers.image.get_mut(..cells)?;

        probe.gram(&self.gram);
        let w = weights(&self.gram, self.settings.kept);
        probe.weights(&w);
        project(beats, &w, slow_time);
        probe.slow_time(slow_time);

        let bins = self.settings.bins_per_row;
        let mut spectrum = T::ZERO;
        let mut largest = EMPTY;
        for k in 0..frames {
            self.stft.frame(slow_time, k, bins, &mut spectrum);
            T::show(&spectrum, k, probe);
            largest = largest.max(levels::<T>(&spectrum, bins, k, frames, grid));
        }
        for (pixel_out, &level) in image.iter_mut().zip(grid.iter()) {
            *pixel_out = pixel(level, largest, self.settings.range);
        }
        probe.image(image);
        Some(image)
    }

    /// Forgets the recording.
    pub fn reset(&mut self) {
        self.gram = Gram::new();
        self.taken = 0;
    }
}
