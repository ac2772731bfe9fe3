//! The stages of the signal chain one by one.

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
#[path = "signal/logarithm.rs"]
mod logarithm;
#[path = "signal/selftest.rs"]
mod selftest;
#[path = "signal/spectrogram.rs"]
mod spectrogram;
#[path = "signal/stft.rs"]
mod stft;
#[path = "signal/values.rs"]
mod values;
