//! Conjugate multiply-accumulate, the product of dechirping: samples times a conjugate reference, summed in blocks, exactly.
//!
//! [`portable`] is the reference of `arm`'s dual multiply-accumulates.

/// Complex samples: in-phase and quadrature.
pub(crate) type Iq = [i16; 2];

/// `sum conj(reference) samples` of every block of `block` samples, `[real, imaginary]`, by the fastest way of the target.
///
/// |samples| |reference| below 2^31, blocks of at most 2^15 samples. Cost: four multiply-accumulates a sample.
#[inline]
pub fn conj_mac(samples: &[Iq], reference: &[Iq], block: usize, sums: &mut [[i64; 2]]) {
    #[cfg(all(target_arch = "arm", arm_dsp))]
    super::arm::conj_mac(samples, reference, block, sums);
    #[cfg(not(all(target_arch = "arm", arm_dsp)))]
    portable(samples, reference, block, sums);
}

/// [`conj_mac`] in portable Rust.
#[inline]
pub fn portable(samples: &[Iq], reference: &[Iq], block: usize, sums: &mut [[i64; 2]]) {
    let blocks = samples.chunks_exact(block.max(1)).zip(reference.chunks_exact(block.max(1)));
    for (sum, (samples, reference)) in sums.iter_mut().zip(blocks) {
        *sum = block_sum(samples, reference);
    }
}

/// The sum of one block. Not inline: its sums stay in registers.
#[inline(never)]
fn block_sum(samples: &[Iq], reference: &[Iq]) -> [i64; 2] {
    let (mut real, mut imaginary) = (Sum::default(), Sum::default());
    // five at a time, which 125 is made of: fewer turns of the loop
    let ((fives, rest), (references, last)) = (samples.as_chunks::<5>(), reference.as_chunks::<5>());
    for (samples, reference) in fives.iter().zip(references) {
        for k in 0..5 {
            add(&samples[k], &reference[k], &mut real, &mut imaginary);
        }
    }
    rest.iter().zip(last).for_each(|(x, s)| add(x, s, &mut real, &mut imaginary));
    [real.value(), imaginary.value()]
}

/// One product with the conjugate reference. Each value is a load of 16 bits: one instruction on every processor.
#[inline(always)]
fn add(sample: &Iq, reference: &Iq, real: &mut Sum, imaginary: &mut Sum) {
    let (i, q) = (i32::from(sample[0]), i32::from(sample[1]));
    let (c, s) = (i32::from(reference[0]), i32::from(reference[1]));
    real.add((i * c).wrapping_add(q * s));
    imaginary.add((q * c).wrapping_sub(i * s));
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
