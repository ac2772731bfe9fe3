//! What the tests of the core, the tests of the host and the firmware share: models, signals, fault injection.
#![no_std]

pub mod campaign;
pub mod churn;
pub mod models;
pub mod random_model;
pub mod signals;

use core::sync::atomic::Ordering::Relaxed;
use sdp3_core::Retained;

/// Inverts the bits of `mask` in word `at`, modulo [`Retained::LEN`], as radiation does.
pub fn flip(retained: &Retained, at: usize, mask: u32) {
    if let Some(word) = retained.words().get(at % Retained::LEN) {
        word.store(word.load(Relaxed) ^ mask, Relaxed);
    }
}
