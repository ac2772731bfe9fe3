//! The input convolution with its pooling, as the maximum of four convolutions, and its gradient.
//!
//! Pixel (r, c) of the pooled image is the maximum of the convolution at (2r, 2c), (2r, 2c+1), (2r+1, 2c), (2r+1, 2c+1):
//! its four phases. Which of them it was is not stored: the backward pass computes them again.

use super::Shape;
use super::layout::Geometry;
use crate::network::float_network::same_padding;
use pulp::{Arch, Simd, WithSimd};

/// What a thread needs for an image.
#[derive(Debug)]
pub struct Stem {
    arch: Arch,
    geometry: Geometry,
    stride: usize,
    pads: [usize; 2],
    size: [usize; 2],
    /// The image with zeros all round, and the length of a row.
    image: Vec<f32>,
    row: usize,
}

/// Taps of the kernel.
const TAPS: usize = 9;

impl Stem {
    /// For images of a shape.
    pub fn new(shape: &Shape, arch: Arch) -> Stem {
        let (geometry, stride) = (shape.geometry(), shape.stem_stride);
        let size = [shape.rows, shape.frames];
        let pads = size.map(|size| same_padding(size, stride).1);
        let [height, row] = size.map(|size| size + 2 * stride + 4);
        let image = vec![0.0; height * row];
        Stem { arch, geometry, stride, pads, size, image, row }
    }

    fn load(&mut self, image: &[f32]) {
        for (r, values) in image.chunks_exact(self.size[1]).enumerate() {
            self.image[(r + self.pads[0]) * self.row + self.pads[1]..][..self.size[1]]
                .copy_from_slice(values);
        }
    }

    /// The taps of the four phases of a pooled pixel.
    #[inline(always)]
    fn taps(&self, r: usize, c: usize) -> [[f32; TAPS]; 4] {
        let start = 2 * self.stride * (r * self.row + c);
        let mut taps = [[0.0; TAPS]; 4];
        for (phase, taps) in taps.iter_mut().enumerate() {
            let start = start + (phase / 2 * self.row + phase % 2) * self.stride;
            for (y, taps) in taps.chunks_exact_mut(3).enumerate() {
                taps.copy_from_slice(&self.image[start + y * self.row..][..3]);
            }
        }
        taps
    }

    /// Pooled image `x`, `[pixel][C]`; `weights` are `[9][C]`.
    pub fn forward(&mut self, image: &[f32], weights: &[f32], bias: &[f32], x: &mut [f32]) {
        self.load(image);
        self.arch.dispatch(Forward { stem: self, weights, bias, x });
    }

    /// Adds the gradient of the weights, `[9][C]`, for the gradient `g` of the pooled image.
    pub fn backward(&mut self, image: &[f32], weights: &[f32], bias: &[f32], g: &[f32], total: &mut [f32]) {
        self.load(image);
        let arch = self.arch;
        arch.dispatch(Backward { stem: self, weights, bias, g, total });
    }
}

/// The four phases of some channels of a pixel.
#[inline(always)]
fn phases<S: Simd>(
    simd: S,
    taps: &[[f32; TAPS]; 4],
    weights: &[S::f32s; TAPS],
    bias: S::f32s,
) -> [S::f32s; 4] {
    let mut sums = [bias; 4];
    for (sum, taps) in sums.iter_mut().zip(taps) {
        for (&tap, &weight) in taps.iter().zip(weights) {
            *sum = simd.mul_add_f32s(simd.splat_f32s(tap), weight, *sum);
        }
    }
    sums
}

/// The larger of two, the first of equals, and whether it is the second.
#[inline(always)]
fn larger<S: Simd>(simd: S, a: S::f32s, b: S::f32s) -> (S::f32s, S::m32s) {
    let second = simd.less_than_f32s(a, b);
    (simd.select_f32s(second, b, a), second)
}

#[inline(always)]
fn column<S: Simd>(simd: S, weights: &[f32], v: usize, vectors: usize) -> [S::f32s; TAPS] {
    let mut column = [simd.splat_f32s(0.0); TAPS];
    for (to, from) in column.iter_mut().zip(S::as_simd_f32s(weights).0.chunks_exact(vectors)) {
        *to = from[v];
    }
    column
}

struct Forward<'a> {
    stem: &'a Stem,
    weights: &'a [f32],
    bias: &'a [f32],
    x: &'a mut [f32],
}

impl WithSimd for Forward<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let geometry = self.stem.geometry;
        let vectors = geometry.channels / S::F32_LANES;
        let x = S::as_mut_simd_f32s(self.x).0;
        for v in 0..vectors {
            let weights = column::<S>(simd, self.weights, v, vectors);
            let bias = S::as_simd_f32s(self.bias).0[v];
            for (r, row) in x.chunks_exact_mut(geometry.width * vectors).enumerate() {
                for c in 0..geometry.width {
                    let [a, b, p, q] = phases::<S>(simd, &self.stem.taps(r, c), &weights, bias);
                    let (top, low) = (larger::<S>(simd, a, b).0, larger::<S>(simd, p, q).0);
                    row[c * vectors + v] = larger::<S>(simd, top, low).0;
                }
            }
        }
    }
}

struct Backward<'a> {
    stem: &'a mut Stem,
    weights: &'a [f32],
    bias: &'a [f32],
    g: &'a [f32],
    total: &'a mut [f32],
}

impl WithSimd for Backward<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Backward { stem, weights, bias, g, total } = self;
        let geometry = stem.geometry;
        let vectors = geometry.channels / S::F32_LANES;
        let (g, zero) = (S::as_simd_f32s(g).0, simd.splat_f32s(0.0));
        let total = S::as_mut_simd_f32s(total).0;
        for v in 0..vectors {
            let weights = column::<S>(simd, weights, v, vectors);
            let bias = S::as_simd_f32s(bias).0[v];
            for (r, row) in g.chunks_exact(geometry.width * vectors).enumerate() {
                let mut sums = [zero; TAPS];
                for c in 0..geometry.width {
                    let taps = stem.taps(r, c);
                    let [a, b, p, q] = phases::<S>(simd, &taps, &weights, bias);
                    let ((top, second), (low, fourth)) = (larger::<S>(simd, a, b), larger::<S>(simd, p, q));
                    let (_, lower) = larger::<S>(simd, top, low);
                    let g = row[c * vectors + v];
                    let (top_g, low_g) = (simd.select_f32s(lower, zero, g), simd.select_f32s(lower, g, zero));
                    let chosen = [
                        simd.select_f32s(second, zero, top_g),
                        simd.select_f32s(second, top_g, zero),
                        simd.select_f32s(fourth, zero, low_g),
                        simd.select_f32s(fourth, low_g, zero),
                    ];
                    for (taps, g) in taps.iter().zip(chosen) {
                        for (sum, &tap) in sums.iter_mut().zip(taps) {
                            *sum = simd.mul_add_f32s(simd.splat_f32s(tap), g, *sum);
                        }
                    }
                }
                for (tap, sum) in sums.into_iter().enumerate() {
                    let total = &mut total[tap * vectors + v];
                    *total = simd.add_f32s(*total, sum);
                }
            }
        }
    }
}
