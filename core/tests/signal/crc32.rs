//! Tests of `crc32`.

use sdp3_core::crc32::*;

#[test]
fn the_check_value_of_every_catalogue() {
    assert_eq!(crc32(b"123456789"), 0xcbf4_3926);
    assert_eq!(crc32(b""), 0);
}

#[test]
fn every_byte_is_divided_bit_by_bit() {
    for byte in 0..=255_u8 {
        let mut crc = u32::MAX ^ u32::from(byte);
        for _ in 0..8 {
            crc = if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 };
        }
        assert_eq!(crc32(&[byte]), !crc);
    }
}
