//! Sixteen 32-bit integers as one value: the interface between the network's vector kernels and a processor.
//!
//! A kernel is written once over [`SimdI32`]. [`arrays`] is the portable implementation, `x86` has AVX2, AVX-VNNI and
//! AVX-512. All operations are integer, so every implementation gives the same bits. The processor is asked once, and
//! [`Backend`] carries the answer. Another processor joins with one more implementation.

pub(crate) mod arrays;
#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code)]
mod x86;

/// Lanes of a vector.
pub const LANES: usize = 16;

/// One vector in memory, aligned for the widest load.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C, align(64))]
pub struct I32x16(pub [i32; LANES]);

impl I32x16 {
    /// Sixteen zeros.
    pub const ZERO: Self = I32x16([0; LANES]);
}

/// Largest right shift of a [`Requantizer`].
pub const MAX_SHIFT: i8 = 20;

/// Accumulators of a [`Requantizer`] are smaller than this.
pub const MAX_ACCUMULATOR: i64 = 1 << 30;

/// Multiplier, rounding and zero point of sixteen channels, as the vector instructions use them.
#[derive(Debug, Clone, Copy)]
pub struct Requantizer {
    pub multipliers: I32x16,
    /// Multipliers of the odd lanes, in the even lanes.
    pub odd_multipliers: I32x16,
    /// 64-bit offsets of the even lanes, of doubled products.
    pub even_offsets: I32x16,
    /// 64-bit offsets of the odd lanes.
    pub odd_offsets: I32x16,
    /// Shifts to the right.
    pub shifts: I32x16,
}

impl Requantizer {
    /// Gives zero in every lane.
    pub const ZERO: Self = Requantizer {
        multipliers: I32x16::ZERO,
        odd_multipliers: I32x16::ZERO,
        even_offsets: I32x16::ZERO,
        odd_offsets: I32x16::ZERO,
        shifts: I32x16::ZERO,
    };

    /// Sets one lane: `y = requantize(acc, multiplier, shift) + zero`; `None` if the shift is not in -20 to -1.
    ///
    /// The rule of [`sdp3_core::fixed::requantize`] for |acc| < 2^30 with one floor less. Accumulators come doubled, so that
    /// `m acc / 2^31` is the upper word of a 64-bit lane. With m the multiplier and
    /// e = -shift, `round(m acc / 2^31)` is `(m acc + 2^30) >> 31` as m is not negative. Rounding halves away from zero
    /// is `(x + 2^(e-1) - [acc < 0]) >> e`, where for x = 0 the last term changes nothing. The zero point goes in as
    /// `zero 2^e`.
    pub fn set_lane(&mut self, lane: usize, multiplier: i32, shift: i8, zero: i8) -> Option<()> {
        if !(-MAX_SHIFT..=-1).contains(&shift) || multiplier < 0 {
            return None;
        }
        let exponent = u32::from(shift.unsigned_abs());
        let after = (1_i64 << (exponent - 1)) + (i64::from(zero) << exponent);
        let offset = (1_i64 << 31) + (after << 32);
        let even = lane & !1;
        let offsets = if lane == even { &mut self.even_offsets } else { &mut self.odd_offsets };
        (offsets.0[even], offsets.0[even + 1]) = (offset as i32, (offset >> 32) as i32);
        self.multipliers.0[lane] = multiplier;
        if lane != even {
            self.odd_multipliers.0[even] = multiplier;
        }
        self.shifts.0[lane] = exponent as i32;
        Some(())
    }
}

/// A computation on the vectors of any instruction set.
pub trait Kernel {
    /// Runs it; implementations are `#[inline(always)]`, so that the instructions reach their inner loops.
    fn run<S: SimdI32>(self, simd: S);
}

/// Operations on sixteen 32-bit integers. A value of an implementing type proves that the processor has the instructions.
///
/// Every operation wraps unless it says otherwise.
pub trait SimdI32: Copy {
    /// Sixteen i32.
    type I32: Copy;
    /// Sixteen i16.
    type I16: Copy;
    /// Inputs in one word of a [`SimdI32::dot`]: 2 as i16, or 4 as u8 = i8 + 128.
    const INPUTS: usize;
    /// Pixels of which a convolution holds the sums in registers: 4 or 16.
    const TILE: usize;

