//! 3x3 convolutions and their gradients by Winograd's F(4x4, 3x3): 36 products for 16 pixels instead of 144.
//!
//! `Y = A'[(G g G') . (B' d B)]A` for tiles of 4x4 pixels, each from a patch of 6x6 (Lavin and Gray, 2016); the gradient of the
//! kernel is `G'[(B' d B) . (A dY A')]G`, that of the input is the convolution with the mirrored kernel.
//! In single precision the result differs from the direct sum by about 1e-5 of its largest value.

use super::layout::{Aligned, Geometry, Padded, TILE};
use super::products::{accumulate, multiply};
use pulp::{Arch, Simd, WithSimd};
use std::ops::Range;

/// Pixels of a patch's side.
pub const PATCH: usize = 6;
/// Products of a tile, channel by channel.
pub const POINTS: usize = PATCH * PATCH;
/// Tiles that are transformed together: what stays in the processor's first caches.
const STRIP: usize = 16;
/// The default number of channels, for which the compiler sees a constant.
const DEFAULT_CHANNELS: usize = 16;

/// A transform in one dimension, of pixels or of points.
trait Transform<const N: usize, const M: usize> {
    fn apply<S: Simd>(simd: S, from: [S::f32s; N]) -> [S::f32s; M];
}

/// `B'd`: pixels of a patch to points.
struct Patch;
/// `A y`: a tile's gradient to points.
struct Gradient;
/// `A'm`: points to pixels of a tile.
struct Tile;

impl Transform<PATCH, PATCH> for Patch {
    #[inline(always)]
    fn apply<S: Simd>(simd: S, d: [S::f32s; PATCH]) -> [S::f32s; PATCH] {
        let (two, four) = (simd.splat_f32s(2.0), simd.splat_f32s(4.0));
        let (minus_four, minus_five) = (simd.splat_f32s(-4.0), simd.splat_f32s(-5.0));
        let even = simd.mul_add_f32s(minus_four, d[2], d[4]);
        let odd = simd.mul_add_f32s(minus_four, d[1], d[3]);
        let (outer, inner) = (simd.sub_f32s(d[4], d[2]), simd.mul_f32s(two, simd.sub_f32s(d[3], d[1])));
        [
            simd.mul_add_f32s(four, d[0], simd.mul_add_f32s(minus_five, d[2], d[4])),
            simd.add_f32s(even, odd),
            simd.sub_f32s(even, odd),
            simd.add_f32s(outer, inner),
            simd.sub_f32s(outer, inner),
            simd.mul_add_f32s(four, d[1], simd.mul_add_f32s(minus_five, d[3], d[5])),
        ]
    }
}

impl Transform<TILE, PATCH> for Gradient {
    #[inline(always)]
    fn apply<S: Simd>(simd: S, y: [S::f32s; TILE]) -> [S::f32s; PATCH] {
        let (two, four) = (simd.splat_f32s(2.0), simd.splat_f32s(4.0));
        let (even, odd) = (simd.add_f32s(y[0], y[2]), simd.add_f32s(y[1], y[3]));
        let even2 = simd.mul_add_f32s(four, y[2], y[0]);
        let odd2 = simd.mul_f32s(two, simd.mul_add_f32s(four, y[3], y[1]));
        [
            y[0],
            simd.add_f32s(even, odd),
            simd.sub_f32s(even, odd),
            simd.add_f32s(even2, odd2),
            simd.sub_f32s(even2, odd2),
            y[3],
        ]
    }
}

impl Transform<PATCH, TILE> for Tile {
    #[inline(always)]
    fn apply<S: Simd>(simd: S, m: [S::f32s; PATCH]) -> [S::f32s; TILE] {
        let [two, four, eight] = [simd.splat_f32s(2.0), simd.splat_f32s(4.0), simd.splat_f32s(8.0)];
        let (even, odd) = (simd.add_f32s(m[1], m[2]), simd.sub_f32s(m[1], m[2]));
        let (even2, odd2) = (simd.add_f32s(m[3], m[4]), simd.sub_f32s(m[3], m[4]));
        [
            simd.add_f32s(m[0], simd.add_f32s(even, even2)),
            simd.mul_add_f32s(two, odd2, odd),
            simd.mul_add_f32s(four, even2, even),
            simd.add_f32s(simd.mul_add_f32s(eight, odd2, odd), m[5]),
        ]
    }
}

