//! Hostile names, files and folders: text stays text, what is edited is refused, nothing outside the folder is touched.

use sdp3_testkit::models::DSN_200;
use sdp3_tests::{SMALL, call, outcome, program};
use tempfile::TempDir;

/// Runs the command in a folder; exit code, stdout, stderr. `@` is the folder.
fn sdp3(folder: &TempDir, arguments: &[&str]) -> (i32, String, String) {
    let here = folder.path().to_string_lossy();
    let arguments: Vec<String> = arguments.iter().map(|word| word.replace('@', &here)).collect();
    outcome(&call(&program(), &arguments.iter().map(String::as_str).collect::<Vec<_>>()))
}

fn refused(folder: &TempDir, arguments: &[&str], words: &[&str]) {
    let (code, stdout, stderr) = sdp3(folder, arguments);
    assert_eq!(code, 2, "{arguments:?}: {stdout}{stderr}");
    for word in words {
        assert!(stderr.contains(word), "{arguments:?}: {word:?} is not in: {stderr}");
    }
    let control = |c: char| c.is_control() && c != '\n';
    assert!(!stderr.contains(control), "a control character reaches the terminal: {stderr:?}");
}

fn folder() -> TempDir {
    tempfile::tempdir().expect("a folder")
}

fn write(folder: &TempDir, name: &str, content: impl AsRef<[u8]>) {
    std::fs::write(folder.path().join(name), content).expect("a file");
}

/// Names that are more than a name somewhere: in a shell script, in YAML 1.1, on a terminal, in a table or for the eye.
const NAMES: [&str; 12] = [
    "a\n#SBATCH --wrap=reboot",
    "a\r\nb",
    "a\u{85}kind: Pod",
    "a\u{2028}kind: Pod",
    "a\u{1b}[2J",
    "a\u{9b}2J",
    "a\u{202e}b",
    "a\u{61c}b",
    "a\u{fffe}",
    "a\u{e0041}",
    "=1+1",
    "",
];

#[test]
fn a_scenario_has_a_name_that_is_only_a_name() {
    for name in NAMES {
        let folder = folder();
        write(&folder, "s.toml", format!("name = {}\n", serde_json::Value::from(name)));
        refused(
            &folder,
            &["run", "--scenario", "@/s.toml", "--out", "@/out"],
            &["s.toml", "name is", "printable"],
        );
        assert!(!folder.path().join("out").exists(), "{name:?}");
    }
}

#[test]
fn a_plan_and_its_folder_cannot_change_a_script_or_manifest() {
    let folder = folder();
    let kubernetes = ["sweep", "@/p.toml", "--kubernetes", "--shards", "2", "--image", "i", "--out", "@/out"];
    for name in NAMES {
        let name = serde_json::Value::from(name);
        write(&folder, "p.toml", format!("seeds = [1]\nname = {name}\n"));
        refused(&folder, &kubernetes, &["p.toml", "name is"]);
        write(&folder, "p.toml", format!("seeds = [1]\n[[scenario]]\nname = {name}\n"));
        refused(&folder, &kubernetes, &["p.toml", "name is"]);
    }
    write(&folder, "p.toml", "seeds = [1]\n");
    let slurm = ["sweep", "@/p.toml", "--slurm", "--dry-run", "--shards", "2"];
    let out = |path: &'static str| [&slurm[..], &["--out", path]].concat();
    for path in ["@/a\n#SBATCH --wrap=reboot", "@/a\rb", "@/a\"b", "@/a\u{2028}b", "@/hetjob"] {
        refused(&folder, &out(path), &["--out is", "printable"]);
    }
    // a line with either of the last words begins another component of a heterogeneous job
    for option in ["-p a\n#SBATCH --wrap=reboot", "-p a\rb", "reboot", "-p hetjob", "--comment=packjob"] {
        refused(&folder, &[&out("@/out")[..], &["--sbatch", option]].concat(), &["--sbatch is"]);
    }
    write(&folder, "het.toml", "seeds = [1]\nname = \"hetjob-a\"\n");
    let named = ["sweep", "@/het.toml", "--slurm", "--dry-run", "--out", "@/out"];
    refused(&folder, &named, &["name is", "without hetjob"]);
    // image and claim are any text, and stay it
    let odd = "i\"\n---\nkind: Pod\u{85}\u{2028}";
    let claim = [&kubernetes[..], &["--claim", odd]].concat();
    let (code, _, stderr) = sdp3(&folder, &claim);
    assert_eq!(code, 0, "{stderr}");
    let text = std::fs::read_to_string(folder.path().join("out/merge.yaml")).expect("a manifest");
    let job: serde_json::Value = serde_json::from_str(&text).expect("one document of JSON");
    assert_eq!(
        job.pointer("/spec/template/spec/volumes/0/persistentVolumeClaim/claimName"),
        Some(&odd.into())
    );
    assert!(
        text.lines()
            .eq(text.split(['\n', '\r', '\u{85}', '\u{2028}', '\u{2029}']).take(text.lines().count()))
    );
}

