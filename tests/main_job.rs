//! The main job's properties: one JSON object, no mismatch on any target, the same bytes for any thread count, and a flipped
//! bit of a core constant that is found.

use sdp3::results::{Run, Verify};
use sdp3_tests::{SMALL, call, outcome, program, small_run};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

#[test]
fn every_target_agrees_and_the_json_has_its_fields() {
    let (folder, stdout, code, stderr) = small_run();
    assert_eq!(*code, 0, "{stderr}");
    let run: Run = serde_json::from_str(stdout).expect("one JSON object");
    assert_eq!((run.scenario.as_str(), run.seed), ("small", 3));
    assert_eq!(run.verify.mismatches, 0);
    let names: Vec<&str> = run.verify.targets.iter().map(|t| t.name.as_str()).collect();
    assert_eq!(names, ["host-reference", "cortex-m4f", "riscv32imac"]);
    for target in &run.verify.targets {
        assert!(target.compared > 50, "{}", target.name);
        let stages: Vec<&str> = target.stages.iter().map(|s| s.stage.as_str()).collect();
        let expected = [
            "beat",
            "gram",
            "projection",
            "slow-time",
            "frame",
            "image",
            "layer",
            "logits",
            "class",
            "confidence",
            "schedule",
        ];
        // the reference judges frames of either arithmetic by a bound of its own
        let also: &[&str] = if target.name == "host-reference" { &["frame in integers"] } else { &[] };
        let sorted = |mut names: Vec<&str>| -> Vec<String> {
            names.sort_unstable();
            names.into_iter().map(str::to_owned).collect()
        };
        assert_eq!(sorted(stages), sorted([&expected[..], also].concat()), "{}", target.name);
    }
    assert!(run.verify.targets[1].instructions.is_some_and(|n| n > 1_000_000));
    assert_eq!(run.accuracy.len(), 2);
    assert!(run.region.iter().any(|p| p.case == 1) && run.region.iter().any(|p| p.case == 2));
    let slots = run.schedule.sensing_slots + run.schedule.communication_slots.iter().sum::<u32>();
    assert_eq!(slots, 4000);
    let page = std::fs::read_to_string(folder.path().join("out/report.html")).expect("a page");
    assert!(page.contains("riscv32imac") && !page.contains("NaN"));
    assert!(!page.replace("http://www.w3.org/2000/svg", "").contains("://"), "the page is self-contained");
}

/// What goes on from a run is of the run's scenario and seed, 3, though neither is stated again.
#[test]
fn later_commands_go_on_in_the_runs_scenario_with_its_seed() {
    let (run, _, code, stderr) = small_run();
    assert_eq!(*code, 0, "{stderr}");
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    for (name, bytes) in files(&run.path().join("out")) {
        let file = out.join(name);
        std::fs::create_dir_all(file.parent().expect("a folder")).expect("a folder");
        std::fs::write(file, bytes).expect("a file");
    }
    let commands: [(&[&str], &str, Option<&str>); 5] = [
        (&["predict"], "predict.json", None),
        (&["optimize"], "optimize.json", Some("optimize")),
        (&["schedule"], "schedule.json", None),
        (&["schedule", "--periods", "2"], "campaign.json", Some("schedule")),
        (&["early-exits", "--calibrate-per-class", "4"], "early-exits.json", Some("early-exits")),
    ];
    for (words, result, scenario) in commands {
        let mut command = Command::new(program());
        command.args(words).args(["-q", "--out"]).arg(&out);
        let (code, _, stderr) = outcome(&command.output().expect("it starts"));
        assert_eq!(code, 0, "{words:?}: {stderr}");
        let text = std::fs::read_to_string(out.join(result)).expect("a result");
        let found: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        assert_eq!(found["provenance"]["seed"], 3, "{words:?}");
        if let Some(name) = scenario {
            let text =
                std::fs::read_to_string(out.join(format!("{name}-scenario.toml"))).expect("a scenario");
            assert!(text.contains("name = \"small\""), "{words:?}: {text}");
        }
    }
    // a run that began in the same folder and did not end has written its scenario
    let scenario = out.join("scenario.toml");
    let text = std::fs::read_to_string(&scenario).expect("a scenario");
    std::fs::write(&scenario, text.replace("name = \"small\"", "name = \"other\"")).expect("a scenario");
    for words in [&["predict"][..], &["optimize"], &["schedule"], &["verify"], &["report"]] {
        let mut command = Command::new(program());
        command.args(words).args(["-q", "--out"]).arg(&out);
        let (code, _, stderr) = outcome(&command.output().expect("it starts"));
        assert_eq!(code, 2, "{words:?}: {stderr}");
        assert!(stderr.contains("another scenario than run.json is of"), "{words:?}: {stderr}");
    }
}

/// Every file below a folder, by its path from there, with its bytes.
fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in std::fs::read_dir(folder).expect("a folder").flatten() {
        let (path, name) = (entry.path(), PathBuf::from(entry.file_name()));
        if path.is_dir() {
            found.extend(files(&path).into_iter().map(|(below, bytes)| (name.join(below), bytes)));
        } else {
            found.insert(name, std::fs::read(&path).expect("a file"));
        }
    }
    found
}

