//! The input convolution with its pooling on vectors.

use super::direct::tile;
use super::layer::{OutputGroup, requantize, reserve, store};
use super::simd::{Kernel, LANES, SimdI32};
use sdp3_core::dsn::conv::{Conv, pad_before, same};

/// The input convolution with its 2x2 maximum: `[height, width]` to `[pooled height, pooled width, outputs]`.
///
/// Requantisation never falls where its argument rises, so the maximum is taken before it, of the sums.
pub struct Stem<'a> {
    pub layer: &'a Conv<'a>,
    pub groups: &'a [OutputGroup],
    pub words: &'a mut Vec<i32>,
    pub image: &'a [i8],
    pub size: (usize, usize),
    pub output: &'a mut [i8],
}

/// Pixels of the stem in one tile: four after pooling.
const STEM_TILE: usize = 8;

impl Stem<'_> {
    /// Rewrites each image row as words of the four values from each output's first tap; returns the words of a row.
    #[inline(always)]
    fn pad_input<S: SimdI32>(&mut self, simd: S) -> usize {
        let (height, width) = self.size;
        let stride = self.layer.stride;
        let (rows, columns) = (same(height, stride), same(width, stride));
        let (above, before) = (pad_before(height, stride), pad_before(width, stride));
        let zero = self.layer.quant.in_zp;
        let per_pixel = 4 / S::INPUTS;
        let row = columns.next_multiple_of(STEM_TILE) * per_pixel;
        let count = (rows - 1) * stride + 3;
        reserve(self.words, count * row);
        for (y, words) in self.words.chunks_exact_mut(row).take(count).enumerate() {
            let line = y.checked_sub(above).filter(|&y| y < height);
            let line = line.map_or(&[][..], |y| &self.image[y * width..][..width]);
            for (x, words) in words.chunks_exact_mut(per_pixel).enumerate() {
                let at = (x * stride).wrapping_sub(before);
                let four = match line.get(at..).and_then(|rest| rest.first_chunk()) {
                    Some(four) => *four,
                    None => [0, 1, 2, 3].map(|k| line.get(at.wrapping_add(k)).copied().unwrap_or(zero)),
                };
                simd.input_words(&four, words);
            }
        }
        row
    }
}

impl Kernel for Stem<'_> {
    #[inline(always)]
    fn run<S: SimdI32>(mut self, simd: S) {
        let row = self.pad_input(simd);
        let (quant, stride, words) = (&self.layer.quant, self.layer.stride, &self.words[..]);
        let channels = quant.channels;
        let width = same(self.size.1, stride) / 2;
        let step = 4 / S::INPUTS;
        for (group, first) in self.groups.iter().zip((0..).step_by(LANES)) {
            let start = simd.load(&group.start);
            for (y, out) in self.output.chunks_exact_mut(width * channels).enumerate() {
                for x in (0..width).step_by(STEM_TILE / 2) {
                    let mut largest = [start; STEM_TILE / 2];
                    for below in 0..2 {
                        let words = &words[(2 * y + below) * stride * row + 2 * x * step..];
                        let sums = tile::<S, STEM_TILE>(simd, start, group, (step, step), words, row);
                        for k in 0..STEM_TILE / 2 {
                            let pair = simd.max(sums[2 * k], sums[2 * k + 1]);
                            largest[k] = if below == 0 { pair } else { simd.max(largest[k], pair) };
                        }
                    }
                    let values = requantize(simd, quant, &group.requantizer, largest);
                    store(&values, first, channels, out, x);
                }
            }
        }
    }
}
