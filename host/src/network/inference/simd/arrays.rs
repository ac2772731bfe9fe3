//! Sixteen lanes as an array, left to the compiler: the portable implementation, and the reference of the others.

use super::{I32x16, Kernel, LANES, Requantizer, SimdI32, group_words};

/// Sixteen lanes as an array, with `INPUTS` 2 or 4 inputs in a word.
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

impl<const INPUTS: usize> SimdI32 for Arrays<INPUTS> {
    type I32 = [i32; LANES];
    type I16 = [[i16; 2]; LANES / 2];
    const INPUTS: usize = INPUTS;
    const TILE: usize = 4;

    #[inline(always)]
    fn dispatch(self, kernel: impl Kernel) {
        kernel.run(self);
    }

    #[inline(always)]
    fn load(self, vector: &I32x16) -> Self::I32 {
        vector.0
    }

    #[inline(always)]
    fn store(self, v: Self::I32) -> I32x16 {
        I32x16(v)
    }

    #[inline(always)]
    fn splat(self, value: i32) -> Self::I32 {
        [value; LANES]
    }

    #[inline(always)]
    fn widen(self, values: &[i8; LANES]) -> Self::I32 {
        values.map(i32::from)
    }

    #[inline(always)]
    fn add(self, a: Self::I32, b: Self::I32) -> Self::I32 {
        each(a, b, i32::wrapping_add)
    }

    #[inline(always)]
    fn sub(self, a: Self::I32, b: Self::I32) -> Self::I32 {
        each(a, b, i32::wrapping_sub)
    }

    #[inline(always)]
    fn shift_right(self, a: Self::I32, by: u32) -> Self::I32 {
        a.map(|v| v >> (by & 31))
    }

    #[inline(always)]
    fn multiply_low(self, a: Self::I32, b: Self::I32) -> Self::I32 {
        each(a, b, i32::wrapping_mul)
    }

    #[inline(always)]
    fn load16(self, words: &[i32; LANES / 2]) -> Self::I16 {
        words.map(|w| [w as i16, (w >> 16) as i16])
    }

    #[inline(always)]
    fn store16(self, h: Self::I16) -> [i32; LANES / 2] {
        h.map(|[low, high]| i32::from(low) & 0xffff | i32::from(high) << 16)
    }

    #[inline(always)]
    fn add16(self, a: Self::I16, b: Self::I16) -> Self::I16 {
        each16(a, b, i16::wrapping_add)
    }

    #[inline(always)]
    fn sub16(self, a: Self::I16, b: Self::I16) -> Self::I16 {
        each16(a, b, i16::wrapping_sub)
    }

    #[inline(always)]
    fn shift_left16<const N: i32>(self, a: Self::I16) -> Self::I16 {
        a.map(|pair| pair.map(|v| v << N))
    }

    #[inline(always)]
    fn max(self, a: Self::I32, b: Self::I32) -> Self::I32 {
        each(a, b, i32::max)
    }

    #[inline(always)]
    fn shift_left<const N: i32>(self, a: Self::I32) -> Self::I32 {
        a.map(|v| v << N)
    }

    #[inline(always)]
    fn multiply(self, a: Self::I32, b: Self::I32) -> Self::I32 {
        each(a, b, |a, b| i32::from(a as i16) * i32::from(b as i16))
    }

    #[inline(always)]
    fn dot(self, acc: Self::I32, word: i32, weights: Self::I32) -> Self::I32 {
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
    fn requantize<const SIGNED: bool>(self, twice: Self::I32, by: &Requantizer) -> Self::I32 {
        let mut out = twice;
        for (lane, out) in out.iter_mut().enumerate() {
            let even = lane & !1;
            let offsets = if lane == even { &by.even_offsets } else { &by.odd_offsets };
            let offset = i64::from(offsets.0[even + 1]) << 32 | i64::from(offsets.0[even] as u32);
            let product = i64::from(*out) * i64::from(by.multipliers.0[lane]) + offset;
            let away = if SIGNED { *out >> 31 } else { 0 };
            *out = ((product >> 32) as i32).wrapping_add(away) >> (by.shifts.0[lane] & 31);
        }
        out
    }

    #[inline(always)]
    fn narrow(self, v: [Self::I32; 4], low: i8, high: i8) -> [i8; 4 * LANES] {
        let mut out = [0; 4 * LANES];
        for (out, v) in out.iter_mut().zip(v.as_flattened()) {
            *out = ((*v).clamp(-128, 127) as i8).max(low).min(high);
        }
        out
    }

    #[inline(always)]
    fn input_words(self, values: &[i8], words: &mut [i32]) {
        let (fours, _) = values.as_chunks::<4>();
        for (&four, words) in fours.iter().zip(words.chunks_exact_mut(4 / INPUTS)) {
            group_words::<INPUTS>(four, words);
        }
    }
}
