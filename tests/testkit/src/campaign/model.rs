//! Bits that flip in the memory of a model.

use super::Outcome;
use rand_core::Rng;
use sdp3_core::supervision::verified_image::Intact;

/// An accepted model and a copy of it that is damaged.
#[derive(Debug)]
pub struct Damage<'m, 'c> {
    accepted: Intact<'m>,
    copy: &'c mut [u8],
}

impl<'m, 'c> Damage<'m, 'c> {
    /// Copies the model; `None` if it is no model or the memory is too small.
    pub fn new(model: &'m [u8], copy: &'c mut [u8]) -> Option<Self> {
        let (accepted, _) = Intact::accept(model).ok()?;
        let copy = copy.get_mut(..model.len())?;
        copy.iter_mut().zip(model).for_each(|(to, from)| *to = *from);
        Some(Damage { accepted, copy })
    }

    /// Flips one bit, checks the copy, and flips the bit back.
    pub(super) fn inject(&mut self, rng: &mut impl Rng, outcome: &mut Outcome) {
        let bits = self.copy.len() as u64 * 8;
        let at = (u64::from(rng.next_u32()).wrapping_mul(bits)) >> 32;
        self.toggle(at);
        outcome.injected += 1;
        match self.accepted.against(self.copy) {
            Err(_) => {
                outcome.detected += 1;
                outcome.recovered += 1;
            }
            Ok(()) => outcome.silent += 1,
        }
        self.toggle(at);
        outcome.violations += u64::from(self.accepted.against(self.copy).is_err());
    }

    /// Flips a bit of the copy.
    fn toggle(&mut self, bit: u64) {
        self.copy.iter_mut().skip((bit / 8) as usize).take(1).for_each(|byte| *byte ^= 1 << (bit % 8));
    }
}
