//! Samples of a failing converter, from weak to strong faults.
//!
//! Weak faults and glitches of single samples may come from a working converter too, and about one sample in eight is looked at.

use super::{Outcome, below};
use crate::signals::noise;
use rand_core::Rng;
use sdp3_core::config::RadarConfig;
use sdp3_core::supervision::sample_health::{SampleFault, check};

/// Kinds of faults.
pub const KINDS: [&str; 7] = [
    "samples silent",
    "samples, bit stuck",
    "samples, most saturated",
    "samples, large offset",
    "samples, some saturated",
    "samples, small offset",
    "samples, glitch",
];

/// The first so many of [`KINDS`] are always found.
pub const CERTAIN: usize = 4;

/// A fault of the converters in one slot; pairs are in-phase and quadrature.
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
                let amplify = |x: i16| (i32::from(x) * i32::from(quarters) / 4).clamp(-32768, 32767) as i16;
                pairs.iter_mut().for_each(|pair| *pair = pair.map(amplify));
            }
            Corruption::Offset([by_i, by_q]) => {
                let shift = |[i, q]: [i16; 2]| [i.saturating_add(by_i), q.saturating_add(by_q)];
                pairs.iter_mut().for_each(|pair| *pair = shift(*pair));
            }
            Corruption::Glitch(at, value) => {
                let at = (at as usize).checked_rem(pairs.len()).unwrap_or(0);
                pairs.iter_mut().skip(at).take(1).for_each(|pair| *pair = value);
            }
        }
    }

    /// A corruption of [`KINDS`], of random strength.
    ///
    /// Of noise of +-4096 LSB: "most saturated" is amplified 12 to 35 times, "some" up to 12 times; a large offset is one of
    /// 4096 LSB or more in phase, a small one up to that in both.
    pub fn random(kind: usize, rng: &mut impl Rng) -> Self {
        let word = rng.next_u32();
        let value = [word as i16, (word >> 16) as i16];
        let up_to = |limit: u32| (((word & 0xffff) * limit) >> 16) as i16;
        match kind {
            0 => Corruption::Silent(value),
            1 => Corruption::Stuck {
                quadrature: word & 1 == 1,
                bit: (word >> 1) as u8 & 15,
                high: word & 32 == 32,
            },
            2 => Corruption::Saturated(48 + up_to(93) as u8),
            3 if word >> 31 == 0 => Corruption::Offset([4096 + up_to(20000), 0]),
            3 => Corruption::Offset([-4096 - up_to(20000), 0]),
            4 => Corruption::Saturated(4 + up_to(44) as u8),
            5 => Corruption::Offset(value.map(|x| x >> 3)),
            _ => Corruption::Glitch(below(rng, u32::MAX), value),
        }
    }
}

/// Corrupts a slot of noise and checks it.
pub(super) fn inject(kind: usize, rng: &mut impl Rng, outcome: &mut Outcome) {
    let mut samples = [0; RadarConfig::PAPER.values_per_slot()];
    noise(rng, &mut samples);
    outcome.violations += u64::from(check(&samples, &RadarConfig::PAPER).is_err());
    let corruption = Corruption::random(kind, rng);
    corruption.apply(&mut samples);
    outcome.injected += 1;
    match (check(&samples, &RadarConfig::PAPER), corruption) {
        (Ok(()), _) => outcome.silent += 1,
        (Err(SampleFault::Silent), Corruption::Silent(_))
        // a stuck bit may shift the signal, and a shifted or clipped signal may leave a bit unchanged
        | (Err(_), Corruption::Stuck { .. } | Corruption::Saturated(_) | Corruption::Offset(_)) => {
            outcome.detected += 1;
            outcome.recovered += 1;
        }
        (Err(_), _) => outcome.violations += 1,
    }
}
