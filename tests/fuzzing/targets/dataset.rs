//! Any folder is a dataset that can be learned from or refused with words: its manifest, its request, its scenario, a part of it.
//!
//! The first byte says which file is of these bytes; the others are as they should be, and the manifest names all with their digests.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sdp3::dataset::Stored;
use sdp3_fuzz::files::Folder;
use sha2::{Digest, Sha256};

const SCENARIO: &str =
    "name = \"fuzz\"\n[frame]\nsensing_slots = [56]\n[spectrogram]\nwindow = 32\nhop = 8\n";
const REQUEST: &str = r#"{"version": "0.1.0", "scenario_sha256": "", "rho": 0.99, "seed": 1, "per_class": 2, "classes":
["adult-walking", "child-walking", "adult-pacing", "child-pacing", "standing"], "raw": false, "sigmf": false}"#;
const PART: &str = "part-00000.npz";

fn manifest(files: &[(&str, &[u8])]) -> String {
    let record = |(name, bytes): &(&str, &[u8])| {
        let sha256: String = Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect();
        serde_json::json!({ "name": name, "bytes": bytes.len(), "sha256": sha256 })
    };
    serde_json::json!({ "files": files.iter().map(record).collect::<Vec<_>>() }).to_string()
}

fuzz_target!(|data: &[u8]| {
    let Some((&kind, rest)) = data.split_first() else { return };
    let (mut request, mut scenario, mut part) = (REQUEST.as_bytes(), SCENARIO.as_bytes(), &b""[..]);
    match kind % 4 {
        0 => part = rest,
        1 => request = rest,
        2 => scenario = rest,
        _ => {}
    }
    let files = [("request.json", request), ("scenario.toml", scenario), (PART, part)];
    let own = manifest(&files);
    let manifest = if kind % 4 == 3 { rest } else { own.as_bytes() };
    let folder = Folder::new(&[files[0], files[1], files[2], ("manifest.json", manifest)]);
    let mut found = 0;
    let read = Stored::open(folder.path()).and_then(|stored| {
        let slots = stored.slots() as usize;
        stored.each(|recordings| {
            found += recordings.len() as u32;
            assert!(recordings.iter().all(|(_, beats)| beats.len() == slots));
        })?;
        Ok(stored.recordings())
    });
    match read {
        Ok(recordings) => assert_eq!(recordings, found),
        Err(error) => assert!(!error.to_string().is_empty()),
    }
});
