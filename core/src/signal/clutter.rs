//! Clutter removal by truncated SVD: the strongest components of the beat matrix are dropped.
//!
//! Eq. (Y) and y = 1^T Y of the paper. Since U U^H projects, y = w^H X~ with w = (I - U U^H) 1: only the 8 x 8 Gram
//! matrix X~ X~^H and its leading eigenvectors are needed, and y is one inner product per slot. Which components are dropped is
//! fixed, or decided per recording: those with a static slow-time signal ([`ADAPTIVE`]).

use crate::dims::{BEATS, Beat, Complex};
use crate::math::{roundf, sqrtf};
use nalgebra::{ArrayStorage, SMatrix, SVector};

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

#[allow(clippy::new_without_default)] // there is one way to begin
impl Gram {
    /// A Gram matrix of nothing.
    pub const fn new() -> Self {
        Gram { upper: [Complex::new(0, 0); GRAM_LEN] }
    }

    /// Adds one slot. Cost: 8 squared magnitudes and 28 complex multiply-accumulates of 32 x 32 -> 64 bits.
    #[cfg_attr(target_os = "none", inline(never))]
    #[cfg_attr(not(target_os = "none"), inline(always))] // for the caller's vector instructions
    pub fn add(&mut self, beat: &Beat) {
        let rows = add_row::<8>(beat, &mut self.upper);
        let rows = add_row::<7>(beat, rows);
        let rows = add_row::<6>(beat, rows);
        let rows = add_row::<5>(beat, rows);
        let rows = add_row::<4>(beat, rows);
        let rows = add_row::<3>(beat, rows);
        let rows = add_row::<2>(beat, rows);
        add_row::<1>(beat, rows);
    }

    /// The upper triangle, row by row.
    pub fn upper(&self) -> &[Complex<i64>; GRAM_LEN] {
        &self.upper
    }

    /// The entries with their row and column.
    fn entries(&self) -> impl Iterator<Item = (usize, usize, &Complex<i64>)> {
        let places = (0..BEATS).flat_map(|i| (i..BEATS).map(move |j| (i, j)));
        places.zip(&self.upper).map(|((i, j), entry)| (i, j, entry))
    }

    /// Eight diagonal entries of up to 2^63.
    fn trace(&self) -> i128 {
        self.entries().filter(|(i, j, _)| i == j).map(|(_, _, entry)| i128::from(entry.re)).sum()
    }
}

/// Adds a row of the Gram matrix, the products of the first of the last `N` range samples; returns the rows behind it.
#[inline(always)]
fn add_row<'a, const N: usize>(beat: &Beat, rows: &'a mut [Complex<i64>]) -> &'a mut [Complex<i64>] {
    let (Some(beat), Some((row, rows))) = (beat.last_chunk::<N>(), rows.split_first_chunk_mut::<N>()) else {
        return &mut [];
    };
    add_products(beat, row);
    rows
}

/// Adds the products of the first range sample with the conjugates of all: |a|^2 and a b^*.
// RISC-V has too few registers for what the compiler makes of a loop of known length
#[cfg_attr(target_arch = "riscv32", inline(never))]
#[cfg_attr(not(target_arch = "riscv32"), inline(always))]
fn add_products(beat: &[Complex<i32>], row: &mut [Complex<i64>]) {
    let ([a, others @ ..], [energy, row @ ..]) = (beat, row) else { return };
    let [re, im, minus_re] = [a.re, a.im, a.re.wrapping_neg()].map(i64::from);
    energy.re = energy.re.wrapping_add(re * re).wrapping_add(im * im);
    for (b, entry) in others.iter().zip(row) {
        // loaded first, the sums are what the compiler multiplies onto: SMLAL
        let Complex { re: sum_re, im: sum_im } = *entry;
        let (br, bi) = (i64::from(b.re), i64::from(b.im));
        entry.re = sum_re.wrapping_add(re * br).wrapping_add(im * bi);
        entry.im = sum_im.wrapping_add(im * br).wrapping_add(minus_re * bi);
    }
}

