//! The input convolution with its pooling on vectors.

use super::layer::{OutputGroup, border_word, finish, reserve};
use super::simd::{Kernel, SimdI32};
use sdp3_core::dsn::conv::{Conv, pad_before, same};
use std::array::from_fn;

/// The input convolution with its 2x2 maximum: `[height, width]` to `[pooled height, pooled width, outputs]`.
///
/// Requantisation never falls where its argument rises, so the maximum is taken before it, of the sums.
pub struct Stem<'a> {
    pub layer: &'a Conv<'a>,
    pub groups: &'a [OutputGroup],
    pub words: &'a mut Vec<i32>,
    pub bytes: &'a mut Vec<[u8; 4]>,
    pub image: &'a [i8],
    pub size: (usize, usize),
    pub output: &'a mut [i8],
}

/// Pixels of the stem in one tile: four after pooling.
const STEM_TILE: usize = 8;

/// Values ahead of an image's row, so that it begins with a whole word.
const MARGIN: usize = 4;

/// The four values from each pixel's first tap on, in words of `PER_PIXEL` to four values, which lie across those of the row.
#[inline(always)]
fn taps<const STRIDE: usize, const PER_PIXEL: usize>(row: &[u8]) -> [[i32; PER_PIXEL]; STEM_TILE] {
    let row = &row[..((STEM_TILE - 1) * STRIDE + 4) * PER_PIXEL];
    from_fn(|p| {
        let (words, _) = row[p * STRIDE * PER_PIXEL..].as_chunks();
        from_fn(|k| i32::from_le_bytes(words[k]))
    })
}

impl Stem<'_> {
    /// Rewrites each image row as words, between borders of its zero point, and those as bytes; returns the bytes of a row.
    #[inline(always)]
    fn pad_input<S: SimdI32>(&mut self, simd: S) -> usize {
        let (height, width) = self.size;
        let (zero, stride) = (self.layer.quant.in_zp, self.layer.stride);
        let (above, columns) = (pad_before(height, stride), same(width, stride));
        let border = border_word(simd, zero);
        let row = (MARGIN + columns.next_multiple_of(STEM_TILE) * stride + 4) / S::INPUTS;
        let count = (same(height, stride) - 1) * stride + 3;
        reserve(self.words, row);
        let words = &mut self.words[..row];
        words.fill(border);
        reserve(self.bytes, count * row);
        for (y, bytes) in self.bytes.chunks_exact_mut(row).take(count).enumerate() {
            match y.checked_sub(above).filter(|&y| y < height) {
                Some(y) => {
                    let (whole, rest) = self.image[y * width..][..width].as_chunks::<4>();
                    let (inside, end) = words[MARGIN / S::INPUTS..].split_at_mut(whole.len() * 4 / S::INPUTS);
                    simd.input_words(whole.as_flattened(), inside);
                    if !rest.is_empty() {
                        let mut last = [zero; 4];
                        last[..rest.len()].copy_from_slice(rest);
                        simd.input_words(&last, &mut end[..4 / S::INPUTS]);
                    }
                }
                None => words.fill(border),
            }
            for (bytes, word) in bytes.iter_mut().zip(&*words) {
                *bytes = word.to_le_bytes();
            }
        }
        4 * row
    }

    #[inline(always)]
    fn pooled<S: SimdI32, const STRIDE: usize, const PER_PIXEL: usize>(mut self, simd: S) {
        let row = self.pad_input(simd);
        let quant = &self.layer.quant;
        let bytes = self.bytes.as_flattened();
        let width = same(self.size.1, STRIDE) / 2;
        let before = pad_before(self.size.1, STRIDE);
        for group in self.groups {
            let start = simd.load(&group.start);
            let (weights, _) = group.weights.as_chunks::<PER_PIXEL>();
            for (y, out) in self.output.chunks_exact_mut(width * quant.channels).enumerate() {
                let row =
                    |ky: usize| &bytes[(2 * y * STRIDE + ky) * row..][(MARGIN - before) * PER_PIXEL..row];
                let rows: [[_; 3]; 2] = from_fn(|below| from_fn(|ky| row(below * STRIDE + ky)));
                for x in (0..width).step_by(STEM_TILE / 2) {
                    let mut largest = [start; STEM_TILE / 2];
                    for below in 0..2 {
                        let mut sums = [start; STEM_TILE];
                        for (row, weights) in rows[below].into_iter().zip(weights) {
                            let taps = taps::<STRIDE, PER_PIXEL>(&row[2 * x * STRIDE * PER_PIXEL..]);
                            for k in 0..PER_PIXEL {
                                let w = simd.load(&weights[k]);
                                for p in 0..STEM_TILE {
                                    sums[p] = simd.dot(sums[p], taps[p][k], w);
                                }
                            }
                        }
                        for k in 0..STEM_TILE / 2 {
                            let pair = simd.max(sums[2 * k], sums[2 * k + 1]);
                            largest[k] = if below == 0 { pair } else { simd.max(largest[k], pair) };
                        }
                    }
                    finish(simd, quant, group, largest, out, x);
                }
            }
        }
    }
}

impl Kernel for Stem<'_> {
    #[inline(always)]
    fn run<S: SimdI32>(self, simd: S) {
        match (self.layer.stride, S::INPUTS) {
            (1, 4) => self.pooled::<S, 1, 1>(simd),
            (1, _) => self.pooled::<S, 1, 2>(simd),
            (_, 4) => self.pooled::<S, 2, 1>(simd),
            _ => self.pooled::<S, 2, 2>(simd),
        }
    }
}