#[test]
fn one_seed_gives_one_result_for_any_number_of_threads() {
    let folder = tempfile::tempdir().expect("a folder");
    let scenario = folder.path().join("small.toml");
    std::fs::write(&scenario, SMALL).expect("a scenario");
    let run = |out: &str, threads: &str, seed: &str| {
        let out = folder.path().join(out);
        let text = out.to_string_lossy().into_owned();
        let scenario = scenario.to_string_lossy().into_owned();
        let arguments = [
            "run",
            "-q",
            "--targets",
            "host-reference",
            "--seed",
            seed,
            "--threads",
            threads,
            "--scenario",
            &scenario,
            "--out",
            &text,
        ];
        let (code, _, stderr) = outcome(&call(&program(), &arguments));
        assert_eq!(code, 0, "{stderr}");
        files(&out)
    };
    let (one, two, other) = (run("one", "1", "5"), run("two", "2", "5"), run("other", "2", "6"));
    assert!(one.len() >= 8, "{:?}", one.keys());
    // a checkpoint holds the optimiser's state in the order of a hash map
    let whole = |name: &Path| !name.to_string_lossy().ends_with(".checkpoint.json");
    for (name, bytes) in one.iter().filter(|(name, _)| whole(name)) {
        assert!(two.get(name) == Some(bytes), "{} differs between 1 and 2 threads", name.display());
    }
    assert_eq!(one.len(), two.len());
    assert_ne!(one.get(Path::new("run.json")), other.get(Path::new("run.json")), "the seed matters");
}

/// A copy of a file with one bit of the chirp table flipped, wherever the table stands in it: of its first 250 samples, from which RV32
/// makes the others.
fn flip_a_bit(from: &Path, to: &Path) {
    let table: Vec<u8> =
        sdp3_core::signal::dechirp::CHIRP.iter().flatten().flat_map(|part| part.to_le_bytes()).collect();
    let mut bytes = std::fs::read(from).expect("a program");
    let places: Vec<usize> = (0..bytes.len() - table.len())
        .filter(|&at| bytes[at] == table[0] && bytes[at..].starts_with(&table))
        .collect();
    assert!(!places.is_empty(), "{}: the chirp table is in it", from.display());
    for at in places {
        bytes[at + 234] ^= 1 << 3;
    }
    std::fs::write(to, bytes).expect("a copy");
    let mode = std::fs::metadata(from).expect("its mode").permissions();
    std::fs::set_permissions(to, mode).expect("an executable copy");
}

fn verify(program: &Path, arguments: &[&str]) -> (i32, Verify) {
    let (folder, ..) = small_run();
    let out = folder.path().join("out");
    let mut all = vec!["verify", "--json", "--out", out.to_str().expect("a path")];
    all.extend(arguments);
    let (code, stdout, stderr) = outcome(&call(program, &all));
    (code, serde_json::from_str(&stdout).unwrap_or_else(|e| panic!("{e}: {stderr}")))
}

#[test]
fn one_flipped_bit_in_the_host_core_is_found() {
    let folder = tempfile::tempdir().expect("a folder");
    let broken = folder.path().join("sdp3");
    flip_a_bit(&program(), &broken);
    let (code, verdict) = verify(&broken, &["--targets", "host-reference"]);
    assert_eq!(code, 1);
    assert!(verdict.mismatches > 0);
    let detail = verdict.targets[0].detail.clone().expect("the first difference");
    assert!(detail.contains("stage beat"), "{detail}");
    let (code, verdict) = verify(&program(), &["--targets", "host-reference"]);
    assert_eq!((code, verdict.mismatches), (0, 0));
}

#[test]
fn one_flipped_bit_in_the_firmware_is_found() {
    let folder = tempfile::tempdir().expect("a folder");
    let built = program().ancestors().nth(2).expect("target").join("firmware");
    for machine in ["cortex-m4f", "riscv32imac"] {
        std::fs::create_dir_all(folder.path().join(machine)).expect("a folder");
        std::fs::copy(built.join(machine).join("emulator"), folder.path().join(machine).join("emulator"))
            .expect("the emulator's command");
        flip_a_bit(
            &built.join(machine).join("conformance"),
            &folder.path().join(machine).join("conformance"),
        );
    }
    let text = folder.path().to_string_lossy().into_owned();
    let (code, verdict) = verify(&program(), &["--targets", "cortex-m4f,riscv32imac", "--firmware", &text]);
    assert_eq!(code, 1);
    for target in &verdict.targets {
        assert!(target.compared > 50 && target.mismatches > 0, "{target:?}");
        let detail = target.detail.as_deref().unwrap_or_default();
        let located = ["stage beat", "slot 0, index", "expected", "found"].iter().all(|w| detail.contains(w));
        assert!(located, "{detail}");
    }
}

#[test]
fn a_target_that_cannot_run_counts_as_failed() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = folder.path().to_string_lossy().into_owned();
    let (code, verdict) = verify(&program(), &["--targets", "cortex-m4f", "--firmware", &text]);
    assert_eq!((code, verdict.mismatches), (1, 1));
    assert!(verdict.targets[0].detail.as_deref().unwrap_or("").contains("not run"), "{verdict:?}");
}
