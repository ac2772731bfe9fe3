//! Sizes that every configuration shares, and the types of one slot's data on its way to a spectrum.

pub use num_complex::Complex;

/// Range samples per slot that clutter removal works on, at most: the Gram matrix is 8 x 8.
///
/// At the paper's bandwidth everything in a room lies within two range cells; eight block sums keep what the thousand samples
/// hold to -63 dB (d = 3) or better.
pub const BEATS: usize = 8;

/// Doppler rows of the network's image.
pub const ROWS: usize = 64;

/// Length of the Doppler FFT, N_fft.
pub const FFT_LEN: usize = 256;

/// The range samples of one slot, `[fast_time]`, in LSB of [`FastTime`](crate::signal::fast_time::FastTime); the magnitude of
/// each is below 2^25.5. Those that a configuration does not use are zero.
pub type Beat = [Complex<i32>; BEATS];

/// A beat of zeros.
pub const ZERO_BEAT: Beat = [Complex::new(0, 0); BEATS];

/// Spectrum of one frame, `[doppler]`, bin k at k PRF / 256; bins 128 to 255 are the negative frequencies.
pub(crate) type Spectrum = [Complex<f32>; FFT_LEN];

/// The same in integers, in LSB of the slow-time signal (half of it for a window beyond 128 samples). Bins that become no row
/// are zero.
pub(crate) type FixedBins = [Complex<i32>; FFT_LEN];
