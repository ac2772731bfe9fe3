//! What happens to every pixel between two convolutions: normalisation, ReLU, their gradients, and sums per channel.
//!
//! Every channel is a lane of its own: a row is summed in four interleaved parts, and the rows in their order. The same bits on
//! every processor.

use super::layout::{Geometry, Padded};
use pulp::{Arch, Simd, WithSimd};

/// Two sums over the pixels of a channel.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Sums(pub f64, pub f64);

impl std::ops::AddAssign for Sums {
    fn add_assign(&mut self, other: Sums) {
        self.0 += other.0;
        self.1 += other.1;
    }
}

/// Offsets of some channels of a pixel, in vectors.
#[derive(Clone, Copy)]
struct Offsets {
    /// In an image.
    image: usize,
    /// In a [`Padded`] image.
    padded: usize,
    /// In values by channel.
    channel: usize,
}

/// Calls `at` for all channels of all pixels, and adds up the two values that it gives, channel by channel.
#[inline(always)]
fn summed<S: Simd>(
    simd: S,
    geometry: &Geometry,
    sums: &mut [Sums],
    mut at: impl FnMut(Offsets) -> [S::f32s; 2],
) {
    const PARTS: usize = 4;
    let vectors = geometry.channels / S::F32_LANES;
    let [row, padded_row] = [geometry.row(), geometry.padded_row()].map(|values| values / S::F32_LANES);
    let zero = [simd.splat_f32s(0.0); 2];
    for (channel, sums) in sums.chunks_exact_mut(S::F32_LANES).enumerate() {
        let mut total = zero;
        for r in 0..geometry.height {
            let (image, padded) = (r * row + channel, (r + 1) * padded_row + vectors + channel);
            let mut parts = [zero; PARTS];
            let mut first = 0;
            while first < geometry.width {
                for (n, part) in parts.iter_mut().enumerate() {
                    let pixel = first + n;
                    if pixel < geometry.width {
                        let step = pixel * vectors;
                        let found = at(Offsets { image: image + step, padded: padded + step, channel });
                        *part = [simd.add_f32s(part[0], found[0]), simd.add_f32s(part[1], found[1])];
                    }
                }
                first += PARTS;
            }
            for (which, total) in total.iter_mut().enumerate() {
                let left = simd.add_f32s(parts[0][which], parts[1][which]);
                let right = simd.add_f32s(parts[2][which], parts[3][which]);
                *total = simd.add_f32s(*total, simd.add_f32s(left, right));
            }
        }
        // as many lanes as the widest vectors have
        let mut lanes = [[0.0f32; 16]; 2];
        for (lanes, total) in lanes.iter_mut().zip(total) {
            S::as_mut_simd_f32s(lanes).0[0] = total;
        }
        for (l, sums) in sums.iter_mut().enumerate() {
            *sums += Sums(f64::from(lanes[0][l]), f64::from(lanes[1][l]));
        }
    }
}

/// As [`summed`], without sums.
#[inline(always)]
fn each<S: Simd>(geometry: &Geometry, mut at: impl FnMut(Offsets)) {
    let vectors = geometry.channels / S::F32_LANES;
    let [row, padded_row] = [geometry.row(), geometry.padded_row()].map(|values| values / S::F32_LANES);
    for (channel, r) in (0..vectors).flat_map(|channel| (0..geometry.height).map(move |r| (channel, r))) {
        let (image, padded) = (r * row + channel, (r + 1) * padded_row + vectors + channel);
        for step in (0..geometry.width).map(|pixel| pixel * vectors) {
            at(Offsets { image: image + step, padded: padded + step, channel });
        }
    }
}

/// Factors and offsets, `[C]` each.
#[derive(Debug, Clone)]
pub struct Affine {
    pub factors: Vec<f32>,
    pub offsets: Vec<f32>,
}

