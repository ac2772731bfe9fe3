//! Clutter removal by truncated SVD: the strongest components of the beat matrix are dropped.
//!
//! Eq. (Y) and y = 1^T Y of the paper. Since U U^H projects, y = w^H X~ with w = (I - U U^H) 1: only the 8 x 8 Gram
//! matrix X~ X~^H and its leading eigenvectors are needed, and y is one inner product per slot.

use crate::dims::{BEATS, Beat, Complex};
use crate::math::{roundf, sqrtf};
use nalgebra::{SMatrix, SVector};

/// Entries of the Gram matrix's upper triangle, row by row.
pub const GRAM_LEN: usize = BEATS * (BEATS + 1) / 2;

/// The running Gram matrix G = sum over slots of b b^H, exact.
///
/// `[GRAM_LEN]` complex i64, upper triangle row by row. Exact up to [`GRAM_SLOTS`] slots: |b|^2 < 2^51.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Gram {
    upper: [Complex<i64>; GRAM_LEN],
}

/// Most slots a [`Gram`] may sum without overflow.
pub const GRAM_SLOTS: usize = 4000;

impl Default for Gram {
    fn default() -> Self {
        Self::new()
    }
}

impl Gram {
    /// A Gram matrix of nothing.
    pub const fn new() -> Self {
        Gram { upper: [Complex::new(0, 0); GRAM_LEN] }
    }

    /// Adds one slot. Cost: 36 complex multiply-accumulates of 32 x 32 -> 64 bits.
    pub fn add(&mut self, beat: &Beat) {
        let mut entries = self.upper.iter_mut();
        for (i, a) in beat.iter().enumerate() {
            let (ar, ai) = (i64::from(a.re), i64::from(a.im));
            for (b, entry) in beat.iter().skip(i).zip(&mut entries) {
                let (br, bi) = (i64::from(b.re), i64::from(b.im));
                entry.re = entry.re.wrapping_add(ar * br + ai * bi);
                entry.im = entry.im.wrapping_add(ai * br - ar * bi);
            }
        }
    }

    /// The upper triangle, row by row.
    pub fn upper(&self) -> &[Complex<i64>; GRAM_LEN] {
        &self.upper
    }

    /// The matrix divided by its trace, or `None` if it is zero.
    fn normalised(&self) -> Option<Matrix> {
        let mut entries = self.upper.iter();
        let mut matrix = Matrix::zeros();
        let mut trace = 0_i128; // eight diagonal entries of up to 2^63
        for i in 0..BEATS {
            for j in i..BEATS {
                let entry = entries.next()?;
                if i == j {
                    trace += i128::from(entry.re);
                }
                let value = Complex::new(entry.re as f32, entry.im as f32);
                matrix[(i, j)] = value;
                matrix[(j, i)] = value.conj();
            }
        }
        if trace <= 0 {
            return None;
        }
        let trace = trace as f32;
        Some(matrix.map(|value| Complex::new(value.re / trace, value.im / trace)))
    }
}

type Matrix = SMatrix<Complex<f32>, BEATS, BEATS>;
type Vector = SVector<Complex<f32>, BEATS>;

/// Which singular components survive: `first_kept..=last_kept`, counted from 1, strongest first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SvdRange {
    /// The paper's d; 1 keeps the clutter.
    pub first: u8,
    /// Upper cut; 8 keeps the weakest component.
    pub last: u8,
}

/// The projection vector w in Q3.28: y = w^H b.
pub type Projection = [Complex<i32>; BEATS];

/// Fraction bits of a [`Projection`]; |w| <= sqrt(8) < 4.
pub const PROJECTION_BITS: u32 = 28;

/// The projection that keeps everything (w = 1).
pub const UNIT_PROJECTION: Projection = [Complex::new(1 << PROJECTION_BITS, 0); BEATS];

/// w = (I - U U^H) 1 over the dropped components, from the Gram matrix, a few Jacobi rotations at a time.
///
/// f32 throughout; the same bits on every target. Error against exact arithmetic: at most
/// `64 eps / gap` in norm, `gap` being the smallest relative distance between a dropped and a kept eigenvalue.
/// Bounded: [`SWEEPS`] sweeps of 28 rotations, about 70 k floating-point operations in all.
#[derive(Debug, Clone)]
pub(crate) struct ClutterSolver {
    matrix: Matrix,
    vectors: Matrix,
    steps_left: usize,
    kept: SvdRange,
}

