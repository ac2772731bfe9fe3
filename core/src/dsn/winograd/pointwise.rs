//! The layers that treat every value alone: batch normalisation, and addition by tables.
//!
//! TFLite 8-bit specification, DEPTHWISE_CONV_2D and ADD.

use super::packing::{self, channel};
use super::{clamp_all, packed, packed_mut};
use crate::dsn::add::Add;
use crate::dsn::batch_norm::BatchNormRelu;
use crate::dsn::conv::MAX_CHANNELS;
use crate::dsn::established;
use crate::dsn::kernels::piece;
use crate::fixed::{Requantizer, TIMES_FOUR};

/// Entries of a table: one for every int8 value, by its bits.
const TABLE: usize = 256;

/// Words of a channel of a normalisation: those of [`channel`] and four times its weight.
const BATCH_NORM_WORDS: usize = packing::WORDS + 1;

/// Words that either takes at most: an addition's tables, of the left and the right term.
pub const MOST_WORDS: usize = 2 * TABLE;

const _: () = assert!(MAX_CHANNELS * BATCH_NORM_WORDS <= MOST_WORDS);

/// Values of a step: at most 45 000 instructions on Cortex-M4F.
const VALUES: usize = 2560;

/// Packs a normalisation; `None` if these kernels cannot compute it.
#[inline(never)]
pub fn pack_batch_norm(layer: &BatchNormRelu<'_>, words: &mut [i32]) -> Option<()> {
    let channels = packed_mut::<BATCH_NORM_WORDS>(words, layer.quant.channels)?;
    for (c, (words, &weight)) in channels.iter_mut().zip(layer.quant.weights).enumerate() {
        let weight = i32::from(weight as i8);
        let [start, multiplier, offset, shift] = channel::<TIMES_FOUR>(&layer.quant, c, weight, 1)?;
        // for inputs as they are
        *words = [start.wrapping_add(512 * weight), multiplier, offset, shift, 4 * weight];
    }
    Some(())
}

/// Does a step of a normalisation, `[pixels, channels]` to the same shape; true after the last.
#[inline(never)]
pub fn batch_norm(layer: &BatchNormRelu<'_>, words: &[i32], x: &[i8], out: &mut [i8], step: usize) -> bool {
    let channels = layer.quant.channels.max(1);
    let (range, last) = piece(out.len(), (VALUES / channels).max(1) * channels, step);
    let (x, out) = (established(x.get(range.clone())), established(out.get_mut(range)));
    let words = packed::<BATCH_NORM_WORDS>(words, channels);
    match channels {
        8 => by_channels::<8>(words, x, out),
        16 => by_channels::<16>(words, x, out),
        32 => by_channels::<32>(words, x, out),
        _ => {
            for (from, to) in x.chunks_exact(channels).zip(out.chunks_exact_mut(channels)) {
                from.iter().zip(to).zip(words).for_each(|((&x, out), words)| *out = normalised(x, words));
            }
        }
    }
    clamp_all(out, (layer.quant.act_min, layer.quant.act_max));
    last
}

/// An output of a channel with these words.
#[inline(always)]
fn normalised(x: i8, [start, scale @ .., weight]: &[i32; BATCH_NORM_WORDS]) -> i8 {
    let sum = start.wrapping_add(i32::from(x).wrapping_mul(*weight));
    Requantizer::from_words(*scale).apply::<TIMES_FOUR>(sum)
}

/// Channel by channel: its words stay in registers, four pixels at a time.
fn by_channels<const CHANNELS: usize>(words: &[[i32; BATCH_NORM_WORDS]], x: &[i8], out: &mut [i8]) {
    let ((x, _), (out, _)) = (x.as_chunks::<CHANNELS>(), out.as_chunks_mut::<CHANNELS>());
    let ((x, last), (out, last_out)) = (x.as_chunks::<4>(), out.as_chunks_mut::<4>());
    for (c, words) in words.iter().enumerate().take(CHANNELS) {
        for (x, out) in x.iter().zip(&mut *out) {
            for k in 0..4 {
                out[k][c] = normalised(x[k][c], words);
            }
        }
        last.iter().zip(&mut *last_out).for_each(|(x, out)| out[c] = normalised(x[c], words));
    }
}

/// Makes both tables of an addition; `None` if a sum might leave its range.
#[inline(never)]
pub fn pack_add(layer: &Add, words: &mut [i32]) -> Option<()> {
    let mut largest = 0_u32;
    for (term, table) in packed_mut::<TABLE>(words, 2)?.iter_mut().enumerate() {
        let mut most = 0;
        for (bits, value) in table.iter_mut().enumerate() {
            *value = layer.term(term, bits as u8 as i8);
            most = most.max(value.unsigned_abs());
            *value = value.wrapping_shl(2);
        }
        largest = largest.saturating_add(most);
    }
    (i64::from(largest) < Requantizer::MAX_ACCUMULATOR).then_some(())?;
    requantizer(layer).map(|_| ())
}

fn requantizer(layer: &Add) -> Option<Requantizer> {
    Requantizer::new::<TIMES_FOUR>(layer.out_multiplier, layer.out_shift, layer.out_zp)
}

/// Does a step of `x = x + branch`; true after the last.
pub fn add(layer: &Add, words: &[i32], x: &mut [i8], branch: &[i8], step: usize) -> bool {
    let ([left, right, ..], Some(requantizer)) = (words.as_chunks::<TABLE>().0, requantizer(layer)) else {
        established::<()>(None);
        return true;
    };
    let (range, last) = piece(x.len(), VALUES, step);
    let (x, branch) = (established(x.get_mut(range.clone())), established(branch.get(range)));
    add_terms(left, right, requantizer, x, branch);
    clamp_all(x, (layer.act_min, layer.act_max));
    last
}

/// `x = x + branch` out of both tables.
#[inline(never)]
fn add_terms(left: &[i32; TABLE], right: &[i32; TABLE], by: Requantizer, x: &mut [i8], branch: &[i8]) {
    let add = |(x, b): (&mut i8, &i8)| {
        *x = by.apply::<TIMES_FOUR>(left[usize::from(*x as u8)].wrapping_add(right[usize::from(*b as u8)]));
    };
    let ((fours, last), (branch, last_branch)) = (x.as_chunks_mut::<4>(), branch.as_chunks::<4>());
    fours.iter_mut().zip(branch).for_each(|(x, branch)| x.iter_mut().zip(branch).for_each(add));
    last.iter_mut().zip(last_branch).for_each(add);
}
