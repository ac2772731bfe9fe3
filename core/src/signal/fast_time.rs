//! Fast time: the samples of one slot to its range samples, as the radar configuration says.

use super::dechirp::{CHIRP_WORDS, ComplexI16, write_chirp};
use super::range_gate::write_references;
use crate::config::{Dechirp, RadarConfig, SampleFormat};
use crate::dims::{BEATS, Beat, Complex, ZERO_BEAT};
use crate::simd::conj_mac::{Sum, alternating};
use crate::simd::native_conj_mac;

/// Whether the paper's chirp is taken two blocks at a time: where registers are many and loads cost as much as products.
const ALTERNATING: bool = cfg!(target_arch = "riscv32");

// what `alternating` relies on
const _: () = {
    let mut n = 1;
    while n <= 500 {
        let ([re, im], [later_re, later_im]) = (CHIRP_WORDS.0[n - 1], CHIRP_WORDS.0[n + 499]);
        let sign = if n % 2 == 0 { 1 } else { -1 };
        assert!(later_re == sign * re && later_im == sign * im, "the chirp alternates");
        n += 1;
    }
};

/// A configuration and the reference samples it needs.
#[derive(Debug)]
pub struct FastTime<'b> {
    config: RadarConfig,
    /// Empty: summed as they are.
    reference: &'b [ComplexI16],
}

impl<'b> FastTime<'b> {
    /// Fills `memory` with [`RadarConfig::reference_len`] reference samples; `None` if it has fewer or the configuration is not valid.
    pub fn new(config: RadarConfig, memory: &'b mut [ComplexI16]) -> Option<Self> {
        let table = memory.get_mut(..config.reference_len()).filter(|_| config.is_valid())?;
        let reference: &[ComplexI16] = match (config.gate, config.dechirp) {
            (Some(gate), _) => {
                write_references(&config, gate, table);
                table
            }
            (None, Dechirp::Digital) if table.is_empty() => &CHIRP_WORDS.0,
            (None, Dechirp::Digital) => {
                write_chirp(table);
                table
            }
            (None, Dechirp::Analog) => &[],
        };
        Some(FastTime { config, reference })
    }

    /// The configuration.
    pub fn config(&self) -> &RadarConfig {
        &self.config
    }

    /// Range samples of one slot, `round(sum / 2^shift)`, halves up; exact integers throughout. `None` if the slot has not
    /// [`RadarConfig::values_per_slot`] values.
    ///
    /// Cost: one complex multiply-accumulate a sample with digital dechirp, one for each range sample with a gate.
    pub fn beat(&self, slot: &[i16]) -> Option<Beat> {
        if slot.len() != self.config.values_per_slot() {
            return None;
        }
        let samples = usize::from(self.config.samples);
        let kept = usize::from(self.config.range_samples);
        let block = samples.checked_div(kept)?;
        let (pairs, _) = slot.as_chunks::<2>();
        let mut all = [[0_i64; 2]; BEATS];
        let sums = all.get_mut(..kept)?;
        match (self.config.gate, self.config.format) {
            (None, SampleFormat::Real) => {
                for (sum, samples) in sums.iter_mut().zip(slot.chunks_exact(block.max(1))) {
                    *sum = [samples.iter().map(|&x| i64::from(x)).sum(), 0];
                }
            }
            (None, _) if self.reference.is_empty() => block_sums(pairs, block, sums),
            (None, _) if ALTERNATING && core::ptr::eq(self.reference, &CHIRP_WORDS.0[..]) => {
                if let (Some(samples), 125) = (pairs.first_chunk(), block) {
                    alternating(samples, &CHIRP_WORDS.0, &mut all);
                }
            }
            (None, _) => native_conj_mac(pairs, self.reference, block, sums),
            (Some(_), SampleFormat::Complex) => {
                for (sum, reference) in sums.iter_mut().zip(self.reference.chunks_exact(samples.max(1))) {
                    native_conj_mac(pairs, reference, samples, core::slice::from_mut(sum));
                }
            }
            (Some(_), SampleFormat::Real) => {
                for (sum, reference) in sums.iter_mut().zip(self.reference.chunks_exact(samples.max(1))) {
                    *sum = real_conj_mac(slot, reference);
                }
            }
        }
        let mut beat = ZERO_BEAT;
        let shift = self.config.shift();
        let round = |sum: i64| (sum.wrapping_add((1_i64 << shift) >> 1) >> shift) as i32;
        let analog = self.config.dechirp == Dechirp::Analog;
        for (value, [re, im]) in beat.iter_mut().zip(all) {
            *value = Complex::new(round(re), round(if analog { im.wrapping_neg() } else { im }));
        }
        Some(beat)
    }
}

/// Sums of blocks of samples.
fn block_sums(samples: &[ComplexI16], block: usize, sums: &mut [[i64; 2]]) {
    for (sum, samples) in sums.iter_mut().zip(samples.chunks_exact(block.max(1))) {
        *sum = samples.iter().fold([0; 2], |[re, im], [i, q]| [re + i64::from(*i), im + i64::from(*q)]);
    }
}

/// `sum conj(reference) samples` of real samples.
fn real_conj_mac(samples: &[i16], reference: &[ComplexI16]) -> [i64; 2] {
    let (mut re, mut im) = (Sum::default(), Sum::default());
    for (&x, [c, s]) in samples.iter().zip(reference) {
        re.add(i32::from(x) * i32::from(*c));
        im.add((i32::from(x) * i32::from(*s)).wrapping_neg());
    }
    [re.value(), im.value()]
}
