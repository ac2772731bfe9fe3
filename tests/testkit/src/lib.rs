//! What the tests of the core, the tests of the host and the firmware share: models, signals, fault injection.
#![no_std]

pub mod campaign;
pub mod churn;
pub mod models;
pub mod random_model;
pub mod signals;

use core::ops::Range;
use core::sync::atomic::Ordering::Relaxed;
use sdp3_core::Retained;

/// Inverts the bits of `mask` in word `at`, modulo [`Retained::LEN`], as radiation does.
pub fn flip(retained: &Retained, at: usize, mask: u32) {
    if let Some(word) = retained.words().get(at % Retained::LEN) {
        word.store(word.load(Relaxed) ^ mask, Relaxed);
    }
}

/// Inverts a bit, modulo their number, of bytes that their readers take for constant, as radiation does; false if there are none.
///
/// The bytes must lie in memory that can be written, and may have any value.
#[inline(never)]
#[allow(unsafe_code)] // the one place
pub fn flip_bit(bytes: &Range<*const u8>, bit: u32) -> bool {
    let bits = 8 * (bytes.end as usize).wrapping_sub(bytes.start as usize);
    let Some(bit) = (bit as usize).checked_rem(bits) else { return false };
    let byte = core::hint::black_box(bytes.start.wrapping_add(bit / 8)).cast_mut();
    // SAFETY: the byte is one of those, no other context reads it at this time, and every value is a byte. The language knows no
    // memory that changes by itself under a shared reference: the compiler is kept from seeing where the pointer comes from, and no
    // value of the bytes lives across this call, which is not inlined.
    unsafe { byte.write_volatile(byte.read_volatile() ^ 1 << (bit % 8)) };
    true
}
