//! The memory that a front end works in, which is the caller's.
//!
//! A recognition goes through its workspace twice: while its image is made slow time, a spectrum and the log magnitudes lie there, then
//! the network's activations. Only the image goes from one to the other.

use super::clutter::{ClutterSolver, Gram};
use super::dechirp::ComplexI16;
use super::stft::FixedSpectrum;
#[cfg(doc)]
use crate::config::RadarConfig;
use crate::dims::{BEATS, Beat, Complex, ROWS};
use bytemuck::must_cast_mut;

/// Sums of the recording, and eigenvectors of the recording that becomes an image: of a front end alone.
#[derive(Debug, Clone)]
pub struct Clutter {
    pub(super) gram: Gram,
    pub(super) solver: ClutterSolver,
}

#[allow(clippy::new_without_default)] // a default would be made on the stack
impl Clutter {
    /// Zeros.
    pub const fn new() -> Self {
        Clutter { gram: Gram::new(), solver: ClutterSolver::new() }
    }
}

/// Memory the front end works in; the caller's.
#[derive(Debug)]
pub struct FrontEndBuffers<'b> {
    /// [`RadarConfig::reference_len`] reference samples.
    pub reference: &'b mut [ComplexI16],
    /// Range samples, `[slow_time]`: as many as a recording has slots.
    pub beats: &'b mut [Beat],
    /// [`workspace_len`] words; others may use it while no image is in the making.
    ///
    /// At its beginning slow time, as long as `beats`: before it is made the next recording's first slots, one in eight, wait there. Then a
    /// spectrum. At its end the log magnitudes, `[64, frames]` of i16, which become the image in their second half.
    pub workspace: &'b mut [Complex<i32>],
    /// Sums and eigenvectors.
    pub clutter: &'b mut Clutter,
}

/// Words of a spectrum in the workspace.
pub(super) const SPECTRUM: usize = size_of::<FixedSpectrum>() / size_of::<Complex<i32>>();

/// Words of a frame's log magnitudes.
const FRAME: usize = ROWS * size_of::<i16>() / size_of::<Complex<i32>>();

/// Words of 8 bytes that the images of recordings of at most `slots` slots and `frames` frames take.
pub const fn workspace_len(slots: usize, frames: usize) -> usize {
    slots + SPECTRUM + FRAME * frames
}

/// What lies in the workspace.
pub(super) struct Parts<'w> {
    pub slow_time: &'w mut [Complex<i32>],
    pub spectrum: &'w mut FixedSpectrum,
    pub levels: &'w mut [Complex<i32>],
}

/// Parts for recordings of at most `slots` slots and an image of so many frames.
pub(super) fn parts(workspace: &mut [Complex<i32>], slots: usize, frames: usize) -> Option<Parts<'_>> {
    let (rest, levels) = workspace.split_at_mut_checked(workspace.len().checked_sub(FRAME * frames)?)?;
    let (slow_time, rest) = rest.split_at_mut_checked(slots)?;
    Some(Parts { slow_time, spectrum: must_cast_mut(rest.first_chunk_mut::<SPECTRUM>()?), levels })
}

/// Moves the range samples that wait in slow time to the slots' places, and the slow time in those to its own.
pub(super) fn change_places(beats: &mut [Beat], slow_time: &mut [Complex<i32>]) {
    let (waiting, rest) = slow_time.as_chunks_mut::<BEATS>();
    let whole = BEATS * waiting.len();
    for (k, eight) in waiting.iter_mut().enumerate() {
        let beat = *eight;
        let values = beats.iter().skip(BEATS * k).map(|beat| beat[0]);
        eight.iter_mut().zip(values).for_each(|(to, value)| *to = value);
        // no slow time lies here any more
        beats.get_mut(k).into_iter().for_each(|to| *to = beat);
    }
    rest.iter_mut().zip(beats.iter().skip(whole)).for_each(|(to, beat)| *to = beat[0]);
}
