//! The signal chain: samples of a slot to the network's image, one file per step.

pub mod clutter;
pub mod dechirp;
pub mod dechirp2;
pub mod fast_time;
mod range_gate;
pub mod front_end;
pub mod logarithm;
pub mod spectrogram;
pub mod stft;
