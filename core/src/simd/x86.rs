//! The only unsafe code of the crate: x86-64 vector instructions behind [`Lanes`], and the question which there are.
//!
//! A value of [`Ymm`] or [`Zmm`] exists only after [`Ymm::detect`] or [`Zmm::detect`] has seen its instructions; that is
//! what every `unsafe` below stands on. No pointer is read or written: vectors come from arrays of their own size.

use super::{Job, LANES, Lanes, Line, Rescale, quad_words};
use core::arch::x86_64::*;
use core::mem::transmute;

/// What the processor has and the operating system saves: AVX2; AVX-VNNI; AVX-512 F, BW and VNNI.
fn features() -> [bool; 3] {
    #[target_feature(enable = "xsave")]
    fn saved() -> u64 {
        // SAFETY: register 0 exists wherever XGETBV does.
        unsafe { _xgetbv(0) }
    }
    let bit = |register: u32, bit: u32| register >> bit & 1 == 1;
    #[allow(unused_unsafe)] // a safe function in newer compilers
    // SAFETY: every x86-64 processor has CPUID; a leaf is asked only up to the largest there is.
    let leaf = |leaf: u32, sub: u32| unsafe { __cpuid_count(leaf, sub) };
    let last = leaf(0, 0).eax;
    let first = leaf(1, 0).ecx;
    let (xsave, avx) = (bit(first, 27), bit(first, 28));
    if last < 7 || !xsave || !avx {
        return [false; 3];
    }
    // SAFETY: OSXSAVE says that the instruction is there and the operating system uses it.
    let saved = unsafe { saved() };
    let (ymm, zmm) = (saved & 0x06 == 0x06, saved & 0xe6 == 0xe6);
    let seven = leaf(7, 0);
    let more = if seven.eax >= 1 { leaf(7, 1).eax } else { 0 };
    let avx2 = ymm && bit(seven.ebx, 5);
    let avx512 = zmm && bit(seven.ebx, 16) && bit(seven.ebx, 30) && bit(seven.ecx, 11);
    [avx2, avx2 && bit(more, 4), avx2 && avx512]
}

/// Two vectors of 256 bits, AVX2; with `VNNI` also AVX-VNNI.
#[derive(Debug, Clone, Copy)]
pub struct Ymm<const VNNI: bool>(());

impl<const VNNI: bool> Ymm<VNNI> {
    /// The proof that this processor has the instructions.
    pub fn detect() -> Option<Self> {
        let [avx2, avx_vnni, _] = features();
        (if VNNI { avx_vnni } else { avx2 }).then_some(Ymm(()))
    }
}

/// One vector of 512 bits, AVX-512 F, BW and VNNI.
#[derive(Debug, Clone, Copy)]
pub struct Zmm(());

impl Zmm {
    /// The proof that this processor has the instructions.
    pub fn detect() -> Option<Self> {
        features()[2].then_some(Zmm(()))
    }
}

#[target_feature(enable = "avx2")]
fn enter_avx2<L: Lanes>(lanes: L, job: impl Job) {
    job.run(lanes);
}

#[target_feature(enable = "avx2,avxvnni")]
fn enter_avx_vnni<L: Lanes>(lanes: L, job: impl Job) {
    job.run(lanes);
}

#[target_feature(enable = "avx2,avx512f,avx512bw,avx512vnni")]
fn enter_avx512<L: Lanes>(lanes: L, job: impl Job) {
    job.run(lanes);
}

/// Eight lanes of [`Lanes::rescale`]: 64-bit products of the even and the odd lanes, then one shift each.
#[inline]
#[target_feature(enable = "avx2")]
fn rescale_ymm<const SIGNED: bool>(acc: __m256i, [m, m_odd, even, odd, shift]: [__m256i; 5]) -> __m256i {
    let high = _mm256_srli_epi64::<32>(acc);
    let even = _mm256_srli_epi64::<31>(_mm256_add_epi64(_mm256_mul_epi32(acc, m), even));
    let odd = _mm256_slli_epi64::<1>(_mm256_add_epi64(_mm256_mul_epi32(high, m_odd), odd));
    let x = _mm256_blend_epi32::<0b1010_1010>(even, odd);
    let x = if SIGNED { _mm256_add_epi32(x, _mm256_srai_epi32::<31>(acc)) } else { x };
    _mm256_srav_epi32(x, shift)
}