/// Rotations of one step, so that it is short without a floating-point unit: some 110 000 instructions.
const ROTATIONS: usize = 7;

/// Rotations of a sweep, in their order, by step: rows 0 and 1, 0 and 2, ... 6 and 7.
const PAIRS: [[[usize; 2]; ROTATIONS]; BEATS * (BEATS - 1) / 2 / ROTATIONS] = {
    let mut pairs = [[[0; 2]; ROTATIONS]; BEATS * (BEATS - 1) / 2 / ROTATIONS];
    let (mut k, mut p) = (0, 0);
    while p < BEATS {
        let mut q = p + 1;
        while q < BEATS {
            pairs[k / ROTATIONS][k % ROTATIONS] = [p, q];
            (k, q) = (k + 1, q + 1);
        }
        p += 1;
    }
    pairs
};

/// Steps of a solver.
pub const SOLVER_STEPS: usize = SWEEPS * PAIRS.len();

impl ClutterSolver {
    /// Begins with a Gram matrix and the components to keep.
    pub fn new(gram: &Gram, kept: SvdRange) -> Self {
        let all = kept.first <= 1 && usize::from(kept.last) >= BEATS;
        let matrix = gram.normalised().filter(|_| !all);
        // nothing to drop of nothing, or everything kept: the identity has no rotations to do and is not cut
        let (steps_left, kept) = match matrix {
            Some(_) => (SOLVER_STEPS, kept),
            None => (0, SvdRange { first: 1, last: BEATS as u8 }),
        };
        let matrix = matrix.unwrap_or_else(Matrix::identity);
        ClutterSolver { matrix, vectors: Matrix::identity(), steps_left, kept }
    }

    /// Seven rotations; false if none is left.
    pub fn step(&mut self) -> bool {
        let Some(left) = self.steps_left.checked_sub(1) else { return false };
        for &[p, q] in &PAIRS[(SOLVER_STEPS - self.steps_left) % PAIRS.len()] {
            rotate(&mut self.matrix, &mut self.vectors, p % BEATS, q % BEATS);
        }
        self.steps_left = left;
        true
    }

    /// The projection, after the last step.
    pub fn projection(&self) -> Projection {
        let mut w = Vector::from_element(Complex::new(1.0, 0.0));
        let value = |column: usize| self.matrix[(column, column)].re;
        for column in 0..BEATS {
            // rank from 1, strongest first; equal values rank by column
            let own = value(column);
            let stronger = |&other: &usize| value(other) > own || (value(other) == own && other < column);
            let rank = 1 + (0..BEATS).filter(stronger).count();
            if rank < usize::from(self.kept.first) || rank > usize::from(self.kept.last) {
                let u = self.vectors.column(column);
                let inner = u.sum().conj();
                w -= u * inner;
            }
        }
        let mut out = UNIT_PROJECTION;
        for (q, w) in out.iter_mut().zip(w.iter()) {
            *q = Complex::new(to_q28(w.re), to_q28(w.im));
        }
        out
    }
}

/// The projection from the Gram matrix, all rotations at once.
pub fn clutter_projection(gram: &Gram, kept: SvdRange) -> Projection {
    let mut solver = ClutterSolver::new(gram, kept);
    while solver.step() {}
    solver.projection()
}

/// Rounds to Q3.28, halves away from zero; saturates.
fn to_q28(x: f32) -> i32 {
    roundf(x * (1_i32 << PROJECTION_BITS) as f32) as i32
}

/// Jacobi sweeps; convergence is quadratic, f32 is exhausted after five or six.
pub const SWEEPS: usize = 8;

