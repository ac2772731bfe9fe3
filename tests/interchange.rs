//! Networks of and for other programs: LiteRT's own answers, files nobody here wrote, damaged bytes, the commands.
//!
//! The vectors and the Python program that made them lie in `tests/oracles`; `tests/oracle tflite` compares far more.

use sdp3::formats::model_file::{Preprocessing, QuantizedNetwork};
use sdp3::formats::tflite::{ImportDefaults, export, import};
use sdp3::network::interchange::header;
use sdp3::network::parameters::Architecture;
use sdp3::network::safetensors;
use sdp3_core::dsn::Model;
use sdp3_tests::networks::{Random, images, layers, parameters, quantized};
use sdp3_tests::vectors::{bytes, list, signed};
use sdp3_tests::{call, outcome, program};
use serde_json::Value;
use std::path::Path;

/// The preprocessing of the networks that say nothing of their own.
fn import_defaults() -> ImportDefaults {
    let preprocessing =
        Preprocessing { window_len: 32, hop: 4, kaiser_beta: 10.0, ..header(&sdp3_tests::printed_room(), 0) };
    ImportDefaults { preprocessing, sensing_slots: vec![200], classes: Vec::new() }
}

fn golden() -> Vec<Value> {
    let vectors: Value = serde_json::from_str(include_str!("oracles/tflite.json")).expect("JSON");
    list(&vectors["networks"]).clone()
}

#[test]
fn every_layer_of_an_imported_file_has_litert_s_bits() {
    let mut compared = 0;
    for network in golden() {
        let file = bytes(&network["file"]);
        let imported = import(&file, &import_defaults()).expect("a network");
        let found = layers(&imported.to_bytes().expect("a model file"), &signed(&network["image"]));
        let expected = list(&network["tensors"]);
        assert_eq!(found.len(), expected.len());
        for (found, expected) in found.iter().zip(expected) {
            let values = signed(&expected["values"]);
            assert_eq!(found, &values, "{} {}", network["name"], expected["layer"]);
            compared += values.len();
        }
        if network["exported"] == true {
            assert!(export(&imported).expect("a file") == file, "{}", network["name"]);
        }
    }
    assert_eq!(compared, 38_029);
}

#[test]
fn a_file_of_flatbuffers_own_library_is_the_same_network() {
    let made: Value = serde_json::from_str(include_str!("oracles/network.json")).expect("JSON");
    let mut found = 0;
    for network in golden() {
        let Some(reference) = list(&made["networks"]).iter().find(|n| n["name"] == network["name"]) else {
            continue;
        };
        let imported = import(&bytes(&network["file"]), &import_defaults()).expect("a network");
        let reference = QuantizedNetwork::from_bytes(&bytes(&reference["model"])).expect("a model file");
        assert_eq!(imported, reference);
        // and back: another file, the same network
        let exported = export(&imported).expect("a file");
        assert_eq!(import(&exported, &import_defaults()).expect("a network"), imported);
        found += 1;
    }
    assert_eq!(found, 2);
}

#[test]
fn networks_of_every_size_come_back() {
    let mut seed = 100;
    for channels in [4, 8, 16, 32] {
        for (blocks, stem_stride, classes, frames) in [(1, 1, 2, 2), (3, 2, 5, 25), (8, 1, 16, 9)] {
            let architecture = Architecture { channels, blocks, stem_stride, classes };
            let network = quantized(architecture, frames, seed);
            let file = export(&network).expect("a file");
            assert_eq!(import(&file, &import_defaults()).expect("a network"), network);
            seed += 1;
        }
    }
}

