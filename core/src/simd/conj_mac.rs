//! The products and sums of dechirping: samples times a conjugate reference, summed in blocks, exactly.
//!
//! [`plain`] is the portable reference of `arm`'s dual multiply-accumulates.

use crate::dims::{BEATS, BLOCK_SAMPLES, Slot};

/// Sums of the blocks, real and imaginary part.
pub type BlockSums = [[i64; 2]; BEATS];

/// The fastest one of the target.
#[inline]
pub fn conj_mac(samples: &Slot, reference: &Slot) -> BlockSums {
    #[cfg(all(target_arch = "arm", arm_dsp))]
    return super::arm::conj_mac(samples, reference);
    #[cfg(not(all(target_arch = "arm", arm_dsp)))]
    plain(samples, reference)
}

/// `sum conj(reference) samples` of every block; |samples| |reference| below 2^31.
#[inline]
pub fn plain(samples: &Slot, reference: &Slot) -> BlockSums {
    let mut sums = [[0; 2]; BEATS];
    let blocks = samples.chunks_exact(BLOCK_SAMPLES).zip(reference.chunks_exact(BLOCK_SAMPLES));
    for ([re, im], (samples, reference)) in sums.iter_mut().zip(blocks) {
        let (mut real, mut imaginary) = (Sum::default(), Sum::default());
        for (x, s) in samples.iter().zip(reference) {
            let (i, q) = (i32::from(x.i), i32::from(x.q));
            let (c, s) = (i32::from(s.i), i32::from(s.q));
            real.add((i * c).wrapping_add(q * s));
            imaginary.add((q * c).wrapping_sub(i * s));
        }
        (*re, *im) = (real.value(), imaginary.value());
    }
    sums
}

/// A sum of up to 2^15 words of 32 bits, without carries: modulo 2^32, and in units of 2^16 rounded down.
///
/// What the second lacks of the exact sum is below 2^15 2^16, so the first completes it.
#[derive(Default)]
struct Sum {
    low: i32,
    high: i32,
}

impl Sum {
    #[inline(always)]
    fn add(&mut self, value: i32) {
        self.low = self.low.wrapping_add(value);
        self.high = self.high.wrapping_add(value >> 16);
    }

    fn value(&self) -> i64 {
        let rest = self.low.wrapping_sub(self.high << 16) as u32;
        (i64::from(self.high) << 16) + i64::from(rest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dims::{Iq, SLOT_SAMPLES};
    use rand_core::{Rng, SeedableRng};
    use rand_xoshiro::Xoshiro128PlusPlus;

    fn exact(samples: &Slot, reference: &Slot) -> BlockSums {
        let mut sums = [[0; 2]; BEATS];
        for (n, (x, s)) in samples.iter().zip(reference).enumerate() {
            let [i, q, c, s] = [x.i, x.q, s.i, s.q].map(i64::from);
            sums[n / BLOCK_SAMPLES][0] += i * c + q * s;
            sums[n / BLOCK_SAMPLES][1] += q * c - i * s;
        }
        sums
    }

    #[test]
    fn sums_are_exact() {
        let mut random = Xoshiro128PlusPlus::seed_from_u64(5);
        for round in 0..50 {
            let mut draw = || match round {
                0 => i16::MIN,
                1 => [i16::MIN, i16::MAX][random.next_u32() as usize % 2],
                2 => -1,
                _ => random.next_u32() as i16 >> (round % 16),
            };
            let samples: Slot = core::array::from_fn(|_| Iq { i: draw(), q: draw() });
            let reference = crate::signal::dechirp::CHIRP;
            assert_eq!(plain(&samples, &reference), exact(&samples, &reference));
        }
        assert_eq!(SLOT_SAMPLES, BEATS * BLOCK_SAMPLES);
    }
}
