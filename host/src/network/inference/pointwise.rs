//! The layers that treat every value alone, on vectors: batch normalisation and addition; and the average of all pixels.

use super::linear_add::LinearAdd;
use super::packing::{ChannelPhase, PackedAdd, PackedTerm};
use super::simd::{Kernel, LANES, SimdI32};
use sdp3_core::dsn::add::Add;
use sdp3_core::dsn::batch_norm::BatchNormRelu;

/// Values in a step: four vectors.
const STEP: usize = 4 * LANES;

/// Sets `x` to `f` of the place of 64 values, of those in `x` and of those in `other`, which are as many; behind the end are zeros.
///
/// Whole steps are read where they are: a copy on the stack may cross lines of the cache, and reading it then waits for its writing.
#[inline(always)]
fn each_step(x: &mut [i8], other: &[i8], f: impl Fn(usize, &[i8; STEP], &[i8; STEP]) -> [i8; STEP]) {
    let ((x, last_x), (other, last_other)) = (x.as_chunks_mut(), other.as_chunks());
    for (k, (x, other)) in x.iter_mut().zip(other).enumerate() {
        *x = f(k, x, other);
    }
    if !last_x.is_empty() {
        let mut ends = [[0; STEP]; 2];
        for (end, last) in ends.iter_mut().zip([&*last_x, last_other]) {
            end[..last.len()].copy_from_slice(last);
        }
        let [end_x, end_other] = &ends;
        last_x.copy_from_slice(&f(x.len(), end_x, end_other)[..last_x.len()]);
    }
}

/// Four vectors of 64 values.
#[inline(always)]
fn widen<S: SimdI32>(simd: S, values: &[i8; STEP]) -> [S::I32; 4] {
    let (four, _) = values.as_chunks::<LANES>();
    [simd.widen(&four[0]), simd.widen(&four[1]), simd.widen(&four[2]), simd.widen(&four[3])]
}

/// A batch normalisation with its ReLU.
pub struct PointwiseBatchNorm<'a> {
    pub layer: &'a BatchNormRelu<'a>,
    pub phases: &'a [ChannelPhase],
    pub input: &'a [i8],
    pub output: &'a mut [i8],
}

impl PointwiseBatchNorm<'_> {
    #[inline(always)]
    fn all<S: SimdI32, const SIGNED: bool>(self, simd: S) {
        let quant = &self.layer.quant;
        let (low, high) = (quant.act_min, quant.act_max);
        each_step(
            self.output,
            self.input,
            #[inline(always)]
            |k: usize, _: &[i8; STEP], input: &[i8; STEP]| {
                let mut v = widen(simd, input);
                for (i, v) in v.iter_mut().enumerate() {
                    // the remainder is 0 without a division where the channels begin again with every vector
                    let phase = if self.phases.len() == 1 { 0 } else { (4 * k + i) % self.phases.len() };
                    let phase = &self.phases[phase];
                    let product = simd.multiply(*v, simd.load(&phase.weights));
                    let sum = simd.add(product, simd.load(&phase.start));
                    *v = simd.requantize::<SIGNED>(sum, &phase.requantizer);
                }
                simd.narrow(v, low, high)
            },
        );
    }
}

impl Kernel for PointwiseBatchNorm<'_> {
    #[inline(always)]
    fn run<S: SimdI32>(self, simd: S) {
        if self.layer.quant.act_min >= self.layer.quant.out_zp {
            self.all::<S, false>(simd);
        } else {
            self.all::<S, true>(simd);
        }
    }
}

/// An addition with a linear form, in place.
pub struct PointwiseAdd<'a> {
    pub layer: &'a Add,
    pub form: &'a LinearAdd,
    pub x: &'a mut [i8],
    pub branch: &'a [i8],
}

