//! Training as a command: a dataset teaches what its simulation would, and what cannot be learned from is refused by name.

use sdp3_tests::{SMALL, call, outcome, program};
use std::fs;
use std::path::Path;

/// Runs `sdp3 ARGUMENTS` in a folder, written `@`; exit code and stderr.
fn run(folder: &Path, arguments: &str) -> (i32, String) {
    let here = folder.to_string_lossy();
    let arguments: Vec<String> = arguments.split(' ').map(|a| a.replace('@', &here)).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let (code, _, stderr) = outcome(&call(&program(), &arguments));
    (code, stderr)
}

fn done(folder: &Path, arguments: &str) {
    let (code, stderr) = run(folder, arguments);
    assert_eq!(code, 0, "{arguments}: {stderr}");
}

/// Runs what must be refused in these words, and writes no network.
fn refused(folder: &Path, arguments: &str, words: &[&str]) {
    let (code, stderr) = run(folder, arguments);
    assert_eq!(code, 2, "{arguments}: {stderr}");
    for word in words {
        assert!(stderr.contains(word), "{arguments}: {word:?} is not in: {stderr}");
    }
    assert!(!folder.join("refused/models").exists(), "{arguments}");
}

/// A folder with the small scenario, and with others in which one line of it is another.
fn scenarios(others: &[(&str, &str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("s.toml"), SMALL).expect("a scenario");
    for (name, line, other) in others {
        let text = SMALL.replacen(line, other, 1);
        assert_ne!(text, SMALL, "{line}");
        fs::write(folder.path().join(name), text).expect("a scenario");
    }
    folder
}

#[test]
fn a_dataset_teaches_what_its_simulation_would() {
    let folder =
        scenarios(&[("one.toml", "windows = 2", "windows = 1"), ("long.toml", "[200, 300]", "[600]")]);
    let here = folder.path();
    let options = "--scenario @/one.toml --seed 3 -q";
    done(here, &format!("simulate --per-class 8 --out @/data {options}"));
    done(here, &format!("train --data @/data --out @/a {options}"));
    done(here, &format!("train --out @/b {options}"));
    // longer recordings have two windows of each N_s
    done(here, "simulate --per-class 8 --scenario @/long.toml --seed 3 -q --out @/long");
    done(here, "train --data @/long --scenario @/s.toml --seed 3 -q --out @/c");
    done(here, "train --scenario @/s.toml --seed 3 -q --out @/d");
    // what is set stands over the dataset's scenario
    let set = "--set frame.sensing_slots=[200] --set learning.epochs=1 --set learning.windows=1";
    done(here, &format!("train --data @/data {set} --seed 3 -q --out @/e"));
    let learned = |name: &str| here.join("e/models").join(name).exists();
    assert!(learned("dsn-200.json") && !learned("dsn-300.json"));
    done(here, "quantize --data @/data --out @/a --seed 3 -q");
    // later commands take the seed of the networks
    done(here, "quantize --out @/b -q");
    done(here, "early-exits --calibrate-per-class 8 --out @/b -q");
    let exits = fs::read_to_string(here.join("b/early-exits.json")).expect("early exits");
    assert!(exits.contains("\"seed\": 3,"), "{exits}");
    for name in ["dsn-200.json", "dsn-300.json", "dsn-200.sdp3", "dsn-300.sdp3"] {
        let read = |out: &str| fs::read(here.join(out).join("models").join(name)).expect("a network");
        assert!(read("a") == read("b"), "{name}");
        assert!(name.ends_with(".sdp3") || (read("c") == read("d") && read("c") != read("b")), "{name}");
    }
}

#[test]
fn datasets_that_teach_nothing_are_refused() {
    let folder = scenarios(&[
        ("far.toml", "[frame]\n", "[radar]\ncarrier_hz = 24e9\n[frame]\n"),
        ("long.toml", "[200, 300]", "[200, 400]"),
    ]);
    let here = folder.path();
    let train =
        |data: &str, scenario: &str| format!("train --data @/{data} --scenario @/{scenario} --out @/refused");
    done(here, "simulate --per-class 3 --scenario @/s.toml --out @/data -q");
    refused(
        here,
        &train("data", "far.toml"),
        &["scenario.toml", "radar.carrier_hz", "3500000000", "24000000000"],
    );
    let set = "train --data @/data --set radar.carrier_hz=24e9 --out @/refused";
    refused(here, set, &["scenario.toml", "radar.carrier_hz", "3500000000", "24000000000"]);
    refused(here, &train("data", "long.toml"), &["frame.sensing_slots", "300", "400"]);
    refused(here, &train("none", "s.toml"), &["none/manifest.json", "sdp3 simulate"]);

    let two = "simulate --per-class 3 --classes standing,adult-walking --scenario @/s.toml --out @/two -q";
    done(here, two);
    refused(
        here,
        &train("two", "s.toml"),
        &["request.json", "classes", "standing, adult-walking", "child-pacing"],
    );
    done(here, "simulate --per-class 1 --scenario @/s.toml --out @/one -q");
    refused(here, &train("one", "s.toml"), &["request.json", "per_class is 1", "2 to 2000000"]);

    let part = here.join("data/part-00000.npz");
    let mut bytes = fs::read(&part).expect("a part");
    fs::write(&part, &bytes[..bytes.len() / 2]).expect("half a part");
    refused(here, &train("data", "s.toml"), &["part-00000.npz", "SHA-256", "manifest.json"]);
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&part, &bytes).expect("a damaged part");
    refused(here, &train("data", "s.toml"), &["part-00000.npz", "SHA-256"]);
    fs::remove_file(&part).expect("removed");
    refused(here, &train("data", "s.toml"), &["part-00000.npz", "No such file"]);
}

