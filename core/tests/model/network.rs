//! Tests of `dsn::network`.

use sdp3_core::dsn::network::*;

#[test]
fn the_scratch_is_three_maps_or_one_and_the_image_and_a_row() {
    assert_eq!(scratch_bytes(110, 16, 2), 3 * (16 * 27 * 16) + 27 * 16);
    assert_eq!(scratch_bytes(10, 8, 1), 3 * (32 * 5 * 8) + 5 * 8);
    assert_eq!(scratch_bytes(9, 8, 2), 16 * 2 * 8 + 64 * 9 + 2 * 8);
}
