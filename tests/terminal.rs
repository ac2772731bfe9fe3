//! Manners of the command: broken pipes are quiet, Ctrl-C leaves what can be gone on with, bars are for terminals.

use sdp3_tests::{outcome, program};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Recordings of 64 sensing slots: a part of a dataset takes a fraction of a second.
const SHORT: &str = "[frame]\nsensing_slots = [64]\n[spectrogram]\nwindow = 32\nhop = 8\n";

#[test]
fn a_reader_who_has_gone_away_is_not_an_error() {
    for arguments in [&["schema", "run"][..], &["scenario", "show"], &["completions", "bash"], &["--help"]] {
        let (reader, writer) = std::io::pipe().expect("a pipe");
        drop(reader);
        let output = Command::new(program()).args(arguments).stdout(writer).output().expect("it starts");
        let (code, _, stderr) = outcome(&output);
        assert_eq!((code, stderr.as_str()), (0, ""), "{arguments:?}");
    }
    let (reader, writer) = std::io::pipe().expect("a pipe");
    drop(reader);
    let output = Command::new(program()).arg("nonsense").stderr(writer).output().expect("it starts");
    assert_eq!(output.status.code(), Some(2));
}

#[test]
fn a_full_disk_is_an_error() {
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").expect("/dev/full");
    let output = Command::new(program()).args(["schema", "run"]).stdout(full).output().expect("it starts");
    let (code, _, stderr) = outcome(&output);
    assert_eq!(code, 2);
    assert!(stderr.contains("stdout") && stderr.contains("cannot be written"), "{stderr}");
}

#[test]
fn a_file_beyond_the_limit_of_the_system_is_an_error() {
    let folder = tempfile::tempdir().expect("a folder");
    let command = simulate(folder.path(), "out");
    let mut limited = Command::new("sh");
    // blocks of 512 bytes
    limited
        .args(["-c", "ulimit -f 64; exec \"$0\" \"$@\""])
        .arg(command.get_program())
        .args(command.get_args());
    let (code, _, stderr) = outcome(&limited.output().expect("it starts"));
    assert_eq!(code, 2, "{stderr}");
    assert!(stderr.contains("part-00000.npz: cannot be written: File too large"), "{stderr}");
    let left = std::fs::read_dir(folder.path().join("out")).expect("a folder").flatten();
    let left: Vec<String> = left.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    assert!(left.iter().all(|name| !name.contains("partial") && !name.ends_with(".npz")), "{left:?}");
}

/// `sdp3 simulate` of many short recordings.
fn simulate(folder: &Path, out: &str) -> Command {
    let scenario = folder.join("short.toml");
    std::fs::write(&scenario, SHORT).expect("a scenario");
    let mut command = Command::new(program());
    command.args(["simulate", "--raw", "--per-class", "120", "--threads", "1", "--scenario"]);
    command.arg(scenario).arg("--out").arg(folder.join(out));
    command
}

#[test]
fn an_interrupted_command_says_how_to_go_on_and_can() {
    let folder = tempfile::tempdir().expect("a folder");
    let files = |out: &str| {
        let entries = std::fs::read_dir(folder.path().join(out)).expect("a folder");
        let name = |entry: std::io::Result<std::fs::DirEntry>| entry.expect("a file").file_name();
        let mut names: Vec<String> =
            entries.map(|entry| name(entry).to_string_lossy().into_owned()).collect();
        names.sort();
        names
    };
    let signals = ["INT", "TERM", "HUP"];
    for signal in signals {
        let mut command = simulate(folder.path(), signal);
        let child = command.stderr(Stdio::piped()).stdout(Stdio::null()).spawn().expect("it starts");
        let begun = Instant::now();
        while !folder.path().join(signal).join("part-00000.npz").exists() {
            assert!(begun.elapsed() < Duration::from_secs(120), "no part");
            std::thread::sleep(Duration::from_millis(2));
        }
        let id = child.id().to_string();
        assert!(Command::new("kill").args(["-s", signal, &id]).status().expect("kill").success());
        let (code, _, stderr) = outcome(&child.wait_with_output().expect("it ends"));
        assert_eq!(code, 130, "SIG{signal}: {stderr}");
        assert!(stderr.contains("interrupted") && stderr.contains("the same command goes on"), "{stderr}");
        let left = files(signal);
        assert!(left.iter().all(|name| !name.contains("partial")), "{left:?}");
        assert!(!left.contains(&"manifest.json".to_owned()), "it was stopped before its end: {left:?}");
    }
    for name in signals.into_iter().chain(["whole"]) {
        let (code, _, stderr) = outcome(&simulate(folder.path(), name).output().expect("it starts"));
        assert_eq!(code, 0, "{stderr}");
        assert!(!stderr.contains('\u{1b}') && !stderr.contains('\r'), "plain lines: {stderr:?}");
        assert!(stderr.lines().any(|line| line.starts_with("  simulate  ")), "{stderr}");
    }
    for signal in signals {
        for name in files(signal) {
            let read = |out: &str| std::fs::read(folder.path().join(out).join(&name)).expect("a file");
            assert!(read(signal) == read("whole"), "SIG{signal}: {name} differs");
        }
    }
}

/// What a terminal is sent: the command's words through `script`.
fn on_a_terminal(folder: &Path, command: &str, no_colour: bool) -> String {
    let mut script = Command::new("script");
    script.args(["-qec", &format!("{} {command}", program().display()), "/dev/null"]).current_dir(folder);
    script.stdin(Stdio::null()).env("TERM", "xterm-256color").env("COLUMNS", "120").env_remove("NO_COLOR");
    if no_colour {
        script.env("NO_COLOR", "1");
    }
    outcome(&script.output().expect("script, of util-linux")).1
}

#[test]
fn a_terminal_sees_a_bar_with_the_time_left_and_no_colour_unless_it_wants_some() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("short.toml"), SHORT).expect("a scenario");
    let seen = on_a_terminal(folder.path(), "simulate --per-class 60 --scenario short.toml", true);
    assert!(seen.contains("simulate [") && seen.contains(" left)"), "{seen:?}");
    // ESC [ ... m sets a colour
    let coloured = |text: &str| {
        text.split("\u{1b}[")
            .skip(1)
            .any(|rest| rest.trim_start_matches(|c: char| c.is_ascii_digit() || c == ';').starts_with('m'))
    };
    assert!(!coloured(&seen), "{seen:?}");
    assert!(!coloured(&on_a_terminal(folder.path(), "nonsense", true)));
    assert!(coloured(&on_a_terminal(folder.path(), "nonsense", false)));
    let quiet = on_a_terminal(folder.path(), "simulate -q --per-class 1 --scenario short.toml --out q", true);
    assert_eq!(quiet, "");
}
