//! The layers that treat every value alone, on vectors: batch normalisation and addition; and the average of all pixels.

use super::linear_add::LinearAdd;
use super::packing::{ChannelPhase, PackedAdd, PackedTerm};
use super::simd::{Kernel, LANES, SimdI32};
use sdp3_core::dsn::add::Add;
use sdp3_core::dsn::batch_norm::BatchNormRelu;

/// Values in a step: four vectors.
const STEP: usize = 4 * LANES;

/// The `k`-th 64 values; behind the end zeros.
#[inline(always)]
fn load(values: &[i8], k: usize) -> [i8; STEP] {
    let rest = &values[k * STEP..];
    match rest.first_chunk() {
        Some(whole) => *whole,
        None => load_partial(rest),
    }
}

/// Fewer than 64 values, and zeros.
#[inline(never)]
fn load_partial(rest: &[i8]) -> [i8; STEP] {
    let mut out = [0; STEP];
    out[..rest.len()].copy_from_slice(rest);
    out
}

/// Writes the `k`-th 64 values, as many of them as there are.
#[inline(always)]
fn store(values: &mut [i8], k: usize, step: &[i8; STEP]) {
    let rest = &mut values[k * STEP..];
    if let Some(whole) = rest.first_chunk_mut() {
        *whole = *step;
    } else {
        store_partial(rest, step);
    }
}

/// Writes fewer than 64 values.
#[inline(never)]
fn store_partial(rest: &mut [i8], step: &[i8; STEP]) {
    rest.copy_from_slice(&step[..rest.len()]);
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
        for k in 0..self.output.len().div_ceil(STEP) {
            let mut v = widen(simd, &load(self.input, k));
            for (i, v) in v.iter_mut().enumerate() {
                // the remainder is 0 without a division where the channels begin again with every vector
                let phase = if self.phases.len() == 1 { 0 } else { (4 * k + i) % self.phases.len() };
                let phase = &self.phases[phase];
                let product = simd.multiply(*v, simd.load(&phase.weights));
                let sum = simd.add(product, simd.load(&phase.start));
                *v = simd.requantize::<SIGNED>(sum, &phase.requantizer);
            }
            store(self.output, k, &simd.narrow(v, low, high));
        }
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
        for k in 0..self.x.len().div_ceil(STEP) {
            let (mut u, v) = (widen(simd, &load(self.x, k)), widen(simd, &load(self.branch, k)));
            for i in 0..4 {
                let left = simd.add(simd.multiply_low(u[i], a), start);
                u[i] = simd.shift_right(simd.add(left, simd.multiply_low(v[i], b)), self.form.shift);
            }
            store(self.x, k, &simd.narrow(u, self.layer.act_min, self.layer.act_max));
        }
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
        for k in 0..self.x.len().div_ceil(STEP) {
            let (mut u, v) = (widen(simd, &load(self.x, k)), widen(simd, &load(self.branch, k)));
            for i in 0..4 {
                let (left, right) = (term::<S, A>(simd, u[i], a), term::<S, B>(simd, v[i], b));
                let both = simd.add(left, right);
                u[i] = simd.requantize::<true>(simd.add(both, both), sum);
            }
            store(self.x, k, &simd.narrow(u, low, high));
        }
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
