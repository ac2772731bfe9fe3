//! Whether a slot's samples can be trusted: silent, stuck, saturated or offset converters.
//!
//! A received chirp swings about zero with more than a few LSB: every bit of a working converter is sometimes 0 and sometimes 1,
//! the sign's copies above the amplitude included. A beat signal may lie on one side of zero: there only bits below the largest
//! one that moves can be known to be stuck. About 125 samples of a sweep are looked at, at unequal distances, so that the check
//! costs less than taking the slot; faults of single samples are not found. A slot of fewer samples than a sweep has, as a Doppler
//! sensor's, is too short to show more than values at an end of the range.

use crate::config::{Dechirp, RadarConfig, SampleFormat};

/// Samples of a sweep that are looked at, about.
const LOOKED_AT: usize = 125;

/// Of so many values that are looked at one may be at an end of the converter's range.
pub const CLIPPED_ONE_IN: u16 = 100;

/// Largest mean, as a part of the range's positive half: one in 16. A chirp over the whole range has about one in 32.
pub const OFFSET_ONE_IN: i32 = 16;

/// What is wrong with a slot's samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum SampleFault {
    /// The samples are the same.
    #[error("the samples are the same")]
    Silent,
    /// Bits that never moved, one bit each, of the significant ones.
    #[error("bits never move: {i:#06x} in phase, {q:#06x} in quadrature")]
    Stuck {
        /// Of the in-phase (or only) converter.
        i: u16,
        /// Of the quadrature converter.
        q: u16,
    },
    /// More than one in [`CLIPPED_ONE_IN`] values at an end of the range.
    #[error("{values} values are at an end of the range")]
    Saturated {
        /// How many of those looked at.
        values: u16,
    },
    /// A mean beyond one [`OFFSET_ONE_IN`]th of the range.
    #[error("the mean is {i} LSB in phase, {q} in quadrature")]
    Offset {
        /// In phase, LSB.
        i: i16,
        /// In quadrature, LSB.
        q: i16,
    },
}

/// What is known of a converter's values.
struct Values {
    first: i16,
    moved: i16,
    sum: i32,
    clipped: u16,
}

impl Values {
    fn new(first: i16) -> Self {
        Values { first, moved: 0, sum: 0, clipped: 0 }
    }

    #[inline(always)]
    fn add(&mut self, x: i16, ends: (i16, i16)) {
        self.moved |= x ^ self.first;
        self.sum += i32::from(x); // at most 249 values of 16 bits
        self.clipped += u16::from(x == ends.0 || x == ends.1);
    }

    /// Significant bits that never moved.
    fn stuck(&self, config: &RadarConfig) -> u16 {
        let unused = if config.left_justified { 16 - u32::from(config.converter_bits.min(16)) } else { 0 };
        let significant = u16::MAX << (unused & 15);
        let moved = self.moved as u16;
        let known = match config.dechirp {
            Dechirp::Digital => u16::MAX,
            // those below the largest that moves, all where none does
            Dechirp::Analog if moved == 0 => u16::MAX,
            Dechirp::Analog => (u32::MAX >> 1 >> (moved.leading_zeros() + 15)) as u16,
        };
        !moved & significant & known
    }
}

/// Looks at a slot's values, at no more than [`RadarConfig::values_per_slot`]. Cost: 8 instructions for each of about 125 samples, twice for complex ones.
///
/// # Errors
///
/// The first that is found of: silent, stuck, saturated, offset.
pub fn check(slot: &[i16], config: &RadarConfig) -> Result<(), SampleFault> {
    let slot = slot.get(..config.values_per_slot()).unwrap_or(slot);
    let step = (usize::from(config.samples) / LOOKED_AT).max(1);
    let bits = u32::from(config.converter_bits.clamp(8, 16));
    let ends = if config.left_justified {
        (i16::MIN, i16::MAX >> (16 - bits) << (16 - bits))
    } else {
        (i16::MIN >> (16 - bits), i16::MAX >> (16 - bits))
    };
    if config.samples < RadarConfig::LEAST_SAMPLES {
        let values = slot.iter().filter(|&&x| x == ends.0 || x == ends.1).count() as u16;
        return if values == 0 { Ok(()) } else { Err(SampleFault::Saturated { values }) };
    }
    let (pairs, _) = slot.as_chunks::<2>();
    let [first_i, first_q] = *pairs.first().ok_or(SampleFault::Silent)?;
    let (mut i, mut q) = (Values::new(first_i), Values::new(first_q));
    let mut count = 0_u16;
    match config.format {
        SampleFormat::Complex => {
            // the position within a group changes from group to group
            for (k, group) in pairs.chunks_exact(step).enumerate() {
                let [x, y] = group.get(k % step).copied().unwrap_or([first_i, first_q]);
                i.add(x, ends);
                q.add(y, ends);
                count += 2;
            }
        }
        SampleFormat::Real => {
            for (k, group) in slot.chunks_exact(step).enumerate() {
                i.add(group.get(k % step).copied().unwrap_or(first_i), ends);
                count += 1;
            }
        }
    }
    let real = config.format == SampleFormat::Real;
    let each = i32::from(count) / if real { 1 } else { 2 };
    let mean = (i.sum / each.max(1), q.sum / each.max(1));
    let limit = i32::from(ends.1) / OFFSET_ONE_IN;
    let stuck = (i.stuck(config), if real { 0 } else { q.stuck(config) });
    let clipped = i.clipped + q.clipped;
    if i.moved == 0 && (real || q.moved == 0) {
        Err(SampleFault::Silent)
    } else if stuck != (0, 0) {
        Err(SampleFault::Stuck { i: stuck.0, q: stuck.1 })
    } else if clipped > count / CLIPPED_ONE_IN {
        Err(SampleFault::Saturated { values: clipped })
    } else if mean.0.abs() > limit + 1 || mean.1.abs() > limit + 1 {
        Err(SampleFault::Offset { i: mean.0 as i16, q: mean.1 as i16 })
    } else {
        Ok(())
    }
}