/// Changes some bytes: any value anywhere, a special word at an aligned place, a piece moved, the end cut.
fn mutate(file: &[u8], random: &mut Random) -> Vec<u8> {
    let mut file = file.to_vec();
    for _ in 0..1 + random.below(4) {
        let at = random.below(file.len().max(4) - 3);
        let aligned = at / 4 * 4;
        let special = [
            0,
            1,
            u32::MAX,
            1 << 31,
            (1 << 31) - 1,
            file.len() as u32,
            1 << 16,
            (aligned as u32).wrapping_neg(),
        ];
        match random.below(6) {
            0 | 1 => file[at] = random.bits() as u8,
            2 => file[at] ^= 1 << random.below(8),
            3 => file[aligned..aligned + 4].copy_from_slice(&special[random.below(8)].to_le_bytes()),
            4 => {
                let from = random.below(file.len() - 3) / 4 * 4;
                file.copy_within(from..from + 4, aligned);
            }
            _ if random.below(8) == 0 => file.truncate(8 + at.min(file.len() - 8)),
            _ => (),
        }
    }
    file
}

#[test]
fn no_mutation_of_a_file_breaks_the_importer() {
    let mut random = Random::new(1);
    let (mut refused, mut taken) = (0, 0);
    for network in golden() {
        let file = bytes(&network["file"]);
        for _ in 0..20_000 {
            match import(&mutate(&file, &mut random), &import_defaults()) {
                Err(error) => {
                    assert!(!error.to_string().is_empty());
                    refused += 1;
                }
                // what is taken is a model the radar module runs
                Ok(network) => {
                    Model::parse(&network.to_bytes().expect("a model file")).expect("a model");
                    taken += 1;
                }
            }
        }
    }
    assert!(refused > 10_000 && taken > 10_000, "{refused} refused, {taken} taken");
}

#[test]
fn no_mutation_of_float_parameters_breaks_the_importer() {
    let architecture = Architecture { channels: 4, blocks: 1, stem_stride: 1, classes: 3 };
    let file = safetensors::write(&parameters(architecture, 5)).expect("a file");
    let mut random = Random::new(2);
    for _ in 0..20_000 {
        let _ = safetensors::read(&mutate(&file, &mut random), 1);
    }
    for length in 0..file.len() {
        assert!(safetensors::read(&file[..length], 1).is_err(), "{length}");
    }
}

/// Runs the command in a folder; exit code, stdout and stderr.
fn run(folder: &Path, arguments: &str) -> (i32, String, String) {
    let here = folder.to_string_lossy();
    let arguments: Vec<String> = arguments.split(' ').map(|a| a.replace('@', &here)).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    outcome(&call(&program(), &arguments))
}

/// Runs a command that must be refused in these words.
fn refused(folder: &Path, arguments: &str, words: &[&str]) {
    let (code, stdout, stderr) = run(folder, arguments);
    assert_eq!(code, 2, "{arguments}: {stdout}{stderr}");
    for word in words {
        assert!(stderr.contains(word), "{arguments}: {word:?} is not in: {stderr}");
    }
}

#[test]
fn the_commands_exchange_int8_networks() {
    let folder = tempfile::tempdir().expect("a folder");
    let here = folder.path();
    let architecture = Architecture { channels: 8, blocks: 2, stem_stride: 2, classes: 5 };
    let model = quantized(architecture, 10, 3).to_bytes().expect("a model file");
    std::fs::write(here.join("a.sdp3"), &model).expect("a file");
    let (code, stdout, stderr) = run(here, "export @/a.sdp3 --to @/sub/a.tflite --json");
    assert_eq!(code, 0, "{stderr}");
    let done: Value = serde_json::from_str(&stdout).expect("JSON");
    let file = std::fs::read(here.join("sub/a.tflite")).expect("the file");
    assert_eq!(done["bytes"], file.len());
    let (code, _, stderr) = run(here, "import @/sub/a.tflite --to @/b.sdp3");
    assert_eq!(code, 0, "{stderr}");
    assert!(std::fs::read(here.join("b.sdp3")).expect("the file") == model);

    std::fs::write(here.join("half.tflite"), &file[..file.len() / 2]).expect("a file");
    let image = images(10, 1, 5, 1);
    std::fs::write(here.join("image.tflite"), image.pixels.iter().map(|&p| p as u8).collect::<Vec<u8>>())
        .expect("a file");
    for (arguments, words) in [
        ("import @/half.tflite --to @/c.sdp3", ["half.tflite", "truncated or damaged"]),
        ("import @/image.tflite --to @/c.sdp3", ["image.tflite", "file identifier is"]),
        ("import @/none.tflite --to @/c.sdp3", ["none.tflite", "No such file"]),
        ("import @/sub/a.tflite --to @/c.sdp3 --slots 300", ["--slots is 300, must be 200", "a.tflite"]),
        ("import @/sub/a.tflite --to @/c.json", [".tflite to .json", "MODEL.sdp3"]),
        ("export @/sub/a.tflite --to @/c.sdp3", [".tflite to .sdp3", "FILE.tflite"]),
        ("export @/half.tflite.sdp3 --to @/c.tflite", ["half.tflite.sdp3", "No such file"]),
    ] {
        refused(here, arguments, &words);
        assert!(!here.join("c.sdp3").exists() && !here.join("c.tflite").exists());
    }
}

