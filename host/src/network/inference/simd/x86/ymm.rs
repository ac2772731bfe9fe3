//! Two vectors of 256 bits as sixteen lanes: AVX2, with or without AVX-VNNI.

use super::flipped;
use crate::network::inference::simd::{I32x16, Kernel, LANES, Requantizer, SimdI32, group_words};
use std::arch::x86_64::*;
use std::mem::transmute;

/// Two vectors of 256 bits, AVX2; with `VNNI` also AVX-VNNI.
#[derive(Debug, Clone, Copy)]
pub struct Ymm<const VNNI: bool>(());

impl<const VNNI: bool> Ymm<VNNI> {
    /// The proof that this processor has the instructions.
    pub fn detect() -> Option<Self> {
        let vnni = !VNNI || is_x86_feature_detected!("avxvnni");
        (is_x86_feature_detected!("avx2") && vnni).then_some(Ymm(()))
    }
}

#[target_feature(enable = "avx2")]
fn dispatch_avx2<S: SimdI32>(simd: S, kernel: impl Kernel) {
    kernel.run(simd);
}

#[target_feature(enable = "avx2,avxvnni")]
fn dispatch_avx_vnni<S: SimdI32>(simd: S, kernel: impl Kernel) {
    kernel.run(simd);
}

/// Eight lanes of [`SimdI32::requantize`]: 64-bit products of the even and the odd lanes, then one shift each.
#[inline]
#[target_feature(enable = "avx2")]
fn requantize_ymm<const SIGNED: bool>(twice: __m256i, [m, m_odd, even, odd, shift]: [__m256i; 5]) -> __m256i {
    let high = _mm256_srli_epi64::<32>(twice);
    let even = _mm256_srli_epi64::<32>(_mm256_add_epi64(_mm256_mul_epi32(twice, m), even));
    let odd = _mm256_add_epi64(_mm256_mul_epi32(high, m_odd), odd);
    let x = _mm256_blend_epi32::<0b1010_1010>(even, odd);
    let x = if SIGNED { _mm256_add_epi32(x, _mm256_srai_epi32::<31>(twice)) } else { x };
    _mm256_srav_epi32(x, shift)
}

/// Half of [`SimdI32::narrow`].
#[inline]
#[target_feature(enable = "avx2")]
fn narrow_ymm(a: [__m256i; 2], b: [__m256i; 2], low: i8, high: i8) -> __m256i {
    // packing works in halves of 128 bits: quarters 0 2 of each come before 1 3
    let order = _mm256_setr_epi32(0, 4, 1, 5, 2, 6, 3, 7);
    let (a, b) = (_mm256_packs_epi32(a[0], a[1]), _mm256_packs_epi32(b[0], b[1]));
    let bytes = _mm256_permutevar8x32_epi32(_mm256_packs_epi16(a, b), order);
    _mm256_min_epi8(_mm256_max_epi8(bytes, _mm256_set1_epi8(low)), _mm256_set1_epi8(high))
}

impl<const VNNI: bool> SimdI32 for Ymm<VNNI> {
    type I32 = [__m256i; 2];
    type I16 = __m256i;
    const INPUTS: usize = if VNNI { 4 } else { 2 };
    const TILE: usize = 4;

    #[inline(always)]
    fn dispatch(self, kernel: impl Kernel) {
        // SAFETY: `self` proves AVX2, with `VNNI` also AVX-VNNI.
        unsafe { if VNNI { dispatch_avx_vnni(self, kernel) } else { dispatch_avx2(self, kernel) } }
    }

    #[inline(always)]
    fn load(self, vector: &I32x16) -> Self::I32 {
        // SAFETY: both are 64 bytes and any bits are a value of either.
        unsafe { transmute(vector.0) }
    }

    #[inline(always)]
    fn store(self, v: Self::I32) -> I32x16 {
        // SAFETY: both are 64 bytes and any bits are a value of either.
        I32x16(unsafe { transmute::<Self::I32, [i32; LANES]>(v) })
    }

    #[inline(always)]
    fn splat(self, value: i32) -> Self::I32 {
        // SAFETY: `self` proves AVX2.
        unsafe { [_mm256_set1_epi32(value); 2] }
    }

    #[inline(always)]
    fn widen(self, values: &[i8; LANES]) -> Self::I32 {
        // SAFETY: both are 16 bytes and any bits are a value of either; `self` proves AVX2.
        unsafe {
            let v: __m128i = transmute(*values);
            [_mm256_cvtepi8_epi32(v), _mm256_cvtepi8_epi32(_mm_srli_si128::<8>(v))]
        }
    }

