//! The layers that treat every value alone: affine, and addition by tables.

use super::rescale::{MAX_ACCUMULATOR, Rescale, clamp_all};
use crate::dsn::add::Add;
use crate::dsn::affine::Affine;

/// Entries of a table: one for every int8 value, by its bits.
const TABLE: usize = 256;

/// Words of an addition's tables.
pub const ADD_WORDS: usize = 2 * TABLE;

/// An affine layer, `[pixels, channels]` to the same shape, channel by channel.
pub fn affine(layer: &Affine<'_>, input: &[i8], output: &mut [i8]) {
    let channels = layer.layer.channels.max(1);
    for (c, &weight) in layer.layer.weights.iter().enumerate().take(channels) {
        let weight = i32::from(weight as i8);
        let from = input.get(c..).unwrap_or(&[]).iter().step_by(channels);
        let to = output.get_mut(c..).unwrap_or(&mut []).iter_mut().step_by(channels);
        match Rescale::of(&layer.layer, c, weight, 1) {
            Some(rescale) => {
                let weight = 4 * weight;
                for (x, y) in from.zip(to) {
                    let product = i32::from(*x as u8 ^ 0x80).wrapping_mul(weight);
                    *y = rescale.apply(rescale.start.wrapping_add(product));
                }
            }
            None => from.zip(to).for_each(|(x, y)| *y = layer.value(c, *x)),
        }
    }
    clamp_all(output, (layer.layer.act_min, layer.layer.act_max));
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
