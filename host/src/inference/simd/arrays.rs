//! The portable twin of every vector instruction set: sixteen lanes as an array, left to the compiler.

use super::{Job, LANES, Lanes, Line, Rescale, quad_words};

/// Lanes as an array; `INPUTS` 2 or 4 inputs in a word, as the processor that is compared has them.
#[derive(Debug, Clone, Copy)]
pub struct Arrays<const INPUTS: usize>;

/// `f` of two vectors, lane by lane.
#[inline(always)]
fn each(a: [i32; LANES], b: [i32; LANES], f: impl Fn(i32, i32) -> i32) -> [i32; LANES] {
    let mut out = a;
    for (out, b) in out.iter_mut().zip(b) {
        *out = f(*out, b);
    }
    out
}

/// `f` of two half vectors, i16 by i16.
#[inline(always)]
fn each16(
    a: [[i16; 2]; LANES / 2],
    b: [[i16; 2]; LANES / 2],
    f: impl Fn(i16, i16) -> i16,
) -> [[i16; 2]; LANES / 2] {
    let mut out = a;
    for (out, b) in out.as_flattened_mut().iter_mut().zip(b.as_flattened()) {
        *out = f(*out, *b);
    }
    out
}

impl<const INPUTS: usize> Lanes for Arrays<INPUTS> {
    type V = [i32; LANES];
    type H = [[i16; 2]; LANES / 2];
    const INPUTS: usize = INPUTS;
    const TILE: usize = 4;

    #[inline(always)]
    fn enter(self, job: impl Job) {
        job.run(self);
    }

    #[inline(always)]
    fn load(self, line: &Line) -> Self::V {
        line.0
    }

    #[inline(always)]
    fn store(self, v: Self::V) -> Line {
        Line(v)
    }

    #[inline(always)]
    fn splat(self, value: i32) -> Self::V {
        [value; LANES]
    }

    #[inline(always)]
    fn widen(self, values: &[i8; LANES]) -> Self::V {
        values.map(i32::from)
    }

    #[inline(always)]
    fn add(self, a: Self::V, b: Self::V) -> Self::V {
        each(a, b, i32::wrapping_add)
    }

    #[inline(always)]
    fn sub(self, a: Self::V, b: Self::V) -> Self::V {
        each(a, b, i32::wrapping_sub)
    }

    #[inline(always)]
    fn shift_right(self, a: Self::V, by: u32) -> Self::V {
        a.map(|v| v >> (by & 31))
    }

    #[inline(always)]
    fn multiply_low(self, a: Self::V, b: Self::V) -> Self::V {
        each(a, b, i32::wrapping_mul)
    }

    #[inline(always)]
    fn load16(self, words: &[i32; LANES / 2]) -> Self::H {
        words.map(|w| [w as i16, (w >> 16) as i16])
    }

    #[inline(always)]
    fn store16(self, h: Self::H) -> [i32; LANES / 2] {
        h.map(|[low, high]| i32::from(low) & 0xffff | i32::from(high) << 16)
    }

    #[inline(always)]
    fn add16(self, a: Self::H, b: Self::H) -> Self::H {
        each16(a, b, i16::wrapping_add)
    }

    #[inline(always)]
    fn sub16(self, a: Self::H, b: Self::H) -> Self::H {
        each16(a, b, i16::wrapping_sub)
    }

    #[inline(always)]
    fn shift_left16<const N: i32>(self, a: Self::H) -> Self::H {
        a.map(|pair| pair.map(|v| v << N))
    }

    #[inline(always)]
    fn max(self, a: Self::V, b: Self::V) -> Self::V {
        each(a, b, i32::max)
    }

    #[inline(always)]
    fn shift_left<const N: i32>(self, a: Self::V) -> Self::V {
        a.map(|v| v << N)
    }

    #[inline(always)]
    fn multiply(self, a: Self::V, b: Self::V) -> Self::V {
        each(a, b, |a, b| i32::from(a as i16) * i32::from(b as i16))
    }

    #[inline(always)]
    fn dot(self, acc: Self::V, word: i32, weights: Self::V) -> Self::V {
        let sum = |w: i32| {
            if INPUTS == 2 {
                (i32::from(word as i16) * i32::from(w as i16)).wrapping_add((word >> 16) * (w >> 16))
            } else {
                let products = word.to_le_bytes().into_iter().zip(w.to_le_bytes());
                products.map(|(x, w)| i32::from(x) * i32::from(w as i8)).sum()
            }
        };
        each(acc, weights, |acc, w| acc.wrapping_add(sum(w)))
    }

    #[inline(always)]
    fn rescale<const SIGNED: bool>(self, acc: Self::V, lines: &Rescale) -> Self::V {
        let [multipliers, _, even, odd, shifts] = lines;
        let mut out = acc;
        for (lane, out) in out.iter_mut().enumerate() {
            let offsets = if lane % 2 == 0 { even } else { odd };
            let at = |line: &Line, lane: usize| line.0.get(lane).copied().unwrap_or(0);
            let low = i64::from(at(offsets, lane & !1) as u32);
            let offset = i64::from(at(offsets, lane | 1)) << 32 | low;
            let product = i64::from(*out) * i64::from(at(multipliers, lane)) + offset;
            let away = if SIGNED { *out >> 31 } else { 0 };
            *out = ((product >> 31) as i32).wrapping_add(away) >> (at(shifts, lane) & 31);
        }
        out
    }

    #[inline(always)]
    fn narrow(self, v: [Self::V; 4], low: i8, high: i8) -> [i8; 4 * LANES] {
        let mut out = [0; 4 * LANES];
        for (out, v) in out.iter_mut().zip(v.as_flattened()) {
            *out = ((*v).clamp(-128, 127) as i8).max(low).min(high);
        }
        out
    }

    #[inline(always)]
    fn words(self, values: &[i8], words: &mut [i32]) {
        let (fours, _) = values.as_chunks::<4>();
        for (&four, words) in fours.iter().zip(words.chunks_exact_mut(4 / INPUTS)) {
            quad_words::<INPUTS>(four, words);
        }
    }
}
