//! Whether a slot's samples can be trusted.
//!
//! A sweep that comes back swings about zero with more than a few LSB: over a thousand samples every bit of a working converter
//! is sometimes 0 and sometimes 1, the sign's copies above the amplitude included. A bit that never moves is stuck.

use crate::dims::{SLOT_SAMPLES, Slot};

/// Most values of a slot, of 2000, that may be at an end of the converter's range.
pub const MOST_CLIPPED: u16 = 20;

/// Largest mean of a slot in LSB, in phase or in quadrature: a chirp over the whole range has about 1000.
pub const LARGEST_OFFSET: i32 = 2048;

/// What is wrong with a slot's samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum SampleFault {
    /// All samples are the same.
    Silent,
    /// Bits that never moved, one bit each; the upper ones too if the signal lies on one side of zero.
    Stuck {
        /// Of the in-phase converter.
        i: u16,
        /// Of the quadrature converter.
        q: u16,
    },
    /// More than [`MOST_CLIPPED`] values at an end of the range.
    Saturated {
        /// How many.
        values: u16,
    },
    /// A mean beyond [`LARGEST_OFFSET`].
    Offset {
        /// In phase, LSB.
        i: i16,
        /// In quadrature, LSB.
        q: i16,
    },
}

impl core::fmt::Display for SampleFault {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match *self {
            SampleFault::Silent => write!(f, "all samples are the same"),
            SampleFault::Stuck { i, q } => {
                write!(f, "bits never move: {i:#06x} in phase, {q:#06x} in quadrature")
            }
            SampleFault::Saturated { values } => write!(f, "{values} values are at an end of the range"),
            SampleFault::Offset { i, q } => write!(f, "the mean is {i} LSB in phase, {q} in quadrature"),
        }
    }
}

impl core::error::Error for SampleFault {}

/// Looks at a slot. Cost: one pass.
///
/// # Errors
///
/// The first that is found of: silent, stuck, saturated, off its zero.
pub fn check(slot: &Slot) -> Result<(), SampleFault> {
    let [first, ..] = slot;
    let (mut moved, mut sum, mut clipped) = ((0_i16, 0_i16), (0_i32, 0_i32), 0_u16);
    for sample in slot {
        moved = (moved.0 | (sample.i ^ first.i), moved.1 | (sample.q ^ first.q));
        // at most 1000 values of 16 bits
        sum = (sum.0 + i32::from(sample.i), sum.1 + i32::from(sample.q));
        let at_end = |x: i16| u16::from(x == i16::MAX || x == i16::MIN);
        clipped += at_end(sample.i) + at_end(sample.q);
    }
    let stuck = (!moved.0 as u16, !moved.1 as u16);
    let mean = (sum.0 / SLOT_SAMPLES as i32, sum.1 / SLOT_SAMPLES as i32);
    if moved == (0, 0) {
        Err(SampleFault::Silent)
    } else if stuck != (0, 0) {
        Err(SampleFault::Stuck { i: stuck.0, q: stuck.1 })
    } else if clipped > MOST_CLIPPED {
        Err(SampleFault::Saturated { values: clipped })
    } else if mean.0.abs() > LARGEST_OFFSET || mean.1.abs() > LARGEST_OFFSET {
        Err(SampleFault::Offset { i: mean.0 as i16, q: mean.1 as i16 })
    } else {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::dims::Iq;
    use std::string::ToString;

    fn sweep(amplitude: f64) -> Slot {
        core::array::from_fn(|n| {
            let phase = 3e-4 * (n * n) as f64;
            let at = |shift: f64| {
                libm::round(amplitude * libm::cos(phase + shift)).clamp(-32768.0, 32767.0) as i16
            };
            Iq { i: at(0.0), q: at(-1.571) }
        })
    }

    #[test]
    fn working_converters_are_trusted_from_a_few_lsb_to_the_range() {
        for amplitude in [2.0, 5.0, 100.0, 3e4] {
            assert_eq!(check(&sweep(amplitude)), Ok(()), "{amplitude}");
        }
    }

    #[test]
    fn every_fault_has_its_name() {
        assert_eq!(check(&[Iq { i: 5, q: -3 }; SLOT_SAMPLES]), Err(SampleFault::Silent));
        for bit in 0..16 {
            let mut slot = sweep(2000.0);
            slot.iter_mut().for_each(|x| x.q |= 1 << bit);
            assert_eq!(check(&slot), Err(SampleFault::Stuck { i: 0, q: 1 << bit }));
            let mut slot = sweep(2000.0);
            slot.iter_mut().for_each(|x| x.i &= !(1 << bit));
            assert_eq!(check(&slot), Err(SampleFault::Stuck { i: 1 << bit, q: 0 }));
        }
        assert!(matches!(check(&sweep(4e4)), Err(SampleFault::Saturated { values: 500.. })));
        let mut slot = sweep(5000.0);
        slot.iter_mut().for_each(|x| x.i += 2500);
        assert!(matches!(check(&slot), Err(SampleFault::Offset { i: 2300..2700, q: -200..200 })));
    }

    /// Samples that move every bit about these means.
    fn about(i: i16, q: i16) -> Slot {
        core::array::from_fn(|n| {
            let swing = 31 * (n as i16 / 2) + 1;
            let swing = if n % 2 == 0 { swing } else { -swing };
            Iq { i: i + swing, q: q - swing }
        })
    }

    #[test]
    fn the_limits_are_the_last_values_that_are_taken() {
        let offset = |i, q| Err(SampleFault::Offset { i, q });
        for (i, q, found) in [
            (2048, 0, Ok(())),
            (0, -2048, Ok(())),
            (-2048, 2048, Ok(())),
            (2049, 0, offset(2049, 0)),
            (-2049, 1, offset(-2049, 1)),
            (0, 2049, offset(0, 2049)),
            (7, -2049, offset(7, -2049)),
        ] {
            assert_eq!(check(&about(i, q)), found, "{i}, {q}");
        }
        for (at_i, at_q) in [(20, 0), (0, 20), (10, 10)] {
            for end in [i16::MAX, i16::MIN] {
                let mut slot = about(0, 0);
                slot.iter_mut().take(at_i).for_each(|x| x.i = end);
                slot.iter_mut().skip(500).take(at_q).for_each(|x| x.q = end);
                assert_eq!(check(&slot), Ok(()));
                slot[300].q = end;
                assert_eq!(check(&slot), Err(SampleFault::Saturated { values: 21 }));
            }
        }
    }

    #[test]
    fn every_fault_says_what_it_is() {
        for (fault, words) in [
            (SampleFault::Silent, "all samples are the same"),
            (
                SampleFault::Stuck { i: 1, q: 0x8000 },
                "bits never move: 0x0001 in phase, 0x8000 in quadrature",
            ),
            (SampleFault::Saturated { values: 21 }, "21 values are at an end of the range"),
            (SampleFault::Offset { i: -3000, q: 4 }, "the mean is -3000 LSB in phase, 4 in quadrature"),
        ] {
            assert_eq!(fault.to_string(), words);
        }
    }
}
