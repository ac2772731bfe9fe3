//! Tests of `signal::spectrogram`.

use sdp3_core::signal::logarithm::FLOOR;
use sdp3_core::signal::spectrogram::*;

#[test]
fn intensity_runs_from_the_maximum_to_the_range() {
    assert_eq!(quantize_db(100, 100, 1063), 127);
    assert_eq!(quantize_db(100 - 1062, 100, 1063), -127);
    assert_eq!(quantize_db(100 - 1063, 100, 1063), -128);
    assert_eq!(quantize_db(FLOOR, FLOOR, 1063), -128);
    assert_eq!(quantize_db(0, 0, 0), -128);
}
