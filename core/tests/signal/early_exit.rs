//! Tests of `early_exit`.

use sdp3_core::early_exit::*;

#[test]
fn one_weight_is_a_temperature() {
    // logits 0.1 nat a step at temperature 2: 0.05 nat a step
    let weight = (0.05 * 65536.0) as i32;
    let mut evidence = [0; 3];
    add_evidence(&mut evidence, &[40, -10, 20], weight);
    let (class, confidence) = decide(&evidence);
    let exact = 1.0 / (1.0 + libm::exp(-2.5) + libm::exp(-1.0));
    assert_eq!(class, 0);
    assert!((f64::from(confidence) / exact - 1.0).abs() < 6e-3, "{confidence} {exact}");
    add_evidence(&mut evidence, &[-40, 10, 120], weight);
    assert_eq!(decide(&evidence).0, 2);
    assert_eq!(decide(&[5, 5]), (0, 0.5));
    assert_eq!(decide(&[i32::MAX, i32::MIN]), (0, 1.0));
}