#[test]
fn checkpoints_and_networks_of_others_are_refused_and_kept() {
    let folder = scenarios(&[
        ("wide.toml", "channels = 4", "channels = 8"),
        ("slow.toml", "epochs = 3", "epochs = 4"),
    ]);
    let here = folder.path();
    let train = |scenario: &str| format!("train --resume --scenario @/{scenario} --out @/out -q");
    done(here, &train("s.toml"));
    let checkpoint = here.join("out/models/dsn-200.checkpoint.json");
    let text = fs::read(&checkpoint).expect("a checkpoint");
    let network = fs::read(here.join("out/models/dsn-200.json")).expect("a network");
    let scenario = fs::read(here.join("out/scenario.toml")).expect("a scenario");
    let refusals: [(&str, &[&str]); 2] = [
        (
            "wide.toml",
            &["dsn-200.checkpoint.json: foreign: architecture.channels is 4, must be 8", "without --resume"],
        ),
        ("slow.toml", &["dsn-200.checkpoint.json: foreign: settings.epochs is 3, must be 4"]),
    ];
    for (other, words) in refusals {
        refused(here, &train(other), words);
        assert_eq!(fs::read(here.join("out/scenario.toml")).expect("a scenario"), scenario);
    }
    assert_eq!(fs::read(&checkpoint).expect("a checkpoint"), text);
    assert_eq!(fs::read(here.join("out/models/dsn-200.json")).expect("a network"), network);
    fs::write(&checkpoint, &text[..text.len() / 2]).expect("half a checkpoint");
    refused(here, &train("s.toml"), &["dsn-200.checkpoint.json: damaged", "line", "without --resume"]);
    let other = String::from_utf8_lossy(&text).replacen("\"loss\": ", "\"loss\": 1", 1);
    fs::write(&checkpoint, other).expect("another loss");
    refused(here, &train("s.toml"), &["dsn-200.checkpoint.json: damaged: sha256 = "]);

    let file = here.join("out/models/dsn-300.json");
    let text = fs::read_to_string(&file).expect("a network");
    fs::write(&file, &text[..text.len() / 2]).expect("half a network");
    refused(here, "quantize --out @/out", &["dsn-300.json", "line"]);
    let wider = text.replacen("\"channels\": 4", "\"channels\": 8", 1);
    assert_ne!(wider, text);
    fs::write(&file, wider).expect("a network that is not what it says");
    refused(here, "quantize --out @/out", &["dsn-300.json", "stem", "36", "72"]);
    assert!(!here.join("out/models/dsn-300.sdp3").exists());
}
