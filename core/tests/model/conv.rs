//! Tests of `dsn::conv`.

use sdp3_core::dsn::conv::*;

#[test]
fn padding_is_tflites() {
    // (n, stride) -> (out, before): 64/2 pads 0 before and 1 after; 35/2 pads 1 and 1
    assert_eq!((same(64, 2), pad_before(64, 2)), (32, 0));
    assert_eq!((same(35, 2), pad_before(35, 2)), (18, 1));
    assert_eq!((same(10, 1), pad_before(10, 1)), (10, 1));
}
