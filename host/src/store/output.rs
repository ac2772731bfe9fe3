//! The output folder: files appear whole or not at all.
//!
//! Every file is written beside its name, synced, and renamed over it; then the folder is synced, so that this also holds when the
//! power fails.

use crate::store::limited;
use crate::{COMMIT, COMMIT_DATE, PROGRAM};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Why a file could not be written or read.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// The folder or a file in it cannot be written.
    #[error("{path}: cannot be written: {source}; --out needs a folder this user may write to")]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A file cannot be read.
    #[error("{path}: cannot be read: {source}; {hint}")]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
        /// What makes this file.
        hint: &'static str,
    },
    /// A file is not what it should be.
    #[error("{path}: {reason}")]
    Content {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
}

/// What a file is called while it is written, before the writer's [`mark`].
const PARTIAL: &str = ".sdp3-partial-";
/// The file that tries whether the folder can be written to, before the writer's [`mark`].
const PROBE: &str = ".sdp3-probe-";

/// The machine's name: processes on several may share a folder.
fn machine() -> String {
    std::fs::read_to_string("/proc/sys/kernel/hostname")
        .map_or_else(|_| String::new(), |name| name.trim().into())
}

/// Who writes: `PROCESS@MACHINE`.
pub(crate) fn mark(process: u32) -> String {
    format!("{process}@{}", machine())
}

/// Whether another process of that number runs this program. Where the system does not say, it is taken to run.
fn runs(process: u32) -> bool {
    // "1234 (name) S ...": number, name, state
    let stat = |process: &str| {
        let text = std::fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
        let (name, state) = text.split_once('(')?.1.rsplit_once(") ")?;
        Some((name.to_owned(), state.starts_with(['Z', 'X'])))
    };
    match stat("self") {
        // a number may be given again: to this process, or to another program
        Some(this) => process != std::process::id() && stat(&process.to_string()) == Some(this),
        None => true,
    }
}

/// Files of this process that are not whole yet.
static UNFINISHED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

fn unfinished() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes what is half-written, and holds every thread that would begin or finish a file until the process ends: for a
/// program that is about to.
pub fn abandon() {
    let unfinished = unfinished();
    for file in unfinished.iter() {
        let _ = std::fs::remove_file(file);
    }
    std::mem::forget(unfinished);
}

/// Makes a folder, those above it too, and syncs the entry of each new one.
fn create_folder(folder: &Path) -> io::Result<()> {
    if folder.is_dir() {
        return Ok(());
    }
    let above = parent(folder);
    if let Some(above) = above {
        create_folder(above)?;
    }
    match std::fs::create_dir(folder) {
        // another process was faster
        Err(_) if folder.is_dir() => Ok(()),
        made => made.and_then(|()| sync_folder(above.unwrap_or(Path::new(".")))),
    }
}

/// The folder above, unless it is the working one.
fn parent(path: &Path) -> Option<&Path> {
    path.parent().filter(|above| !above.as_os_str().is_empty())
}

/// Makes the names in a folder durable, where the system can sync folders.
fn sync_folder(folder: &Path) -> io::Result<()> {
    if cfg!(not(unix)) {
        return Ok(());
    }
    match File::open(folder).and_then(|folder| folder.sync_all()) {
        // some network file systems sync files only
        Err(error) if matches!(error.kind(), io::ErrorKind::InvalidInput | io::ErrorKind::Unsupported) => {
            Ok(())
        }
        synced => synced,
    }
}

/// An output folder that is known to be writable.
#[derive(Debug, Clone)]
pub struct Output {
    folder: PathBuf,
    seed: Option<u64>,
}

/// What made a result. The date is the commit's, not today's: the same program makes the same bytes.
#[derive(Debug, Serialize)]
struct Provenance {
    program: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    commit: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    commit_date: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    seed: Option<u64>,
}

/// A result's file.
#[derive(Serialize)]
struct Stated<'a, T> {
    provenance: Provenance,
    #[serde(flatten)]
    result: &'a T,
}

impl Output {
    /// Makes the folder if need be, tries to write to it, and removes what killed runs left half-written.
    ///
    /// # Errors
    ///
    /// [`OutputError::Write`] naming the folder.
    pub fn create(folder: &Path) -> Result<Self, OutputError> {
        let output = Output { folder: folder.to_owned(), seed: None };
        let fail = |source| OutputError::Write { path: folder.to_owned(), source };
        create_folder(folder).map_err(fail)?;
        let probe = folder.join(format!("{PROBE}{}", mark(std::process::id())));
        std::fs::write(&probe, b"").and_then(|()| std::fs::remove_file(&probe)).map_err(fail)?;
        output.sweep()?;
        Ok(output)
    }

