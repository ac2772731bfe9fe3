//! Bits that flip in a model's memory.

use super::Outcome;
use crate::supervision::verified_image::Intact;
use rand_core::Rng;

/// An accepted model and a copy of it to damage.
#[derive(Debug)]
pub struct Damage<'m, 'c> {
    whole: Intact<'m>,
    copy: &'c mut [u8],
}

impl<'m, 'c> Damage<'m, 'c> {
    /// Copies the model; `None` if it is no model or the memory is too small.
    pub fn new(model: &'m [u8], copy: &'c mut [u8]) -> Option<Self> {
        let (whole, _) = Intact::accept(model).ok()?;
        let copy = copy.get_mut(..model.len())?;
        copy.iter_mut().zip(model).for_each(|(to, from)| *to = *from);
        Some(Damage { whole, copy })
    }

    /// Flips one bit, looks, and flips it back.
    pub(super) fn flip(&mut self, rng: &mut impl Rng, outcome: &mut Outcome) {
        let bits = self.copy.len() as u64 * 8;
        let at = (u64::from(rng.next_u32()).wrapping_mul(bits)) >> 32;
        self.toggle(at);
        outcome.injected += 1;
        match self.whole.against(self.copy) {
            Err(_) => {
                outcome.detected += 1;
                outcome.recovered += 1;
            }
            Ok(()) => outcome.silent += 1,
        }
        self.toggle(at);
        outcome.broken += u64::from(self.whole.against(self.copy).is_err());
    }

    /// Flips a bit of the copy.
    fn toggle(&mut self, bit: u64) {
        self.copy.iter_mut().skip((bit / 8) as usize).take(1).for_each(|byte| *byte ^= 1 << (bit % 8));
    }
}
