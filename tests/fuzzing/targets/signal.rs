//! Any file of a measured signal is read or refused with words: WAV, NPY, NPZ, SigMF, HDF5.
//!
//! The first byte says which; of SigMF the text before the first zero byte is the description, the rest the samples.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sdp3::recordings::{Stated, read};
use sdp3_fuzz::files::File;

fuzz_target!(|data: &[u8]| {
    let Some((&kind, rest)) = data.split_first() else { return };
    let stated = Stated { carrier_hz: Some(24e9), rate_hz: Some(64.0), ..Default::default() };
    let stated = if kind & 128 == 0 { stated } else { Stated::default() };
    let file = match kind & 7 {
        0 => File::new("wav", rest),
        1 => File::new("npy", rest),
        2 => File::new("npz", rest),
        3 => {
            let end = rest.iter().position(|&byte| byte == 0).unwrap_or(rest.len());
            File::new("sigmf-data", rest.get(end + 1..).unwrap_or_default());
            File::new("sigmf-meta", &rest[..end])
        }
        _ => File::new("h5", rest),
    };
    match read(file.path(), &stated) {
        Ok(signal) => assert!(!signal.samples.is_empty() && signal.rate_hz > 0.0),
        Err(error) => assert!(!error.to_string().is_empty()),
    }
});
