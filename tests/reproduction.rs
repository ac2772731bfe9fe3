//! The paper's items: what the command writes, that it goes on and can be cut in shards; and the page of the committed results.

use sdp3::reproduce::page::{page, read};
use sdp3_tests::{SMALL, call, outcome, program};
use std::path::{Path, PathBuf};

/// Items that this takes seconds for.
const ITEMS: [&str; 5] = ["spectrograms", "training", "learning-curve", "learning-curve-models", "region"];

fn reproduce(folder: &Path, out: &str, options: &[&str]) -> (i32, String, String) {
    let scenario = folder.join("s.toml");
    let small = SMALL.replace("[200, 300]", "[200, 300, 400, 600]");
    std::fs::write(&scenario, small).expect("a scenario");
    let (scenario, out) = (scenario.to_string_lossy(), folder.join(out));
    let out = out.to_string_lossy();
    let mut arguments = vec!["reproduce", "--scenario", &scenario, "--out", &out, "--json", "-q"];
    arguments.extend(options);
    outcome(&call(&program(), &arguments))
}

#[test]
fn items_are_kept_and_shards_give_the_same() {
    let folder = tempfile::tempdir().expect("a folder");
    let (code, first, stderr) = reproduce(folder.path(), "whole", &ITEMS);
    assert_eq!(code, 0, "{stderr}");
    let found: serde_json::Value = serde_json::from_str(&first).expect("JSON alone on stdout");
    for (item, name) in found.as_array().expect("a list").iter().zip(ITEMS) {
        assert_eq!((&item["item"], &item["size"]), (&name.into(), &"quick".into()));
        assert_eq!((&item["seed_set"], &item["seeds"][0]), (&"development".into(), &101.into()));
        for side in ["verdict", "verdict_as_printed"] {
            let verdict = item[side].as_str().expect("a verdict");
            assert!(
                ["reproduced", "order-only", "not-reproduced", "not-testable"].contains(&verdict),
                "{verdict}"
            );
        }
        let made = folder.path().join("whole").join(format!("{name}.json"));
        assert!(made.is_file(), "{}", made.display());
        for figure in item["figures"].as_array().expect("figures") {
            for form in ["svg", "pdf", "png"] {
                let file = made.with_file_name(format!("{}.{form}", figure.as_str().expect("a name")));
                assert!(file.is_file(), "{}", file.display());
            }
        }
    }
    // the whole page needs every item
    assert!(!folder.path().join("whole/reproduction.md").exists());
    let cell = folder.path().join("whole/cells/networks-here-3.5-101.json");
    let time = std::fs::metadata(&cell).and_then(|m| m.modified()).expect("a time");
    let (code, second, stderr) = reproduce(folder.path(), "whole", &ITEMS);
    assert_eq!((code, &second), (0, &first), "{stderr}");
    assert_eq!(std::fs::metadata(&cell).and_then(|m| m.modified()).expect("a time"), time, "made twice");
    for shard in ["2/2", "1/2"] {
        let (code, none, stderr) =
            reproduce(folder.path(), "parts", &[&ITEMS[..], &["--shard", shard, "--threads", "1"]].concat());
        assert_eq!((code, none.trim()), (0, "[]"), "{stderr}");
    }
    let (code, parts, stderr) = reproduce(folder.path(), "parts", &ITEMS);
    assert_eq!((code, &parts), (0, &first), "{stderr}");
}

#[test]
fn seeds_of_several_sets_and_folders_of_other_sizes_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    for (seed, seeds, word) in [("5", "1", "--seed is 5 to 5"), ("1000", "2", "--seed is 1000 to 1001")] {
        let (code, _, stderr) =
            reproduce(folder.path(), "refused", &["region", "--seed", seed, "--seeds", seeds]);
        assert_eq!(code, 2, "{stderr}");
        for word in [word, "seeds of one set: 101 to 1000 (development), or from 1001 on (final)"] {
            assert!(stderr.contains(word), "{word:?} is not in: {stderr}");
        }
    }
    let (code, _, stderr) = reproduce(folder.path(), "one", &["spectrograms"]);
    assert_eq!(code, 0, "{stderr}");
    let (code, _, stderr) = reproduce(folder.path(), "one", &["spectrograms", "--size", "paper"]);
    assert_eq!(code, 2, "{stderr}");
    assert!(stderr.contains("study.json") && stderr.contains("use another --out"), "{stderr}");
}

#[test]
fn the_committed_results_are_those_of_the_cells_of_the_final_test() {
    let committed = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/reproduction");
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::create_dir(folder.path().join("cells")).expect("a folder");
    for part in ["", "cells"] {
        for file in std::fs::read_dir(committed.join("final").join(part)).expect("cells") {
            let file = file.expect("a cell").path();
            if file.is_file() {
                let to = folder.path().join(part).join(file.file_name().expect("a name"));
                std::fs::copy(&file, to).expect("a copy");
            }
        }
    }
    let scenario = committed.join("final/scenario.toml");
    let (scenario, out) = (scenario.to_string_lossy(), folder.path().to_string_lossy());
    let options =
        ["--size", "paper", "--seed", "1001", "--seeds", "5", "--scenario", &scenario, "--out", &out];
    // the divergences of measured recordings need these: docs/protocol.md has the whole command
    let items = ["channel-models", "intensities", "accuracy-over-epochs"];
    let arguments = [&["reproduce", "--json", "-q"], &items[..], &ITEMS, &options].concat();
    let (code, found, stderr) = outcome(&call(&program(), &arguments));
    assert_eq!(code, 0, "{stderr}");
    let found: serde_json::Value = serde_json::from_str(&found).expect("JSON alone on stdout");
    let found = found.as_array().expect("a list");
    assert_eq!(found.len(), items.len() + ITEMS.len());
    for item in found {
        let file = committed.join(format!("{}.json", item["item"].as_str().expect("a name")));
        let text = std::fs::read_to_string(&file).expect("a result");
        let mut kept: serde_json::Value = serde_json::from_str(&text).expect("a result");
        kept.as_object_mut().expect("an object").remove("provenance");
        assert_eq!(*item, kept, "{}", file.display());
    }
    // nothing was trained
    let cells = |folder: &Path| std::fs::read_dir(folder.join("cells")).expect("cells").count();
    assert_eq!(cells(folder.path()), cells(&committed.join("final")));
}

#[test]
fn the_committed_page_is_that_of_the_committed_results() {
    let docs: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs");
    let results = read(&docs.join("reproduction")).expect("results");
    let written = page(&results, "reproduction");
    let file = docs.join("reproduction.md");
    if std::env::var_os("SDP3_WRITE_PAGES").is_some() {
        std::fs::write(&file, &written).expect("the page");
    }
    let committed = std::fs::read_to_string(&file).expect("the page");
    assert_eq!(committed, written, "docs/reproduction.md: SDP3_WRITE_PAGES=1 writes it");
    for result in &results {
        for figure in &result.figures {
            let figure = docs.join(format!("reproduction/{figure}.svg"));
            assert!(figure.is_file(), "{}", figure.display());
        }
    }
}