#[test]
fn no_name_of_a_file_reaches_the_terminal_raw() {
    let folder = folder();
    for name in ["a\u{1b}[31m.wav", "a\u{9b}2J.npy", "a\rb.sigmf-meta"] {
        write(&folder, name, "nothing");
        let file = format!("@/{name}");
        refused(
            &folder,
            &["calibrate", "--measured", &file, "--carrier", "24e9", "--out", "@/out"],
            &["\\u{"],
        );
    }
}

#[test]
fn no_argument_reaches_the_terminal_raw() {
    let folder = folder();
    for argument in ["--\u{1b}[2J", "a\u{9b}2J", "a\u{202e}b"] {
        refused(&folder, &["run", argument], &["\\u{"]);
        refused(&folder, &["run", "--seed", argument], &["\\u{"]);
        refused(&folder, &[argument], &["\\u{"]);
    }
}

#[test]
fn a_key_is_not_overwritten() {
    let folder = folder();
    write(&folder, "m.sdp3", DSN_200);
    let (code, _, stderr) = sdp3(&folder, &["model", "keygen", "@/k"]);
    assert_eq!(code, 0, "{stderr}");
    let read = |name: &str| std::fs::read(folder.path().join(name)).expect("a file");
    let before = [read("k.key"), read("k.pub")];
    for to in ["@/k.key", "@/k.pub"] {
        refused(
            &folder,
            &["model", "sign", "@/m.sdp3", "--key", "@/k.key", "--to", to],
            &["--to is", "a model file"],
        );
    }
    refused(&folder, &["model", "keygen", "@/k"], &["k.key"]);
    assert_eq!([read("k.key"), read("k.pub")], before);
    for _ in 0..2 {
        let (code, _, stderr) =
            sdp3(&folder, &["model", "sign", "@/m.sdp3", "--key", "@/k.key", "--to", "@/s.sdp3"]);
        assert_eq!(code, 0, "{stderr}");
    }
}

#[test]
fn edited_and_mixed_results_are_refused_by_name() {
    let folder = folder();
    write(&folder, "s.toml", SMALL);
    for (out, seed) in [("@/a", "1"), ("@/b", "2")] {
        let run = [
            "run",
            "-q",
            "--scenario",
            "@/s.toml",
            "--targets",
            "host-reference",
            "--seed",
            seed,
            "--out",
            out,
        ];
        let (code, _, stderr) = sdp3(&folder, &run);
        assert_eq!(code, 0, "{stderr}");
    }
    let path = |name: &str| folder.path().join(name);
    let report = ["report", "--out", "@/a"];
    let edited = |name: &str, from: &str, to: &str, words: &[&str]| {
        let file = path("a").join(name);
        let text = std::fs::read_to_string(&file).expect("a result");
        assert!(text.contains(from), "{from} is not in {name}");
        std::fs::write(&file, text.replacen(from, to, 1)).expect("written");
        refused(&folder, &report, words);
        std::fs::write(&file, text).expect("written");
    };
    edited("run.json", "\"rho\": 0.", "\"rho\": 0.1", &["run.json", "changed", "sha256"]);
    edited("figures.json", "\"classes\"", "\"classes\" ", &["figures.json", "changed", "sha256"]);
    edited("scenario.toml", "draws = 20", "draws = 21", &["scenario.toml"]);
    for name in ["run.json", "figures.json"] {
        let own = std::fs::read(path("a").join(name)).expect("a result");
        std::fs::copy(path("b").join(name), path("a").join(name)).expect("copied");
        refused(&folder, &report, &["figures.json", "provenance.seed", "the files of one run"]);
        std::fs::write(path("a").join(name), own).expect("written");
    }
    let (code, _, stderr) = sdp3(&folder, &report);
    assert_eq!(code, 0, "{stderr}");
}

#[cfg(unix)]
#[test]
fn no_link_leads_out_of_the_folder() {
    use std::os::unix::fs::symlink;
    let folder = folder();
    write(&folder, "s.toml", SMALL);
    write(&folder, "precious", "precious");
    std::fs::create_dir_all(folder.path().join("elsewhere")).expect("a folder");
    std::fs::create_dir_all(folder.path().join("out")).expect("a folder");
    let link =
        |to: &str, name: &str| symlink(folder.path().join(to), folder.path().join(name)).expect("a link");
    // a file that is a link is replaced, not followed
    link("precious", "out/campaign.json");
    let schedule = [
        "schedule",
        "-q",
        "--periods",
        "2",
        "--sensing-slots",
        "200",
        "--scenario",
        "@/s.toml",
        "--out",
        "@/out",
    ];
    let (code, _, stderr) = sdp3(&folder, &schedule);
    assert_eq!(code, 0, "{stderr}");
    assert_eq!(std::fs::read(folder.path().join("precious")).expect("a file"), b"precious");
    assert!(!folder.path().join("out/campaign.json").is_symlink());
    link("elsewhere", "out/models");
    let train = ["train", "-q", "--scenario", "@/s.toml", "--out", "@/out"];
    refused(&folder, &train, &["out/models", "a link"]);
    assert_eq!(std::fs::read_dir(folder.path().join("elsewhere")).expect("a folder").count(), 0);
}
