//! Conjugate multiply-accumulate, the product of dechirping: samples times a conjugate reference, summed in blocks, exactly.
//!
//! [`portable`] is the reference of `arm`'s dual multiply-accumulates.

/// Complex samples: in-phase and quadrature.
pub(crate) type ComplexI16 = [i16; 2];

/// `sum conj(reference) samples` of every block of `block` samples, `[real, imaginary]`, by the fastest way of the target.
///
/// |samples| |reference| below 2^31, blocks of at most 2^15 samples. Cost: four multiply-accumulates a sample.
#[inline]
pub fn conj_mac(samples: &[ComplexI16], reference: &[ComplexI16], block: usize, sums: &mut [[i64; 2]]) {
    #[cfg(all(target_arch = "arm", arm_dsp))]
    super::arm::conj_mac(samples, reference, block, sums);
    #[cfg(not(all(target_arch = "arm", arm_dsp)))]
    portable(samples, reference, block, sums);
}

/// [`conj_mac`] in portable Rust.
#[inline]
pub fn portable(samples: &[ComplexI16], reference: &[ComplexI16], block: usize, sums: &mut [[i64; 2]]) {
    match (samples.first_chunk(), reference.first_chunk(), sums.first_chunk_mut()) {
        // of known length the compiler unrolls the loop by five
        (Some(samples), Some(reference), Some(sums)) if block == 125 => paper(samples, reference, sums),
        _ => blocks(samples, reference, block, sums),
    }
}

/// The blocks of the paper's configuration.
#[inline(never)]
fn paper(samples: &[ComplexI16; 1000], reference: &[ComplexI16; 1000], sums: &mut [[i64; 2]; 8]) {
    blocks(samples, reference, 125, sums);
}

#[inline(always)]
fn blocks(samples: &[ComplexI16], reference: &[ComplexI16], block: usize, sums: &mut [[i64; 2]]) {
    let blocks = samples.chunks_exact(block.max(1)).zip(reference.chunks_exact(block.max(1)));
    for (sum, (samples, reference)) in sums.iter_mut().zip(blocks) {
        let (mut real, mut imaginary) = (Sum::default(), Sum::default());
        for ([i, q], [c, s]) in samples.iter().zip(reference) {
            let [i, q, c, s] = [*i, *q, *c, *s].map(i32::from);
            real.add((i * c).wrapping_add(q * s));
            imaginary.add((q * c).wrapping_sub(i * s));
        }
        *sum = [real.value(), imaginary.value()];
    }
}

/// A sum of up to 2^15 words of 32 bits, without carries: modulo 2^32, and in units of 2^16 rounded down.
///
/// What the second lacks of the exact sum is below 2^15 2^16, so the first completes it.
#[derive(Default)]
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

    pub(crate) fn value(&self) -> i64 {
        let rest = self.low.wrapping_sub(self.high << 16) as u32;
        (i64::from(self.high) << 16) + i64::from(rest)
    }
}
