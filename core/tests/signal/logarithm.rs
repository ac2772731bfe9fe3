//! Tests of `signal::logarithm`.

use sdp3_core::signal::logarithm::*;

#[test]
fn levels_are_the_floor_of_the_exact_logarithm() {
    for exponent in -126..=127_i32 {
        for (i, &threshold) in SIGNIFICAND_THRESHOLDS.iter().enumerate() {
            let threshold = threshold >> 8;
            for significand in [threshold - 1, threshold, threshold + 1, threshold + 31] {
                if !(1 << 23..1 << 24).contains(&significand) {
                    continue;
                }
                let p = f32::from_bits(((exponent + 127) as u32) << 23 | significand & 0x7f_ffff);
                let exact = (f64::from(p).log2() * 64.0).floor() as i16;
                assert_eq!(level(p), exact, "{p:e} near threshold {i}");
            }
        }
    }
    for (i, &threshold) in SIGNIFICAND_THRESHOLDS.iter().enumerate() {
        for significand in (-3..=3).map(|k| u64::from(threshold).wrapping_add_signed(k)) {
            for shift in [0, 1, 13, 31].into_iter().filter(|_| significand < 1 << 32) {
                let exact = ((significand as f64).log2() * 64.0).floor() as i16 + 64 * shift;
                let p = significand << shift;
                assert_eq!(level_u64(p), exact, "{p} near threshold {i}");
                assert_eq!(level_u64(p | ((1 << shift) - 1)), exact);
            }
        }
    }
    for p in 1..100_000_u64 {
        assert_eq!(level_u64(p), ((p as f64).log2() * 64.0 + 1e-9).floor() as i16);
    }
    for p in [0.0, -1.0, 1e-40, f32::INFINITY, f32::NAN] {
        assert_eq!(level(p), FLOOR);
    }
}
