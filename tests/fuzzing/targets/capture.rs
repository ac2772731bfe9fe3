//! Any motion capture, BVH or CSV, is a motion that can be asked at every time, or refused with words.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sdp3::simulator::body::capture::Capture;
use sdp3_fuzz::files::File;

fuzz_target!(|data: &[u8]| {
    let Some((&kind, rest)) = data.split_first() else { return };
    let file = File::new(if kind % 2 == 0 { "csv" } else { "bvh" }, rest);
    match Capture::read(file.path()) {
        Ok(capture) => {
            for part in [0.0, 0.3, 1.0, 2.5] {
                let (places, velocities) = capture.at(part * capture.duration_s());
                assert!(places.iter().chain(&velocities).flatten().all(|x| x.is_finite()));
            }
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
});
