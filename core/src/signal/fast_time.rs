//! Fast time: the samples of one slot to its range samples, as the radar configuration says.

use super::dechirp::{CHIRP_WORDS, Iq, write_chirp};
use super::range_gate::write_references;
use crate::config::{Dechirp, RadarConfig, SampleFormat};
use crate::dims::{BEATS, Beat, Complex, ZERO_BEAT};
use crate::simd::conj_mac::{Sum, conj_mac};

/// A configuration and the reference samples it needs.
#[derive(Debug)]
pub struct FastTime<'b> {
    config: RadarConfig,
    /// Empty: summed as they are.
    reference: &'b [Iq],
}

impl<'b> FastTime<'b> {
    /// Fills `memory` with [`RadarConfig::reference_len`] reference samples; `None` if it has fewer or the configuration is not valid.
    pub fn new(config: RadarConfig, memory: &'b mut [Iq]) -> Option<Self> {
        let table = memory.get_mut(..config.reference_len()).filter(|_| config.is_valid())?;
        let reference: &[Iq] = match (config.gate, config.dechirp) {
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
            (None, _) if self.reference.is_empty() => block_sums(pairs, block, sums),
            (None, _) => conj_mac(pairs, self.reference, block, sums),
            (Some(_), SampleFormat::Complex) => {
                for (sum, reference) in sums.iter_mut().zip(self.reference.chunks_exact(samples.max(1))) {
                    conj_mac(pairs, reference, samples, core::slice::from_mut(sum));
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
fn block_sums(samples: &[Iq], block: usize, sums: &mut [[i64; 2]]) {
    for (sum, samples) in sums.iter_mut().zip(samples.chunks_exact(block.max(1))) {
        *sum = samples.iter().fold([0; 2], |[re, im], [i, q]| [re + i64::from(*i), im + i64::from(*q)]);
    }
}

/// `sum conj(reference) samples` of real samples.
fn real_conj_mac(samples: &[i16], reference: &[Iq]) -> [i64; 2] {
    let (mut re, mut im) = (Sum::default(), Sum::default());
    for (&x, [c, s]) in samples.iter().zip(reference) {
        re.add(i32::from(x) * i32::from(*c));
        im.add((i32::from(x) * i32::from(*s)).wrapping_neg());
    }
    [re.value(), im.value()]
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::config::RangeGate;
    use crate::signal::dechirp::CHIRP;
    use std::vec;
    use std::vec::Vec;

    #[test]
    fn the_chirp_against_itself_is_a_constant() {
        let chirp = FastTime::new(RadarConfig::PAPER, &mut []).unwrap();
        let full = (32767_i64 * 32767 * 125) >> RadarConfig::PAPER.shift();
        for value in chirp.beat(CHIRP.as_flattened()).unwrap() {
            // rounding of the table: each sample is off by at most 0.71 of 32767
            assert!((i64::from(value.re) - full).abs() < full / 30_000, "{}", value.re);
            assert!(i64::from(value.im).abs() < full / 30_000);
        }
    }

    /// The strongest slot there is for a range sample: every value at the end of the range that adds to it.
    fn loudest(fast_time: &FastTime<'_>) -> Vec<i16> {
        let samples = usize::from(fast_time.config.samples);
        let at = |n: usize| fast_time.reference.get(n).copied().unwrap_or([1, 1]);
        let end = |s: i16| if s < 0 { i16::MIN } else { i16::MAX };
        let values = (0..samples).flat_map(|n| at(n).map(end));
        match fast_time.config.format {
            SampleFormat::Complex => values.collect(),
            SampleFormat::Real => values.step_by(2).collect(),
        }
    }

    #[test]
    fn a_full_scale_slot_of_any_configuration_stays_within_the_stated_magnitude() {
        let blocks = RadarConfig { dechirp: Dechirp::Analog, ..RadarConfig::PAPER };
        let wide = RadarConfig { samples: 2048, ..RadarConfig::IWR };
        let gate = |bins| Some(RangeGate { first_bin: 8, bins_per_sample: bins });
        let mut configs = vec![RadarConfig::PAPER, RadarConfig::BGT60, RadarConfig::IWR, blocks];
        configs.extend([1, 2, 32].map(|bins| RadarConfig { gate: gate(bins), ..wide }));
        configs.extend([64, 200, 2048].map(|samples| RadarConfig { samples, ..RadarConfig::PAPER }));
        configs.extend([64, 2048].map(|samples| RadarConfig {
            samples,
            range_samples: 1,
            ..RadarConfig::PAPER
        }));
        configs.push(RadarConfig { samples: 2048, range_samples: 1, ..blocks });
        for config in configs {
            let mut memory = vec![[0; 2]; config.reference_len()];
            let fast_time = FastTime::new(config, &mut memory).unwrap();
            for value in fast_time.beat(&loudest(&fast_time)).unwrap() {
                let power = i64::from(value.re).pow(2) + i64::from(value.im).pow(2);
                assert!(power < 1 << 51, "{config:?}: {value}");
            }
            assert!(fast_time.beat(&[0; 63]).is_none());
        }
    }

    #[test]
    fn real_and_complex_echoes_land_in_the_range_sample_that_covers_them() {
        for config in [RadarConfig::BGT60, RadarConfig::IWR] {
            let gate = config.gate.unwrap();
            let mut memory = vec![[0; 2]; config.reference_len()];
            let fast_time = FastTime::new(config, &mut memory).unwrap();
            let bins = f64::from(gate.bins_per_sample);
            for range in 0..8 {
                for inside in [0.0, 0.3, 0.5, 0.9] {
                    let bin = f64::from(gate.first_bin) - 0.5 + bins * (range as f64 + inside);
                    let phase = |n: usize| std::f64::consts::TAU * bin * n as f64 / f64::from(config.samples);
                    let pair = |n: usize| [(1e4 * phase(n).cos()) as i16, (1e4 * phase(n).sin()) as i16];
                    let all: Vec<i16> = (0..usize::from(config.samples)).flat_map(pair).collect();
                    let real = config.format == SampleFormat::Real;
                    let slot: Vec<i16> = all.iter().copied().step_by(1 + usize::from(real)).collect();
                    let beat = fast_time.beat(&slot).unwrap();
                    let power = beat.map(|b| f64::from(b.re).hypot(f64::from(b.im)));
                    let strongest = (0..8).max_by(|&a, &b| power[a].total_cmp(&power[b])).unwrap();
                    // at the very edge two neighbours are alike
                    assert!(
                        strongest == range || (inside == 0.0 && strongest + 1 == range),
                        "{bin}: {power:?}"
                    );
                }
            }
        }
    }
}
