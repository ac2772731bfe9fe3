//! Tests of `dsn::head`.

use sdp3_core::dsn::head::*;
use sdp3_core::dsn::per_channel::PerChannelQuant;

/// Two classes of one weight each.
fn head() -> Head<'static> {
    let layer = PerChannelQuant {
        in_zp: -3,
        out_zp: 5,
        act_min: -100,
        act_max: 100,
        channels: 2,
        multipliers: &[[0, 0, 0, 64]; 2], // 2^30: one half
        biases: &[[10, 0, 0, 0], [246, 255, 255, 255]],
        shifts: &[1, 0], // doubled again, and not
        weights: &[2, 253],
    };
    Head { quant: layer, inputs: 1 }
}

#[test]
fn a_class_is_its_scaled_sum() {
    let mut logits = [0; 2];
    head().forward(&[4], &mut logits);
    // 10 + (4 + 3) 2 = 24; -10 - (4 + 3) 3 = -31, halved -15.5, which the first rounding takes to -15
    assert_eq!(logits, [24 + 5, -15 + 5]);
    head().forward(&[127], &mut logits);
    assert_eq!(logits, [100, -100]);
}

#[test]
fn the_class_is_the_first_maximum() {
    for (logits, class) in [([1, 5, 5], 1), ([-128, -128, -128], 0), ([3, 2, 4], 2)] {
        assert_eq!(arg_max(&logits), class);
    }
}

#[test]
fn far_below_the_best_counts_nothing() {
    assert_eq!(confidence(&[7, 7], 0, 1.0), 0.5);
    assert_eq!(confidence(&[1], 1, 1.0), 0.0, "no such class");
    assert_eq!(confidence(&[-17, -17, -17, -17, -17, 0], 5, 1.0), 1.0);
    assert!(confidence(&[-16, -16, -16, -16, -16, 0], 5, 1.0) < 1.0);
    let exact = 1.0 / (1.0 + libm::exp(-1.0) + libm::exp(-3.0));
    let found = f64::from(confidence(&[2, 1, -1], 0, 1.0));
    assert!((found / exact - 1.0).abs() < 6e-3, "{found} {exact}");
}
