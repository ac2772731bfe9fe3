//! One vector of 512 bits as sixteen lanes: AVX-512 F, BW and VNNI.

use super::flipped;
use crate::network::inference::simd::{I32x16, Kernel, LANES, Requantizer, SimdI32};
use std::arch::x86_64::*;
use std::mem::transmute;

/// One vector of 512 bits, AVX-512 F, BW and VNNI.
#[derive(Debug, Clone, Copy)]
pub struct Zmm(());

impl Zmm {
    /// The proof that this processor has the instructions.
    pub fn detect() -> Option<Self> {
        let avx512 = is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512bw");
        let vnni = is_x86_feature_detected!("avx512vnni");
        (is_x86_feature_detected!("avx2") && avx512 && vnni).then_some(Zmm(()))
    }
}

#[target_feature(enable = "avx2,avx512f,avx512bw,avx512vnni")]
fn dispatch_avx512<S: SimdI32>(simd: S, kernel: impl Kernel) {
    kernel.run(simd);
}

impl SimdI32 for Zmm {
    type I32 = __m512i;
    type I16 = __m256i;
    const INPUTS: usize = 4;
    const TILE: usize = 16;

    #[inline(always)]
    fn dispatch(self, kernel: impl Kernel) {
        // SAFETY: `self` proves AVX-512 F, BW, VNNI and AVX2.
        unsafe { dispatch_avx512(self, kernel) }
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
        // SAFETY: `self` proves AVX-512 F.
        unsafe { _mm512_set1_epi32(value) }
    }

    #[inline(always)]
    fn widen(self, values: &[i8; LANES]) -> Self::I32 {
        // SAFETY: both are 16 bytes and any bits are a value of either; `self` proves AVX-512 F.
        unsafe { _mm512_cvtepi8_epi32(transmute::<[i8; LANES], __m128i>(*values)) }
    }

    #[inline(always)]
    fn add(self, a: Self::I32, b: Self::I32) -> Self::I32 {
        // SAFETY: `self` proves AVX-512 F.
        unsafe { _mm512_add_epi32(a, b) }
    }

    #[inline(always)]
    fn sub(self, a: Self::I32, b: Self::I32) -> Self::I32 {
        // SAFETY: `self` proves AVX-512 F.
        unsafe { _mm512_sub_epi32(a, b) }
    }

    #[inline(always)]
    fn shift_right(self, a: Self::I32, by: u32) -> Self::I32 {
        // SAFETY: `self` proves AVX-512 F.
        unsafe { _mm512_sra_epi32(a, _mm_cvtsi32_si128(by as i32)) }
    }

    #[inline(always)]
    fn multiply_low(self, a: Self::I32, b: Self::I32) -> Self::I32 {
        // SAFETY: `self` proves AVX-512 F.
        unsafe { _mm512_mullo_epi32(a, b) }
    }

    half_vectors!();

    #[inline(always)]
    fn max(self, a: Self::I32, b: Self::I32) -> Self::I32 {
        // SAFETY: `self` proves AVX-512 F.
        unsafe { _mm512_max_epi32(a, b) }
    }

    #[inline(always)]
    fn shift_left<const N: i32>(self, a: Self::I32) -> Self::I32 {
        // SAFETY: `self` proves AVX-512 F; the shift by a vector is by the same `N` in all lanes.
        unsafe { _mm512_sllv_epi32(a, _mm512_set1_epi32(N)) }
    }

    #[inline(always)]
    fn multiply(self, a: Self::I32, b: Self::I32) -> Self::I32 {
        // SAFETY: `self` proves AVX-512 BW.
        unsafe { _mm512_madd_epi16(a, b) }
    }

    #[inline(always)]
    fn dot(self, acc: Self::I32, word: i32, weights: Self::I32) -> Self::I32 {
        // SAFETY: `self` proves AVX-512 VNNI.
        unsafe { _mm512_dpbusd_epi32(acc, _mm512_set1_epi32(word), weights) }
    }

    #[inline(always)]
    fn requantize<const SIGNED: bool>(self, twice: Self::I32, by: &Requantizer) -> Self::I32 {
        // SAFETY: `self` proves AVX-512 F.
        unsafe {
            let high = _mm512_srli_epi64::<32>(twice);
            let (even_m, odd_m) = (self.load(&by.multipliers), self.load(&by.odd_multipliers));
            let even = _mm512_add_epi64(_mm512_mul_epi32(twice, even_m), self.load(&by.even_offsets));
            let odd = _mm512_add_epi64(_mm512_mul_epi32(high, odd_m), self.load(&by.odd_offsets));
            let x = _mm512_mask_shuffle_epi32::<_MM_PERM_CDAB>(odd, 0b0101_0101_0101_0101, even);
            let x = if SIGNED { _mm512_add_epi32(x, _mm512_srai_epi32::<31>(twice)) } else { x };
            _mm512_srav_epi32(x, self.load(&by.shifts))
        }
    }

    #[inline(always)]
    fn narrow(self, v: [Self::I32; 4], low: i8, high: i8) -> [i8; 4 * LANES] {
        // SAFETY: `self` proves AVX-512 BW; both are 64 bytes and any bits are a value of either.
        unsafe {
            // packing works in quarters of 128 bits: a transposition of four by four puts them in order
            let order = _mm512_setr_epi32(0, 4, 8, 12, 1, 5, 9, 13, 2, 6, 10, 14, 3, 7, 11, 15);
            let (a, b) = (_mm512_packs_epi32(v[0], v[1]), _mm512_packs_epi32(v[2], v[3]));
            let bytes = _mm512_permutexvar_epi32(order, _mm512_packs_epi16(a, b));
            let bytes = _mm512_max_epi8(bytes, _mm512_set1_epi8(low));
            transmute(_mm512_min_epi8(bytes, _mm512_set1_epi8(high)))
        }
    }

    #[inline(always)]
    fn input_words(self, values: &[i8], words: &mut [i32]) {
        flipped(values, words);
    }
}