/// `y = max(factor x + offset, 0)`.
pub fn affine_relu(arch: Arch, geometry: &Geometry, x: &[f32], affine: &Affine, y: &mut Padded) {
    struct Relu<'a>(&'a Geometry, &'a [f32], &'a Affine, &'a mut [f32]);
    impl WithSimd for Relu<'_> {
        type Output = ();

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            let Relu(geometry, x, Affine { factors, offsets }, y) = self;
            let (x, y) = (S::as_simd_f32s(x).0, S::as_mut_simd_f32s(y).0);
            let (factors, offsets) = (S::as_simd_f32s(factors).0, S::as_simd_f32s(offsets).0);
            let zero = simd.splat_f32s(0.0);
            each::<S>(
                geometry,
                #[inline(always)]
                |at| {
                    let v = simd.mul_add_f32s(x[at.image], factors[at.channel], offsets[at.channel]);
                    y[at.padded] = simd.select_f32s(simd.less_than_f32s(zero, v), v, zero);
                },
            );
        }
    }
    arch.dispatch(Relu(geometry, x, affine, y.values_mut()));
}

/// Adds the sums of the values and of their squares.
pub fn moments(arch: Arch, geometry: &Geometry, x: &[f32], sums: &mut [Sums]) {
    struct Moments<'a>(&'a Geometry, &'a [f32], &'a mut [Sums]);
    impl WithSimd for Moments<'_> {
        type Output = ();

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            let x = S::as_simd_f32s(self.1).0;
            summed(
                simd,
                self.0,
                self.2,
                #[inline(always)]
                |at| [x[at.image], simd.mul_f32s(x[at.image], x[at.image])],
            );
        }
    }
    arch.dispatch(Moments(geometry, x, sums));
}

/// `y += bias`, and `y += x` if there is one; adds the moments of `y`.
pub fn add(
    arch: Arch,
    geometry: &Geometry,
    x: Option<&[f32]>,
    bias: &[f32],
    y: &mut [f32],
    sums: &mut [Sums],
) {
    struct Add<'a>(&'a Geometry, Option<&'a [f32]>, &'a [f32], &'a mut [f32], &'a mut [Sums]);
    impl WithSimd for Add<'_> {
        type Output = ();

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            let Add(geometry, x, bias, y, sums) = self;
            let (bias, y) = (S::as_simd_f32s(bias).0, S::as_mut_simd_f32s(y).0);
            let x = S::as_simd_f32s(x.unwrap_or_default()).0;
            summed(
                simd,
                geometry,
                sums,
                #[inline(always)]
                |at| {
                    let mut v = simd.add_f32s(y[at.image], bias[at.channel]);
                    if let Some(&x) = x.get(at.image) {
                        v = simd.add_f32s(x, v);
                    }
                    y[at.image] = v;
                    [v, simd.mul_f32s(v, v)]
                },
            );
        }
    }
    arch.dispatch(Add(geometry, x, bias, y, sums));
}

/// ReLU's gradient in place, `g = 0` where `active` is not positive; adds the sums of g and of `g (x - mean)`.
pub fn gate(
    arch: Arch,
    geometry: &Geometry,
    g: &mut [f32],
    active: &Padded,
    (x, means): (&[f32], &[f32]),
    sums: &mut [Sums],
) {
    struct Gate<'a>(&'a Geometry, &'a mut [f32], &'a [f32], (&'a [f32], &'a [f32]), &'a mut [Sums]);
    impl WithSimd for Gate<'_> {
        type Output = ();

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            let Gate(geometry, g, active, (x, means), sums) = self;
            let (g, active) = (S::as_mut_simd_f32s(g).0, S::as_simd_f32s(active).0);
            let (x, means, zero) = (S::as_simd_f32s(x).0, S::as_simd_f32s(means).0, simd.splat_f32s(0.0));
            summed(
                simd,
                geometry,
                sums,
                #[inline(always)]
                |at| {
                    let on = simd.less_than_f32s(zero, active[at.padded]);
                    let v = simd.select_f32s(on, g[at.image], zero);
                    g[at.image] = v;
                    [v, simd.mul_f32s(v, simd.sub_f32s(x[at.image], means[at.channel]))]
                },
            );
        }
    }
    arch.dispatch(Gate(geometry, g, active.values(), (x, means), sums));
}

