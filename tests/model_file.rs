//! Model files written by the host and read by the core: damage of every kind is refused, by file name and reason.

use sdp3_core::dsn::{Model, ModelError};
use sdp3_testkit::models::{DSN_200, DSN_200_SIGNED};
use sdp3_tests::{call, outcome, program, small_run};

fn model() -> Vec<u8> {
    let (folder, _, code, stderr) = small_run();
    assert_eq!(*code, 0, "{stderr}");
    std::fs::read(folder.path().join("out/models/dsn-200.sdp3")).expect("a model")
}

#[test]
fn the_core_reads_what_the_host_wrote() {
    let bytes = model();
    let model = Model::parse(&bytes).expect("a model");
    assert_eq!((model.sensing_slots(), model.frames(), model.channels(), model.blocks()), (200, 10, 4, 2));
    assert_eq!((model.classes(), model.class_name(3)), (5, "adult-walking"));
    assert_eq!((model.carrier_khz(), model.interval_us()), (3_500_000, 1000));
}

#[test]
fn every_truncation_and_every_flipped_bit_is_refused_with_the_right_error() {
    for (name, bytes) in [("unsigned", DSN_200), ("signed", DSN_200_SIGNED)] {
        Model::parse(bytes).expect("a model");
        for length in 0..bytes.len() {
            let error = Model::parse(&bytes[..length]).expect_err("refused");
            let right = match length {
                0..68 => error == ModelError::Truncated { need: 68, have: length },
                _ => error == ModelError::Length { stated: bytes.len(), have: length },
            };
            assert!(right, "{name}, {length} bytes: {error}");
        }
        let mut damaged = bytes.to_vec();
        for at in 0..bytes.len() {
            for bit in 0..8 {
                damaged[at] ^= 1 << bit;
                let error = Model::parse(&damaged).expect_err("refused");
                let right = match at {
                    0..4 => error == ModelError::Magic,
                    4..6 => matches!(error, ModelError::Version { .. }),
                    6..8 => matches!(error, ModelError::Field { name: "header_len", .. }),
                    8..12 => matches!(error, ModelError::Length { have, .. } if have == bytes.len()),
                    _ => matches!(error, ModelError::Checksum { .. }),
                };
                assert!(right, "{name}, byte {at} bit {bit}: {error}");
                damaged[at] ^= 1 << bit;
            }
        }
    }
}

#[test]
fn a_truncated_model_file_stops_verify_with_its_name() {
    let (folder, ..) = small_run();
    let copy = tempfile::tempdir().expect("a folder");
    std::fs::create_dir_all(copy.path().join("models")).expect("a folder");
    for name in ["run.json", "scenario.toml", "models/dsn-200.sdp3", "models/dsn-300.sdp3"] {
        std::fs::copy(folder.path().join("out").join(name), copy.path().join(name)).expect("a copy");
    }
    let path = copy.path().join("models/dsn-300.sdp3");
    let bytes = std::fs::read(&path).expect("a model");
    std::fs::write(&path, &bytes[..bytes.len() / 2]).expect("half a model");
    let out = copy.path().to_string_lossy().into_owned();
    let (code, _, stderr) =
        outcome(&call(&program(), &["verify", "--targets", "host-reference", "--out", &out]));
    assert_eq!(code, 2, "{stderr}");
    assert!(stderr.contains("dsn-300.sdp3") && stderr.contains("truncated"), "{stderr}");
}
