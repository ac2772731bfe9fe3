//! What a sensor's samples are: the radar configuration, part of every model file.
//!
//! Three ways lead from a sweep to at most eight range samples:
//!
//! | `dechirp` | `gate` | range samples |
//! |---|---|---|
//! | digital | none | times the conjugate chirp, summed in blocks ([`dechirp`](crate::signal::dechirp)) |
//! | analog | none | summed in blocks; of a Doppler sensor, which has no sweep, all samples of a slot |
//! | analog | some | the range profile around some bins (`signal::range_gate`) |

use crate::dims::BEATS;

/// Complex or real samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SampleFormat {
    /// In-phase and quadrature, interleaved, in-phase first.
    Complex,
    /// One value a sample; needs a sensor that dechirps. Range samples of a gate are complex. Sums of blocks are real, so that approaching
    /// and receding are alike; see [`RadarConfig::one_sided`].
    Real,
}

/// Where the received sweep is mixed with the sent one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Dechirp {
    /// In this crate: the converter samples the received chirp at a rate equal to the bandwidth.
    Digital,
    /// In the sensor: the converter samples the beat signal, the sent sweep times the conjugate of the received one, so that
    /// range is a positive frequency. Range samples are conjugated: an approaching target has a positive Doppler frequency as with
    /// digital dechirp.
    Analog,
}

/// Which part of the range profile is kept: each range sample covers `bins_per_sample` bins of c / (2 B).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RangeGate {
    /// First bin of the profile.
    pub first_bin: u16,
    /// Bins of one range sample, 1 to 32.
    pub bins_per_sample: u8,
}

/// A sensor's samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RadarConfig {
    /// Samples of a sweep, 64 to 2048; from 1 where the sensor dechirps and there is no gate.
    pub samples: u16,
    /// Complex or real.
    pub format: SampleFormat,
    /// Significant bits of a value, 8 to 16.
    pub converter_bits: u8,
    /// Whether they are the upper bits of the 16, the lower ones zero; else the value is sign-extended.
    pub left_justified: bool,
    /// Where the sweep is dechirped.
    pub dechirp: Dechirp,
    /// Range samples kept of a slot, 1 to 8; without a gate they divide `samples`.
    pub range_samples: u8,
    /// Which bins of the range profile they are; needs a sensor that dechirps.
    pub gate: Option<RangeGate>,
}

impl RadarConfig {
    /// The paper's radar: L = 1000 complex samples at 10 MHz, eight block sums of 125.
    pub const PAPER: Self = RadarConfig {
        samples: 1000,
        format: SampleFormat::Complex,
        converter_bits: 16,
        left_justified: false,
        dechirp: Dechirp::Digital,
        range_samples: 8,
        gate: None,
    };

    /// A 60 GHz module of the Infineon BGT60 family: 128 real samples of 12 bits; at 1 GHz a bin is 15 cm, the gate 0.9 to 5.7 m.
    pub const BGT60: Self = RadarConfig {
        samples: 128,
        format: SampleFormat::Real,
        converter_bits: 12,
        dechirp: Dechirp::Analog,
        gate: Some(RangeGate { first_bin: 6, bins_per_sample: 4 }),
        ..Self::PAPER
    };

    /// A 77 GHz module of the TI IWR family: 256 complex samples; at 4 GHz a bin is 3.7 cm, the gate 0.9 to 5.7 m.
    pub const IWR: Self = RadarConfig {
        samples: 256,
        dechirp: Dechirp::Analog,
        gate: Some(RangeGate { first_bin: 24, bins_per_sample: 16 }),
        ..Self::PAPER
    };

    /// A Doppler sensor with one mixer (continuous wave, one output): a slot is one real sample.
    pub const DOPPLER: Self = RadarConfig {
        samples: 1,
        format: SampleFormat::Real,
        dechirp: Dechirp::Analog,
        range_samples: 1,
        ..Self::PAPER
    };

    /// A Doppler sensor with I and Q: a slot is one complex sample. Q leads I where a target approaches, as in the beat of a sweep.
    pub const DOPPLER_IQ: Self = RadarConfig { format: SampleFormat::Complex, ..Self::DOPPLER };

    /// Fewest samples of a sweep.
    pub(crate) const LEAST_SAMPLES: u16 = 64;

    /// Whether every field is within its range and they fit together.
    pub const fn is_valid(&self) -> bool {
        let (samples, kept) = (self.samples as usize, self.range_samples as usize);
        let complex = matches!(self.format, SampleFormat::Complex);
        let analog = matches!(self.dechirp, Dechirp::Analog);
        let least = if analog && self.gate.is_none() { 1 } else { Self::LEAST_SAMPLES };
        let sizes = self.samples >= least && samples <= 2048 && kept >= 1 && kept <= BEATS;
        let bits = self.converter_bits >= 8 && self.converter_bits <= 16;
        let fits = match self.gate {
            None => kept > 0 && samples.is_multiple_of(kept),
            Some(RangeGate { first_bin, bins_per_sample }) => {
                let bins = if complex { samples } else { samples / 2 };
                let end = first_bin as usize + bins_per_sample as usize * kept;
                bins_per_sample >= 1 && bins_per_sample <= 32 && end <= bins && analog
            }
        };
        sizes && bits && fits && (complex || analog)
    }

