//! Samples of a failing converter, from weak to strong faults.
//!
//! Weak faults and single glitches may come from a working converter too: they stay silent here.

use super::{Outcome, SAMPLES, SCHEDULE, slot};
use crate::signals::noise;
use rand_core::Rng;
use sdp3_core::supervision::sample_health::{SampleFault, check};

/// A fault of the converter in one slot; pairs are in-phase and quadrature.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Corruption {
    /// One value for all samples.
    Silent([i16; 2]),
    /// A bit of one of the two converters is stuck at 0 or 1.
    Stuck {
        /// Whether it is the quadrature converter.
        quadrature: bool,
        /// The bit, 0..16.
        bit: u8,
        /// Whether it is stuck at 1.
        high: bool,
    },
    /// Amplified by so many quarters, clipped to the range.
    Saturated(u8),
    /// Shifted by so many LSB, clipped to the range.
    Offset([i16; 2]),
    /// One sample, this one modulo their number, has another value.
    Glitch(u32, [i16; 2]),
}

impl Corruption {
    /// Corrupts interleaved samples.
    pub fn apply(self, samples: &mut [i16]) {
        let (pairs, _) = samples.as_chunks_mut::<2>();
        let clip = |x: i32| x.clamp(i32::from(i16::MIN), i32::from(i16::MAX)) as i16;
        match self {
            Corruption::Silent(value) => pairs.fill(value),
            Corruption::Stuck { quadrature, bit, high } => {
                let mask = 1_i16.wrapping_shl(u32::from(bit));
                for [i, q] in pairs {
                    let x = if quadrature { q } else { i };
                    *x = if high { *x | mask } else { *x & !mask };
                }
            }
            Corruption::Saturated(quarters) => {
                let louder = |x: i16| clip(i32::from(x) * i32::from(quarters) / 4);
                pairs.iter_mut().for_each(|pair| *pair = pair.map(louder));
            }
            Corruption::Offset(by) => {
                let shifted = |x: i16, by: i16| clip(i32::from(x) + i32::from(by));
                pairs.iter_mut().for_each(|[i, q]| (*i, *q) = (shifted(*i, by[0]), shifted(*q, by[1])));
            }
            Corruption::Glitch(at, value) => {
                let at = (at as usize).checked_rem(pairs.len()).unwrap_or(0);
                pairs.iter_mut().skip(at).take(1).for_each(|pair| *pair = value);
            }
        }
    }

    /// A corruption of random strength; `kind` is 0..5 in the order of the variants.
    pub fn random(kind: usize, rng: &mut impl Rng) -> Self {
        let word = rng.next_u32();
        let value = [word as i16, (word >> 16) as i16];
        match kind {
            0 => Corruption::Silent(value),
            1 => Corruption::Stuck {
                quadrature: word & 1 == 1,
                bit: (word >> 1) as u8 & 15,
                high: word & 32 == 32,
            },
            2 => Corruption::Saturated(4 + (word & 127) as u8),
            3 => Corruption::Offset(value.map(|x| x >> 3)),
            _ => Corruption::Glitch(rng.next_u32(), value),
        }
    }
}

/// Corrupts a slot of noise and checks it.
pub(super) fn inject(kind: usize, rng: &mut impl Rng, outcome: &mut Outcome) {
    let mut samples = [0; SAMPLES];
    noise(rng, &mut samples);
    outcome.violations += u64::from(check(&slot(&samples)).is_err());
    let corruption = Corruption::random(kind.saturating_sub(SCHEDULE + 1), rng);
    corruption.apply(&mut samples);
    outcome.injected += 1;
    match (check(&slot(&samples)), corruption) {
        (Ok(()), _) => outcome.silent += 1,
        (Err(SampleFault::Silent), Corruption::Silent(_))
        // a stuck bit may clip or shift the signal, and a shifted or clipped signal may leave a bit unchanged
        | (Err(_), Corruption::Stuck { .. } | Corruption::Saturated(_) | Corruption::Offset(_)) => {
            outcome.detected += 1;
            outcome.recovered += 1;
        }
        (Err(_), _) => outcome.violations += 1,
    }
}
