//! Firmware in QEMU: build it, run a suite on it, read what it prints.
//!
//! Lines: `case <i> <stage> <count> <digest>`, `case <i> instructions <n>`, `schedule <count> <digest>`,
//! `selftest <digest>`, `stack <bytes>`, and `done` last. Anything cut short is refused.

use super::digests::Stage;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// An emulated machine and the program for it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Firmware {
    /// Name of the target.
    pub name: &'static str,
    /// The program.
    pub elf: PathBuf,
    emulator: &'static str,
    machine: &'static [&'static str],
}

/// What firmware printed.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct FirmwareReport {
    /// Each case.
    pub cases: Vec<CaseReport>,
    /// Slots and digest of the schedule.
    pub schedule: Option<(u64, u64)>,
    /// Most stack used, in bytes.
    pub stack_bytes: Option<u64>,
    /// Digest of the power-on self test.
    pub selftest: Option<u64>,
}

/// One case.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct CaseReport {
    /// Stages in order.
    pub stages: Vec<Stage>,
    /// Instructions of one recognition.
    pub instructions: Option<u64>,
}

/// Why a target could not run.
#[derive(Debug, thiserror::Error)]
pub enum QemuError {
    /// The program is not there.
    #[error("{0}: no such firmware; firmware-sim/build makes it")]
    Missing(PathBuf),
    /// QEMU cannot be started.
    #[error("{emulator}: cannot be started: {source}; firmware-sim/build installs it")]
    Start {
        /// The command.
        emulator: &'static str,
        /// What the system says.
        source: std::io::Error,
    },
    /// It took too long.
    #[error("{name}: not done after {seconds} s")]
    TimeOut {
        /// The target.
        name: &'static str,
        /// The limit.
        seconds: u64,
    },
    /// It ended without saying `done`, or said something else.
    #[error("{name}: {reason}")]
    Output {
        /// The target.
        name: &'static str,
        /// What is wrong.
        reason: String,
    },
    /// The build script failed.
    #[error("firmware-sim/build: {0}")]
    Build(String),
}

/// The machines whose firmware lies in `folder`.
pub fn targets(folder: &Path) -> Vec<Firmware> {
    let elf = |name: &str| folder.join(name).join("conformance");
    vec![
        Firmware {
            name: "cortex-m4f",
            elf: elf("cortex-m4f"),
            emulator: "qemu-system-arm",
            machine: &["-M", "mps2-an386", "-icount", "shift=6"],
        },
        Firmware {
            name: "riscv32imac",
            elf: elf("riscv32imac"),
            emulator: "qemu-system-riscv32",
            machine: &["-M", "virt", "-cpu", "rv32,f=false,d=false", "-bios", "none", "-icount", "shift=0"],
        },
    ]
}

/// Where the firmware is or will be built: an explicit folder, `SDP3_FIRMWARE`, or beside this program's profile.
pub fn folder(explicit: Option<&Path>) -> PathBuf {
    if let Some(folder) = explicit {
        return folder.to_owned();
    }
    if let Some(folder) = std::env::var_os("SDP3_FIRMWARE") {
        return folder.into();
    }
    let program = std::env::current_exe().unwrap_or_default();
    let above = program.ancestors().skip(2).take(2).map(|dir| dir.join("firmware"));
    let mut candidates = above.clone();
    candidates.find(|dir| dir.is_dir()).or_else(|| above.into_iter().next()).unwrap_or_default()
}

/// Builds the firmware from the repository this program was built in; every line it prints goes to `line`.
///
/// # Errors
///
/// [`QemuError::Build`] with the script's last words.
pub fn build(out: &Path, line: &mut dyn FnMut(&str)) -> Result<(), QemuError> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let script = root.join("firmware-sim").join("build");
    if !script.is_file() {
        let text = "the repository is not here any more; give --firmware DIR with firmware built elsewhere";
        return Err(QemuError::Build(text.into()));
    }
    let fail = |error: std::io::Error| QemuError::Build(error.to_string());
    std::fs::create_dir_all(out).map_err(fail)?;
    let out = out.canonicalize().map_err(fail)?;
    let mut command = Command::new(&script);
    command.arg("--out").arg(out).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    // what cargo set for this program would steer the cross build
    for (name, _) in std::env::vars_os() {
        if name.to_string_lossy().starts_with("CARGO_PKG") || name == "RUSTUP_TOOLCHAIN" {
            command.env_remove(name);
        }
    }
    let mut child = command.spawn().map_err(fail)?;
    let errors = child.stderr.take().map(|mut pipe| {
        std::thread::spawn(move || {
            let mut text = String::new();
            let _ = pipe.read_to_string(&mut text);
            text
        })
    });
    for text in
        child.stdout.take().into_iter().flat_map(|pipe| BufReader::new(pipe).lines()).map_while(Result::ok)
    {
        line(&text);
    }
    let errors = errors.and_then(|thread| thread.join().ok()).unwrap_or_default();
    if child.wait().map_err(fail)?.success() { Ok(()) } else { Err(QemuError::Build(tail(&errors))) }
}

