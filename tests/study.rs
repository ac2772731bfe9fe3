//! Studies: what they write, that they go on where they were, and that a folder belongs to one of them.

use sdp3_tests::{SMALL, call, outcome, program};
use serde_json::Value;
use std::path::Path;

fn study(folder: &Path, name: &str, options: &[&str]) -> (i32, String, String) {
    let scenario = folder.join("s.toml");
    std::fs::write(&scenario, SMALL).expect("a scenario");
    let (scenario, out) = (scenario.to_string_lossy(), folder.join("out"));
    let out = out.to_string_lossy();
    let mut arguments = vec!["study", name, "--scenario", &scenario, "--out", &out, "--json", "-q"];
    arguments.extend(options);
    outcome(&call(&program(), &arguments))
}

#[test]
fn a_learning_curve_is_kept_cell_by_cell() {
    let folder = tempfile::tempdir().expect("a folder");
    let (code, first, stderr) = study(folder.path(), "learning-curve", &["--seeds", "2", "--threads", "1"]);
    assert_eq!(code, 0, "{stderr}");
    let found: Value = serde_json::from_str(&first).expect("JSON alone on stdout");
    let rows = found["rows"].as_array().expect("rows");
    assert_eq!(rows.len(), 2);
    for row in rows {
        let each = row["each"].as_array().expect("seeds");
        assert_eq!(each.len(), 2);
        let mean = each.iter().filter_map(Value::as_f64).sum::<f64>() / 2.0;
        assert!((row["int8"]["mean"].as_f64().expect("a mean") - mean).abs() < 1e-12);
        assert_eq!(row["tested"], 20);
    }
    let out = folder.path().join("out");
    for name in
        ["study.json", "scenario.toml", "learning-curve.json", "learning-curve.md", "learning-curve.svg"]
    {
        assert!(out.join(name).is_file(), "{name} is missing");
    }
    // one cell lost: made again, with other threads, the same
    let cell = out.join("cells/seed-2.json");
    let before = std::fs::read(&cell).expect("a cell");
    std::fs::remove_file(&cell).expect("removed");
    let kept = out.join("cells/seed-1.json");
    let time = std::fs::metadata(&kept).and_then(|m| m.modified()).expect("a time");
    let (code, second, stderr) = study(folder.path(), "learning-curve", &["--seeds", "2", "--threads", "2"]);
    assert_eq!((code, &second), (0, &first), "{stderr}");
    assert_eq!(std::fs::read(&cell).expect("a cell"), before);
    assert_eq!(std::fs::metadata(&kept).and_then(|m| m.modified()).expect("a time"), time, "made twice");
    // a damaged cell is refused by name and kept
    let text = String::from_utf8(before).expect("JSON");
    std::fs::write(&cell, text.replacen("\"tested\": ", "\"tested\": 1", 1)).expect("damage");
    let (code, _, stderr) = study(folder.path(), "learning-curve", &["--seeds", "2"]);
    assert_eq!(code, 2, "{stderr}");
    for word in ["cells/seed-2.json: damaged: sha256 = ", "remove it to have it made again"] {
        assert!(stderr.contains(word), "{word:?} is not in: {stderr}");
    }
    // another study does not touch the folder
    let (code, _, stderr) = study(folder.path(), "learning-curve", &["--seeds", "2", "--seed", "9"]);
    assert_eq!(code, 2, "{stderr}");
    assert!(stderr.contains("study.json") && stderr.contains("--out"), "{stderr}");
}