    /// Whether range samples are real: then slot n is multiplied by (-j)^n, which brings Doppler frequencies of 0 to half the slot rate to the
    /// middle of the spectrum, so that row 0 of an image is at 0 Hz if its rows cover half of the slot rate.
    pub const fn one_sided(&self) -> bool {
        matches!(self.format, SampleFormat::Real) && self.gate.is_none()
    }

    /// Values of i16 in a slot: two a complex sample.
    pub const fn values_per_slot(&self) -> usize {
        match self.format {
            SampleFormat::Complex => 2 * self.samples as usize,
            SampleFormat::Real => self.samples as usize,
        }
    }

    /// Reference samples that a pipeline makes for itself and keeps in its memory: none for the paper's chirp, which is a constant.
    pub const fn reference_len(&self) -> usize {
        match (self.gate, self.dechirp) {
            (Some(_), _) => self.samples as usize * self.range_samples as usize,
            (None, Dechirp::Digital) if self.samples != Self::PAPER.samples => self.samples as usize,
            _ => 0,
        }
    }

    /// Bits dropped from the sum that makes a range sample, so that its magnitude stays below 2^25.5.
    ///
    /// A sample is below 2^15.5, a reference below 2^15. Blocks of n: `5 + ceil(log2 n)` after the product, `ceil(log2 n) - 9`
    /// without. A gate's reference has about half of its samples' number as sum of magnitudes: `5 + ceil(log2 samples)`.
    pub const fn shift(&self) -> u32 {
        let block =
            (self.samples / if self.range_samples == 0 { 1 } else { self.range_samples as u16 }) as u32;
        match (self.gate, self.dechirp) {
            (Some(_), _) => 5 + ceil_log2(self.samples as u32),
            (None, Dechirp::Digital) => 5 + ceil_log2(block),
            (None, Dechirp::Analog) => ceil_log2(block).saturating_sub(9),
        }
    }

    /// The eight bytes of a model file's header; all zero for [`RadarConfig::PAPER`].
    ///
    /// Samples (u16, little-endian); range samples; converter bits; flags: 1 real, 2 left-justified, 4 dechirped in the sensor;
    /// bins per range sample, 0 without a gate; first bin (u16).
    pub const fn to_bytes(&self) -> [u8; 8] {
        let (first, bins) = match self.gate {
            Some(RangeGate { first_bin, bins_per_sample }) => (first_bin.to_le_bytes(), bins_per_sample),
            None => ([0, 0], 0),
        };
        let samples = self.samples.to_le_bytes();
        let flags = matches!(self.format, SampleFormat::Real) as u8
            | (self.left_justified as u8) << 1
            | (matches!(self.dechirp, Dechirp::Analog) as u8) << 2;
        let bytes = [
            samples[0],
            samples[1],
            self.range_samples,
            self.converter_bits,
            flags,
            bins,
            first[0],
            first[1],
        ];
        if matches!(bytes, [0xe8, 3, 8, 16, 0, 0, 0, 0]) { [0; 8] } else { bytes }
    }

    /// The inverse of [`RadarConfig::to_bytes`]; `None` if they are no valid configuration.
    pub const fn from_bytes(bytes: [u8; 8]) -> Option<Self> {
        let [s0, s1, range_samples, converter_bits, flags, bins_per_sample, f0, f1] = bytes;
        if matches!(bytes, [0, 0, 0, 0, 0, 0, 0, 0]) {
            return Some(Self::PAPER);
        }
        let first_bin = u16::from_le_bytes([f0, f1]);
        let config = RadarConfig {
            samples: u16::from_le_bytes([s0, s1]),
            format: if flags & 1 != 0 { SampleFormat::Real } else { SampleFormat::Complex },
            converter_bits,
            left_justified: flags & 2 != 0,
            dechirp: if flags & 4 != 0 { Dechirp::Analog } else { Dechirp::Digital },
            range_samples,
            gate: if bins_per_sample > 0 { Some(RangeGate { first_bin, bins_per_sample }) } else { None },
        };
        let whole = flags < 8 && (bins_per_sample > 0 || first_bin == 0);
        if whole && config.is_valid() { Some(config) } else { None }
    }
}

/// The least k with `n <= 2^k`.
pub(crate) const fn ceil_log2(n: u32) -> u32 {
    if n <= 1 { 0 } else { u32::BITS - (n - 1).leading_zeros() }
}
