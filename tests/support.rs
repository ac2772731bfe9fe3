//! Helpers shared by the cross-crate tests: the built command, a small scenario, and one run of it.

pub mod networks;
pub mod suites;
pub mod vectors;

use sdp3::scenario::Scenario;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

/// A scenario that runs in seconds: two N_s, few recordings, a small network.
pub const SMALL: &str = r#"
name = "small"
[frame]
sensing_slots = [200, 300]
[learning]
train_per_class = 8
test_per_class = 4
recording_slots = 600
windows = 2
epochs = 3
batch = 10
channels = 4
blocks = 2
stem_stride = 2
[communication]
draws = 20
"#;

/// The paper's room and radar as printed, with the default images but d = 2 and 50 dB: what the networks and digests of these tests were
/// made with.
pub fn printed_room() -> Scenario {
    let printed =
        sdp3::scenario::builtin::named(Path::new("as-printed")).map(|one| one.scenario()).unwrap_or_default();
    let usual = Scenario::default();
    let mut spectrogram = usual.spectrogram;
    (spectrogram.first_kept, spectrogram.range_db) = (2, 50.0);
    Scenario { spectrogram, learning: usual.learning, ..printed }
}

/// The `sdp3` command beside this test's profile.
///
/// # Panics
///
/// If it is not built: `tests/run` builds it first.
pub fn program() -> PathBuf {
    let test = std::env::current_exe().expect("this test has a path");
    let profile = test.ancestors().nth(2).expect("target/<profile>/deps/<test>");
    let program = profile.join("sdp3");
    assert!(
        program.is_file(),
        "{} is missing: run tests/run, or cargo build --release first",
        program.display()
    );
    program
}

/// Runs a program with arguments.
///
/// # Panics
///
/// If it cannot be started.
pub fn call(program: &Path, arguments: &[&str]) -> Output {
    Command::new(program).args(arguments).output().expect("the command starts")
}

/// Exit code, stdout and stderr.
pub fn outcome(output: &Output) -> (i32, String, String) {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code().unwrap_or(-1), text(&output.stdout), text(&output.stderr))
}

/// One whole run of the small scenario with all targets, made once for all tests of a file: folder, stdout and exit code.
///
/// # Panics
///
/// If the run cannot be started.
pub fn small_run() -> &'static (tempfile::TempDir, String, i32, String) {
    static RUN: OnceLock<(tempfile::TempDir, String, i32, String)> = OnceLock::new();
    RUN.get_or_init(|| {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let scenario = folder.path().join("small.toml");
        std::fs::write(&scenario, SMALL).expect("a scenario");
        let out = folder.path().join("out");
        let arguments = [
            "run",
            "--json",
            "--seed",
            "3",
            "--scenario",
            &scenario.to_string_lossy(),
            "--out",
            &out.to_string_lossy(),
        ];
        let (code, stdout, stderr) = outcome(&call(&program(), &arguments));
        (folder, stdout, code, stderr)
    })
}