/// What a thread needs to convolve an image.
#[derive(Debug)]
pub struct Winograd {
    geometry: Geometry,
    arch: Arch,
    /// Transformed input, transformed gradient and products, `[point][tile of the strip][channel]`.
    input: Aligned,
    gradient: Aligned,
    products: Aligned,
}

/// Values from one point to the next: a strip's and a cache line, so that not all points lie in one set of the cache.
const fn point(channels: usize) -> usize {
    STRIP * channels + 16
}

impl Winograd {
    pub fn new(geometry: Geometry, arch: Arch) -> Winograd {
        let points = || Aligned::new(POINTS * point(geometry.channels));
        Winograd { geometry, arch, input: points(), gradient: points(), products: points() }
    }

    /// The convolution `y` of `x`, with kernels of [`super::kernels::forward_kernels`].
    pub fn convolve(&mut self, x: &Padded, kernels: &[f32], y: &mut [f32]) {
        let arch = self.arch;
        arch.dispatch(Convolve { pass: self, x, kernels, y });
    }

    /// For the gradient `g` of the convolution's output: adds that of the kernels, and sets `y`, that of the input `x`, with
    /// kernels of [`super::kernels::backward_kernels`].
    pub fn gradients(&mut self, x: &Padded, g: &Padded, kernels: &[f32], sums: &mut [f32], y: &mut [f32]) {
        let arch = self.arch;
        arch.dispatch(Gradients { pass: self, x, g, kernels, sums, y });
    }

    fn strips(&self) -> impl Iterator<Item = Range<usize>> + use<> {
        let tiles: usize = self.geometry.tiles().iter().product();
        (0..tiles).step_by(STRIP).map(move |first| first..tiles.min(first + STRIP))
    }
}

/// Products of a strip of transformed tiles with kernels, point by point.
#[inline(always)]
fn multiply_points<S: Simd>(simd: S, c: usize, tiles: usize, from: &[f32], kernels: &[f32], to: &mut [f32]) {
    let points = from.chunks_exact(point(c)).zip(to.chunks_exact_mut(point(c)));
    for ((from, to), kernels) in points.zip(kernels.chunks_exact(c * c)) {
        multiply(simd, &from[..tiles * c], kernels, c, &mut to[..tiles * c]);
    }
}

/// Transforms N x N pixels of every tile of a strip to its points.
#[inline(always)]
fn input_transform<S: Simd, T: Transform<N, PATCH>, const N: usize>(
    simd: S,
    (geometry, strip): (&Geometry, Range<usize>),
    image: &Padded,
    points: &mut [f32],
) {
    let (vectors, row) = (geometry.channels / S::F32_LANES, geometry.padded_row() / S::F32_LANES);
    let [_, columns] = geometry.tiles();
    let (x, points) = (S::as_simd_f32s(image.values()).0, S::as_mut_simd_f32s(points).0);
    let (point, border) = (point(geometry.channels) / S::F32_LANES, (PATCH - N) / 2);
    for (index, at) in strip.enumerate() {
        let start = (at / columns * TILE + border) * row + (at % columns * TILE + border) * vectors;
        for v in 0..vectors {
            let from = &x[start + v..][..(N - 1) * (row + vectors) + 1];
            let mut rows = [[simd.splat_f32s(0.0); N]; PATCH];
            for k in 0..N {
                let mut column = [simd.splat_f32s(0.0); N];
                for r in 0..N {
                    column[r] = from[r * row + k * vectors];
                }
                let column = T::apply(simd, column);
                for p in 0..PATCH {
                    rows[p][k] = column[p];
                }
            }
            let to = &mut points[index * vectors + v..][..(POINTS - 1) * point + 1];
            for (p, values) in rows.into_iter().enumerate() {
                for (q, value) in T::apply(simd, values).into_iter().enumerate() {
                    to[(p * PATCH + q) * point] = value;
                }
            }
        }
    }
}