type Matrix = SMatrix<Complex<f32>, BEATS, BEATS>;
const ZEROS: Matrix = Matrix::from_array_storage(ArrayStorage([[Complex::new(0.0, 0.0); BEATS]; BEATS]));
type Vector = SVector<Complex<f32>, BEATS>;

/// Which singular components survive: `first_kept..=last_kept`, counted from 1, strongest first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SvdRange {
    /// The paper's d; 1 keeps the clutter, [`ADAPTIVE`] drops what is static.
    pub first: u8,
    /// Upper cut; 8 keeps the weakest component.
    pub last: u8,
}

/// As the first component kept: the leading components are dropped as long as they are static, at most seven.
///
/// Of the energy lambda of a component's slow-time signal `u^H b[n]`, `|sum u^H b[n]|^2 / N` is that of its mean over N slots. It is
/// clutter if that is more than [`STATIC_SHARE`] of it. Compared in integers.
pub const ADAPTIVE: u8 = 0;

/// Static share of a component's energy beyond which it is clutter, in 1/2048: 33 dB above all that moves.
pub const STATIC_SHARE: i128 = 2047;

/// Sum over slots of the range samples, `[fast_time]`, |sum| < 2^37.5.
pub(crate) type Sum = [Complex<i64>; BEATS];

/// The projection vector w in Q3.28: y = w^H b.
pub(crate) type Projection = [Complex<i32>; BEATS];

