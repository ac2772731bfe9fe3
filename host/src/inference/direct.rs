//! 3x3 convolutions on vectors: sixteen outputs in the lanes, a row of pixels in registers.
//!
//! The input is first rewritten as words of two or four inputs, with a border of its zero point: then no pixel is
//! special, and a row of the kernel is one run of successive words. Cost: 9 inputs / 2 or 9 inputs / 4 vector products
//! a pixel and sixteen outputs.

use super::layer::{Convolution, Group, finish, put};
use crate::simd::{LANES, Lanes};

/// Sums of `P` successive pixels: three runs of `run` words, rows apart; a pixel is `step` words.
#[inline(always)]
pub fn tile<L: Lanes, const P: usize>(
    lanes: L,
    start: L::V,
    group: &Group<'_>,
    (run, step): (usize, usize),
    words: &[i32],
    row: usize,
) -> Option<[L::V; P]> {
    let mut sums = [start; P];
    for ky in 0..3 {
        let words = words.get(ky * row..)?.get(..(P - 1) * step + run)?;
        let weights = group.words.get(ky * run..)?.get(..run)?;
        for k in 0..run {
            let w = lanes.load(&weights[k]);
            for p in 0..P {
                sums[p] = lanes.dot(sums[p], words[p * step + k], w);
            }
        }
    }
    Some(sums)
}

impl Convolution<'_> {
    #[inline(always)]
    fn rows<L: Lanes, const QUADS: usize, const P: usize>(mut self, lanes: L) {
        let step = QUADS * (4 / L::INPUTS);
        let (height, width) = self.size;
        let columns = width.next_multiple_of(P) + 2;
        let row = columns * step;
        self.spread(lanes, step, (height + 2, columns));
        let (layer, words) = (&self.layer.layer, &*self.words);
        let channels = layer.channels;
        let mut lines = self.lines;
        for first in (0..channels).step_by(LANES) {
            let Some(group) = Group::take(&mut lines, 9 * step) else { return };
            let start = lanes.load(group.biases);
            let rows = self.output.chunks_exact_mut((width * channels).max(1));
            for (y, out) in rows.take(height).enumerate() {
                for x in (0..width).step_by(P) {
                    let words = words.get(y * row + x * step..).unwrap_or(&[]);
                    let Some(sums) = tile::<L, P>(lanes, start, &group, (3 * step, step), words, row) else {
                        return;
                    };
                    let (fours, _) = sums.as_chunks::<4>();
                    for (k, &four) in fours.iter().enumerate() {
                        let values = finish(lanes, layer, group.rescale, four);
                        put(&values, first, channels, out, x + 4 * k);
                    }
                }
            }
        }
    }

    /// The convolution, for four times `QUADS` inputs.
    #[inline(always)]
    pub fn direct<L: Lanes, const QUADS: usize>(self, lanes: L) {
        match L::TILE {
            4 => self.rows::<L, QUADS, 4>(lanes),
            8 => self.rows::<L, QUADS, 8>(lanes),
            _ => self.rows::<L, QUADS, 16>(lanes),
        }
    }
}
