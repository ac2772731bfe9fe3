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

#[test]
fn a_level_above_the_maximum_is_the_maximum() {
    for (level, largest) in [(100, 0), (1, 0), (i16::MAX, FLOOR + 1)] {
        assert_eq!(quantize_db(level, largest, 1), 127, "{level} above {largest}");
        assert_eq!(quantize_db(level, largest, 4095), 127);
        assert_eq!(quantize_db(level, largest, 0), -128);
    }
    assert_eq!(quantize_db(0, FLOOR, 1063), -128, "nothing has power");
    assert_eq!(quantize_db(FLOOR + 1, i16::MAX, 4095), -128);
}

#[test]
#[cfg_attr(miri, ignore)] // eight million of them
fn intensities_are_those_of_a_division() {
    for range in 1..=4095_u16 {
        for below in 0..range {
            let expected = 127 - i32::from(below) * 255 / i32::from(range);
            assert_eq!(i32::from(quantize_db(-(below as i16), 0, range)), expected, "{below} of {range}");
        }
    }
}