    #[inline(always)]
    fn add(self, a: Self::I32, b: Self::I32) -> Self::I32 {
        // SAFETY: `self` proves AVX2.
        unsafe { [_mm256_add_epi32(a[0], b[0]), _mm256_add_epi32(a[1], b[1])] }
    }

    #[inline(always)]
    fn sub(self, a: Self::I32, b: Self::I32) -> Self::I32 {
        // SAFETY: `self` proves AVX2.
        unsafe { [_mm256_sub_epi32(a[0], b[0]), _mm256_sub_epi32(a[1], b[1])] }
    }

    #[inline(always)]
    fn shift_right(self, a: Self::I32, by: u32) -> Self::I32 {
        // SAFETY: `self` proves AVX2.
        unsafe {
            let by = _mm_cvtsi32_si128(by as i32);
            [_mm256_sra_epi32(a[0], by), _mm256_sra_epi32(a[1], by)]
        }
    }

    #[inline(always)]
    fn multiply_low(self, a: Self::I32, b: Self::I32) -> Self::I32 {
        // SAFETY: `self` proves AVX2.
        unsafe { [_mm256_mullo_epi32(a[0], b[0]), _mm256_mullo_epi32(a[1], b[1])] }
    }

    half_vectors!();

    #[inline(always)]
    fn max(self, a: Self::I32, b: Self::I32) -> Self::I32 {
        // SAFETY: `self` proves AVX2.
        unsafe { [_mm256_max_epi32(a[0], b[0]), _mm256_max_epi32(a[1], b[1])] }
    }

    #[inline(always)]
    fn shift_left<const N: i32>(self, a: Self::I32) -> Self::I32 {
        // SAFETY: `self` proves AVX2.
        unsafe { [_mm256_slli_epi32::<N>(a[0]), _mm256_slli_epi32::<N>(a[1])] }
    }

    #[inline(always)]
    fn multiply(self, a: Self::I32, b: Self::I32) -> Self::I32 {
        // SAFETY: `self` proves AVX2.
        unsafe { [_mm256_madd_epi16(a[0], b[0]), _mm256_madd_epi16(a[1], b[1])] }
    }

    #[inline(always)]
    fn dot(self, acc: Self::I32, word: i32, weights: Self::I32) -> Self::I32 {
        // SAFETY: `self` proves AVX2, with `VNNI` also AVX-VNNI.
        unsafe {
            let word = _mm256_set1_epi32(word);
            let ([a, b], [v, w]) = (acc, weights);
            if VNNI {
                [_mm256_dpbusd_avx_epi32(a, word, v), _mm256_dpbusd_avx_epi32(b, word, w)]
            } else {
                let (v, w) = (_mm256_madd_epi16(word, v), _mm256_madd_epi16(word, w));
                [_mm256_add_epi32(a, v), _mm256_add_epi32(b, w)]
            }
        }
    }

    #[inline(always)]
    fn requantize<const SIGNED: bool>(self, twice: Self::I32, by: &Requantizer) -> Self::I32 {
        let (m, m_odd) = (self.load(&by.multipliers), self.load(&by.odd_multipliers));
        let (even, odd) = (self.load(&by.even_offsets), self.load(&by.odd_offsets));
        let shift = self.load(&by.shifts);
        // SAFETY: `self` proves AVX2.
        unsafe {
            [
                requantize_ymm::<SIGNED>(twice[0], [m[0], m_odd[0], even[0], odd[0], shift[0]]),
                requantize_ymm::<SIGNED>(twice[1], [m[1], m_odd[1], even[1], odd[1], shift[1]]),
            ]
        }
    }

    #[inline(always)]
    fn narrow(self, v: [Self::I32; 4], low: i8, high: i8) -> [i8; 4 * LANES] {
        // SAFETY: `self` proves AVX2; the result is 64 bytes of which any bits are values.
        unsafe { transmute([narrow_ymm(v[0], v[1], low, high), narrow_ymm(v[2], v[3], low, high)]) }
    }

    #[inline(always)]
    fn input_words(self, values: &[i8], words: &mut [i32]) {
        if VNNI {
            return flipped(values, words);
        }
        let ((values, rest), (words, rest_words)) = (values.as_chunks::<16>(), words.as_chunks_mut::<8>());
        for (&values, words) in values.iter().zip(words) {
            // SAFETY: sizes are equal, 16 and 32 bytes, and any bits are values; `self` proves AVX2.
            *words = unsafe {
                let wide = _mm256_cvtepi8_epi16(transmute::<[i8; LANES], __m128i>(values));
                transmute::<__m256i, [i32; LANES / 2]>(wide)
            };
        }
        let (rest, _) = rest.as_chunks::<4>();
        for (&four, words) in rest.iter().zip(rest_words.chunks_exact_mut(2)) {
            group_words::<2>(four, words);
        }
    }
}
