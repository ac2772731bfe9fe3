//! The layers that treat every value alone, by tables: affine and addition.

use super::packing::TABLE;
use super::rescale::{MAX_ACCUMULATOR, Rescale, clamp_all};
use crate::dsn::add::Add;

/// Words of an addition's tables.
pub const ADD_WORDS: usize = 2 * TABLE;

/// Looks every value up in its channel's table: `[pixels, channels]` to the same shape.
pub fn look_up(tables: &[i8], input: &[i8], output: &mut [i8]) {
    let (tables, _) = tables.as_chunks::<TABLE>();
    let (tables, _) = tables.as_chunks::<4>();
    let length = 4 * tables.len().max(1);
    for (from, to) in input.chunks_exact(length).zip(output.chunks_exact_mut(length)) {
        let ((from, _), (to, _)) = (from.as_chunks::<4>(), to.as_chunks_mut::<4>());
        for ((from, to), tables) in from.iter().zip(to).zip(tables) {
            for k in 0..4 {
                to[k] = tables[k][usize::from(from[k] as u8)];
            }
        }
    }
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