#[test]
fn baselines_are_the_same_after_an_interruption() {
    let folder = tempfile::tempdir().expect("a folder");
    let (code, first, stderr) = study(folder.path(), "baselines", &["--seeds", "2", "--threads", "1"]);
    assert_eq!(code, 0, "{stderr}");
    let found: Value = serde_json::from_str(&first).expect("JSON alone on stdout");
    let rows = found["rows"].as_array().expect("rows");
    assert_eq!(rows.len(), 2);
    for row in rows {
        let methods = row["accuracy"].as_array().expect("methods").len();
        assert!(methods >= 2, "the network and a plain one");
        for method in 0..methods {
            let each: Vec<f64> =
                row["each"][method].as_array().expect("seeds").iter().filter_map(Value::as_f64).collect();
            assert_eq!(each.len(), 2);
            let mean = row["accuracy"][method]["mean"].as_f64().expect("a mean");
            assert!((mean - (each[0] + each[1]) / 2.0).abs() < 1e-12 && (0.0..=1.0).contains(&mean));
        }
        // the first method less each other one
        let number = |pointer: String| row.pointer(&pointer).and_then(Value::as_f64).expect("a number");
        assert_eq!(row["differences"].as_array().map(Vec::len), Some(methods - 1));
        for other in 1..methods {
            let of = |end: &str| number(format!("/differences/{}/{end}", other - 1));
            let difference = number("/accuracy/0/mean".into()) - number(format!("/accuracy/{other}/mean"));
            assert!((of("mean") - difference).abs() < 1e-12, "{row}");
            assert!(of("low") <= difference && difference <= of("high"), "{row}");
        }
        assert_eq!(row["tested"], 20);
    }
    let out = folder.path().join("out");
    for name in ["baselines.json", "baselines.md", "baselines.svg"] {
        assert!(out.join(name).is_file(), "{name} is missing");
    }
    for cell in ["cnn-rate", "seed-2-dsn", "seed-1-cnn-300"] {
        std::fs::remove_file(out.join(format!("cells/{cell}.json"))).expect("a cell");
    }
    let (code, second, stderr) = study(folder.path(), "baselines", &["--seeds", "2", "--threads", "2"]);
    assert_eq!((code, &second), (0, &first), "{stderr}");
}

#[test]
fn an_ablation_simulates_what_differs_and_goes_on() {
    let folder = tempfile::tempdir().expect("a folder");
    let options = ["--seeds", "1", "--set", "frame.sensing_slots=[200]", "--set", "learning.epochs=1"];
    let with = |more: &[&str]| study(folder.path(), "ablation", &[&options[..], more].concat());
    let (code, _, stderr) = with(&["--seed", "100"]);
    assert_eq!(code, 2, "{stderr}");
    assert!(stderr.contains("--seed is 100, must be 101 to 1000"), "{stderr}");
    let (code, first, stderr) = with(&["--threads", "1"]);
    assert_eq!(code, 0, "{stderr}");
    let found: Value = serde_json::from_str(&first).expect("JSON alone on stdout");
    let (rows, effects) =
        (found["rows"].as_array().expect("rows"), found["effects"].as_array().expect("effects"));
    assert_eq!((rows.len(), &found["tested"]), (2 * effects.len(), &20.into()));
    for row in rows {
        let number = |pointer: &str| row.pointer(pointer).and_then(Value::as_f64).expect("a number");
        let difference = number("/with/mean") - number("/without/mean");
        assert!((number("/difference/mean") - difference).abs() < 1e-12, "{row}");
        assert!(number("/difference/low") <= difference && difference <= number("/difference/high"), "{row}");
        let slots = if number("/carrier_hz") == 60e9 { 800 } else { 200 };
        assert_eq!(row["sensing_slots"], slots);
    }
    let out = folder.path().join("out");
    for name in ["ablation.json", "ablation.csv", "ablation.md"] {
        assert!(out.join(name).is_file(), "{name} is missing");
    }
    // at each carrier the default, with those that differ in the spectrogram alone, and one other arm of every other effect; sizes of
    // comparisons have neither eight windows nor one
    let of = |start: &str| {
        let field = |effect: &&Value| effect["with"][0].as_str().expect("a field").starts_with(start);
        effects.iter().filter(field).count()
    };
    let (same, both) = (of("spectrogram."), of("learning.windows"));
    assert!(same > 0 && both == 1);
    let cells = || std::fs::read_dir(out.join("cells")).expect("cells").flatten().map(|entry| entry.path());
    assert_eq!(cells().count(), 2 * (1 + effects.len() - same + both));
    let lost = cells().find(|file| file.to_string_lossy().contains("60ghz")).expect("a cell");
    let before = std::fs::read(&lost).expect("a cell");
    std::fs::remove_file(&lost).expect("removed");
    let (code, second, stderr) = with(&["--threads", "2"]);
    assert_eq!((code, &second), (0, &first), "{stderr}");
    assert_eq!(std::fs::read(&lost).expect("a cell"), before);
}

