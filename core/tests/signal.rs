//! The stages of the signal chain one by one.

#[path = "signal/clutter.rs"]
mod clutter;
#[path = "signal/config.rs"]
mod config;
#[path = "signal/conj_mac.rs"]
mod conj_mac;
#[path = "signal/crc32.rs"]
mod crc32;
#[path = "signal/digest.rs"]
mod digest;
#[path = "signal/early_exit.rs"]
mod early_exit;
#[path = "signal/fast_time.rs"]
mod fast_time;
#[path = "signal/fixed_stft.rs"]
mod fixed_stft;
#[path = "signal/logarithm.rs"]
mod logarithm;
#[path = "signal/math.rs"]
mod math;
#[path = "signal/selftest.rs"]
mod selftest;
#[path = "signal/spectrogram.rs"]
mod spectrogram;
#[path = "signal/stft.rs"]
mod stft;
#[path = "signal/values.rs"]
mod values;
