//! Samples of a failing converter, from weak to strong faults.
//!
//! Weak faults and glitches of single samples may come from a working converter too, and about one sample in eight is looked at.

use super::{Outcome, below};
use crate::signals::noise;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;
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

/// A kind of corruption, its strength in words, and a corruption of that strength.
pub type Strength = (&'static str, &'static str, fn(&mut [i16], u32));

/// Corruptions from strengths that are never found to such that always are, if there are any.
pub const STRENGTHS: [Strength; 18] = {
    const OFFSET: &str = "offset in phase, part of full scale";
    const SATURATED: &str = "saturated values, share";
    const GLITCH: &str = "one sample, height as part of full scale";
    [
        (OFFSET, "1/32", |samples, _| offset(samples, 1024)),
        (OFFSET, "3/64", |samples, _| offset(samples, 1536)),
        (OFFSET, "7/128", |samples, _| offset(samples, 1792)),
        (OFFSET, "1/16", |samples, _| offset(samples, 2048)),
        (OFFSET, "9/128", |samples, _| offset(samples, 2304)),
        (OFFSET, "5/64", |samples, _| offset(samples, 2560)),
        (OFFSET, "3/32", |samples, _| offset(samples, 3072)),
        (OFFSET, "1/8", |samples, _| offset(samples, 4096)),
        (SATURATED, "0.002", |samples, seed| saturate(samples, 2, seed)),
        (SATURATED, "0.005", |samples, seed| saturate(samples, 5, seed)),
        (SATURATED, "0.01", |samples, seed| saturate(samples, 10, seed)),
        (SATURATED, "0.02", |samples, seed| saturate(samples, 20, seed)),
        (SATURATED, "0.03", |samples, seed| saturate(samples, 30, seed)),
        (SATURATED, "0.05", |samples, seed| saturate(samples, 50, seed)),
        (SATURATED, "0.1", |samples, seed| saturate(samples, 100, seed)),
        (GLITCH, "1/4", |samples, seed| Corruption::Glitch(seed, [1 << 13, 0]).apply(samples)),
        (GLITCH, "1/2", |samples, seed| Corruption::Glitch(seed, [1 << 14, 0]).apply(samples)),
        (GLITCH, "1", |samples, seed| Corruption::Glitch(seed, [i16::MAX, 0]).apply(samples)),
    ]
};

fn offset(samples: &mut [i16], by: i16) {
    Corruption::Offset([by, 0]).apply(samples);
}

/// Of a thousand values about so many at an end of the range.
fn saturate(samples: &mut [i16], of_thousand: u32, seed: u32) {
    let mut rng = Xoshiro128PlusPlus::seed_from_u64(seed.into());
    let chosen = samples.iter_mut().filter(|_| below(&mut rng, 1000) < of_thousand);
    chosen.for_each(|x| *x = if *x < 0 { i16::MIN } else { i16::MAX });
}

/// Of so many slots of seeded noise, corrupted with a strength, those that the check of samples refuses.
pub fn refused((_, _, corrupt): &Strength, slots: u32, seed: u64) -> u32 {
    let mut rng = Xoshiro128PlusPlus::seed_from_u64(seed);
    let mut samples = [0; RadarConfig::PAPER.values_per_slot()];
    let refused = (0..slots).filter(|_| {
        noise(&mut rng, &mut samples);
        corrupt(&mut samples, rng.next_u32());
        check(&samples, &RadarConfig::PAPER).is_err()
    });
    refused.count() as u32
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
