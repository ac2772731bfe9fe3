//! Firmware in QEMU: build it, run a suite on it, read what it prints.
//!
//! The folder of a machine holds its programs and `emulator`, the command that runs them: `firmware-sim/build` makes it.

use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// The emulated machines with a clock in the table `firmware-sim/machines`, by name.
pub const MACHINES: [&str; 8] = [
    "cortex-m3",
    "cortex-m4f",
    "cortex-m7",
    "cortex-m33",
    "cortex-m55",
    "riscv32imac",
    "riscv32imafc",
    "cortex-a53",
];

/// Those without one, which run the conformance suite.
pub const UNTIMED: [&str; 3] = ["cortex-m0plus", "riscv32imc", "riscv32zve"];

/// An emulated machine and a program for it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Firmware {
    /// Name of the target.
    pub name: &'static str,
    /// The program.
    pub elf: PathBuf,
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
        emulator: String,
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
    /// It ended badly, or said something that cannot be understood.
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

/// A program of the firmware in `folder`, on every machine.
pub fn machines(folder: &Path, program: &str) -> Vec<Firmware> {
    let firmware = |name| Firmware { name, elf: folder.join(name).join(program) };
    MACHINES.into_iter().chain(UNTIMED).map(firmware).collect()
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

/// Builds a program of the firmware for some machines, from the repository this program was built in; every line that
/// the script prints goes to `line`.
///
/// # Errors
///
/// [`QemuError::Build`] with the script's last words.
pub fn build(
    out: &Path,
    program: &str,
    machines: &[&str],
    line: &mut dyn FnMut(&str),
) -> Result<(), QemuError> {
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
    command
        .arg("--out")
        .arg(out)
        .args(["--program", program])
        .args(machines)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
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

/// Runs a program in `folder` and returns all it prints. Arguments have no spaces; paths in them are relative to the folder.
///
/// # Errors
///
/// [`QemuError`]; a program that does not end with exit code 0 in time counts as not run.
pub fn run(
    firmware: &Firmware,
    folder: &Path,
    arguments: &[String],
    limit: Duration,
) -> Result<String, QemuError> {
    let command = firmware.elf.with_file_name("emulator");
    let command = std::fs::read_to_string(&command).map_err(|_| QemuError::Missing(command))?;
    let elf = firmware.elf.canonicalize().map_err(|_| QemuError::Missing(firmware.elf.clone()))?;
    let name = firmware.name;
    let mut words = command.split_ascii_whitespace();
    let emulator = words.next().unwrap_or_default();
    let given: Vec<String> =
        arguments.iter().map(|text| format!(",arg={}", text.replace(',', ",,"))).collect();
    let mut child = Command::new(emulator)
        .args(words)
        .args(["-nographic", "-monitor", "none", "-serial", "none", "-semihosting-config"])
        .arg(format!("enable=on,target=native{}", given.concat()))
        .arg("-kernel")
        .arg(elf)
        .current_dir(folder)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(|source| QemuError::Start { emulator: emulator.to_owned(), source })?;
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
            Err(source) => break Err(QemuError::Start { emulator: emulator.to_owned(), source }),
        }
    }?;
    let text: Vec<String> = readers.into_iter().filter_map(|reader| reader.join().ok()).collect();
    let text = text.join("\n");
    if status.success() {
        return Ok(text);
    }
    let reason = format!("ended with {status}; its last words:\n{}", tail(&text));
    Err(QemuError::Output { name, reason })
}
