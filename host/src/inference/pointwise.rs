//! The layers that treat every value alone, on vectors: affine and addition, and the average over all pixels.

use super::packing::{is_half, phases};
use crate::dsn::add::Add;
use crate::dsn::batch_norm::BatchNormRelu;
use crate::dsn::pool::mean;
use crate::simd::{Job, LANES, Lanes, Line, Rescale};

/// Values in a step: four vectors.
const STEP: usize = 4 * LANES;

/// The `k`-th 64 values; behind the end zeros.
#[inline(always)]
fn step(values: &[i8], k: usize) -> [i8; STEP] {
    let rest = values.get(k * STEP..).unwrap_or(&[]);
    match rest.first_chunk() {
        Some(whole) => *whole,
        None => last(rest),
    }
}

/// Fewer than 64 values, and zeros.
#[inline(never)]
fn last(rest: &[i8]) -> [i8; STEP] {
    let mut out = [0; STEP];
    out.iter_mut().zip(rest).for_each(|(o, &r)| *o = r);
    out
}

/// Writes the `k`-th 64 values, as many of them as there are.
#[inline(always)]
fn put(values: &mut [i8], k: usize, step: &[i8; STEP]) {
    let rest = values.get_mut(k * STEP..).unwrap_or_default();
    if let Some(whole) = rest.first_chunk_mut() {
        *whole = *step;
    } else {
        put_last(rest, step);
    }
}

/// Writes fewer than 64 values.
#[inline(never)]
fn put_last(rest: &mut [i8], step: &[i8; STEP]) {
    rest.iter_mut().zip(step).for_each(|(r, &s)| *r = s);
}

/// Four vectors of 64 values.
#[inline(always)]
fn widen<L: Lanes>(lanes: L, values: &[i8; STEP]) -> [L::V; 4] {
    let (four, _) = values.as_chunks::<LANES>();
    match four {
        [a, b, c, d] => [lanes.widen(a), lanes.widen(b), lanes.widen(c), lanes.widen(d)],
        _ => [lanes.splat(0); 4],
    }
}

/// An affine layer with its ReLU.
pub struct PointwiseAffine<'a> {
    pub layer: &'a BatchNormRelu<'a>,
    pub lines: &'a [Line],
    pub input: &'a [i8],
    pub output: &'a mut [i8],
}

impl PointwiseAffine<'_> {
    /// One phase of the channels: sixteen lanes.
    #[inline(always)]
    fn vector<L: Lanes, const SIGNED: bool>(lanes: L, x: L::V, lines: &[Line; 7]) -> L::V {
        let [bias, weights, rescale @ ..] = lines;
        let sum = lanes.add(lanes.multiply(x, lanes.load(weights)), lanes.load(bias));
        lanes.rescale::<SIGNED>(sum, rescale)
    }

    #[inline(always)]
    fn all<L: Lanes, const SIGNED: bool>(self, lanes: L) {
        let layer = &self.layer.layer;
        let count = phases(layer.channels).max(1);
        let (all, _) = self.lines.as_chunks::<7>();
        let Some(all) = all.get(..count) else { return };
        let (low, high) = (layer.act_min, layer.act_max);
        for k in 0..self.output.len().div_ceil(STEP) {
            let mut v = widen(lanes, &step(self.input, k));
            for (i, v) in v.iter_mut().enumerate() {
                // the remainder is 0 without a division where the channels begin anew with every vector
                let phase = if count == 1 { 0 } else { (4 * k + i) % count };
                let Some(lines) = all.get(phase) else { return };
                *v = Self::vector::<L, SIGNED>(lanes, *v, lines);
            }
            put(self.output, k, &lanes.narrow(v, low, high));
        }
    }
}

impl Job for PointwiseAffine<'_> {
    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        if self.layer.layer.act_min >= self.layer.layer.out_zp {
            self.all::<L, false>(lanes);
        } else {
            self.all::<L, true>(lanes);
        }
    }
}

/// An addition, in place.
pub struct PointwiseAdd<'a> {
    pub layer: &'a Add,
    pub lines: &'a [Line],
    pub x: &'a mut [i8],
    pub branch: &'a [i8],
}

/// An input of an addition with its guard bits; `HALF` if its scale is the larger one, so that it is exactly halved.
#[inline(always)]
fn term<L: Lanes, const HALF: bool>(lanes: L, v: L::V, offset: L::V, rescale: &Rescale) -> L::V {
    if HALF {
        lanes.add(lanes.shift_left::<19>(v), offset)
    } else {
        lanes.rescale::<true>(lanes.add(lanes.shift_left::<20>(v), offset), rescale)
    }
}

impl PointwiseAdd<'_> {
    #[inline(always)]
    fn all<L: Lanes, const A: bool, const B: bool>(self, lanes: L) -> Option<()> {
        let (offsets, rest) = self.lines.split_first_chunk::<2>()?;
        let (scales, _) = rest.as_chunks::<5>();
        let [first, second, last, ..] = scales else { return None };
        let [a, b] = [lanes.load(&offsets[0]), lanes.load(&offsets[1])];
        let (low, high) = (self.layer.act_min, self.layer.act_max);
        for k in 0..self.x.len().div_ceil(STEP) {
            let (mut u, v) = (widen(lanes, &step(self.x, k)), widen(lanes, &step(self.branch, k)));
            for i in 0..4 {
                let left = term::<L, A>(lanes, u[i], a, first);
                let right = term::<L, B>(lanes, v[i], b, second);
                u[i] = lanes.rescale::<true>(lanes.add(left, right), last);
            }
            put(self.x, k, &lanes.narrow(u, low, high));
        }
        Some(())
    }
}

impl Job for PointwiseAdd<'_> {
    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let half = |k: usize| is_half(self.layer.multiplier[k], self.layer.shift[k]);
        let _ = match (half(0), half(1)) {
            (true, true) => self.all::<L, true, true>(lanes),
            (true, false) => self.all::<L, true, false>(lanes),
            (false, true) => self.all::<L, false, true>(lanes),
            (false, false) => self.all::<L, false, false>(lanes),
        };
    }
}

/// [`crate::dsn::pool::average`] for channels that divide sixteen.
pub struct Average<'a> {
    pub input: &'a [i8],
    pub channels: usize,
    pub output: &'a mut [i8],
}

impl Job for Average<'_> {
    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let (vectors, rest) = self.input.as_chunks::<LANES>();
        let mut sums = [lanes.splat(0); 4];
        let (fours, ones) = vectors.as_chunks::<4>();
        for four in fours {
            for k in 0..4 {
                sums[k] = lanes.add(sums[k], lanes.widen(&four[k]));
            }
        }
        for one in ones {
            sums[0] = lanes.add(sums[0], lanes.widen(one));
        }
        let [a, b, c, d] = sums;
        let mut sums = lanes.store(lanes.add(lanes.add(a, b), lanes.add(c, d))).0;
        for (sum, &value) in sums.iter_mut().zip(rest) {
            *sum += i32::from(value);
        }
        let pixels = self.input.len() / self.channels.max(1);
        for (c, out) in self.output.iter_mut().take(self.channels).enumerate() {
            *out = mean(sums.iter().skip(c).step_by(self.channels.max(1)).sum(), pixels);
        }
    }
}