/// Eight lanes of [`Lanes::multiply`]; the upper half of b's lanes is cleared, so that its sign adds nothing.
#[inline]
#[target_feature(enable = "avx2")]
fn multiply_ymm(a: __m256i, b: __m256i) -> __m256i {
    _mm256_madd_epi16(a, _mm256_and_si256(b, _mm256_set1_epi32(0xffff)))
}

/// Half of [`Lanes::narrow`].
#[inline]
#[target_feature(enable = "avx2")]
fn narrow_ymm(a: [__m256i; 2], b: [__m256i; 2], low: i8, high: i8) -> __m256i {
    // packing works in halves of 128 bits: quarters 0 2 of each come before 1 3
    let order = _mm256_setr_epi32(0, 4, 1, 5, 2, 6, 3, 7);
    let (a, b) = (_mm256_packs_epi32(a[0], a[1]), _mm256_packs_epi32(b[0], b[1]));
    let bytes = _mm256_permutevar8x32_epi32(_mm256_packs_epi16(a, b), order);
    _mm256_min_epi8(_mm256_max_epi8(bytes, _mm256_set1_epi8(low)), _mm256_set1_epi8(high))
}

impl<const VNNI: bool> Lanes for Ymm<VNNI> {
    type V = [__m256i; 2];
    type H = __m256i;
    const INPUTS: usize = if VNNI { 4 } else { 2 };
    const TILE: usize = 4;

    #[inline(always)]
    fn enter(self, job: impl Job) {
        // SAFETY: `self` proves AVX2, with `VNNI` also AVX-VNNI.
        unsafe { if VNNI { enter_avx_vnni(self, job) } else { enter_avx2(self, job) } }
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
        // SAFETY: `self` proves AVX2.
        unsafe { [_mm256_set1_epi32(value); 2] }
    }

    #[inline(always)]
    fn widen(self, values: &[i8; LANES]) -> Self::V {
        // SAFETY: both are 16 bytes and any bits are a value of either; `self` proves AVX2.
        unsafe {
            let v: __m128i = transmute(*values);
            [_mm256_cvtepi8_epi32(v), _mm256_cvtepi8_epi32(_mm_srli_si128::<8>(v))]
        }
    }

    #[inline(always)]
    fn add(self, a: Self::V, b: Self::V) -> Self::V {
        // SAFETY: `self` proves AVX2.
        unsafe { [_mm256_add_epi32(a[0], b[0]), _mm256_add_epi32(a[1], b[1])] }
    }

    #[inline(always)]
    fn sub(self, a: Self::V, b: Self::V) -> Self::V {
        // SAFETY: `self` proves AVX2.
        unsafe { [_mm256_sub_epi32(a[0], b[0]), _mm256_sub_epi32(a[1], b[1])] }
    }

    #[inline(always)]
    fn shift_right(self, a: Self::V, by: u32) -> Self::V {
        // SAFETY: `self` proves AVX2.
        unsafe {
            let by = _mm_cvtsi32_si128(by as i32);
            [_mm256_sra_epi32(a[0], by), _mm256_sra_epi32(a[1], by)]
        }
    }

    #[inline(always)]
    fn multiply_low(self, a: Self::V, b: Self::V) -> Self::V {
        // SAFETY: `self` proves AVX2.
        unsafe { [_mm256_mullo_epi32(a[0], b[0]), _mm256_mullo_epi32(a[1], b[1])] }
    }

    #[inline(always)]
    fn load16(self, words: &[i32; LANES / 2]) -> Self::H {
        // SAFETY: both are 32 bytes and any bits are a value of either.
        unsafe { transmute(*words) }
    }

    #[inline(always)]
    fn store16(self, h: Self::H) -> [i32; LANES / 2] {
        // SAFETY: both are 32 bytes and any bits are a value of either.
        unsafe { transmute(h) }
    }