fn tail(text: &str) -> String {
    let lines: Vec<&str> = text.lines().collect();
    lines[lines.len().saturating_sub(12)..].join("\n")
}

/// Runs a suite file on a target.
///
/// # Errors
///
/// [`QemuError`].
pub fn run(firmware: &Firmware, suite: &Path, limit: Duration) -> Result<FirmwareReport, QemuError> {
    if !firmware.elf.is_file() {
        return Err(QemuError::Missing(firmware.elf.clone()));
    }
    let name = firmware.name;
    let arguments = format!("enable=on,target=native,arg={}", suite.display().to_string().replace(',', ",,"));
    let mut child = Command::new(firmware.emulator)
        .args(firmware.machine)
        .args([
            "-nographic",
            "-monitor",
            "none",
            "-serial",
            "none",
            "-semihosting-config",
            &arguments,
            "-kernel",
        ])
        .arg(&firmware.elf)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(|source| QemuError::Start { emulator: firmware.emulator, source })?;
    // semihosting text comes on stderr or stdout, by machine: both are read
    let pipes: Vec<Box<dyn Read + Send>> = [
        child.stdout.take().map(|p| Box::new(p) as Box<dyn Read + Send>),
        child.stderr.take().map(|p| Box::new(p) as Box<dyn Read + Send>),
    ]
    .into_iter()
    .flatten()
    .collect();
    let readers: Vec<_> = pipes
        .into_iter()
        .map(|mut pipe| {
            std::thread::spawn(move || {
                let mut text = Vec::new();
                let _ = pipe.read_to_end(&mut text);
                String::from_utf8_lossy(&text).into_owned()
            })
        })
        .collect();
    let begun = Instant::now();
    let status = loop {
        match child.try_wait() {
            Ok(Some(status)) => break Ok(status),
            Ok(None) if begun.elapsed() > limit => {
                let _ = child.kill();
                let _ = child.wait();
                break Err(QemuError::TimeOut { name, seconds: limit.as_secs() });
            }
            Ok(None) => std::thread::sleep(Duration::from_millis(20)),
            Err(source) => break Err(QemuError::Start { emulator: firmware.emulator, source }),
        }
    }?;
    let text: Vec<String> = readers.into_iter().filter_map(|reader| reader.join().ok()).collect();
    let text = text.join("\n");
    let report = parse(&text);
    match report {
        Some(report) if status.success() => Ok(report),
        _ => {
            let reason = format!("ended with {status} before it was done; its last words:\n{}", tail(&text));
            Err(QemuError::Output { name, reason })
        }
    }
}

/// Reads the lines firmware prints; `None` unless they end with `done` and every line is understood.
pub fn parse(text: &str) -> Option<FirmwareReport> {
    let mut report = FirmwareReport::default();
    let mut done = false;
    for line in text.lines().map(str::trim).filter(|line| !line.is_empty()) {
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        let hex = |digits: &str| u64::from_str_radix(digits, 16).ok();
        match words[..] {
            ["case", index, "instructions", n] => {
                let index: usize = index.parse().ok()?;
                report.cases.get_mut(index)?.instructions = Some(n.parse().ok()?);
            }
            ["case", index, stage, count, digest] => {
                let index: usize = index.parse().ok()?;
                if index == report.cases.len() {
                    report.cases.push(CaseReport::default());
                }
                let stage = (stage.to_owned(), count.parse().ok()?, hex(digest)?);
                report.cases.get_mut(index)?.stages.push(stage);
            }
            ["schedule", count, digest] => report.schedule = Some((count.parse().ok()?, hex(digest)?)),
            ["selftest", digest] => report.selftest = Some(hex(digest)?),
            ["stack", bytes] => report.stack_bytes = Some(bytes.parse().ok()?),
            ["done"] => done = true,
            _ => return None,
        }
    }
    done.then_some(report)
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = "selftest 0ba80aa6e02f79c8\ncase 0 beat 16000 00000000000000ff\ncase 0 gram 72 0a\n\
                        case 0 instructions 123\nschedule 40 71e32feb3f4cd392\nstack 26228\ndone\n";

    #[test]
    fn whole_outputs_are_read_and_others_refused() {
        let report = parse(GOOD).unwrap();
        assert_eq!(report.cases.len(), 1);
        assert_eq!(report.cases[0].stages[0], ("beat".into(), 16000, 255));
        assert_eq!((report.cases[0].instructions, report.stack_bytes), (Some(123), Some(26228)));
        assert_eq!(parse(GOOD.trim_end_matches("done\n")), None);
        assert_eq!(parse("case 0 beat x 00\ndone"), None);
        assert_eq!(parse("panicked at core\ndone"), None);
        assert_eq!(parse("case 3 beat 1 00\ndone"), None);
    }
}