/// Annihilates a[p][q] with a unitary rotation of columns and rows p, q, and turns the vectors along.
fn rotate(a: &mut Matrix, v: &mut Matrix, p: usize, q: usize) {
    let pivot = a[(p, q)];
    let magnitude = sqrtf(pivot.re * pivot.re + pivot.im * pivot.im);
    if magnitude < 1e-18 {
        return;
    }
    let phase = Complex::new(pivot.re / magnitude, -pivot.im / magnitude); // exp(-j arg)
    let tau = (a[(q, q)].re - a[(p, p)].re) / (2.0 * magnitude);
    let root = sqrtf(1.0 + tau * tau);
    let t = if tau >= 0.0 { 1.0 / (tau + root) } else { -1.0 / (root - tau) };
    let c = 1.0 / sqrtf(1.0 + t * t);
    let s = t * c;
    for matrix in [&mut *a, v] {
        for row in 0..BEATS {
            let (x, y) = (matrix[(row, p)], phase * matrix[(row, q)]);
            matrix[(row, p)] = x * c - y * s;
            matrix[(row, q)] = x * s + y * c;
        }
    }
    let phase = phase.conj();
    for column in 0..BEATS {
        let (x, y) = (a[(p, column)], phase * a[(q, column)]);
        a[(p, column)] = x * c - y * s;
        a[(q, column)] = x * s + y * c;
    }
    // what the rotation makes exactly zero and real is stored so
    a[(p, q)] = Complex::new(0.0, 0.0);
    a[(q, p)] = Complex::new(0.0, 0.0);
    a[(p, p)].im = 0.0;
    a[(q, q)].im = 0.0;
}

/// Significant bits kept of the slow-time signal: an f32 holds them exactly.
pub const SLOW_TIME_BITS: u32 = 23;

/// Largest part of `w^H b` over the slots, as its magnitude.
pub fn largest_part(beats: &[Beat], projection: &Projection) -> u64 {
    let parts = beats.iter().map(|beat| inner(projection, beat));
    parts.fold(0, |largest, y| largest.max(y.re.unsigned_abs()).max(y.im.unsigned_abs()))
}

/// The power of two by which slow time is scaled, so that a part of this magnitude has [`SLOW_TIME_BITS`].
pub fn slow_time_shift(largest: u64) -> u32 {
    (u64::BITS - largest.leading_zeros()).saturating_sub(SLOW_TIME_BITS)
}

/// `y[n] = w^H b[n] / 2^shift` for every slot, halves up.
///
/// In: `[slow_time, BEATS]`, out: `[slow_time]` complex i32 with |re|, |im| <= 2^23 for the [`slow_time_shift`] of the
/// [`largest_part`]. Exact i64 products.
pub fn project(beats: &[Beat], projection: &Projection, shift: u32, slow_time: &mut [Complex<i32>]) {
    for (out, beat) in slow_time.iter_mut().zip(beats) {
        let y = inner(projection, beat);
        *out = Complex::new(round_shift(y.re, shift), round_shift(y.im, shift));
    }
}

/// w^H b, exact: |w| |b| < 2^1.5 2^28 2^1.5 2^25.5 < 2^57.
fn inner(projection: &Projection, beat: &Beat) -> Complex<i64> {
    let mut sum = Complex::new(0_i64, 0_i64);
    for (w, b) in projection.iter().zip(beat) {
        let (wr, wi) = (i64::from(w.re), i64::from(w.im));
        let (br, bi) = (i64::from(b.re), i64::from(b.im));
        sum.re = sum.re.wrapping_add((wr * br).wrapping_add(wi * bi));
        sum.im = sum.im.wrapping_add((wr * bi).wrapping_sub(wi * br));
    }
    sum
}

