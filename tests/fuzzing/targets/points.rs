//! Any CSV or JSON of accuracy points is read, within its ranges, or refused with words.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sdp3::formats::points::read;
use sdp3_fuzz::files::File;

fuzz_target!(|data: &[u8]| {
    match read(File::new("csv", data).path()) {
        Ok(points) => {
            assert!(points.iter().all(|p| (0.0..=1.0).contains(&p.accuracy) && p.sensing_slots > 1.0))
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
});
