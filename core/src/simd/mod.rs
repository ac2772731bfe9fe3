//! Sixteen lanes of 32-bit integers: the one seam between the network's vector kernels and a processor.
//!
//! A kernel is written once over [`Lanes`]; [`arrays`] is its portable twin, `x86` the same in AVX2, AVX-VNNI and
//! AVX-512. All operations are integer, so the bits are the same on every one. Which of them this processor has is
//! asked once ([`Isa::best`]) and carried as a value. Another processor joins with one more implementation.

#[cfg(all(target_arch = "arm", arm_dsp))]
#[allow(unsafe_code)]
mod arm;
pub mod arrays;
pub mod conj_mac;
pub mod conj_mac2;
pub mod dual_mac;
pub mod mulh;
#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code)]
mod x86;

/// Lanes of a vector.
pub const LANES: usize = 16;

/// One vector in memory, aligned for the widest load.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C, align(64))]
pub struct Line(pub [i32; LANES]);

impl Line {
    /// Sixteen zeros.
    pub const ZERO: Self = Line([0; LANES]);
}

/// Multiplier, rounding and zero point of sixteen channels, as vectors use them; made by [`set_lane`].
///
/// Lines: multipliers; those of the odd lanes in even lanes; 64-bit offsets of the even and of the odd lanes; shifts.
pub type Rescale = [Line; 5];

/// Largest right shift that a [`Rescale`] takes.
pub const MAX_SHIFT: i8 = 20;

/// Accumulators of a [`Rescale`] are smaller than this.
pub const MAX_ACCUMULATOR: i64 = 1 << 30;

/// Sets one lane: `y = requantize(acc, multiplier, shift) + zero`; false if the shift is not in -20..=-1.
///
/// The rule of [`crate::fixed::requantize`] for |acc| < 2^30, by one floor less: with m the multiplier and e = -shift,
/// `round(m acc / 2^31)` is `(m acc + 2^30) >> 31` as m is not negative, and rounding halves away from zero is
/// `(x + 2^(e-1) - [acc < 0]) >> e`, where for x = 0 the last term changes nothing. The zero point goes in as `zero 2^e`.
pub fn set_lane(lines: &mut Rescale, lane: usize, multiplier: i32, shift: i8, zero: i8) -> bool {
    if !(-MAX_SHIFT..=-1).contains(&shift) || multiplier < 0 {
        return false;
    }
    let exponent = u32::from(shift.unsigned_abs());
    let after = (1_i64 << (exponent - 1)) + (i64::from(zero) << exponent);
    let offset = (1_i64 << 30) + (after << 31);
    let (low, high) = (offset as i32, (offset >> 32) as i32);
    let pair = lane & !1;
    let odd = lane & 1;
    for (line, at, value) in [
        (0, lane, multiplier),
        (1, pair, if odd == 1 { multiplier } else { 0 }),
        (2 + odd, pair, low),
        (2 + odd, pair + 1, high),
        (4, lane, exponent as i32),
    ] {
        if line == 1 && odd == 0 {
            continue;
        }
        if let Some(slot) = lines.get_mut(line).and_then(|line| line.0.get_mut(at)) {
            *slot = value;
        }
    }
    true
}

/// The fastest [`dual_mac::DualMac`] of the target.
#[cfg(all(target_arch = "arm", arm_dsp, not(arm_mve)))]
pub use arm::Dsp as NativeDualMac;
/// The fastest [`dual_mac::DualMac`] of the target.
#[cfg(all(target_arch = "arm", arm_mve))]
pub use arm::Helium as NativeDualMac;
/// The fastest [`dual_mac::DualMac`] of the target.
#[cfg(not(all(target_arch = "arm", arm_dsp)))]
pub type NativeDualMac = dual_mac::Plain;

/// What is to be done with the vectors of one instruction set.
pub trait Job {
    /// Does it; implementations are `#[inline(always)]`, so that the instructions reach their inner loops.
    fn run<L: Lanes>(self, lanes: L);
}

/// Sixteen 32-bit lanes. A value of an implementing type is the proof that the processor has the instructions.
///
/// Every operation wraps unless it says otherwise.
pub trait Lanes: Copy {
    /// Sixteen i32.
    type V: Copy;
    /// Sixteen i16.
    type H: Copy;
    /// Inputs in one word of a [`Lanes::dot`]: 2 as i16, or 4 as u8 = i8 + 128.
    const INPUTS: usize;
    /// Pixels a convolution holds in registers: 4, 8 or 16.
    const TILE: usize;