/// `round(x / 2^shift)`, halves up; shift 0..=40.
const fn round_shift(x: i64, shift: u32) -> i32 {
    if shift == 0 { x as i32 } else { (x.wrapping_add(1 << (shift - 1)) >> shift) as i32 }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use rand_core::{Rng, SeedableRng};
    use std::vec::Vec;

    fn noise(seed: u64, slots: usize) -> Vec<Beat> {
        let mut rng = rand_xoshiro::Xoshiro128PlusPlus::seed_from_u64(seed);
        let mut draw = || (rng.next_u32() as i32) >> 7;
        (0..slots).map(|_| core::array::from_fn(|_| Complex::new(draw(), draw()))).collect()
    }

    #[test]
    fn eigenvectors_rebuild_the_matrix_and_are_unitary() {
        for seed in 0..200 {
            let mut gram = Gram::new();
            noise(seed, 1 + seed as usize % 20).iter().for_each(|beat| gram.add(beat));
            let matrix = gram.normalised().unwrap();
            let mut solver = ClutterSolver::new(&gram, SvdRange { first: 2, last: 8 });
            while solver.step() {}
            let v = solver.vectors;
            let d =
                Matrix::from_diagonal(&Vector::from_fn(|i, _| Complex::new(solver.matrix[(i, i)].re, 0.0)));
            let rebuilt = v * d * v.adjoint();
            assert!((rebuilt - matrix).camax() < 2e-6, "seed {seed}");
            assert!((v.adjoint() * v - Matrix::identity()).camax() < 2e-6, "seed {seed}");
        }
    }

    #[test]
    fn a_constant_echo_is_removed_to_the_arithmetic() {
        // one static echo at full scale: rank one, so nothing may be left at d = 2
        let echo: Beat =
            core::array::from_fn(|i| Complex::new(20_000_000 - 900_000 * i as i32, 1_000_000 * i as i32));
        let beats = [echo; 300];
        let mut gram = Gram::new();
        beats.iter().for_each(|beat| gram.add(beat));
        let w = clutter_projection(&gram, SvdRange { first: 2, last: 8 });
        let kept = inner(&w, &echo);
        let whole = inner(&UNIT_PROJECTION, &echo);
        let ratio = (kept.re as f64).hypot(kept.im as f64) / (whole.re as f64).hypot(whole.im as f64);
        assert!(ratio < 1e-6, "left over: {ratio}");
    }

    #[test]
    fn full_scale_recordings_do_not_overflow() {
        // the loudest beats there are, as many as a Gram matrix takes: one static echo, removed like any other
        let loudest: Beat = [Complex::new(32_700_000, 32_700_000); BEATS];
        let mut gram = Gram::new();
        (0..GRAM_SLOTS).for_each(|_| gram.add(&loudest));
        assert!(gram.upper().iter().all(|entry| entry.re > 0));
        let w = clutter_projection(&gram, SvdRange { first: 2, last: 8 });
        assert_ne!(w, UNIT_PROJECTION);
        let kept = inner(&w, &loudest);
        assert!(kept.re.unsigned_abs() < 1 << 38, "{kept}"); // of 2^56 before
    }

    #[test]
    fn keeping_everything_sums_the_beat() {
        let beats = noise(7, 40);
        let mut gram = Gram::new();
        beats.iter().for_each(|beat| gram.add(beat));
        assert_eq!(clutter_projection(&gram, SvdRange { first: 1, last: 8 }), UNIT_PROJECTION);
        assert_eq!(clutter_projection(&Gram::new(), SvdRange { first: 2, last: 8 }), UNIT_PROJECTION);
    }

    #[test]
    fn components_are_cut_by_rank_from_both_ends() {
        // every slot in one range cell: eigenvectors are the cells, the later the stronger, the first two alike
        let mut gram = Gram::new();
        for (cell, times) in [1, 1, 2, 3, 4, 5, 6, 7].into_iter().enumerate() {
            let mut beat = crate::dims::ZERO_BEAT;
            beat[cell] = Complex::new(1000, -1000);
            (0..times).for_each(|_| gram.add(&beat));
        }
        let ranks = [7, 8, 6, 5, 4, 3, 2, 1];
        for first in 1..=8 {
            for last in first..=8 {
                let kept = |rank: &u8| (first..=last).contains(rank);
                let wanted = ranks.map(|rank| Complex::new(i32::from(kept(&rank)) << PROJECTION_BITS, 0));
                assert_eq!(clutter_projection(&gram, SvdRange { first, last }), wanted, "{first}..={last}");
            }
        }
    }

    #[test]
    fn slow_time_uses_its_bits() {
        let beats = noise(3, 64);
        let mut y = [Complex::new(0, 0); 64];
        project(&beats, &UNIT_PROJECTION, slow_time_shift(largest_part(&beats, &UNIT_PROJECTION)), &mut y);
        let largest = y.iter().map(|y| y.re.unsigned_abs().max(y.im.unsigned_abs())).max().unwrap();
        assert!((1 << 22..=1 << 23).contains(&largest), "{largest}");
        let mut silent = [Complex::new(1, 1); 4];
        assert_eq!(slow_time_shift(largest_part(&[crate::dims::ZERO_BEAT; 4], &UNIT_PROJECTION)), 0);
        project(&[crate::dims::ZERO_BEAT; 4], &UNIT_PROJECTION, 0, &mut silent);
        assert_eq!(silent, [Complex::new(0, 0); 4]);
    }
}
