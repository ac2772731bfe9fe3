//! Sweeps by the command: shards, what is kept and made again, and bad input.

use sdp3_tests::{outcome, program};
use serde_json::Value;
use std::path::Path;
use std::process::Command;

/// Cells that take a moment each.
const PLAN: &str = r#"
name = "tiny"
sensing_slots = [64, 96]
seeds = [1, 2]
[[scenario]]
name = "tiny"
[scenario.spectrogram]
window = 32
hop = 8
[scenario.learning]
train_per_class = 4
test_per_class = 2
windows = 1
epochs = 2
batch = 10
channels = 4
blocks = 1
stem_stride = 2
[scenario.communication]
draws = 10
"#;

/// Every variable that names a shard.
const VARIABLES: [&str; 6] = [
    "SLURM_ARRAY_TASK_ID",
    "SLURM_ARRAY_TASK_COUNT",
    "SLURM_ARRAY_TASK_MIN",
    "SLURM_ARRAY_TASK_STEP",
    "JOB_COMPLETION_INDEX",
    "JOB_COMPLETIONS",
];

/// Runs the command in `folder`, where the plan is `p.toml`.
fn call(folder: &Path, arguments: &[&str], environment: &[(&str, &str)]) -> (i32, String, String) {
    std::fs::write(folder.join("p.toml"), PLAN).expect("a plan");
    let mut command = Command::new(program());
    for name in VARIABLES {
        command.env_remove(name);
    }
    command.args(arguments).envs(environment.iter().copied()).current_dir(folder);
    outcome(&command.output().expect("the command starts"))
}

fn json(folder: &Path, arguments: &[&str], environment: &[(&str, &str)]) -> Value {
    let (code, stdout, stderr) = call(folder, arguments, environment);
    assert_eq!(code, 0, "{arguments:?}: {stderr}");
    serde_json::from_str(&stdout).expect("JSON alone on stdout")
}

#[test]
fn shards_of_any_split_and_threads_merge_to_the_same_bytes() {
    let folder = tempfile::tempdir().expect("a folder");
    let sweep = |out: &'static str, threads: &'static str| {
        vec!["sweep", "p.toml", "--json", "-q", "--out", out, "--threads", threads]
    };
    let whole = json(folder.path(), &sweep("one", "1"), &[]);
    assert_eq!([&whole["made"], &whole["kept"], &whole["missing"]], [4, 0, 0]);
    let task = [("SLURM_ARRAY_TASK_ID", "3"), ("SLURM_ARRAY_TASK_MIN", "1"), ("SLURM_ARRAY_TASK_COUNT", "3")];
    let third = json(folder.path(), &sweep("two", "2"), &task);
    assert_eq!([&third["made"], &third["missing"]], [1, 3], "{third}");
    assert_eq!(third["shard"], "3/3");
    let (code, _, stderr) = call(folder.path(), &["merge", "two"], &[]);
    assert_eq!(code, 2, "{stderr}");
    assert!(stderr.contains("3 of 4 cells") && stderr.contains("00000.json: missing"), "{stderr}");
    assert!(
        !folder.path().join("two/merged.json").exists() && !folder.path().join("two/merged.csv").exists()
    );
    let index = [("JOB_COMPLETION_INDEX", "0"), ("JOB_COMPLETIONS", "3")];
    assert_eq!(json(folder.path(), &sweep("two", "2"), &index)["shard"], "1/3");
    // the command line wins, and says so
    let mut asked = sweep("two", "1");
    asked.retain(|word| *word != "-q");
    asked.extend(["--shard", "2/3"]);
    let (code, _, stderr) = call(folder.path(), &asked, &index);
    assert_eq!(code, 0, "{stderr}");
    assert!(stderr.contains("--shard 2/3 is made, although the environment says 1/3"), "{stderr}");
    // done cells are kept, a damaged one is made again
    std::fs::write(folder.path().join("two/cells/00001.json"), b"{}").expect("damage");
    let again = json(folder.path(), &sweep("two", "2"), &[]);
    assert_eq!([&again["made"], &again["kept"], &again["missing"]], [1, 3, 0], "{again}");
    let merged = json(folder.path(), &["merge", "one", "--json"], &[]);
    assert_eq!(merged["cells"].as_array().map(Vec::len), Some(4));
    json(folder.path(), &["merge", "two", "--json"], &[]);
    for name in ["sweep.toml", "merged.csv", "merged.json", "cells/00000.json", "cells/00003.json"] {
        let read = |out: &str| std::fs::read(folder.path().join(out).join(name)).expect(name);
        assert!(read("one") == read("two"), "{name} differs");
    }
}