/// Fraction bits of a `Projection`; |w| <= sqrt(8) < 4.
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
    trace: i128,
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
    /// Without a matrix.
    pub const fn new() -> Self {
        ClutterSolver {
            matrix: ZEROS,
            vectors: ZEROS,
            trace: 0,
            steps_left: 0,
            kept: SvdRange { first: 0, last: 0 },
        }
    }

    /// Begins with a Gram matrix, divided by its trace, and the components to keep.
    pub fn begin(&mut self, gram: &Gram, kept: SvdRange) {
        (self.trace, self.steps_left, self.kept) = (gram.trace(), SOLVER_STEPS, kept);
        self.vectors.fill_with_identity();
        if self.trace <= 0 || (kept.first == 1 && usize::from(kept.last) >= BEATS) {
            // nothing to drop of nothing, or everything kept: the identity has no rotations to do and is not cut
            (self.trace, self.steps_left, self.kept) = (1, 0, SvdRange { first: 1, last: BEATS as u8 });
            return self.matrix.fill_with_identity();
        }
        let divisor = self.trace as f32;
        for (i, j, entry) in gram.entries() {
            let value = Complex::new(entry.re as f32 / divisor, entry.im as f32 / divisor);
            self.matrix[(i % BEATS, j % BEATS)] = value;
            self.matrix[(j % BEATS, i % BEATS)] = value.conj();
        }
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

    /// Rank from 1 of each column's component, strongest first; equal values rank by column.
    fn ranks(&self) -> [usize; BEATS] {
        let value = |column: usize| self.matrix[(column, column)].re;
        let mut ranks = [1; BEATS];
        for (column, rank) in ranks.iter_mut().enumerate() {
            let own = value(column % BEATS);
            let stronger = |&other: &usize| value(other) > own || (value(other) == own && other < column);
            *rank += (0..BEATS).filter(stronger).count();
        }
        ranks
    }

    /// Whether a column's component is static: 2048 |u^H s|^2 > [`STATIC_SHARE`] N lambda, u in Q3.28 and lambda in 2^-30 of the trace.
    fn is_static(&self, column: usize, slots: usize, sum: &Sum) -> bool {
        let largest = sum.iter().fold(0, |most, z| most | z.re.unsigned_abs() | z.im.unsigned_abs());
        let shift = (u64::BITS - largest.leading_zeros()).saturating_sub(30) & 31;
        let (mut re, mut im) = (0_i64, 0_i64);
        for (u, s) in self.vectors.column(column % BEATS).iter().zip(sum) {
            let (ur, ui) = (i64::from(to_q28(u.re)), i64::from(to_q28(u.im)));
            let (sr, si) = (s.re >> shift, s.im >> shift);
            re = re.wrapping_add(ur * sr + ui * si);
            im = im.wrapping_add(ur * si - ui * sr);
        }
        let (re, im) = (i128::from(re >> PROJECTION_BITS), i128::from(im >> PROJECTION_BITS));
        let value = roundf(self.matrix[(column % BEATS, column % BEATS)].re * (1 << 30) as f32) as i32;
        let energy = (self.trace * i128::from(value)) >> 30;
        energy > 0 && ((re * re + im * im) << (2 * shift + 11)) > STATIC_SHARE * energy * slots as i128
    }

    /// The projection, after the last step; `sum` over `slots` is that of the range samples where the first component is [`ADAPTIVE`].
    pub fn projection(&self, slots: usize, sum: &Sum) -> Projection {
        let ranks = self.ranks();
        let last = usize::from(self.kept.last);
        let mut first = usize::from(self.kept.first.max(1));
        if self.kept.first == ADAPTIVE {
            let is_clutter = |rank| (0..BEATS).any(|k| ranks[k] == rank && self.is_static(k, slots, sum));
            while first < last && is_clutter(first) {
                first += 1;
            }
        }
        let mut w = Vector::from_element(Complex::new(1.0, 0.0));
        for column in 0..BEATS {
            if ranks[column] < first || ranks[column] > last {
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

/// Adds range sample `k` of slots to its sum. If slots are `turned` by (-j)^n, the sum is that before their turns, turned as a whole.
#[inline(never)]
pub(crate) fn add_samples(sum: &mut Complex<i64>, k: usize, beats: &[Beat], turned: bool) {
    for beat in beats {
        let (Complex { re, im }, b) = (*sum, beat[k % BEATS]);
        let (re, im) = if turned { (im, re.wrapping_neg()) } else { (re, im) };
        *sum = Complex::new(re.wrapping_add(i64::from(b.re)), im.wrapping_add(i64::from(b.im)));
    }
}

/// The projection of a recording of at most [`GRAM_SLOTS`] slots at once, `[slow_time, BEATS]`.
pub fn clutter_projection(beats: &[Beat], kept: SvdRange) -> Projection {
    let (mut gram, mut sum) = (Gram::new(), Sum::default());
    beats.iter().for_each(|beat| gram.add(beat));
    if kept.first == ADAPTIVE {
        sum.iter_mut().enumerate().for_each(|(k, sum)| add_samples(sum, k, beats, false));
    }
    let mut solver = ClutterSolver::new();
    solver.begin(&gram, kept);
    while solver.step() {}
    solver.projection(beats.len(), &sum)
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
/// [`largest_part`]; a smaller one leaves the lower 32 bits, one beyond 63 is taken as 63. Exact i64 products.
pub fn project(beats: &[Beat], projection: &Projection, shift: u32, slow_time: &mut [Complex<i32>]) {
    let shift = shift.min(63);
    for (out, beat) in slow_time.iter_mut().zip(beats) {
        let y = inner(projection, beat);
        *out = Complex::new(round_shift(y.re, shift), round_shift(y.im, shift));
    }
}

/// w^H b, exact: |w| |b| < 2^1.5 2^28 2^1.5 2^25.5 < 2^57.
fn inner(projection: &Projection, beat: &Beat) -> Complex<i64> {
    // sums of products alone are what the compiler multiplies onto: SMLAL
    let (mut re, mut plus, mut minus) = (0_i64, 0_i64, 0_i64);
    for (w, b) in projection.iter().zip(beat) {
        let (wr, wi) = (i64::from(w.re), i64::from(w.im));
        let (br, bi) = (i64::from(b.re), i64::from(b.im));
        re = re.wrapping_add(wr * br).wrapping_add(wi * bi);
        plus = plus.wrapping_add(wr * bi);
        minus = minus.wrapping_add(wi * br);
    }
    Complex::new(re, plus.wrapping_sub(minus))
}

/// `round(x / 2^shift)`, halves up; shift 0 to 63.
const fn round_shift(x: i64, shift: u32) -> i32 {
    if shift == 0 { x as i32 } else { (x.wrapping_add(1 << (shift - 1)) >> shift) as i32 }
}