    /// Writes a file of its own, whole or not at all, in a folder that is made if need be; its path.
    ///
    /// # Errors
    ///
    /// [`OutputError::Write`] naming folder or file.
    pub(crate) fn write_file(file: &Path, bytes: &[u8]) -> Result<PathBuf, OutputError> {
        let folder = parent(file).unwrap_or(Path::new("."));
        Output::create(folder)?.write(&file.file_name().unwrap_or_default().to_string_lossy(), bytes)
    }

    /// The same folder for results of a seed.
    pub fn of_seed(self, seed: u64) -> Self {
        Output { seed: Some(seed), ..self }
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Path of a file in it.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// Writes a file, whole or not at all.
    ///
    /// # Errors
    ///
    /// [`OutputError::Write`] naming the file.
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<PathBuf, OutputError> {
        self.fill(name, |file| file.write_all(bytes))?;
        Ok(self.path(name))
    }

    /// Writes a file piece by piece, whole or not at all.
    ///
    /// # Errors
    ///
    /// [`OutputError::Write`] naming the file, also for what `fill` reports.
    pub fn fill<T>(
        &self,
        name: &str,
        fill: impl FnOnce(&mut BufWriter<File>) -> io::Result<T>,
    ) -> Result<T, OutputError> {
        let path = self.path(name);
        let fail = |source| OutputError::Write { path: path.clone(), source };
        let folder = parent(&path).unwrap_or(Path::new("."));
        create_folder(folder).map_err(fail)?;
        let mut partial = path.clone().into_os_string();
        partial.push(format!("{PARTIAL}{}", mark(std::process::id())));
        let partial = PathBuf::from(partial);
        unfinished().insert(partial.clone());
        let written = File::create(&partial).and_then(|file| {
            let mut file = BufWriter::with_capacity(1 << 16, file);
            let value = fill(&mut file)?;
            // the name must not be there before the bytes are
            file.into_inner().map_err(io::IntoInnerError::into_error)?.sync_all()?;
            Ok(value)
        });
        let mut unfinished = unfinished();
        let written = written.and_then(|value| std::fs::rename(&partial, &path).map(|()| value));
        if written.is_err() {
            let _ = std::fs::remove_file(&partial);
        }
        unfinished.remove(&partial);
        drop(unfinished);
        written.and_then(|value| sync_folder(folder).map(|()| value)).map_err(fail)
    }

    /// Removes what runs on this machine that were killed left half-written in the folder and the folders in it, unless that
    /// process still runs.
    fn sweep(&self) -> Result<(), OutputError> {
        let fail = |path: &Path| {
            let path = path.to_owned();
            move |source| OutputError::Write { path, source }
        };
        let machine = machine();
        let mut folders = vec![self.folder.clone()];
        while let Some(folder) = folders.pop() {
            let entries = match std::fs::read_dir(&folder) {
                Err(_) if folder != self.folder => continue, // somebody else's
                entries => entries.map_err(fail(&folder))?,
            };
            for entry in entries {
                let entry = entry.map_err(fail(&folder))?;
                if folder == self.folder && entry.file_type().is_ok_and(|kind| kind.is_dir()) {
                    folders.push(entry.path());
                }
                let name = entry.file_name().to_string_lossy().into_owned();
                let writer = name.rsplit_once(PARTIAL).map(|(_, writer)| writer).or(name.strip_prefix(PROBE));
                let here = writer.and_then(|writer| writer.split_once('@')).filter(|(_, at)| *at == machine);
                let process = here.and_then(|(process, _)| process.parse().ok());
                if process.is_none_or(runs) {
                    continue;
                }
                match std::fs::remove_file(entry.path()) {
                    Err(error) if error.kind() != io::ErrorKind::NotFound => {
                        return Err(fail(&entry.path())(error));
                    }
                    _ => {}
                }
            }
        }
        Ok(())
    }

    /// Writes a value as JSON.
    ///
    /// # Errors
    ///
    /// [`OutputError::Write`] naming the file.
    pub fn write_json(&self, name: &str, value: &impl Serialize) -> Result<PathBuf, OutputError> {
        self.write(name, format!("{}\n", to_json(value)).as_bytes())
    }

    /// Writes a result as JSON that begins with `provenance`: program, its commit and the commit's date where they are known, seed. It must be an object, no list.
    ///
    /// # Errors
    ///
    /// [`OutputError::Write`] naming the file.
    pub fn write_result(&self, name: &str, result: &impl Serialize) -> Result<PathBuf, OutputError> {
        let provenance =
            Provenance { program: PROGRAM, commit: COMMIT, commit_date: COMMIT_DATE, seed: self.seed };
        self.write_json(name, &Stated { provenance, result })
    }

    /// Reads a file.
    ///
    /// # Errors
    ///
    /// [`OutputError::Read`] naming the file and, by `hint`, what makes it.
    pub fn read(&self, name: &str, hint: &'static str) -> Result<Vec<u8>, OutputError> {
        let path = self.path(name);
        limited::read(&path, limited::WHOLE).map_err(|source| OutputError::Read { path, source, hint })
    }

    /// Reads a JSON file.
    ///
    /// # Errors
    ///
    /// [`OutputError::Read`], or [`OutputError::Content`] with line, column and field.
    pub fn read_json<T: DeserializeOwned>(&self, name: &str, hint: &'static str) -> Result<T, OutputError> {
        serde_json::from_slice(&self.read(name, hint)?)
            .map_err(|error| OutputError::Content { path: self.path(name), reason: error.to_string() })
    }
}

/// A value as indented JSON.
pub fn to_json(value: &impl Serialize) -> String {
    serde_json::to_string_pretty(value).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_result_states_what_made_it_and_is_read_as_before() {
        #[derive(Debug, PartialEq, Serialize, serde::Deserialize)]
        struct Found {
            rho: f64,
            slots: Vec<u32>,
        }
        let folder = tempfile::tempdir().unwrap();
        let output = Output::create(folder.path()).unwrap().of_seed(7);
        let found = Found { rho: 0.1 + 0.2, slots: vec![1, 2] };
        output.write_result("found.json", &found).unwrap();
        assert_eq!(output.read_json::<Found>("found.json", "").unwrap(), found);
        let whole: serde_json::Value = output.read_json("found.json", "").unwrap();
        assert_eq!(
            (&whole["provenance"]["program"], &whole["provenance"]["seed"]),
            (&PROGRAM.into(), &7.into())
        );
        let stated = |field: &str| whole["provenance"].get(field).and_then(|value| value.as_str());
        assert_eq!((stated("commit"), stated("commit_date")), (COMMIT, COMMIT_DATE));
    }

    #[test]
    fn files_appear_whole_and_leave_nothing_beside_them() {
        let folder = tempfile::tempdir().unwrap();
        let output = Output::create(&folder.path().join("a/b")).unwrap();
        output.write("models/x.bin", b"1").unwrap();
        output.write("models/x.bin", b"22").unwrap();
        assert_eq!(output.read("models/x.bin", "").unwrap(), b"22");
        assert_eq!(std::fs::read_dir(output.path("models")).unwrap().count(), 1);
        let error = output.fill("models/y.bin", |_| Err::<(), _>(io::Error::other("broken"))).unwrap_err();
        assert!(error.to_string().contains("y.bin") && error.to_string().contains("broken"), "{error}");
        assert_eq!(std::fs::read_dir(output.path("models")).unwrap().count(), 1);
        let error = Output::create(Path::new("/proc/nowhere")).unwrap_err().to_string();
        assert!(error.contains("/proc/nowhere") && error.contains("--out"), "{error}");
    }

    #[test]
    fn only_our_leftovers_of_dead_runs_are_swept() {
        let folder = tempfile::tempdir().unwrap();
        let output = Output::create(folder.path()).unwrap();
        // 4294967295 is no process
        let (own, dead) = (mark(std::process::id()), mark(4_294_967_295));
        let gone = [
            format!("a.npz.sdp3-partial-{dead}"),
            format!(".sdp3-probe-{dead}"),
            format!("models/b.sdp3-partial-{dead}"),
            format!("a.npz.sdp3-partial-{own}"),
        ];
        let kept = [
            "a.npz".into(),
            format!("b.txt.partial-{dead}"),
            "a.npz.sdp3-partial-".into(),
            "a.npz.sdp3-partial-x".into(),
            "a.npz.sdp3-partial-4294967295@elsewhere.invalid".into(),
        ];
        std::fs::create_dir(output.path("models")).unwrap();
        gone.iter().chain(&kept).for_each(|name| std::fs::write(output.path(name), b"").unwrap());
        Output::create(folder.path()).unwrap();
        assert!(gone.iter().all(|name| !output.path(name).exists()));
        assert!(kept.iter().all(|name| output.path(name).exists()));
    }
}