    /// Runs a kernel where the compiler may use the instructions.
    fn dispatch(self, kernel: impl Kernel);
    /// Reads a vector.
    fn load(self, vector: &I32x16) -> Self::I32;
    /// Writes a vector.
    fn store(self, v: Self::I32) -> I32x16;
    /// The same value in all lanes.
    fn splat(self, value: i32) -> Self::I32;
    /// Sixteen int8 values.
    fn widen(self, values: &[i8; LANES]) -> Self::I32;
    /// Sum.
    fn add(self, a: Self::I32, b: Self::I32) -> Self::I32;
    /// Difference.
    fn sub(self, a: Self::I32, b: Self::I32) -> Self::I32;
    /// Larger of two.
    fn max(self, a: Self::I32, b: Self::I32) -> Self::I32;
    /// Shift to the left by `N`.
    fn shift_left<const N: i32>(self, a: Self::I32) -> Self::I32;
    /// Arithmetic shift to the right.
    fn shift_right(self, a: Self::I32, by: u32) -> Self::I32;
    /// Lower half of the product.
    fn multiply_low(self, a: Self::I32, b: Self::I32) -> Self::I32;
    /// Product of two values that fit in i16; the upper halves of b's lanes are zeros.
    fn multiply(self, a: Self::I32, b: Self::I32) -> Self::I32;
    /// Reads sixteen i16.
    fn load16(self, words: &[i32; LANES / 2]) -> Self::I16;
    /// Writes sixteen i16.
    fn store16(self, h: Self::I16) -> [i32; LANES / 2];
    /// Sum of i16.
    fn add16(self, a: Self::I16, b: Self::I16) -> Self::I16;
    /// Difference of i16.
    fn sub16(self, a: Self::I16, b: Self::I16) -> Self::I16;
    /// Shift of i16 to the left by `N`.
    fn shift_left16<const N: i32>(self, a: Self::I16) -> Self::I16;
    /// `acc + sum_i input_i weight_i`: one word of inputs for all lanes, each lane with its own word of weights
    /// (i16 pairs, or int8 quadruples).
    fn dot(self, acc: Self::I32, word: i32, weights: Self::I32) -> Self::I32;
    /// Requantises accumulators that are given doubled; without `SIGNED` only results of those that are not negative count.
    fn requantize<const SIGNED: bool>(self, twice: Self::I32, by: &Requantizer) -> Self::I32;
    /// Four vectors to 64 int8 values in order, saturated and clamped to `low..=high`.
    fn narrow(self, v: [Self::I32; 4], low: i8, high: i8) -> [i8; 4 * LANES];
    /// Int8 values, a multiple of 4, to words for [`SimdI32::dot`].
    fn input_words(self, values: &[i8], words: &mut [i32]);
}

/// Four values to 4 / [`SimdI32::INPUTS`] words.
#[inline(always)]
fn group_words<const INPUTS: usize>(four: [i8; 4], words: &mut [i32]) {
    let [a, b, c, d] = four.map(|v| i32::from(v) & 0xffff);
    match words {
        [one] if INPUTS == 4 => *one = i32::from_le_bytes(four.map(|v| v as u8 ^ 0x80)),
        [one, two] if INPUTS == 2 => (*one, *two) = (a | b << 16, c | d << 16),
        _ => {}
    }
}

/// An instruction set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Isa {
    /// The plain loops of [`sdp3_core::dsn`], which every processor runs.
    Scalar,
    /// Vector kernels on arrays, left to the compiler.
    Arrays,
    /// x86-64 with AVX2.
    Avx2,
    /// x86-64 with AVX2 and AVX-VNNI.
    AvxVnni,
    /// x86-64 with AVX-512 F, BW and VNNI.
    Avx512Vnni,
}

impl Isa {
    /// Every instruction set, slowest first.
    pub const ALL: [Isa; 5] = [Isa::Scalar, Isa::Arrays, Isa::Avx2, Isa::AvxVnni, Isa::Avx512Vnni];

    /// Name, as commands take it.
    pub const fn name(self) -> &'static str {
        match self {
            Isa::Scalar => "scalar",
            Isa::Arrays => "arrays",
            Isa::Avx2 => "avx2",
            Isa::AvxVnni => "avx-vnni",
            Isa::Avx512Vnni => "avx512-vnni",
        }
    }

    /// Whether this processor, under this operating system, has it.
    pub fn available(self) -> bool {
        self == Isa::Scalar || Backend::new(self).is_some()
    }

    /// The fastest one available.
    pub fn best() -> Isa {
        Isa::ALL.into_iter().rfind(|isa| isa.available()).unwrap_or(Isa::Scalar)
    }
}

/// The vectors of an available instruction set.
#[derive(Debug, Clone, Copy)]
pub enum Backend {
    Arrays(arrays::Arrays<2>),
    #[cfg(target_arch = "x86_64")]
    Avx2(x86::Ymm<false>),
    #[cfg(target_arch = "x86_64")]
    AvxVnni(x86::Ymm<true>),
    #[cfg(target_arch = "x86_64")]
    Avx512Vnni(x86::Zmm),
}

impl Backend {
    /// `None` for [`Isa::Scalar`] and for what the processor does not have.
    pub fn new(isa: Isa) -> Option<Self> {
        match isa {
            Isa::Arrays => Some(Backend::Arrays(arrays::Arrays)),
            #[cfg(target_arch = "x86_64")]
            Isa::Avx2 => x86::Ymm::detect().map(Backend::Avx2),
            #[cfg(target_arch = "x86_64")]
            Isa::AvxVnni => x86::Ymm::detect().map(Backend::AvxVnni),
            #[cfg(target_arch = "x86_64")]
            Isa::Avx512Vnni => x86::Zmm::detect().map(Backend::Avx512Vnni),
            _ => None,
        }
    }

    /// Runs a kernel.
    pub fn dispatch(self, kernel: impl Kernel) {
        match self {
            Backend::Arrays(simd) => simd.dispatch(kernel),
            #[cfg(target_arch = "x86_64")]
            Backend::Avx2(simd) => simd.dispatch(kernel),
            #[cfg(target_arch = "x86_64")]
            Backend::AvxVnni(simd) => simd.dispatch(kernel),
            #[cfg(target_arch = "x86_64")]
            Backend::Avx512Vnni(simd) => simd.dispatch(kernel),
        }
    }

    /// [`SimdI32::INPUTS`] of these vectors.
    pub fn word_inputs(self) -> usize {
        match self {
            Backend::Arrays(_) => 2,
            #[cfg(target_arch = "x86_64")]
            Backend::Avx2(_) => 2,
            #[cfg(target_arch = "x86_64")]
            Backend::AvxVnni(_) | Backend::Avx512Vnni(_) => 4,
        }
    }
}

#[cfg(test)]
mod tests;
