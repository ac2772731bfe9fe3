//! 3x3 convolutions on vectors: sixteen outputs in the lanes, a row of pixels in registers.
//!
//! The input is first rewritten as words of two or four inputs, with a border of its zero point: then no pixel is
//! special. Cost: 9 inputs / 2 or 9 inputs / 4 vector products a pixel and sixteen outputs, and a word is read once for the three
//! columns of the kernel.

use super::layer::{Convolution, finish, reserve};
use super::simd::{I32x16, SimdI32};

/// Sums of `P` successive pixels, of three rows of pixels of `STEP` words. Eight pixels at a time, column by column of the kernel: ten words
/// fit in registers beside sixteen sums, and successive products do not wait for each other.
#[inline(always)]
fn tile<S: SimdI32, const STEP: usize, const P: usize>(
    simd: S,
    start: S::I32,
    weights: &[[I32x16; STEP]],
    rows: [&[[i32; STEP]]; 3],
) -> [S::I32; P] {
    let mut sums = [start; P];
    for (row, weights) in rows.into_iter().zip(weights.as_chunks::<3>().0) {
        let row = &row[..P + 2];
        for k in 0..STEP {
            let w = [simd.load(&weights[0][k]), simd.load(&weights[1][k]), simd.load(&weights[2][k])];
            for eight in (0..P).step_by(8) {
                for kx in 0..3 {
                    for p in eight..(eight + 8).min(P) {
                        sums[p] = simd.dot(sums[p], row[p + kx][k], w[kx]);
                    }
                }
            }
        }
    }
    sums
}

impl Convolution<'_> {
    #[inline(always)]
    fn rows<S: SimdI32, const STEP: usize, const P: usize>(mut self, simd: S) {
        let (height, width) = self.size;
        let columns = width.next_multiple_of(P) + 2;
        reserve(self.words, (height + 2) * columns * STEP);
        self.pad_input(simd, STEP, (height + 2, columns));
        let (pixels, _) = self.words.as_chunks::<STEP>();
        let quant = &self.layer.quant;
        let channels = quant.channels;
        for group in self.groups {
            let start = simd.load(&group.start);
            let (weights, _) = group.weights.as_chunks::<STEP>();
            let rows = self.output.chunks_exact_mut(width * channels);
            for (y, out) in rows.take(height).enumerate() {
                for x in (0..width).step_by(P) {
                    let row = |ky: usize| &pixels[(y + ky) * columns + x..];
                    let sums = tile::<S, STEP, P>(simd, start, weights, [row(0), row(1), row(2)]);
                    let (fours, _) = sums.as_chunks::<4>();
                    // by hand: the compiler leaves a loop, with the sums in memory
                    finish(simd, quant, group, fours[0], out, x);
                    if P == 16 {
                        finish(simd, quant, group, fours[1], out, x + 4);
                        finish(simd, quant, group, fours[2], out, x + 8);
                        finish(simd, quant, group, fours[3], out, x + 12);
                    }
                }
            }
        }
    }

    /// The convolution, for pixels of `STEP` words.
    #[inline(always)]
    pub fn direct<S: SimdI32, const STEP: usize>(self, simd: S) {
        match S::TILE {
            4 => self.rows::<S, STEP, 4>(simd),
            _ => self.rows::<S, STEP, 16>(simd),
        }
    }
}
