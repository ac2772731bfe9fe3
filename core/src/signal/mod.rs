//! The signal chain: samples of a slot to the network's image, one file per step.

pub mod clutter;
pub mod dechirp;
pub mod fast_time;
pub mod front_end;
pub mod logarithm;
mod range_gate;
pub mod spectrogram;
pub mod stft;
mod workspace;
