//! The input convolution and its 2x2 maximum in one: a tile's four outputs are the square that is pooled.
//!
//! Winograd's F(2x2, 3x3) of one channel. Requantising never falls as the accumulator grows, so the largest of the four
//! sums is requantised and no row of the convolution is kept. Cost per pooled value: 16 products, 32 sums and
//! differences, one requantisation.

use super::packing::{kernel, point};
use super::rescale::{self, Rescale, clamp_all};
use crate::dsn::conv::Conv;
use crate::simd::pairs::POINTS;

/// Words of a channel: its weights at the points, `[column][row]`, then its [`Rescale`].
pub const WORDS: usize = POINTS + rescale::WORDS;

/// Packs the weights; `None` if tiles cannot compute it.
pub fn pack(stem: &Conv<'_>, words: &mut [i32]) -> Option<()> {
    let (channels, _) = words.as_chunks_mut::<WORDS>();
    for (o, words) in channels.iter_mut().enumerate() {
        let (points, constants) = words.split_first_chunk_mut::<POINTS>()?;
        let weights = kernel(stem, o, 0);
        for (place, value) in points.iter_mut().enumerate() {
            *value = point(&weights, place % 4, place / 4);
        }
        *constants.first_chunk_mut()? = stem.layer.rescale(o, 9)?.to_words();
    }
    Some(())
}

/// B^T on four values.
#[inline(always)]
fn forward([a, b, c, d]: [i32; 4]) -> [i32; 4] {
    [a.wrapping_sub(c), b.wrapping_add(c), c.wrapping_sub(b), b.wrapping_sub(d)]
}

/// Column `x` of four rows, transformed downwards; outside the image it is `border`.
#[inline(always)]
fn column(rows: &[&[i8]; 4], x: usize, border: i32) -> [i32; 4] {
    forward(rows.map(|row| row.get(x).map_or(border, |&v| i32::from(v as u8 ^ 0x80))))
}

/// `[height, width]` to `[height / 2, width / 2, channels]`, for a stride of 1.
pub fn pooled(stem: &Conv<'_>, constants: &[i32], image: &[i8], (_, width): (usize, usize), output: &mut [i8]) {
    let layer = &stem.layer;
    let border = i32::from(layer.in_zp) + 128;
    let (channels, _) = constants.as_chunks::<WORDS>();
    let lines = |y: usize| y.checked_sub(1).and_then(|y| image.get(y * width..)?.get(..width)).unwrap_or(&[]);
    let line = width / 2 * layer.channels;
    for (y, output) in output.chunks_exact_mut(line.max(1)).enumerate() {
        let rows = [lines(2 * y), lines(2 * y + 1), lines(2 * y + 2), lines(2 * y + 3)];
        let mut columns = [[0; 4], [0; 4], forward([border; 4]), column(&rows, 0, border)];
        for (x, pixel) in output.chunks_exact_mut(layer.channels.max(1)).enumerate() {
            let [_, _, a, b] = columns;
            columns = [a, b, column(&rows, 2 * x + 1, border), column(&rows, 2 * x + 2, border)];
            let mut points = [[0; 4]; 4];
            for row in 0..4 {
                let along = forward(columns.map(|column| column[row]));
                for k in 0..4 {
                    points[k][row] = along[k];
                }
            }
            for (out, words) in pixel.iter_mut().zip(channels) {
                *out = largest(&points, words);
            }
        }
    }
    clamp_all(output, (layer.act_min, layer.act_max));
}

/// The largest of a tile's four outputs.
#[inline(always)]
fn largest(points: &[[i32; 4]; 4], words: &[i32; WORDS]) -> i8 {
    let (mut upper, mut lower) = ([0_i32; 4], [0_i32; 4]);
    for (k, [d0, d1, d2, d3]) in points.iter().enumerate() {
        let w = &words[4 * k..4 * k + 4];
        let (a, b) = (w[1].wrapping_mul(*d1), w[2].wrapping_mul(*d2));
        upper[k] = a.wrapping_add(b).wrapping_add(w[0].wrapping_mul(*d0));
        lower[k] = a.wrapping_sub(b).wrapping_sub(w[3].wrapping_mul(*d3));
    }
    let most = |m: [i32; 4]| {
        let left = m[0].wrapping_add(m[1]).wrapping_add(m[2]);
        left.max(m[1].wrapping_sub(m[2]).wrapping_sub(m[3]))
    };
    let [.., start, multiplier, offset, shift] = *words;
    let rescale = Rescale::from_words([start, multiplier, offset, shift]);
    rescale.apply(most(upper).max(most(lower)).wrapping_add(start))
}