#[test]
fn bad_input_is_refused_by_name_and_nothing_is_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let refused = |arguments: &[&str], environment: &[(&str, &str)], words: &[&str]| {
        let (code, stdout, stderr) = call(folder.path(), arguments, environment);
        assert_eq!(code, 2, "{arguments:?}: {stdout}{stderr}");
        words.iter().for_each(|word| assert!(stderr.contains(word), "{word:?} is not in: {stderr}"));
        assert!(!folder.path().join("out").exists(), "{arguments:?} wrote");
    };
    let sweep = |more: &[&'static str]| [&["sweep", "p.toml", "--out", "out"], more].concat();
    for shard in ["0/3", "4/3", "1/0", "2"] {
        refused(&sweep(&["--shard", shard]), &[], &["--shard", shard, "1/N to N/N"]);
    }
    refused(&sweep(&["--slurm", "--shards", "0"]), &[], &["--shards", "0"]);
    refused(&sweep(&["--slurm", "--shards", "5"]), &[], &["--shards is 5", "1 to 4"]);
    refused(&sweep(&["--shards", "2"]), &[], &["--shards", "--shard I/N"]);
    refused(&sweep(&["--kubernetes"]), &[], &["--image"]);
    refused(&sweep(&["--slurm", "--shard", "1/2"]), &[], &["--shard"]);
    let beyond =
        [("SLURM_ARRAY_TASK_ID", "9"), ("SLURM_ARRAY_TASK_MIN", "1"), ("SLURM_ARRAY_TASK_COUNT", "3")];
    refused(&sweep(&[]), &beyond, &["SLURM_ARRAY_TASK_ID is 9", "one of 3 numbers from 1"]);
    refused(&sweep(&[]), &[("JOB_COMPLETION_INDEX", "1")], &["JOB_COMPLETIONS is missing"]);
    refused(&["sweep", "none.toml", "--out", "out"], &[], &["none.toml", "cannot be read"]);
    for (text, words) in [
        ("seed = [1]\n", vec!["q.toml", "`seed`", "seeds"]),
        ("rho = []\n", vec!["q.toml: rho is []", "at least one value"]),
        ("rho = [2.0]\n", vec!["q.toml", "channel.rho is 2", "0 to 1"]),
    ] {
        std::fs::write(folder.path().join("q.toml"), text).expect("a plan");
        refused(&["sweep", "q.toml", "--out", "out"], &[], &words);
    }
    refused(&["merge", "out"], &[], &["out: no sweep", "sweep.toml"]);
    refused(&["sweep", "p.toml", "--out", "/proc/none"], &[], &["/proc/none", "--out"]);
}

#[test]
fn scripts_are_written_and_a_missing_slurm_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let slurm = ["sweep", "p.toml", "--out", "out", "--slurm", "--sbatch=--partition=long", "--json"];
    let done = json(folder.path(), &[&slurm[..], &["--dry-run"]].concat(), &[]);
    assert_eq!((&done["shards"], &done["array"]), (&4.into(), &Value::Null));
    for (file, word) in
        [("sweep.sbatch", "#SBATCH --array=1-4\n"), ("merge.sbatch", "#SBATCH --partition=long\n")]
    {
        let text = std::fs::read_to_string(folder.path().join("out").join(file)).expect(file);
        assert!(text.contains(word), "{text}");
    }
    let (code, _, stderr) = call(folder.path(), &slurm, &[("PATH", "/none")]);
    assert!(code == 2 && stderr.contains("sbatch") && stderr.contains("--dry-run"), "{stderr}");
}

#[test]
fn the_plans_of_the_documentation_are_legal() {
    let folder = tempfile::tempdir().expect("a folder");
    let plans = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/plans");
    for (name, shards) in [("quick.toml", 4), ("carriers.toml", 100), ("spacing.toml", 50)] {
        let (plan, out) = (plans.join(name), folder.path().join(name));
        let arguments = [
            "sweep",
            &plan.to_string_lossy(),
            "--slurm",
            "--dry-run",
            "--json",
            "--out",
            &out.to_string_lossy(),
        ];
        assert_eq!(json(folder.path(), &arguments, &[])["shards"], shards, "{name}");
    }
}
