//! The input convolution with its pooling on vectors.

use super::direct::tile;
use super::layer::{Group, finish, put};
use crate::dsn::conv::{Conv, pad_before, same};
use crate::simd::{Job, LANES, Lanes, Line};

/// The input convolution with its 2x2 maximum: `[height, width]` to `[pooled height, pooled width, outputs]`.
///
/// Requantisation never falls where its argument rises, so the maximum is taken before it, of the sums.
pub struct Stem<'a> {
    pub layer: &'a Conv<'a>,
    pub lines: &'a [Line],
    pub words: &'a mut [i32],
    pub image: &'a [i8],
    pub size: (usize, usize),
    pub pooled: &'a mut [i8],
}

/// Pixels of the stem in one tile: four after pooling.
const STEM_TILE: usize = 8;

impl Stem<'_> {
    /// Rewrites each image row as words of the four values from each output's first tap; returns the words of a row.
    #[inline(always)]
    fn spread<L: Lanes>(&mut self, lanes: L) -> usize {
        let (height, width) = self.size;
        let stride = self.layer.stride;
        let (rows, columns) = (same(height, stride), same(width, stride));
        let (above, before) = (pad_before(height, stride), pad_before(width, stride));
        let zero = self.layer.layer.in_zp;
        let per_pixel = 4 / L::INPUTS;
        let row = columns.next_multiple_of(STEM_TILE) * per_pixel;
        let count = (rows.max(1) - 1) * stride + 3;
        for (y, words) in self.words.chunks_exact_mut(row.max(1)).take(count).enumerate() {
            let line = y.checked_sub(above).filter(|&y| y < height);
            let line = line.and_then(|y| self.image.get(y * width..)?.get(..width)).unwrap_or(&[]);
            for (x, words) in words.chunks_exact_mut(per_pixel).enumerate() {
                let at = (x * stride).wrapping_sub(before);
                let four = match line.get(at..).and_then(|rest| rest.first_chunk()) {
                    Some(four) => *four,
                    None => [0, 1, 2, 3].map(|k| line.get(at.wrapping_add(k)).copied().unwrap_or(zero)),
                };
                lanes.words(&four, words);
            }
        }
        row
    }
}

impl Job for Stem<'_> {
    #[inline(always)]
    fn run<L: Lanes>(mut self, lanes: L) {
        let row = self.spread(lanes);
        let (layer, stride, words) = (&self.layer.layer, self.layer.stride, &*self.words);
        let channels = layer.channels;
        let width = same(self.size.1, stride) / 2;
        let step = 4 / L::INPUTS;
        let mut lines = self.lines;
        for first in (0..channels).step_by(LANES) {
            let Some(group) = Group::take(&mut lines, 3 * step) else { return };
            let start = lanes.load(group.biases);
            for (y, out) in self.pooled.chunks_exact_mut((width * channels).max(1)).enumerate() {
                for x in (0..width).step_by(STEM_TILE / 2) {
                    let mut largest = [start; STEM_TILE / 2];
                    for below in 0..2 {
                        let at = (2 * y + below) * stride * row + 2 * x * step;
                        let words = words.get(at..).unwrap_or(&[]);
                        let shape = (step, step);
                        let sums = tile::<L, STEM_TILE>(lanes, start, &group, shape, words, row);
                        let Some(sums) = sums else { return };
                        for k in 0..STEM_TILE / 2 {
                            let pair = lanes.max(sums[2 * k], sums[2 * k + 1]);
                            largest[k] = if below == 0 { pair } else { lanes.max(largest[k], pair) };
                        }
                    }
                    let values = finish(lanes, layer, group.rescale, largest);
                    put(&values, first, channels, out, x);
                }
            }
        }
    }
}
