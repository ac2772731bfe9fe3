//! The shapes of what walks down the street: a slot, its decimated beat, the spectrum of a frame.
//!
//! Sensing model of the paper, section II-B: B = 10 MHz, T_sw = 100 us, f_s = 10 MHz, hence L = T_sw f_s = 1000.

pub use nalgebra::Complex;

/// Complex samples in one sensing slot, L.
pub const SLOT_SAMPLES: usize = 1000;

/// Decimated beat samples per slot, L'. Everything in a room lies within two range cells, so eight samples
/// keep what the thousand say to -63 dB (d = 3) or better.
pub const BEATS: usize = 8;

/// Samples summed into one beat sample.
pub const BLOCK_SAMPLES: usize = SLOT_SAMPLES / BEATS;

/// Doppler rows of the network's image.
pub const ROWS: usize = 64;

/// Length of the Doppler FFT, N_fft.
pub const FFT_LEN: usize = 256;

/// One complex sample of the converter: in-phase and quadrature, LSB, two's complement; one word, in-phase first.
#[repr(C, align(4))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Iq {
    /// In-phase part in LSB.
    pub i: i16,
    /// Quadrature part in LSB.
    pub q: i16,
}

impl Iq {
    /// Reads the converter's byte order: i then q, each little-endian.
    pub const fn from_le_bytes(bytes: [u8; 4]) -> Self {
        let [i0, i1, q0, q1] = bytes;
        Iq { i: i16::from_le_bytes([i0, i1]), q: i16::from_le_bytes([q0, q1]) }
    }

    /// The inverse of [`Iq::from_le_bytes`].
    pub const fn to_le_bytes(self) -> [u8; 4] {
        let [i0, i1] = self.i.to_le_bytes();
        let [q0, q1] = self.q.to_le_bytes();
        [i0, i1, q0, q1]
    }
}

/// The samples of one sensing slot, `[fast_time]`.
pub type Slot = [Iq; SLOT_SAMPLES];

/// The decimated beat signal of one slot, `[fast_time]`, in eighths of an ADC LSB summed over
/// [`BLOCK_SAMPLES`]; the magnitude of each value is below 2^25.5.
pub type Beat = [Complex<i32>; BEATS];

/// A beat of zeros.
pub const ZERO_BEAT: Beat = [Complex::new(0, 0); BEATS];

/// Spectrum of one frame, `[doppler]`, bin k at k PRF / 256; bins 128..=255 are the negative frequencies.
pub type Spectrum = [Complex<f32>; FFT_LEN];

/// The same in integers, in LSB of the slow-time signal (half of it for a window beyond 128 samples). Bins that become no row are
/// zero.
pub type FixedBins = [Complex<i32>; FFT_LEN];

const _: () = assert!(BLOCK_SAMPLES * BEATS == SLOT_SAMPLES, "the blocks must tile the slot");

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_in_phase_first_and_little_endian() {
        let sample = Iq { i: 0x0201, q: -2 };
        assert_eq!(sample.to_le_bytes(), [1, 2, 0xfe, 0xff]);
        assert_eq!(Iq::from_le_bytes([1, 2, 0xfe, 0xff]), sample);
    }
}
