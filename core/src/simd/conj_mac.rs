//! Conjugate multiply-accumulate, the product of dechirping: samples times a conjugate reference, summed in blocks, exactly.
//!
//! [`portable`] is the reference of Arm's dual multiply-accumulates and of RV32's order of the paper's blocks;
//! [`super::native_conj_mac`] and [`super::native_eight_blocks`] are the fastest of a target.

/// Complex samples: in-phase and quadrature.
pub(crate) type ComplexI16 = [i16; 2];

/// `sum conj(reference) samples` of every block of `block` samples, `[real, imaginary]`, in portable Rust.
///
/// |samples| |reference| below 2^31, blocks of at most 2^15 samples. Cost: four multiply-accumulates a sample.
#[inline]
pub fn portable(samples: &[ComplexI16], reference: &[ComplexI16], block: usize, sums: &mut [[i64; 2]]) {
    let blocks = samples.chunks_exact(block.max(1)).zip(reference.chunks_exact(block.max(1)));
    for (sum, (samples, reference)) in sums.iter_mut().zip(blocks) {
        *sum = match (<&[ComplexI16; 125]>::try_from(samples), <&[ComplexI16; 125]>::try_from(reference)) {
            (Ok(samples), Ok(reference)) => paper_block(samples, reference),
            _ => block_sum(samples, reference),
        };
    }
}

/// A block of the paper's configuration: a loop of known length is unrolled by the compiler.
#[inline(never)]
fn paper_block(samples: &[ComplexI16; 125], reference: &[ComplexI16; 125]) -> [i64; 2] {
    block_sum(samples, reference)
}

/// The sum of one block.
#[inline(always)]
fn block_sum(samples: &[ComplexI16], reference: &[ComplexI16]) -> [i64; 2] {
    let (mut real, mut imaginary) = (Sum::default(), Sum::default());
    let mut add = |x: &ComplexI16, s: &ComplexI16| {
        let (i, q) = (i32::from(x[0]), i32::from(x[1]));
        let (c, s) = (i32::from(s[0]), i32::from(s[1]));
        real.add((i * c).wrapping_add(q * s));
        imaginary.add((q * c).wrapping_sub(i * s));
    };
    // as many registers as RISC-V has hold five products
    const UNROLLED: usize = if cfg!(target_arch = "riscv32") { 5 } else { 1 };
    let (samples, rest) = samples.as_chunks::<UNROLLED>();
    let (references, last) = reference.as_chunks::<UNROLLED>();
    for (samples, reference) in samples.iter().zip(references) {
        for k in 0..UNROLLED {
            add(&samples[k], &reference[k]);
        }
    }
    rest.iter().zip(last).for_each(|(x, s)| add(x, s));
    [real.value(), imaginary.value()]
}

/// Samples of the paper's chirp.
pub(crate) type Chirp = [ComplexI16; 1000];

/// [`portable`] of the paper's eight blocks of 125 samples.
#[inline]
pub fn eight_blocks(samples: &Chirp, reference: &Chirp) -> [[i64; 2]; 8] {
    let mut sums = [[0; 2]; 8];
    portable(samples, reference, 125, &mut sums);
    sums
}

/// A sum of up to 2^15 words of 32 bits, without carries: modulo 2^32, and in units of 2^16 rounded down.
///
/// What the second lacks of the exact sum is below 2^15 2^16, so the first completes it.
#[derive(Debug, Clone, Copy, Default)]
#[repr(C)]
pub(crate) struct Sum {
    low: i32,
    high: i32,
}

impl Sum {
    #[inline(always)]
    pub(crate) fn add(&mut self, value: i32) {
        self.low = self.low.wrapping_add(value);
        self.high = self.high.wrapping_add(value >> 16);
    }

    /// The sum of fewer than 2^15 words, some of them taken away: what is lacking is below 2^15 2^16 with either sign.
    #[cfg(all(target_arch = "riscv32", target_feature = "m"))]
    pub(crate) fn short_value(&self) -> i64 {
        (i64::from(self.high) << 16) + i64::from(self.low.wrapping_sub(self.high << 16))
    }

    pub(crate) fn value(&self) -> i64 {
        let rest = self.low.wrapping_sub(self.high << 16) as u32;
        (i64::from(self.high) << 16) + i64::from(rest)
    }
}
