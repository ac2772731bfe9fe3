//! One vector of 512 bits as sixteen lanes: AVX-512 F, BW and VNNI.

use super::{features, flipped};
use crate::simd::{Job, LANES, Lanes, Line, Rescale};
use core::arch::x86_64::*;
use core::mem::transmute;

/// One vector of 512 bits, AVX-512 F, BW and VNNI.
#[derive(Debug, Clone, Copy)]
pub struct Zmm(());

impl Zmm {
    /// The proof that this processor has the instructions.
    pub fn detect() -> Option<Self> {
        features()[2].then_some(Zmm(()))
    }
}

#[target_feature(enable = "avx2,avx512f,avx512bw,avx512vnni")]
fn enter_avx512<L: Lanes>(lanes: L, job: impl Job) {
    job.run(lanes);
}

impl Lanes for Zmm {
    type V = __m512i;
    type H = __m256i;
    const INPUTS: usize = 4;
    const TILE: usize = 16;

    #[inline(always)]
    fn enter(self, job: impl Job) {
        // SAFETY: `self` proves AVX-512 F, BW, VNNI and AVX2.
        unsafe { enter_avx512(self, job) }
    }

    #[inline(always)]
    fn load(self, line: &Line) -> Self::V {
        // SAFETY: both are 64 bytes and any bits are a value of either.
        unsafe { transmute(line.0) }
    }

    #[inline(always)]
    fn store(self, v: Self::V) -> Line {
        // SAFETY: both are 64 bytes and any bits are a value of either.
        Line(unsafe { transmute::<Self::V, [i32; LANES]>(v) })
    }

    #[inline(always)]
    fn splat(self, value: i32) -> Self::V {
        // SAFETY: `self` proves AVX-512 F.
        unsafe { _mm512_set1_epi32(value) }
    }

    #[inline(always)]
    fn widen(self, values: &[i8; LANES]) -> Self::V {
        // SAFETY: both are 16 bytes and any bits are a value of either; `self` proves AVX-512 F.
        unsafe { _mm512_cvtepi8_epi32(transmute::<[i8; LANES], __m128i>(*values)) }
    }

    #[inline(always)]
    fn add(self, a: Self::V, b: Self::V) -> Self::V {
        // SAFETY: `self` proves AVX-512 F.
        unsafe { _mm512_add_epi32(a, b) }
    }

    #[inline(always)]
    fn sub(self, a: Self::V, b: Self::V) -> Self::V {
        // SAFETY: `self` proves AVX-512 F.
        unsafe { _mm512_sub_epi32(a, b) }
    }

    #[inline(always)]
    fn shift_right(self, a: Self::V, by: u32) -> Self::V {
        // SAFETY: `self` proves AVX-512 F.
        unsafe { _mm512_sra_epi32(a, _mm_cvtsi32_si128(by as i32)) }
    }

    #[inline(always)]
    fn multiply_low(self, a: Self::V, b: Self::V) -> Self::V {
        // SAFETY: `self` proves AVX-512 F.
        unsafe { _mm512_mullo_epi32(a, b) }
    }

    half_vectors!();

    #[inline(always)]
    fn max(self, a: Self::V, b: Self::V) -> Self::V {
        // SAFETY: `self` proves AVX-512 F.
        unsafe { _mm512_max_epi32(a, b) }
    }

    #[inline(always)]
    fn shift_left<const N: i32>(self, a: Self::V) -> Self::V {
        // SAFETY: `self` proves AVX-512 F; the shift by a vector is by the same `N` in all lanes.
        unsafe { _mm512_sllv_epi32(a, _mm512_set1_epi32(N)) }
    }

    #[inline(always)]
    fn multiply(self, a: Self::V, b: Self::V) -> Self::V {
        // SAFETY: `self` proves AVX-512 BW. The upper half of b's lanes is cleared, so its sign adds nothing.
        unsafe { _mm512_madd_epi16(a, _mm512_and_si512(b, _mm512_set1_epi32(0xffff))) }
    }

    #[inline(always)]
    fn dot(self, acc: Self::V, word: i32, weights: Self::V) -> Self::V {
        // SAFETY: `self` proves AVX-512 VNNI.
        unsafe { _mm512_dpbusd_epi32(acc, _mm512_set1_epi32(word), weights) }
    }

    #[inline(always)]
    fn rescale<const SIGNED: bool>(self, acc: Self::V, lines: &Rescale) -> Self::V {
        let [m, m_odd, even, odd, shift] = lines;
        // SAFETY: `self` proves AVX-512 F.
        unsafe {
            let high = _mm512_srli_epi64::<32>(acc);
            let (even_m, odd_m) = (self.load(m), self.load(m_odd));
            let even = _mm512_add_epi64(_mm512_mul_epi32(acc, even_m), self.load(even));
            let odd = _mm512_add_epi64(_mm512_mul_epi32(high, odd_m), self.load(odd));
            let x = _mm512_mask_blend_epi32(
                0b1010_1010_1010_1010,
                _mm512_srli_epi64::<31>(even),
                _mm512_slli_epi64::<1>(odd),
            );
            let x = if SIGNED { _mm512_add_epi32(x, _mm512_srai_epi32::<31>(acc)) } else { x };
            _mm512_srav_epi32(x, self.load(shift))
        }
    }

    #[inline(always)]
    fn narrow(self, v: [Self::V; 4], low: i8, high: i8) -> [i8; 4 * LANES] {
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
    fn words(self, values: &[i8], words: &mut [i32]) {
        flipped(values, words);
    }
}