#[test]
fn clutter_is_removed_by_decision_and_by_every_fixed_d() {
    let folder = tempfile::tempdir().expect("a folder");
    let options = ["--seeds", "1", "--set", "frame.sensing_slots=[200]", "--set", "learning.epochs=1"];
    let with = |more: &[&str]| study(folder.path(), "clutter", &[&options[..], more].concat());
    let (code, _, stderr) = with(&["--set", "channel.mode=paper"]);
    assert_eq!(code, 2, "{stderr}");
    assert!(stderr.contains("channel.model is dahc") && stderr.contains("channel.mode = rician"), "{stderr}");
    std::fs::remove_dir_all(folder.path().join("out")).expect("removed");
    let (code, found, stderr) = with(&[]);
    assert_eq!(code, 0, "{stderr}");
    let found: Value = serde_json::from_str(&found).expect("JSON alone on stdout");
    let rows = found["rows"].as_array().expect("rows");
    let ratios: Vec<_> = rows.iter().filter_map(|row| row["clutter_to_target_db"].as_f64()).collect();
    assert_eq!(ratios, [-20.0, -10.0, 0.0, 10.0, 20.0, 30.0, 40.0]);
    for row in rows {
        let fixed: Vec<_> =
            row["fixed"].as_array().expect("fixed").iter().filter_map(|d| d["mean"].as_f64()).collect();
        assert_eq!(fixed.len(), 3);
        let best = fixed.iter().copied().fold(0.0, f64::max);
        assert_eq!(fixed[row["best_d"].as_u64().expect("d") as usize - 1], best);
        let difference = row["adaptive"]["mean"].as_f64().expect("adaptive") - best;
        assert!((row["difference"]["mean"].as_f64().expect("a mean") - difference).abs() < 1e-12, "{row}");
    }
    for name in ["clutter.json", "clutter.csv", "clutter.md"] {
        assert!(folder.path().join("out").join(name).is_file(), "{name} is missing");
    }
}

#[test]
fn candidates_are_compared_on_development_seeds_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    for (seed, seeds) in [("5", "1"), ("1000", "2")] {
        let options = ["--seed", seed, "--seeds", seeds];
        let (code, _, stderr) = study(folder.path(), "selection", &options);
        assert_eq!(code, 2, "{stderr}");
        assert!(stderr.contains("--seed") && stderr.contains("101 to 1000"), "{stderr}");
    }
    let (code, first, stderr) = study(folder.path(), "selection", &["--seeds", "1", "--threads", "1"]);
    assert_eq!(code, 0, "{stderr}");
    let found: Value = serde_json::from_str(&first).expect("JSON alone on stdout");
    let (candidates, rows) =
        (found["candidates"].as_array().expect("candidates"), found["rows"].as_array().expect("rows"));
    assert_eq!((rows.len(), &found["tested"]), (candidates.len() * 2 * 2, &20.into()));
    assert_eq!(candidates[0]["fields"].as_array().map(Vec::len), Some(0));
    for candidate in candidates {
        let of = |row: &&Value| row["candidate"] == candidate["name"];
        let each = rows.iter().filter(of).map(|row| row["accuracy"]["mean"].as_f64().expect("a mean"));
        let mean = each.sum::<f64>() / 4.0;
        let found = candidate["mean"]["accuracy"].as_f64().expect("a mean");
        assert!((found - mean).abs() < 1e-9, "{candidate}");
    }
    let out = folder.path().join("out");
    for name in ["selection.json", "selection.csv", "selection.md"] {
        assert!(out.join(name).is_file(), "{name} is missing");
    }
    let (code, second, stderr) = study(folder.path(), "selection", &["--seeds", "1", "--threads", "2"]);
    assert_eq!((code, &second), (0, &first), "{stderr}");
}

