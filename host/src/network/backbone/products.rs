//! Products of small matrices in the processor's widest vectors: what a Winograd transform leaves of a convolution.
//!
//! Every product is fused with its sum and every sum is taken in index order in a lane of its own, so the bits are the
//! same with AVX-512, AVX2, NEON or none of them. Without fused instructions in hardware they are emulated, slowly.

use pulp::Simd;

/// `y = a b`: `y` `[rows][outputs]`, `a` `[rows][depth]`, `b` `[depth][outputs]`; outputs are a multiple of 8.
#[inline(always)]
pub fn multiply<S: Simd>(simd: S, a: &[f32], b: &[f32], outputs: usize, y: &mut [f32]) {
    let (rows, depth) = (y.len() / outputs, b.len() / outputs);
    Product::<false> { a, b, rows, depth, outputs }.all(simd, y);
}

/// `y += a' b`: `y` `[rows][outputs]`, `a` `[depth][rows]`, `b` `[depth][outputs]`; outputs are a multiple of 8.
#[inline(always)]
pub fn accumulate<S: Simd>(simd: S, a: &[f32], b: &[f32], outputs: usize, y: &mut [f32]) {
    let (rows, depth) = (y.len() / outputs, b.len() / outputs);
    Product::<true> { a, b, rows, depth, outputs }.all(simd, y);
}

/// Adds to `y`, and `a` is transposed, if `TRANSPOSED`.
#[derive(Clone, Copy)]
struct Product<'a, const TRANSPOSED: bool> {
    a: &'a [f32],
    b: &'a [f32],
    rows: usize,
    depth: usize,
    outputs: usize,
}

impl<const TRANSPOSED: bool> Product<'_, TRANSPOSED> {
    #[inline(always)]
    fn all<S: Simd>(self, simd: S, y: &mut [f32]) {
        // as many sums as hide the latency of a fused sum and leave registers for the factors
        match S::F32_LANES {
            16 => self.columns::<S, 16, 1>(simd, y),
            8 if self.outputs.is_multiple_of(16) => self.columns::<S, 4, 2>(simd, y),
            8 => self.columns::<S, 8, 1>(simd, y),
            4 => self.columns::<S, 8, 2>(simd, y),
            _ => self.columns::<S, 2, 4>(simd, y),
        }
    }

    #[inline(always)]
    fn columns<S: Simd, const R: usize, const V: usize>(self, simd: S, y: &mut [f32]) {
        for v in (0..self.outputs / S::F32_LANES).step_by(V) {
            let mut row = 0;
            while row + R <= self.rows {
                self.tile::<S, R, V>(simd, row, v, y);
                row += R;
            }
            while row + 4 <= self.rows {
                self.tile::<S, 4, V>(simd, row, v, y);
                row += 4;
            }
            while row < self.rows {
                self.tile::<S, 1, V>(simd, row, v, y);
                row += 1;
            }
        }
    }

    /// R rows by V vectors of outputs.
    #[inline(always)]
    fn tile<S: Simd, const R: usize, const V: usize>(self, simd: S, row: usize, v: usize, y: &mut [f32]) {
        let width = self.outputs / S::F32_LANES;
        let y = &mut S::as_mut_simd_f32s(y).0[row * width..][..R * width];
        let mut sums = [[simd.splat_f32s(0.0); V]; R];
        if TRANSPOSED {
            for (sums, y) in sums.iter_mut().zip(y.chunks_exact(width)) {
                sums.copy_from_slice(&y[v..][..V]);
            }
        }
        let mut rows: [&[f32]; R] = [&[]; R];
        if !TRANSPOSED {
            for (r, values) in rows.iter_mut().enumerate() {
                *values = &self.a[(row + r) * self.depth..][..self.depth];
            }
        }
        for (k, b) in self.b.chunks_exact(self.outputs).enumerate().take(self.depth) {
            let b = &S::as_simd_f32s(b).0[v..][..V];
            let column = if TRANSPOSED { &self.a[k * self.rows + row..][..R] } else { &[] };
            for r in 0..R {
                let a = simd.splat_f32s(if TRANSPOSED { column[r] } else { rows[r][k] });
                for v in 0..V {
                    sums[r][v] = simd.mul_add_f32s(a, b[v], sums[r][v]);
                }
            }
        }
        for (sums, y) in sums.iter().zip(y.chunks_exact_mut(width)) {
            y[v..][..V].copy_from_slice(sums);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{every_arch, numbers};
    use super::*;
    use pulp::WithSimd;

    struct Both<'a>(usize, &'a [f32], &'a [f32], &'a [f32], &'a mut [f32], &'a mut [f32]);
    impl WithSimd for Both<'_> {
        type Output = ();

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            let Both(outputs, a, transposed, b, y, sums) = self;
            multiply(simd, a, b, outputs, y);
            accumulate(simd, transposed, b, outputs, sums);
        }
    }

    #[test]
    fn both_are_their_formulas_on_every_instruction_set() {
        for (rows, depth, outputs) in [(1, 3, 8), (16, 16, 16), (21, 5, 24), (39, 1, 32), (7, 16, 16)] {
            let (a, b) = (numbers(rows * depth, 1), numbers(depth * outputs, 2));
            let transposed: Vec<f32> = (0..rows * depth).map(|n| a[n % rows * depth + n / rows]).collect();
            for arch in every_arch(outputs) {
                let (mut y, mut sums) = (vec![f32::NAN; rows * outputs], vec![0.5; rows * outputs]);
                arch.dispatch(Both(outputs, &a, &transposed, &b, &mut y, &mut sums));
                for (r, o) in (0..rows).flat_map(|r| (0..outputs).map(move |o| (r, o))) {
                    let fused = |start: f32| {
                        (0..depth).fold(start, |sum, k| a[r * depth + k].mul_add(b[k * outputs + o], sum))
                    };
                    assert_eq!([y[r * outputs + o], sums[r * outputs + o]], [fused(0.0), fused(0.5)]);
                }
            }
        }
    }
}
