//! Fast time: the samples of one slot to its range samples, as the radar configuration says.

use super::dechirp::{CHIRP_WORDS, ComplexI16, write_chirp};
use super::range_gate::write_references;
use crate::config::{Dechirp, RadarConfig, SampleFormat};
use crate::dims::{BEATS, Beat, Complex, ZERO_BEAT};
use crate::simd::conj_mac::Sum;
use crate::simd::{native_conj_mac, native_eight_blocks};

// what RISC-V's `eight_blocks` relies on
const _: () = {
    let mut at = 0;
    while at < 3 * 250 {
        let (k, n) = (at / 250 + 1, at % 250 + 1);
        let [re, im] = CHIRP_WORDS.0[n - 1];
        let [turned_re, turned_im] = [[re, im], [-im, re], [-re, -im], [im, -re]][(k * n + k % 2) % 4];
        let [later_re, later_im] = CHIRP_WORDS.0[n + 250 * k - 1];
        assert!(later_re == turned_re && later_im == turned_im, "the chirp turns");
        at += 1;
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
        let (shift, mut beat) = (self.config.shift(), ZERO_BEAT);
        for (value, [re, im]) in beat.iter_mut().zip(self.sums(slot)?) {
            *value = Complex::new(rounded(re, shift), rounded(im, shift));
        }
        Some(beat)
    }

    /// The sums of a slot's blocks of samples, or of a gate.
    #[inline(always)]
    fn sums(&self, slot: &[i16]) -> Option<[[i64; 2]; BEATS]> {
        let (pairs, _) = slot.as_chunks::<2>();
        let eight = usize::from(self.config.range_samples) == BEATS;
        if eight && core::ptr::eq(self.reference, &CHIRP_WORDS.0[..]) {
            return Some(native_eight_blocks(pairs.first_chunk()?, &CHIRP_WORDS.0));
        }
        let samples = usize::from(self.config.samples);
        let kept = usize::from(self.config.range_samples);
        let block = samples.checked_div(kept)?;
        let mut all = [[0_i64; 2]; BEATS];
        let sums = all.get_mut(..kept)?;
        match (self.config.gate, self.config.format) {
            (None, SampleFormat::Real) => {
                for (sum, samples) in sums.iter_mut().zip(slot.chunks_exact(block.max(1))) {
                    *sum = [samples.iter().map(|&x| i64::from(x)).sum(), 0];
                }
            }
            (None, _) if self.reference.is_empty() => block_sums(pairs, block, sums),
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
        if self.config.dechirp == Dechirp::Analog {
            all.iter_mut().for_each(|[_, im]| *im = im.wrapping_neg());
        }
        Some(all)
    }
}

/// `round(sum / 2^shift)`, halves up, 32 bits of it; shifts up to 31.
#[inline(always)]
fn rounded(sum: i64, shift: u32) -> i32 {
    let shift = shift & 31;
    let (low, carry) = (sum as u32).overflowing_add((1 << shift) >> 1);
    let high = ((sum >> 32) as u32).wrapping_add(u32::from(carry));
    (low >> shift | high << 1 << (31 - shift)) as i32
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
