//! What happens to every pixel between two convolutions: normalisation, ReLU, their gradients, and sums per channel.
//!
//! Sums are kept in sixteen lanes and then added in double precision, in index order: the same bits on every processor.

use super::products::LANES;
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

/// Sums two values over vectors of pixels, `at(0)` to `at(count - 1)`, every lane of [`LANES`] on its own.
#[inline(always)]
fn summed<S: Simd>(simd: S, count: usize, at: impl FnMut(usize) -> (S::f32s, S::f32s)) -> Sums {
    match S::F32_LANES {
        16 => lanes::<S, 1>(simd, count, at),
        8 => lanes::<S, 2>(simd, count, at),
        4 => lanes::<S, 4>(simd, count, at),
        _ => lanes::<S, LANES>(simd, count, at),
    }
}

/// U vectors to sixteen lanes.
#[inline(always)]
fn lanes<S: Simd, const U: usize>(
    simd: S,
    count: usize,
    mut at: impl FnMut(usize) -> (S::f32s, S::f32s),
) -> Sums {
    let mut sums = [[simd.splat_f32s(0.0); U]; 2];
    for p in 0..count / U {
        for u in 0..U {
            let (a, b) = at(p * U + u);
            sums[0][u] = simd.add_f32s(sums[0][u], a);
            sums[1][u] = simd.add_f32s(sums[1][u], b);
        }
    }
    let mut lanes = [[0.0f32; LANES]; 2];
    for (lanes, sums) in lanes.iter_mut().zip(&sums) {
        S::as_mut_simd_f32s(lanes).0.copy_from_slice(sums);
    }
    let total = |lanes: &[f32; LANES]| lanes.iter().map(|&v| f64::from(v)).sum();
    Sums(total(&lanes[0]), total(&lanes[1]))
}

/// `y = max(factor x + offset, 0)`.
pub fn affine_relu(arch: Arch, x: &[f32], factor: f32, offset: f32, y: &mut [f32]) {
    arch.dispatch(
        #[inline(always)]
        || {
            for (y, x) in y.iter_mut().zip(x) {
                let v = x * factor + offset;
                *y = if v > 0.0 { v } else { 0.0 };
            }
        },
    );
}

/// Sum of the values and of their squares.
pub fn moments(arch: Arch, x: &[f32]) -> Sums {
    struct Moments<'a>(&'a [f32]);
    impl WithSimd for Moments<'_> {
        type Output = Sums;

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) -> Sums {
            let x = S::as_simd_f32s(self.0).0;
            summed(simd, x.len(), |p| (x[p], simd.mul_f32s(x[p], x[p])))
        }
    }
    arch.dispatch(Moments(x))
}

/// `y = x + t`.
pub fn add(arch: Arch, x: &[f32], t: &[f32], y: &mut [f32]) {
    arch.dispatch(
        #[inline(always)]
        || {
            for ((y, x), t) in y.iter_mut().zip(x).zip(t) {
                *y = x + t;
            }
        },
    );
}

/// ReLU's gradient in place, `g = 0` where `active` is not positive; sums of g and of `g (x - mean)`.
pub fn gate(arch: Arch, g: &mut [f32], active: &[f32], x: &[f32], mean: f32) -> Sums {
    struct Gate<'a>(&'a mut [f32], &'a [f32], &'a [f32], f32);
    impl WithSimd for Gate<'_> {
        type Output = Sums;

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) -> Sums {
            let g = S::as_mut_simd_f32s(self.0).0;
            let (active, x) = (&S::as_simd_f32s(self.1).0[..g.len()], &S::as_simd_f32s(self.2).0[..g.len()]);
            let (zero, mean) = (simd.splat_f32s(0.0), simd.splat_f32s(self.3));
            summed(simd, g.len(), |p| {
                let on = simd.less_than_f32s(zero, active[p]);
                g[p] = simd.select_f32s(on, g[p], zero);
                (g[p], simd.mul_f32s(g[p], simd.sub_f32s(x[p], mean)))
            })
        }
    }
    arch.dispatch(Gate(g, active, x, mean))
}

/// Gradient of a batch normalisation: `dx = outer g + slope (x - mean) + constant`.
#[derive(Debug, Clone, Copy, Default)]
pub struct NormGradient {
    /// Factor of the gradient behind the normalisation.
    pub outer: f32,
    /// Factor of the centred input.
    pub slope: f32,
    /// What is the same for every pixel.
    pub constant: f32,
    pub mean: f32,
}

impl NormGradient {
    pub fn set(&self, arch: Arch, g: &[f32], x: &[f32], y: &mut [f32]) {
        let n = *self;
        arch.dispatch(
            #[inline(always)]
            || {
                for ((y, g), x) in y.iter_mut().zip(g).zip(x) {
                    *y = n.outer * g + (n.slope * (x - n.mean) + n.constant);
                }
            },
        );
    }

    pub fn add(&self, arch: Arch, g: &[f32], x: &[f32], y: &mut [f32]) {
        let n = *self;
        arch.dispatch(
            #[inline(always)]
            || {
                for ((y, g), x) in y.iter_mut().zip(g).zip(x) {
                    *y += n.outer * g + (n.slope * (x - n.mean) + n.constant);
                }
            },
        );
    }
}