impl Kernel for PointwiseAdd<'_> {
    #[inline(always)]
    fn run<S: SimdI32>(self, simd: S) {
        let ([a, b], start) =
            (self.form.weights.each_ref().map(|w| simd.load(w)), simd.load(&self.form.start));
        let (shift, low, high) = (self.form.shift, self.layer.act_min, self.layer.act_max);
        each_step(
            self.x,
            self.branch,
            #[inline(always)]
            |_: usize, x: &[i8; STEP], branch: &[i8; STEP]| {
                let (mut u, v) = (widen(simd, x), widen(simd, branch));
                for i in 0..4 {
                    let left = simd.add(simd.multiply_low(u[i], a), start);
                    u[i] = simd.shift_right(simd.add(left, simd.multiply_low(v[i], b)), shift);
                }
                simd.narrow(u, low, high)
            },
        );
    }
}

/// An addition without a linear form, in place: TFLite's three requantisations.
pub struct RequantizedAdd<'a> {
    pub layer: &'a Add,
    pub packed: &'a PackedAdd,
    pub x: &'a mut [i8],
    pub branch: &'a [i8],
}

/// An input of an addition with its guard bits; `HALF` if it is exactly halved.
#[inline(always)]
fn term<S: SimdI32, const HALF: bool>(simd: S, v: S::I32, packed: &PackedTerm) -> S::I32 {
    let offset = simd.load(&packed.offset);
    if HALF {
        simd.add(simd.shift_left::<19>(v), offset)
    } else {
        simd.requantize::<true>(simd.add(simd.shift_left::<21>(v), offset), &packed.requantizer)
    }
}

impl RequantizedAdd<'_> {
    #[inline(always)]
    fn all<S: SimdI32, const A: bool, const B: bool>(self, simd: S) {
        let PackedAdd { terms: [a, b], sum } = self.packed;
        let (low, high) = (self.layer.act_min, self.layer.act_max);
        each_step(
            self.x,
            self.branch,
            #[inline(always)]
            |_: usize, x: &[i8; STEP], branch: &[i8; STEP]| {
                let (mut u, v) = (widen(simd, x), widen(simd, branch));
                for i in 0..4 {
                    let (left, right) = (term::<S, A>(simd, u[i], a), term::<S, B>(simd, v[i], b));
                    let both = simd.add(left, right);
                    u[i] = simd.requantize::<true>(simd.add(both, both), sum);
                }
                simd.narrow(u, low, high)
            },
        );
    }
}

impl Kernel for RequantizedAdd<'_> {
    #[inline(always)]
    fn run<S: SimdI32>(self, simd: S) {
        match [self.packed.terms[0].half, self.packed.terms[1].half] {
            [true, true] => self.all::<S, true, true>(simd),
            [true, false] => self.all::<S, true, false>(simd),
            [false, true] => self.all::<S, false, true>(simd),
            [false, false] => self.all::<S, false, false>(simd),
        }
    }
}

/// The average over all pixels, halves away from zero, for channels that divide sixteen.
pub struct Average<'a> {
    pub input: &'a [i8],
    pub channels: usize,
    pub output: &'a mut [i8],
}

impl Kernel for Average<'_> {
    #[inline(always)]
    fn run<S: SimdI32>(self, simd: S) {
        let (vectors, rest) = self.input.as_chunks::<LANES>();
        let mut sums = [simd.splat(0); 4];
        let (fours, ones) = vectors.as_chunks::<4>();
        for four in fours {
            for k in 0..4 {
                sums[k] = simd.add(sums[k], simd.widen(&four[k]));
            }
        }
        for one in ones {
            sums[0] = simd.add(sums[0], simd.widen(one));
        }
        let [a, b, c, d] = sums;
        let mut sums = simd.store(simd.add(simd.add(a, b), simd.add(c, d))).0;
        for (sum, &value) in sums.iter_mut().zip(rest) {
            *sum += i32::from(value);
        }
        let pixels = (self.input.len() / self.channels) as i32;
        for (c, out) in self.output.iter_mut().take(self.channels).enumerate() {
            let sum: i32 = sums.iter().skip(c).step_by(self.channels).sum();
            let half = if sum > 0 { pixels / 2 } else { -(pixels / 2) };
            *out = ((sum + half) / pixels).clamp(-128, 127) as i8;
        }
    }
}
