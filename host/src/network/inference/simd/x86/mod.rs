//! The only unsafe code of the crate: x86-64 vector instructions as [`super::SimdI32`].
//!
//! A value of [`Ymm`] or [`Zmm`] exists only after [`Ymm::detect`] or [`Zmm::detect`] has found its instructions. Every
//! `unsafe` below relies on that. No pointer is read or written: vectors come from arrays of their own size.

/// The operations on sixteen i16 in 256 bits, which both vectors share.
macro_rules! half_vectors {
    () => {
        #[inline(always)]
        fn load16(self, words: &[i32; LANES / 2]) -> Self::I16 {
            // SAFETY: both are 32 bytes and any bits are a value of either.
            unsafe { transmute(*words) }
        }

        #[inline(always)]
        fn store16(self, h: Self::I16) -> [i32; LANES / 2] {
            // SAFETY: both are 32 bytes and any bits are a value of either.
            unsafe { transmute(h) }
        }

        #[inline(always)]
        fn add16(self, a: Self::I16, b: Self::I16) -> Self::I16 {
            // SAFETY: `self` proves AVX2.
            unsafe { _mm256_add_epi16(a, b) }
        }

        #[inline(always)]
        fn sub16(self, a: Self::I16, b: Self::I16) -> Self::I16 {
            // SAFETY: `self` proves AVX2.
            unsafe { _mm256_sub_epi16(a, b) }
        }

        #[inline(always)]
        fn shift_left16<const N: i32>(self, a: Self::I16) -> Self::I16 {
            // SAFETY: `self` proves AVX2.
            unsafe { _mm256_slli_epi16::<N>(a) }
        }
    };
}

mod ymm;
mod zmm;

pub use ymm::Ymm;
pub use zmm::Zmm;

/// Words of four: the values with their sign bits flipped.
#[inline(always)]
fn flipped(values: &[i8], words: &mut [i32]) {
    let (fours, _) = values.as_chunks::<4>();
    for (&four, word) in fours.iter().zip(words) {
        *word = i32::from_le_bytes(four.map(|v| v as u8)) ^ 0x8080_8080_u32 as i32;
    }
}