    #[inline(always)]
    fn add16(self, a: Self::H, b: Self::H) -> Self::H {
        // SAFETY: `self` proves AVX2.
        unsafe { _mm256_add_epi16(a, b) }
    }

    #[inline(always)]
    fn sub16(self, a: Self::H, b: Self::H) -> Self::H {
        // SAFETY: `self` proves AVX2.
        unsafe { _mm256_sub_epi16(a, b) }
    }

    #[inline(always)]
    fn shift_left16<const N: i32>(self, a: Self::H) -> Self::H {
        // SAFETY: `self` proves AVX2.
        unsafe { _mm256_slli_epi16::<N>(a) }
    }

    #[inline(always)]
    fn max(self, a: Self::V, b: Self::V) -> Self::V {
        // SAFETY: `self` proves AVX2.
        unsafe { [_mm256_max_epi32(a[0], b[0]), _mm256_max_epi32(a[1], b[1])] }
    }

    #[inline(always)]
    fn shift_left<const N: i32>(self, a: Self::V) -> Self::V {
        // SAFETY: `self` proves AVX2.
        unsafe { [_mm256_slli_epi32::<N>(a[0]), _mm256_slli_epi32::<N>(a[1])] }
    }

    #[inline(always)]
    fn multiply(self, a: Self::V, b: Self::V) -> Self::V {
        // SAFETY: `self` proves AVX2.
        unsafe { [multiply_ymm(a[0], b[0]), multiply_ymm(a[1], b[1])] }
    }

    #[inline(always)]
    fn dot(self, acc: Self::V, word: i32, weights: Self::V) -> Self::V {
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
    fn rescale<const SIGNED: bool>(self, acc: Self::V, lines: &Rescale) -> Self::V {
        let [a, b, c, d, e] = lines;
        let [a, b, c, d, e] = [self.load(a), self.load(b), self.load(c), self.load(d), self.load(e)];
        // SAFETY: `self` proves AVX2.
        unsafe {
            [
                rescale_ymm::<SIGNED>(acc[0], [a[0], b[0], c[0], d[0], e[0]]),
                rescale_ymm::<SIGNED>(acc[1], [a[1], b[1], c[1], d[1], e[1]]),
            ]
        }
    }

    #[inline(always)]
    fn narrow(self, v: [Self::V; 4], low: i8, high: i8) -> [i8; 4 * LANES] {
        // SAFETY: `self` proves AVX2; the result is 64 bytes of which any bits are values.
        unsafe { transmute([narrow_ymm(v[0], v[1], low, high), narrow_ymm(v[2], v[3], low, high)]) }
    }

    #[inline(always)]
    fn words(self, values: &[i8], words: &mut [i32]) {
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
            quad_words::<2>(four, words);
        }
    }
}

/// Words of four: the values with their sign bits turned over.
#[inline(always)]
fn flipped(values: &[i8], words: &mut [i32]) {
    let (fours, _) = values.as_chunks::<4>();
    for (&four, word) in fours.iter().zip(words) {
        *word = i32::from_le_bytes(four.map(|v| v as u8)) ^ 0x8080_8080_u32 as i32;
    }
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

    #[inline(always)]
    fn load16(self, words: &[i32; LANES / 2]) -> Self::H {
        // SAFETY: both are 32 bytes and any bits are a value of either.
        unsafe { transmute(*words) }
    }

    #[inline(always)]
    fn store16(self, h: Self::H) -> [i32; LANES / 2] {
        // SAFETY: both are 32 bytes and any bits are a value of either.
        unsafe { transmute(h) }
    }

    #[inline(always)]
    fn add16(self, a: Self::H, b: Self::H) -> Self::H {
        // SAFETY: `self` proves AVX2.
        unsafe { _mm256_add_epi16(a, b) }
    }

    #[inline(always)]
    fn sub16(self, a: Self::H, b: Self::H) -> Self::H {
        // SAFETY: `self` proves AVX2.
        unsafe { _mm256_sub_epi16(a, b) }
    }

    #[inline(always)]
    fn shift_left16<const N: i32>(self, a: Self::H) -> Self::H {
        // SAFETY: `self` proves AVX2.
        unsafe { _mm256_slli_epi16::<N>(a) }
    }

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
