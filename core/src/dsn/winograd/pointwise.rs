//! The layers that treat every value alone: affine, and addition by tables.

use super::rescale::{MAX_ACCUMULATOR, Rescale, WORDS, clamp_all};
use crate::dsn::add::Add;
use crate::dsn::batch_norm::BatchNormRelu;
use crate::dsn::conv::MAX_CHANNELS;

/// Entries of a table: one for every int8 value, by its bits.
const TABLE: usize = 256;

/// Words that either takes at most: an addition's tables.
pub const MOST_WORDS: usize = 2 * TABLE;

/// Words of a channel of an affine layer: its [`Rescale`] and four times its weight.
const AFFINE_WORDS: usize = WORDS + 1;

/// An affine layer, `[pixels, channels]` to the same shape; false, and nothing is done, if tiles cannot compute it.
pub fn affine(layer: &BatchNormRelu<'_>, words: &mut [i32], input: &[i8], output: &mut [i8]) -> bool {
    let channels = layer.quant.channels;
    let (words, _) = words.as_chunks_mut::<AFFINE_WORDS>();
    let Some(words) = words.get_mut(..channels) else { return false };
    for (c, (words, &weight)) in words.iter_mut().zip(layer.quant.weights).enumerate() {
        let weight = i32::from(weight as i8);
        let Some(rescale) = Rescale::of(&layer.quant, c, weight, 1) else { return false };
        let [a, b, c, d] = rescale.to_words();
        *words = [a, b, c, d, 4 * weight];
    }
    let (words, _) = words.as_chunks::<4>();
    for (from, to) in input.chunks_exact(channels.max(1)).zip(output.chunks_exact_mut(channels.max(1))) {
        let ((from, _), (to, _)) = (from.as_chunks::<4>(), to.as_chunks_mut::<4>());
        for ((from, to), words) in from.iter().zip(to).zip(words) {
            for k in 0..4 {
                let [start, multiplier, offset, shift, weight] = words[k];
                let product = i32::from(from[k] as u8 ^ 0x80).wrapping_mul(weight);
                let rescale = Rescale::from_words([start, multiplier, offset, shift]);
                to[k] = rescale.apply(start.wrapping_add(product));
            }
        }
    }
    clamp_all(output, (layer.quant.act_min, layer.quant.act_max));
    true
}

/// `x = x + branch` with both terms out of tables; false, and nothing is done, if a sum might leave its range.
pub fn add(layer: &Add, words: &mut [i32], x: &mut [i8], branch: &[i8]) -> bool {
    let Some((left, rest)) = words.split_first_chunk_mut::<TABLE>() else { return false };
    let Some(right) = rest.first_chunk_mut::<TABLE>() else { return false };
    let mut largest = 0;
    for (term, table) in [&mut *left, &mut *right].into_iter().enumerate() {
        let mut most = 0;
        for (bits, value) in table.iter_mut().enumerate() {
            *value = layer.term(term, bits as u8 as i8);
            most = most.max(i64::from(*value).abs());
            *value = value.wrapping_shl(2);
        }
        largest += most;
    }
    let rescale = Rescale::new(0, layer.out_multiplier, layer.out_shift, layer.out_zp);
    let Some(rescale) = rescale.filter(|_| largest < MAX_ACCUMULATOR) else { return false };
    for (x, &b) in x.iter_mut().zip(branch) {
        let sum = left[usize::from(*x as u8)].wrapping_add(right[usize::from(b as u8)]);
        *x = rescale.apply(sum);
    }
    clamp_all(x, (layer.act_min, layer.act_max));
    true
}

const _: () = assert!(MAX_CHANNELS * AFFINE_WORDS <= MOST_WORDS);
