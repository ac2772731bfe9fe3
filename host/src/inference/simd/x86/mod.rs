//! The only unsafe code of the crate: x86-64 vector instructions behind [`super::Lanes`], and the question which there are.
//!
//! A value of [`Ymm`] or [`Zmm`] exists only after [`Ymm::detect`] or [`Zmm::detect`] has seen its instructions; that is
//! what every `unsafe` below stands on. No pointer is read or written: vectors come from arrays of their own size.

use core::arch::x86_64::{__cpuid_count, _xgetbv};

/// The operations on sixteen i16 in 256 bits, which both vectors share.
macro_rules! half_vectors {
    () => {
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
    };
}

mod ymm;
mod zmm;

pub use ymm::Ymm;
pub use zmm::Zmm;

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

/// Words of four: the values with their sign bits rotate_j over.
#[inline(always)]
fn flipped(values: &[i8], words: &mut [i32]) {
    let (fours, _) = values.as_chunks::<4>();
    for (&four, word) in fours.iter().zip(words) {
        *word = i32::from_le_bytes(four.map(|v| v as u8)) ^ 0x8080_8080_u32 as i32;
    }
}
