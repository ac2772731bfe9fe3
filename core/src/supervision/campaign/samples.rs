//! Slots that a failing converter gives, from barely to badly.
//!
//! Weak faults and single glitches are within what a working converter does: they stay silent here, and what they cost in
//! accuracy is the host's to tell.

use super::{Outcome, SCHEDULE};
use crate::dims::{Iq, SLOT_SAMPLES, Slot};
use crate::selftest::noise;
use crate::supervision::sample_health::{SampleFault, check};
use rand_core::Rng;

/// What happened to a slot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Spoil {
    /// One value for all samples.
    Silent(Iq),
    /// A bit (0..16) of one converter stuck at 0 or 1.
    Stuck {
        /// Whether of the quadrature converter.
        quadrature: bool,
        /// Which bit.
        bit: u8,
        /// At 1.
        high: bool,
    },
    /// Amplified by so many quarters, clipped to the range.
    Saturated(u8),
    /// Moved by so many LSB, clipped to the range.
    Offset(Iq),
    /// One sample has another value.
    Glitch(u16, Iq),
}

impl Spoil {
    /// Does it.
    pub fn apply(self, slot: &mut Slot) {
        let clip = |x: i32| x.clamp(i32::from(i16::MIN), i32::from(i16::MAX)) as i16;
        match self {
            Spoil::Silent(value) => slot.fill(value),
            Spoil::Stuck { quadrature, bit, high } => {
                let mask = 1_i16.wrapping_shl(u32::from(bit));
                for sample in slot {
                    let x = if quadrature { &mut sample.q } else { &mut sample.i };
                    *x = if high { *x | mask } else { *x & !mask };
                }
            }
            Spoil::Saturated(quarters) => {
                let louder = |x: i16| clip(i32::from(x) * i32::from(quarters) / 4);
                slot.iter_mut().for_each(|x| *x = Iq { i: louder(x.i), q: louder(x.q) });
            }
            Spoil::Offset(by) => {
                let moved = |x: i16, by: i16| clip(i32::from(x) + i32::from(by));
                slot.iter_mut().for_each(|x| *x = Iq { i: moved(x.i, by.i), q: moved(x.q, by.q) });
            }
            Spoil::Glitch(at, value) => {
                if let Some(sample) = slot.get_mut(usize::from(at)) {
                    *sample = value;
                }
            }
        }
    }

    /// Of any strength; `kind` 0..5 in the order here.
    pub fn random(kind: usize, rng: &mut impl Rng) -> Self {
        let word = rng.next_u32();
        let value = Iq { i: word as i16, q: (word >> 16) as i16 };
        match kind {
            0 => Spoil::Silent(value),
            1 => {
                Spoil::Stuck { quadrature: word & 1 == 1, bit: (word >> 1) as u8 & 15, high: word & 32 == 32 }
            }
            2 => Spoil::Saturated(4 + (word & 127) as u8),
            3 => Spoil::Offset(Iq { i: value.i >> 3, q: value.q >> 3 }),
            _ => Spoil::Glitch((rng.next_u32() % SLOT_SAMPLES as u32) as u16, value),
        }
    }
}

/// Spoils a slot of noise and looks at it.
pub(super) fn spoil(kind: usize, rng: &mut impl Rng, outcome: &mut Outcome) {
    let mut slot: Slot = [Iq { i: 0, q: 0 }; SLOT_SAMPLES];
    noise(rng, &mut slot);
    outcome.broken += u64::from(check(&slot).is_err());
    let spoil = Spoil::random(kind.saturating_sub(SCHEDULE + 1), rng);
    spoil.apply(&mut slot);
    outcome.injected += 1;
    match (check(&slot), spoil) {
        (Ok(()), _) => outcome.silent += 1,
        (Err(SampleFault::Silent), Spoil::Silent(_))
        // a stuck bit may clip or move the signal, a moved or clipped one may never show a bit
        | (Err(_), Spoil::Stuck { .. } | Spoil::Saturated(_) | Spoil::Offset(_)) => {
            outcome.detected += 1;
            outcome.recovered += 1;
        }
        (Err(_), _) => outcome.broken += 1,
    }
}