/// Gradient of a batch normalisation: `dx = outer g + slope (x - mean) + constant`, every one `[C]`.
#[derive(Debug, Clone, Default)]
pub struct NormGradient {
    /// Factor of the gradient behind the normalisation.
    pub outer: Vec<f32>,
    /// Factor of the centred input.
    pub slope: Vec<f32>,
    /// What is the same for every pixel.
    pub constant: Vec<f32>,
    pub mean: Vec<f32>,
}

impl NormGradient {
    /// The same gradient at every pixel, whatever that of the output is.
    pub fn constant(values: impl Iterator<Item = f32>) -> NormGradient {
        let constant: Vec<f32> = values.collect();
        let zero = vec![0.0; constant.len()];
        NormGradient { outer: zero.clone(), slope: zero.clone(), mean: zero, constant }
    }

    #[inline(always)]
    fn at<S: Simd>(&self, simd: S, channel: usize, g: S::f32s, x: S::f32s) -> S::f32s {
        let [outer, slope] =
            [S::as_simd_f32s(&self.outer).0[channel], S::as_simd_f32s(&self.slope).0[channel]];
        let [constant, mean] =
            [S::as_simd_f32s(&self.constant).0[channel], S::as_simd_f32s(&self.mean).0[channel]];
        simd.mul_add_f32s(outer, g, simd.mul_add_f32s(slope, simd.sub_f32s(x, mean), constant))
    }

    /// Sets `y` to the gradient of the input `x` from that of the output, `g`.
    pub fn set(&self, arch: Arch, geometry: &Geometry, g: &[f32], x: &[f32], y: &mut Padded) {
        struct Set<'a>(&'a NormGradient, &'a Geometry, &'a [f32], &'a [f32], &'a mut [f32]);
        impl WithSimd for Set<'_> {
            type Output = ();

            #[inline(always)]
            fn with_simd<S: Simd>(self, simd: S) {
                let Set(norm, geometry, g, x, y) = self;
                let (g, x, y) = (S::as_simd_f32s(g).0, S::as_simd_f32s(x).0, S::as_mut_simd_f32s(y).0);
                each::<S>(
                    geometry,
                    #[inline(always)]
                    |at| {
                        y[at.padded] = norm.at(simd, at.channel, g[at.image], x[at.image]);
                    },
                );
            }
        }
        arch.dispatch(Set(self, geometry, g, x, y.values_mut()));
    }

    /// Sets `y` and `outer` to the gradient, plus the previous `outer` if they `accumulate`; adds its sums.
    pub fn add(
        &self,
        arch: Arch,
        geometry: &Geometry,
        (g, x): (&[f32], &[f32]),
        (accumulate, outer): (bool, &mut [f32]),
        y: &mut Padded,
        sums: &mut [Sums],
    ) {
        struct Add<'a> {
            norm: &'a NormGradient,
            geometry: &'a Geometry,
            g: &'a [f32],
            x: &'a [f32],
            accumulate: bool,
            outer: &'a mut [f32],
            y: &'a mut [f32],
            sums: &'a mut [Sums],
        }
        impl WithSimd for Add<'_> {
            type Output = ();

            #[inline(always)]
            fn with_simd<S: Simd>(self, simd: S) {
                let Add { norm, geometry, g, x, accumulate, outer, y, sums } = self;
                let (g, x, y) = (S::as_simd_f32s(g).0, S::as_simd_f32s(x).0, S::as_mut_simd_f32s(y).0);
                let (outer, zero) = (S::as_mut_simd_f32s(outer).0, simd.splat_f32s(0.0));
                summed(
                    simd,
                    geometry,
                    sums,
                    #[inline(always)]
                    |at| {
                        let before = if accumulate { outer[at.image] } else { zero };
                        let v = simd.add_f32s(before, norm.at(simd, at.channel, g[at.image], x[at.image]));
                        (outer[at.image], y[at.padded]) = (v, v);
                        [v, zero]
                    },
                );
            }
        }
        let y = y.values_mut();
        arch.dispatch(Add { norm: self, geometry, g, x, accumulate, outer, y, sums });
    }
}
