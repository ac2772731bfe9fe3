//! The requantiser against its definition in i128.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sdp3_core::fixed::requantize;
use sdp3_fuzz::Bytes;

fuzz_target!(|data: &[u8]| {
    let mut bytes = Bytes(data);
    let (accumulator, word, shift) = (bytes.u32() as i32, bytes.u32(), 7 - (bytes.u8() % 39) as i8);
    let multiplier = if word == 0 { 0 } else { (1 << 30) | (word >> 2) as i32 };
    let (left, right) = (u32::from(shift.max(0).unsigned_abs()), u32::from(shift.min(0).unsigned_abs()));
    let wrapped = (i128::from(accumulator) << left) as i32;
    let high = (i128::from(wrapped) * i128::from(multiplier) + (1 << 30)).div_euclid(1 << 31);
    let magnitude = (2 * high.abs() + (1 << right)).div_euclid(2 << right);
    let expected = if high < 0 { -magnitude } else { magnitude };
    assert_eq!(i128::from(requantize(accumulator, multiplier, shift)), expected);
});
