//! No number of the street outgrows its word: the ranges stage by stage, each proved by the compiler.
//!
//! Stated are magnitudes, of complex numbers too: a part is never larger. Where a sum wraps on purpose (a convolution with its
//! bias, as TensorFlow Lite's reference does) the stage says so. The kernels in vectors and tiles have ranges of their own, beside
//! what packs their weights.

use crate::dims::{BEATS, BLOCK_SAMPLES, SLOT_SAMPLES};
use crate::dsn::conv::MAX_CHANNELS;
use crate::early_exit::{EXITS, MAX_WEIGHT};
use crate::scheduler::apportion::WEIGHT_BITS as LEVEL_BITS;
use crate::scheduler::layout::{LONGEST_PERIOD, RECEIVERS};
use crate::signal::clutter::{GRAM_SLOTS, SLOW_TIME_BITS, WEIGHT_BITS};
use crate::signal::dechirp::{BEAT_SHIFT, CHIRP};
use crate::signal::logarithm::LEVELS_PER_OCTAVE;

/// `|b|^2` of a beat sample is below two to this.
const BEAT_POWER_BITS: u32 = 51;

// Samples to beats. |x| <= sqrt(2) 2^15; |s| is the reference's largest.
const _: () = {
    let mut reference = 0;
    let mut n = 0;
    while n < SLOT_SAMPLES {
        let (i, q) = (CHIRP[n].i as i128, CHIRP[n].q as i128);
        let power = i * i + q * q;
        reference = if power > reference { power } else { reference };
        n += 1;
    }
    let product = (2 << 30) * reference;
    assert!(product < 1 << 62, "each part of x conj(s) fits i32");
    let sum = product * (BLOCK_SAMPLES * BLOCK_SAMPLES) as i128;
    // rounding adds less than 1 to |b| < 2^26
    assert!((sum >> (2 * BEAT_SHIFT)) + (1 << 27) < 1 << BEAT_POWER_BITS, "a beat's power is as stated");
};

// Beats to the Gram matrix, whose entries are no larger than its diagonal's.
const _: () = assert!((GRAM_SLOTS as i128) << BEAT_POWER_BITS < 1 << 63, "a sum of powers fits i64");

// Beats to slow time: |w| <= sqrt(8) for any projection w = P 1, and |w^H b| <= |w| |b|.
const _: () = {
    let squared_bits = BEATS.ilog2() + 2 * WEIGHT_BITS + BEATS.ilog2() + BEAT_POWER_BITS;
    assert!(squared_bits < 2 * 57, "w^H b is below 2^57 and fits i64");
    assert!(57 - SLOW_TIME_BITS <= 40, "no shift is longer than stated");
};

// Slow time to spectrum in integers: twice the binary logarithm of the largest magnitude, so that sqrt(2) counts 1.
const _: () = {
    let (twice, four_times, half) = (2, 4, 2);
    let signal = 2 * SLOW_TIME_BITS + 1;
    // half of the samples are zero and the others taken eight-fold; all are there and taken four-fold
    let (short, long) = (signal + 3 * twice + twice, signal + 2 * twice + four_times);
    let first = if short > long { short } else { long };
    let second = first - half + four_times;
    let third = second - half + four_times;
    let bin = third - half + four_times;
    assert!(third < 2 * 31 && bin < 2 * 31, "every sum fits i32");
    assert!(bin + twice <= 64, "the powers of four bins fit u64");
};

// Powers to levels: of f32, and of u64.
const _: () = assert!(128 * (LEVELS_PER_OCTAVE as i32) < 1 << 15, "a level fits i16");

// Image to logits: |x - z| <= 255, |w| <= 128.
const _: () =
    assert!(255 * 128 * 9 * (MAX_CHANNELS as i64) < 1 << 31, "a convolution without its bias fits i32");

// Logits to evidence.
const _: () = assert!(128 * MAX_WEIGHT as i64 * (EXITS as i64) < 1 << 31, "evidence fits i32");

// Rates to shares: what is divided is the slots and what everybody has.
const _: () = {
    let divided = (RECEIVERS as i128 + 1) * LONGEST_PERIOD as i128;
    assert!(divided << LEVEL_BITS < 1 << 63, "a weighted level fits i64");
    assert!(2 * LONGEST_PERIOD as i128 * (u32::MAX as i128) < 1 << 63, "a receiver's bits fit i64");
};
