//! Tests of `digest`.

use sdp3_core::digest::*;

#[test]
fn fnv_matches_its_published_vectors() {
    // draft-eastlake-fnv, 64-bit FNV-1a: "", "a", "foobar"
    assert_eq!(Digest::new().hash(), 0xcbf2_9ce4_8422_2325);
    let mut a = Digest::new();
    a.value(*b"a");
    assert_eq!(a.hash(), 0xaf63_dc4c_8601_ec8c);
    let mut foobar = Digest::new();
    foobar.value(*b"foobar");
    assert_eq!((foobar.hash(), foobar.count()), (0x8594_4171_f739_67e8, 1));
    foobar.value([0_u8; 8]);
    assert_eq!((Digest::new().count(), foobar.count()), (0, 2));
}
