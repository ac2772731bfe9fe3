//! The stem's inner loop by pairs: the largest of four sums of products of pairs, for every channel.

use crate::fixed::{Requantizer, TIMES_FOUR};

/// Words of a channel: five pairs of weights, eleven that are not read, what the sums start with, then multiplier, offset and shift of its scale.
pub const WORDS: usize = 20;

/// Of four outputs the values of five pairs of i16, of the last the lower half alone.
pub(crate) type PatchPairs = [[i32; 5]; 4];

/// The largest of four sums of products of pairs, requantised: one value a channel. Wraps.
#[inline(always)]
pub fn portable(pairs: &PatchPairs, channels: &[[i32; WORDS]], values: &mut [i8]) {
    for (value, words) in values.iter_mut().zip(channels) {
        let [.., start, multiplier, offset, shift] = *words;
        let sums = pairs.map(|pairs| {
            pairs.iter().zip(words).fold(start, |sum, (&pair, &weights)| {
                let low = i32::from(pair as i16) * i32::from(weights as i16);
                sum.wrapping_add(low).wrapping_add((pair >> 16) * (weights >> 16))
            })
        });
        let most = sums.into_iter().fold(i32::MIN, i32::max);
        *value = Requantizer::from_words([multiplier, offset, shift]).apply::<TIMES_FOUR>(most);
    }
}