/// Writes a tone as a mono recording of 16 bits at 2 kHz.
fn wav(file: &Path, hz: f64, seconds: u32) {
    let rate = 2000_u32;
    let sample = |n: u32| {
        let phase = std::f64::consts::TAU * hz * f64::from(n) / f64::from(rate);
        ((20_000.0 * phase.sin()) as i16).to_le_bytes()
    };
    let data: Vec<u8> = (0..rate * seconds).flat_map(sample).collect();
    let mut bytes = b"RIFF".to_vec();
    bytes.extend((36 + data.len() as u32).to_le_bytes());
    bytes.extend(b"WAVEfmt ");
    bytes.extend(16_u32.to_le_bytes());
    bytes.extend([1_u16, 1].into_iter().flat_map(u16::to_le_bytes));
    bytes.extend([rate, 2 * rate].into_iter().flat_map(u32::to_le_bytes));
    bytes.extend([2_u16, 16].into_iter().flat_map(u16::to_le_bytes));
    bytes.extend(b"data");
    bytes.extend((data.len() as u32).to_le_bytes());
    bytes.extend(data);
    std::fs::write(file, bytes).expect("a recording");
}

#[test]
fn measured_recordings_are_scored_with_baselines() {
    let folder = tempfile::tempdir().expect("a folder");
    let (code, _, stderr) = study(folder.path(), "sim-to-real", &["--seeds", "1"]);
    assert_eq!(code, 2, "{stderr}");
    assert!(stderr.contains("--measured"), "{stderr}");
    let measured = folder.path().join("measured");
    std::fs::create_dir(&measured).expect("a folder");
    for (name, hz, seconds) in
        [("walking.wav", 150.0, 5), ("running.wav", 400.0, 3), ("short_walk.wav", 1.0, 0)]
    {
        wav(&measured.join(name), hz, seconds);
    }
    let measured = measured.to_string_lossy();
    let options = ["--measured", &measured, "--carrier", "24.125e9", "--seeds", "2"];
    let (code, first, stderr) = study(folder.path(), "sim-to-real", &options);
    assert_eq!(code, 0, "{stderr}");
    let found: Value = serde_json::from_str(&first).expect("JSON alone on stdout");
    let seconds: Vec<_> =
        found["recordings"].as_array().expect("recordings").iter().map(|r| r["seconds"].clone()).collect();
    assert_eq!(seconds, [3, 5]);
    assert_eq!(found["left_out"].as_array().map(Vec::len), Some(1));
    let scores = found["scores"].as_array().expect("scores");
    assert!(scores.len() >= 6);
    for score in scores {
        let of = |end: &str| score["balanced"][end].as_f64().expect("a share");
        assert!(of("low") <= of("mean") && of("mean") <= of("high"), "{score}");
        let shares: Vec<f64> =
            score["recordings"].as_array().expect("shares").iter().filter_map(Value::as_f64).collect();
        assert!((of("mean") - (shares[0] + shares[1]) / 2.0).abs() < 1e-9, "{score}");
    }
    // the majority class is walking
    assert_eq!(scores[3]["recordings"], serde_json::json!([0.0, 1.0]));
    let (code, second, stderr) = study(folder.path(), "sim-to-real", &options);
    assert_eq!((code, &second), (0, &first), "{stderr}");
}