/// Transforms the products of a strip to pixels of `y`.
#[inline(always)]
fn output_transform<S: Simd>(
    simd: S,
    (geometry, strip): (&Geometry, Range<usize>),
    points: &[f32],
    y: &mut [f32],
) {
    let (vectors, row) = (geometry.channels / S::F32_LANES, geometry.row() / S::F32_LANES);
    let [_, columns] = geometry.tiles();
    let (points, y) = (S::as_simd_f32s(points).0, S::as_mut_simd_f32s(y).0);
    let point = point(geometry.channels) / S::F32_LANES;
    for (index, at) in strip.enumerate() {
        let [top, left] = [at / columns * TILE, at % columns * TILE];
        let [height, width] = [geometry.height - top, geometry.width - left].map(|left| left.min(TILE));
        for v in 0..vectors {
            let from = &points[index * vectors + v..][..(POINTS - 1) * point + 1];
            let mut rows = [[simd.splat_f32s(0.0); PATCH]; TILE];
            for q in 0..PATCH {
                let mut column = [simd.splat_f32s(0.0); PATCH];
                for p in 0..PATCH {
                    column[p] = from[(p * PATCH + q) * point];
                }
                let column = Tile::apply(simd, column);
                for r in 0..TILE {
                    rows[r][q] = column[r];
                }
            }
            for (r, values) in rows.into_iter().enumerate() {
                if r < height {
                    let pixels = Tile::apply(simd, values);
                    let to = &mut y[(top + r) * row + left * vectors + v..][..(width - 1) * vectors + 1];
                    for (k, value) in pixels.into_iter().enumerate() {
                        if k < width {
                            to[k * vectors] = value;
                        }
                    }
                }
            }
        }
    }
}

struct Convolve<'a> {
    pass: &'a mut Winograd,
    x: &'a Padded,
    kernels: &'a [f32],
    y: &'a mut [f32],
}

impl WithSimd for Convolve<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        match self.pass.geometry.channels {
            DEFAULT_CHANNELS => self.run(simd, DEFAULT_CHANNELS),
            channels => self.run(simd, channels),
        }
    }
}

impl Convolve<'_> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S, channels: usize) {
        let Convolve { pass, x, kernels, y } = self;
        let geometry = Geometry { channels, ..pass.geometry };
        for strip in pass.strips() {
            let at = (&geometry, strip.clone());
            input_transform::<S, Patch, PATCH>(simd, at.clone(), x, &mut pass.input);
            multiply_points(simd, channels, strip.len(), &pass.input, kernels, &mut pass.products);
            output_transform(simd, at, &pass.products, y);
        }
    }
}

struct Gradients<'a> {
    pass: &'a mut Winograd,
    x: &'a Padded,
    g: &'a Padded,
    kernels: &'a [f32],
    sums: &'a mut [f32],
    y: &'a mut [f32],
}

impl WithSimd for Gradients<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        match self.pass.geometry.channels {
            DEFAULT_CHANNELS => self.run(simd, DEFAULT_CHANNELS),
            channels => self.run(simd, channels),
        }
    }
}

