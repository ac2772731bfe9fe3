//! Two sums of products over shifted images, in the processor's widest vectors: all the work of training a convolution.
//!
//! An image is a row of planes, one per channel, each a flat list of pixels in which a tap of the kernel is a constant
//! shift. A 3x3 convolution is then `y[o][p] = sum_k w[k][o] x[shift[k] + p]`, one k per input channel and tap; its
//! input gradient is the same with mirrored weights, its weight gradient is `sum_p x[shift[k] + p] g[o][p]`.
//!
//! Every product is fused with its sum and lanes are counted in sixteens on every processor, so the bits are the same
//! with AVX-512, AVX2, NEON or none of them. Without fused instructions in hardware they are emulated, slowly.

use pulp::{Arch, Simd, WithSimd};

/// Planes are a multiple of this many pixels long.
pub const BLOCK: usize = 48;
/// Lanes of a weight gradient's sum.
pub const LANES: usize = 16;

/// `y[o * plane + p] = bias[o] + sum_k weights[k * outputs + o] * x[shifts[k] + p]` for `p` in `0..pixels`.
///
/// `bias` holds one value per output, a multiple of 4 of them; `pixels` is a multiple of [`BLOCK`].
#[derive(Debug)]
pub struct Convolve<'a> {
    /// Planes of the input.
    pub x: &'a [f32],
    /// Where each k begins in `x`.
    pub shifts: &'a [usize],
    pub weights: &'a [f32],
    pub bias: &'a [f32],
    /// Pixels of a plane of the output.
    pub pixels: usize,
    /// Planes of the output, one behind the other.
    pub y: &'a mut [f32],
}

impl Convolve<'_> {
    pub fn run(self, arch: Arch) {
        arch.dispatch(self);
    }

    #[inline(always)]
    fn tiles<S: Simd, const O: usize, const V: usize>(&mut self, simd: S, first: usize) {
        let (outputs, width) = (self.bias.len(), V * S::F32_LANES);
        let bias = &self.bias[first..first + O];
        for p in (0..self.pixels).step_by(width) {
            let mut sums: [[S::f32s; V]; O] = std::array::from_fn(|o| [simd.splat_f32s(bias[o]); V]);
            for (&shift, weights) in self.shifts.iter().zip(self.weights.chunks_exact(outputs)) {
                let (x, _) = S::as_simd_f32s(&self.x[shift + p..][..width]);
                let weights = &weights[first..first + O];
                for o in 0..O {
                    let w = simd.splat_f32s(weights[o]);
                    for v in 0..V {
                        sums[o][v] = simd.mul_add_f32s(w, x[v], sums[o][v]);
                    }
                }
            }
            for o in 0..O {
                let (y, _) = S::as_mut_simd_f32s(&mut self.y[(first + o) * self.pixels + p..][..width]);
                y[..V].copy_from_slice(&sums[o]);
            }
        }
    }
}

impl WithSimd for Convolve<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let mut first = 0;
        while first < self.bias.len() {
            if S::F32_LANES == 16 && self.bias.len() - first >= 8 {
                self.tiles::<S, 8, 3>(simd, first);
                first += 8;
            } else {
                self.tiles::<S, 4, 3>(simd, first);
                first += 4;
            }
        }
    }
}

/// `sums[(k * outputs + o) * LANES + l] += sum_p x[shifts[k] + p] * g[o * plane + p]` over `p` = l modulo [`LANES`].
///
/// Shifts come in threes; `outputs` is a multiple of 4, `pixels` of [`LANES`]. Fastest where `g` is aligned to 64 bytes.
#[derive(Debug)]
pub struct Correlate<'a> {
    /// Planes of the input.
    pub x: &'a [f32],
    /// Where each k begins in `x`.
    pub shifts: &'a [usize],
    /// Planes of the output's gradient.
    pub g: &'a [f32],
    /// Distance of the planes in `g`.
    pub plane: usize,
    /// Number of planes in `g`.
    pub outputs: usize,
    pub pixels: usize,
    pub sums: &'a mut [f32],
}

