//! Tests of `dsn::pool`.

use sdp3_core::dsn::pool::*;

#[test]
fn average_rounds_halves_away_from_zero() {
    let input = [1, -1, 7, 0, 9, 9, 127, -128, 2, -2, 8, 0, 8, 9, 127, -128];
    let mut out = [0; 8];
    average(&input, 8, 0, &mut out);
    assert_eq!(out, [2, -2, 8, 0, 9, 9, 127, -128]);
    average(&input, 8, 4, &mut out[..4]);
    assert_eq!(out[..4], [9, 9, 127, -128]);
}