impl Gradients<'_> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S, c: usize) {
        let Gradients { pass, x, g, kernels, sums, y } = self;
        let geometry = Geometry { channels: c, ..pass.geometry };
        for strip in pass.strips() {
            let at = (&geometry, strip.clone());
            let values = strip.len() * c;
            input_transform::<S, Patch, PATCH>(simd, at.clone(), x, &mut pass.input);
            input_transform::<S, Gradient, TILE>(simd, at.clone(), g, &mut pass.gradient);
            let points = pass.input.chunks_exact(point(c)).zip(pass.gradient.chunks_exact(point(c)));
            for ((x, g), sums) in points.zip(sums.chunks_exact_mut(c * c)) {
                accumulate(simd, &x[..values], &g[..values], c, sums);
            }
            input_transform::<S, Patch, PATCH>(simd, at.clone(), g, &mut pass.gradient);
            multiply_points(simd, c, strip.len(), &pass.gradient, kernels, &mut pass.products);
            output_transform(simd, at, &pass.products, y);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::kernels::{backward_kernels, forward_kernels, kernel_gradients, transformed};
    use super::super::tests::{every_arch, numbers};
    use super::*;

    /// An image as whole tiles with zeros all round.
    fn padded(geometry: Geometry, image: &[f32]) -> Padded {
        let mut padded = Padded::new(geometry);
        for (r, row) in image.chunks_exact(geometry.row()).enumerate() {
            padded.values_mut()[(r + 1) * geometry.padded_row() + geometry.channels..][..row.len()]
                .copy_from_slice(row);
        }
        padded
    }

    /// Calls `each` with every tap of every pixel inside the image: position in the input, in the output, and tap.
    fn taps(g: &Geometry, mut each: impl FnMut(usize, usize, usize)) {
        for (r, c, tap) in (0..g.height).flat_map(|r| (0..9 * g.width).map(move |n| (r, n / 9, n % 9))) {
            let (y, x) = ((r + tap / 3).wrapping_sub(1), (c + tap % 3).wrapping_sub(1));
            if y < g.height && x < g.width {
                each((y * g.width + x) * g.channels, (r * g.width + c) * g.channels, tap);
            }
        }
    }

    #[test]
    fn they_are_the_direct_sums_and_the_same_bits_on_every_instruction_set() {
        for (channels, height, width) in [(8, 8, 8), (16, 16, 16), (16, 7, 9), (24, 5, 33), (32, 1, 2)] {
            let geometry = Geometry { channels, height, width };
            let (c, image) = (channels, geometry.image());
            let (x, g, kernels) = (numbers(image, 1), numbers(image, 2), numbers(9 * c * c, 3));
            let mut direct = [vec![0.0f64; image], vec![0.0f64; image], vec![0.0f64; 9 * c * c]];
            taps(&geometry, |from, to, tap| {
                for (o, i) in (0..c).flat_map(|o| (0..c).map(move |i| (o, i))) {
                    let kernel = (o * c + i) * 9 + tap;
                    let [k, x, g] = [kernels[kernel], x[from + i], g[to + o]].map(f64::from);
                    direct[0][to + o] += k * x;
                    direct[1][from + i] += k * g;
                    direct[2][kernel] += x * g;
                }
            });
            let (forward, mirrored) = (forward_kernels(&kernels, c), backward_kernels(&kernels, c));
            let mut first: Option<[Vec<f32>; 3]> = None;
            for arch in every_arch(channels) {
                let mut pass = Winograd::new(geometry, arch);
                let (mut y, mut back) = (vec![f32::NAN; image], vec![f32::NAN; image]);
                let mut sums = vec![0.0; transformed(c)];
                let (x, g) = (padded(geometry, &x), padded(geometry, &g));
                pass.convolve(&x, &forward, &mut y);
                pass.gradients(&x, &g, &mirrored, &mut sums, &mut back);
                let found = [y, back, kernel_gradients([&sums[..]].into_iter(), c)];
                for (found, direct) in found.iter().zip(&direct) {
                    let largest = direct.iter().fold(0.0f64, |m, v| m.max(v.abs()));
                    for (&found, direct) in found.iter().zip(direct) {
                        assert!((f64::from(found) - direct).abs() < 1e-5 * largest, "{found} {direct}");
                    }
                }
                assert_eq!(first.get_or_insert(found.clone()), &found);
            }
        }
    }
}