impl Correlate<'_> {
    pub fn run(self, arch: Arch) {
        arch.dispatch(self);
    }

    /// Three shifts by O outputs, U vectors to sixteen lanes.
    #[inline(always)]
    fn tile<S: Simd, const O: usize, const U: usize>(&mut self, simd: S, k: usize, first: usize) {
        let count = self.pixels / S::F32_LANES;
        let x: [&[S::f32s]; 3] = std::array::from_fn(|i| {
            &S::as_simd_f32s(&self.x[self.shifts[k + i]..][..self.pixels]).0[..count]
        });
        let g: [&[S::f32s]; O] = std::array::from_fn(|o| {
            &S::as_simd_f32s(&self.g[(first + o) * self.plane..][..self.pixels]).0[..count]
        });
        let mut sums = [[[simd.splat_f32s(0.0); U]; O]; 3];
        for p in 0..count / U {
            for u in 0..U {
                for o in 0..O {
                    let g = g[o][p * U + u];
                    for i in 0..3 {
                        sums[i][o][u] = simd.mul_add_f32s(x[i][p * U + u], g, sums[i][o][u]);
                    }
                }
            }
        }
        for (i, o) in (0..3).flat_map(|i| (0..O).map(move |o| (i, o))) {
            let at = ((k + i) * self.outputs + first + o) * LANES;
            let (total, _) = S::as_mut_simd_f32s(&mut self.sums[at..][..LANES]);
            for u in 0..U {
                total[u] = simd.add_f32s(total[u], sums[i][o][u]);
            }
        }
    }
}

impl WithSimd for Correlate<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        for k in (0..self.shifts.len()).step_by(3) {
            let mut first = 0;
            while first < self.outputs {
                let left = self.outputs - first;
                first += match S::F32_LANES {
                    16 if left >= 8 => {
                        self.tile::<S, 8, 1>(simd, k, first);
                        8
                    }
                    16 => {
                        self.tile::<S, 4, 1>(simd, k, first);
                        4
                    }
                    8 => {
                        self.tile::<S, 2, 2>(simd, k, first);
                        2
                    }
                    4 => {
                        self.tile::<S, 2, 4>(simd, k, first);
                        2
                    }
                    _ => {
                        self.tile::<S, 1, 16>(simd, k, first);
                        1
                    }
                };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(count: usize, seed: u32) -> Vec<f32> {
        let mut state = seed;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 23) as f32 - 1.0
        };
        (0..count).map(|_| next()).collect()
    }

    /// Every instruction set that this processor has.
    fn every() -> Vec<Arch> {
        #[cfg(target_arch = "x86_64")]
        let wider = [pulp::x86::V3::try_new().map(Arch::V3), pulp::x86::V4::try_new().map(Arch::V4)];
        #[cfg(not(target_arch = "x86_64"))]
        let wider = [Some(Arch::new())];
        [Arch::Scalar].into_iter().chain(wider.into_iter().flatten()).collect()
    }

    #[test]
    fn both_are_their_formulas_and_the_same_bits_on_every_instruction_set() {
        let (pixels, slack) = (2 * BLOCK, 7);
        for outputs in [4, 8, 12] {
            let shifts = [0, 1, 5, pixels + slack, pixels + slack + 2, pixels + slack + 6];
            let x = numbers(2 * (pixels + slack), 1);
            let (weights, bias) = (numbers(6 * outputs, 2), numbers(outputs, 3));
            let g = numbers(outputs * (pixels + slack), 4);
            let mut found: Option<(Vec<f32>, Vec<f32>)> = None;
            for arch in every() {
                let mut y = vec![0.0; outputs * pixels];
                let (x, shifts) = (&x[..], &shifts[..]);
                Convolve { x, shifts, weights: &weights, bias: &bias, pixels, y: &mut y }.run(arch);
                let mut sums = vec![0.5; 6 * outputs * LANES];
                let plane = pixels + slack;
                Correlate { x, shifts, g: &g, plane, outputs, pixels, sums: &mut sums }.run(arch);
                let (y0, sums0) = found.get_or_insert_with(|| (y.clone(), sums.clone()));
                assert_eq!((&y, &sums), (&*y0, &*sums0));
            }
            let (y, sums) = found.unwrap();
            for (o, p) in (0..outputs).flat_map(|o| (0..pixels).map(move |p| (o, p))) {
                let fused =
                    (0..6).fold(bias[o], |s, k| weights[k * outputs + o].mul_add(x[shifts[k] + p], s));
                assert_eq!(y[o * pixels + p], fused);
            }
            for (k, o) in (0..6).flat_map(|k| (0..outputs).map(move |o| (k, o))) {
                let product = |p| f64::from(x[shifts[k] + p]) * f64::from(g[o * (pixels + slack) + p]);
                let expected = 8.0 + (0..pixels).map(product).sum::<f64>();
                let lanes = &sums[(k * outputs + o) * LANES..][..LANES];
                let sum: f64 = lanes.iter().map(|&s| f64::from(s)).sum();
                assert!((sum - expected).abs() < 1e-4, "{sum} {expected}");
            }
        }
    }
}