#[test]
fn the_commands_quantise_a_float_network() {
    let folder = tempfile::tempdir().expect("a folder");
    let here = folder.path();
    let architecture = Architecture { channels: 4, blocks: 2, stem_stride: 2, classes: 5 };
    let network = parameters(architecture, 7);
    std::fs::write(here.join("a.json"), serde_json::to_vec(&network).expect("JSON")).expect("a file");
    let (code, _, stderr) = run(here, "export @/a.json --to @/a.safetensors");
    assert_eq!(code, 0, "{stderr}");
    let (code, _, stderr) = run(here, "import @/a.safetensors --to @/b.json");
    assert_eq!(code, 0, "{stderr}");
    let read = |name: &str| std::fs::read(here.join(name)).expect("the file");
    assert!(read("a.json") == read("b.json"));
    let (code, stdout, stderr) = run(here, "import @/a.safetensors --to @/a.sdp3 --slots 200 --json -q");
    assert_eq!(code, 0, "{stderr}");
    let done: Value = serde_json::from_str(&stdout).expect("JSON");
    let report = list(&done["quantization"]["layers"]);
    assert_eq!(report.len(), 2 + 4 * 2 + 2);
    assert!(report.iter().all(|l| l["sqnr_db"].as_f64().expect("a number") > 10.0), "{stdout}");
    assert!(
        report.iter().all(|l| (0.0..0.1).contains(&l["clipped"].as_f64().expect("a number"))),
        "{stdout}"
    );
    let model = std::fs::read(here.join("a.sdp3")).expect("the file");
    let model = Model::parse(&model).expect("a model");
    assert_eq!((model.frames(), model.class_name(3)), (10, "adult-walking"));

    let mut corrupted = network.clone();
    corrupted.blocks[1].conv1[7] = f32::NAN;
    std::fs::write(here.join("nan.safetensors"), safetensors::write(&corrupted).expect("a file"))
        .expect("a file");
    let three = parameters(Architecture { classes: 3, ..architecture }, 7);
    std::fs::write(here.join("three.safetensors"), safetensors::write(&three).expect("a file"))
        .expect("a file");
    std::fs::write(here.join("no.safetensors"), b"no").expect("a file");
    for (arguments, words) in [
        (
            "import @/nan.safetensors --to @/c.sdp3 --slots 200",
            ["blocks.1.conv1.weight, value 7 is NaN", "finite"],
        ),
        (
            "import @/three.safetensors --to @/c.sdp3 --slots 200",
            ["three.safetensors", "classes is 3, must be 5"],
        ),
        (
            "import @/no.safetensors --to @/c.sdp3 --slots 200",
            ["no.safetensors", "not a readable safetensors"],
        ),
        ("import @/a.safetensors --to @/c.sdp3", ["a.safetensors", "--slots"]),
        ("import @/a.safetensors --to @/c.sdp3 --slots 65000", ["frame.sensing_slots", "65000"]),
    ] {
        refused(here, arguments, &words);
        assert!(!here.join("c.sdp3").exists());
    }
}
