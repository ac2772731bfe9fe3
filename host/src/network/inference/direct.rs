//! 3x3 convolutions on vectors: sixteen outputs in the lanes, a row of pixels in registers.
//!
//! The input is first rewritten as words of two or four inputs, with a border of its zero point: then no pixel is
//! special, and a row of the kernel is one run of successive words. Cost: 9 inputs / 2 or 9 inputs / 4 vector products
//! a pixel and sixteen outputs.

use super::layer::{Convolution, OutputGroup, requantize, reserve, store};
use super::simd::{LANES, SimdI32};

/// Sums of `P` successive pixels: three runs of `run` words, `row` words apart; a pixel is `step` words.
#[inline(always)]
pub fn tile<S: SimdI32, const P: usize>(
    simd: S,
    start: S::I32,
    group: &OutputGroup,
    (run, step): (usize, usize),
    words: &[i32],
    row: usize,
) -> [S::I32; P] {
    let mut sums = [start; P];
    for ky in 0..3 {
        let words = &words[ky * row..][..(P - 1) * step + run];
        let weights = &group.weights[ky * run..][..run];
        for k in 0..run {
            let w = simd.load(&weights[k]);
            for p in 0..P {
                sums[p] = simd.dot(sums[p], words[p * step + k], w);
            }
        }
    }
    sums
}

impl Convolution<'_> {
    #[inline(always)]
    fn rows<S: SimdI32, const CHANNEL_GROUPS: usize, const P: usize>(mut self, simd: S) {
        let step = CHANNEL_GROUPS * (4 / S::INPUTS);
        let (height, width) = self.size;
        let columns = width.next_multiple_of(P) + 2;
        let row = columns * step;
        reserve(self.words, (height + 2) * row);
        self.pad_input(simd, step, (height + 2, columns));
        let (quant, words) = (&self.layer.quant, &self.words[..]);
        let channels = quant.channels;
        for (group, first) in self.groups.iter().zip((0..).step_by(LANES)) {
            let start = simd.load(&group.start);
            let rows = self.output.chunks_exact_mut(width * channels);
            for (y, out) in rows.take(height).enumerate() {
                for x in (0..width).step_by(P) {
                    let words = &words[y * row + x * step..];
                    let sums = tile::<S, P>(simd, start, group, (3 * step, step), words, row);
                    let (fours, _) = sums.as_chunks::<4>();
                    for (k, &four) in fours.iter().enumerate().take_while(|(k, _)| x + 4 * k < width) {
                        let values = requantize(simd, quant, &group.requantizer, four);
                        store(&values, first, channels, out, x + 4 * k);
                    }
                }
            }
        }
    }

    /// The convolution, for four times `CHANNEL_GROUPS` inputs.
    #[inline(always)]
    pub fn direct<S: SimdI32, const CHANNEL_GROUPS: usize>(self, simd: S) {
        match S::TILE {
            4 => self.rows::<S, CHANNEL_GROUPS, 4>(simd),
            _ => self.rows::<S, CHANNEL_GROUPS, 16>(simd),
        }
    }
}