    /// Runs a job where the compiler may use the instructions.
    fn enter(self, job: impl Job);
    /// Reads a line.
    fn load(self, line: &Line) -> Self::V;
    /// Writes a line.
    fn store(self, v: Self::V) -> Line;
    /// The same value in all lanes.
    fn splat(self, value: i32) -> Self::V;
    /// Sixteen int8 values.
    fn widen(self, values: &[i8; LANES]) -> Self::V;
    /// Sum.
    fn add(self, a: Self::V, b: Self::V) -> Self::V;
    /// Difference.
    fn sub(self, a: Self::V, b: Self::V) -> Self::V;
    /// Larger of two.
    fn max(self, a: Self::V, b: Self::V) -> Self::V;
    /// Shift to the left by `N`.
    fn shift_left<const N: i32>(self, a: Self::V) -> Self::V;
    /// Shift to the right by a number, with the sign.
    fn shift_right(self, a: Self::V, by: u32) -> Self::V;
    /// Lower half of the product.
    fn multiply_low(self, a: Self::V, b: Self::V) -> Self::V;
    /// Reads sixteen i16.
    fn load16(self, words: &[i32; LANES / 2]) -> Self::H;
    /// Writes sixteen i16.
    fn store16(self, h: Self::H) -> [i32; LANES / 2];
    /// Sum of i16.
    fn add16(self, a: Self::H, b: Self::H) -> Self::H;
    /// Difference of i16.
    fn sub16(self, a: Self::H, b: Self::H) -> Self::H;
    /// Shift of i16 to the left by `N`.
    fn shift_left16<const N: i32>(self, a: Self::H) -> Self::H;
    /// Product of two values that fit in i16.
    fn multiply(self, a: Self::V, b: Self::V) -> Self::V;
    /// `acc + sum_i input_i weight_i`: one word of inputs for all lanes, each lane with its own word of weights
    /// (i16 pairs, or int8 quadruples).
    fn dot(self, acc: Self::V, word: i32, weights: Self::V) -> Self::V;
    /// Requantises; without `SIGNED` only results of accumulators that are not negative count.
    fn rescale<const SIGNED: bool>(self, acc: Self::V, lines: &Rescale) -> Self::V;
    /// Four vectors to 64 int8 values in order, saturated and clamped to `low..=high`.
    fn narrow(self, v: [Self::V; 4], low: i8, high: i8) -> [i8; 4 * LANES];
    /// Int8 values, a multiple of 4, to words for [`Lanes::dot`].
    fn words(self, values: &[i8], words: &mut [i32]);
}

/// Four values to 4 / [`Lanes::INPUTS`] words.
#[inline(always)]
pub(crate) fn quad_words<const INPUTS: usize>(four: [i8; 4], words: &mut [i32]) {
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
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Isa {
    /// The plain loops of [`crate::dsn`], which every processor runs.
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
        match self {
            Isa::Scalar | Isa::Arrays => true,
            #[cfg(target_arch = "x86_64")]
            Isa::Avx2 => x86::Ymm::<false>::detect().is_some(),
            #[cfg(target_arch = "x86_64")]
            Isa::AvxVnni => x86::Ymm::<true>::detect().is_some(),
            #[cfg(target_arch = "x86_64")]
            Isa::Avx512Vnni => x86::Zmm::detect().is_some(),
            #[cfg(not(target_arch = "x86_64"))]
            _ => false,
        }
    }

    /// The fastest one available.
    pub fn best() -> Isa {
        Isa::ALL.into_iter().rfind(|isa| isa.available()).unwrap_or(Isa::Scalar)
    }
}

/// The vectors of an available instruction set, for jobs.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Unit {
    Arrays(arrays::Arrays<2>),
    #[cfg(target_arch = "x86_64")]
    Avx2(x86::Ymm<false>),
    #[cfg(target_arch = "x86_64")]
    AvxVnni(x86::Ymm<true>),
    #[cfg(target_arch = "x86_64")]
    Avx512Vnni(x86::Zmm),
}

impl Unit {
    /// `None` for [`Isa::Scalar`] and for what the processor does not have.
    pub(crate) fn new(isa: Isa) -> Option<Self> {
        match isa {
            Isa::Arrays => Some(Unit::Arrays(arrays::Arrays)),
            #[cfg(target_arch = "x86_64")]
            Isa::Avx2 => x86::Ymm::detect().map(Unit::Avx2),
            #[cfg(target_arch = "x86_64")]
            Isa::AvxVnni => x86::Ymm::detect().map(Unit::AvxVnni),
            #[cfg(target_arch = "x86_64")]
            Isa::Avx512Vnni => x86::Zmm::detect().map(Unit::Avx512Vnni),
            _ => None,
        }
    }

    pub(crate) fn run(self, job: impl Job) {
        match self {
            Unit::Arrays(lanes) => lanes.enter(job),
            #[cfg(target_arch = "x86_64")]
            Unit::Avx2(lanes) => lanes.enter(job),
            #[cfg(target_arch = "x86_64")]
            Unit::AvxVnni(lanes) => lanes.enter(job),
            #[cfg(target_arch = "x86_64")]
            Unit::Avx512Vnni(lanes) => lanes.enter(job),
        }
    }

    /// [`Lanes::INPUTS`] of these vectors.
    pub(crate) fn inputs(self) -> usize {
        match self {
            Unit::Arrays(_) => 2,
            #[cfg(target_arch = "x86_64")]
            Unit::Avx2(_) => 2,
            #[cfg(target_arch = "x86_64")]
            Unit::AvxVnni(_) | Unit::Avx512Vnni(_) => 4,
        }
    }
}

#[cfg(test)]
mod tests;
