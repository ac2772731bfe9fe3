//! No number of the signal chain outgrows its word: the ranges stage by stage, each proved by the compiler.
//!
//! Stated are magnitudes, of complex numbers too: a part is never larger. Where a sum wraps on purpose (a convolution with its
//! bias, as TensorFlow Lite's reference does) the stage says so. The Winograd kernels have ranges of their own, beside what
//! packs their weights.

use crate::config::{Dechirp, RadarConfig, RangeGate};
use crate::dims::BEATS;
use crate::dsn::conv::MAX_CHANNELS;
use crate::early_exit::{EXITS, MAX_WEIGHT};
use crate::scheduler::apportion::WEIGHT_BITS as LEVEL_BITS;
use crate::scheduler::layout::{LONGEST_PERIOD, USERS};
use crate::signal::clutter::{GRAM_SLOTS, PROJECTION_BITS, SLOW_TIME_BITS};
use crate::signal::dechirp::CHIRP;
use crate::signal::logarithm::LEVELS_PER_OCTAVE;
use crate::signal::stft::{BUTTERFLY_BITS, FULL_SHIFT, HALF_SHIFT, HIGH_PRODUCT_BITS, STAGES};

/// `|b|^2` of a range sample is below two to this.
const BEAT_POWER_BITS: u32 = 51;

// Samples to range samples. |x| <= sqrt(2) 2^15; |s| is the reference's largest, for every length of block.
const _: () = {
    let mut reference = 0;
    let mut n = 0;
    while n < CHIRP.len() {
        let (i, q) = (CHIRP[n][0] as i128, CHIRP[n][1] as i128);
        let power = i * i + q * q;
        reference = if power > reference { power } else { reference };
        n += 1;
    }
    let sample = 2 << 30;
    let product = sample * reference;
    assert!(product < 1 << 62, "each part of x conj(s) fits i32");
    let mut samples = 1;
    while samples <= 2048 {
        // one block of all samples is the longest; rounding adds less than 1 to |b| < 2^26
        let config = RadarConfig { samples, range_samples: 1, ..RadarConfig::PAPER };
        let length = samples as i128;
        let digital = (product * length * length) >> (2 * config.shift());
        let analog = RadarConfig { dechirp: Dechirp::Analog, ..config };
        let sums = (sample * length * length) >> (2 * analog.shift());
        // a gate's reference has at most half the samples' number as sum of magnitudes, to a hundredth
        let gate = Some(RangeGate { first_bin: 0, bins_per_sample: 1 });
        let gated = RadarConfig { gate, ..analog };
        let profile = (product * length * length / 4 * 51 / 50) >> (2 * gated.shift());
        let limit = (1 << BEAT_POWER_BITS) - (1 << 27);
        assert!(digital < limit && sums < limit && profile < limit, "a range sample's power is as stated");
        samples += 1;
    }
};

// Beats to the Gram matrix: no entry is larger than the diagonal's.
const _: () = assert!((GRAM_SLOTS as i128) << BEAT_POWER_BITS < 1 << 63, "a sum of powers fits i64");

// Beats to slow time: |w| <= sqrt(8) for any projection w = P 1, and |w^H b| <= |w| |b|.
const _: () = {
    let squared_bits = BEATS.ilog2() + 2 * PROJECTION_BITS + BEATS.ilog2() + BEAT_POWER_BITS;
    assert!(squared_bits < 2 * 57, "w^H b is below 2^57 and fits i64");
    assert!(57 - SLOW_TIME_BITS <= 63, "no shift is longer than stated");
};

// Slow time to spectrum in integers: twice the binary logarithm of the largest magnitude, so that sqrt(2) counts 1.
const _: () = {
    let (twice, four_times) = (2, 2 * BUTTERFLY_BITS);
    let halved = 2 * HIGH_PRODUCT_BITS;
    let signal = 2 * SLOW_TIME_BITS + 1;
    // half of the samples are zero, so that a butterfly only doubles; or all are there
    let (short, long) = (signal + 2 * HALF_SHIFT + twice, signal + 2 * FULL_SHIFT + four_times);
    let mut sum = if short > long { short } else { long };
    // the other stages of a part, and the combination of the parts
    let mut stage = 1;
    while stage <= STAGES {
        assert!(sum < 2 * 31, "every sum fits i32");
        sum = sum - halved + four_times;
        stage += 1;
    }
    assert!(sum < 2 * 31 && sum + twice <= 64, "a bin fits i32, and the powers of four bins fit u64");
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
    let divided = (USERS as i128 + 1) * LONGEST_PERIOD as i128;
    assert!(divided << LEVEL_BITS < 1 << 63, "a weighted level fits i64");
    assert!(2 * LONGEST_PERIOD as i128 * (u32::MAX as i128) < 1 << 63, "a user's bits fit i64");
};
