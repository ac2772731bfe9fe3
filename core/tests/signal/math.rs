//! Tests of `math`: against std and printed tables.

use sdp3_core::math::*;

#[test]
fn compile_time_trigonometry_agrees_with_the_platform() {
    for k in 0..2000 {
        let (s, c) = sin_cos_turn(k, 2000);
        let x = core::f64::consts::TAU * k as f64 / 2000.0;
        assert!((s - x.sin()).abs() < 1e-14 && (c - x.cos()).abs() < 1e-14, "{k}: {s} {c}");
    }
}

#[test]
fn compile_time_powers_of_two_agree_with_the_platform() {
    for k in 0..64 {
        assert!((exp2_fraction(k, 64) - (k as f64 / 64.0).exp2()).abs() < 1e-15);
    }
}

#[test]
fn bessel_series_matches_tabulated_values() {
    // Abramowitz & Stegun, table 9.8 and 9.11
    for (x, i0) in [(0.0, 1.0), (1.0, 1.266_065_88), (5.0, 27.239_871_8), (10.0, 2_815.716_63)] {
        assert!((f64::from(bessel_i0f(x)) / i0 - 1.0).abs() < 2e-6, "{x}");
    }
}

#[test]
fn fast_exponential_holds_its_bound() {
    let mut worst = 0.0_f64;
    for k in 0..=1600 {
        let x = -(k as f32) / 100.0;
        let exact = f64::from(x).exp();
        worst = worst.max((f64::from(fast_expf(x)) / exact - 1.0).abs());
    }
    assert!(worst < 3e-3, "{worst}");
}
