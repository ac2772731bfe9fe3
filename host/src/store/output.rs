//! The output folder: files appear whole or not at all.
//!
//! Every file is written beside its name ([`super::partial`]), synced, and renamed over it; then the folder is synced, so that this also
//! holds when the power fails.

use super::difference::difference;
use super::digest::{sealed, sha256, unseal};
use super::partial::{Partial, Swept, sweep};
use crate::error::Invalid;
use crate::store::limited;
use crate::{COMMIT, COMMIT_DATE, PROGRAM};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Component::Normal, Path, PathBuf};

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
    scenario_sha256: Option<String>,
    leftover: Option<PathBuf>,
}

/// What made a result. The date is the commit's, not today's: the same program makes the same bytes.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Provenance {
    program: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    commit: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    commit_date: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) seed: Option<u64>,
    /// Of the scenario's text.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) scenario_sha256: Option<String>,
    /// Of the file's own text with an empty `sha256`.
    sha256: String,
}

impl Provenance {
    /// The first field that shows that another run made it: its name, its value here, and there.
    pub(crate) fn other_run(&self, other: &Self) -> Option<(String, String, String)> {
        let run = |of: &Self| {
            serde_json::to_value(Provenance { sha256: String::new(), ..of.clone() }).unwrap_or_default()
        };
        difference("", &run(self), &run(other))
    }
}

/// A result's file.
#[derive(Serialize)]
struct Stated<'a, T> {
    provenance: Provenance,
    #[serde(flatten)]
    result: &'a T,
}

/// What is read of it first.
#[derive(Deserialize)]
struct Head {
    provenance: Provenance,
}

impl Output {
    /// Makes the folder if need be, tries to write to it, and removes what killed runs left half-written.
    ///
    /// # Errors
    ///
    /// [`OutputError::Write`] naming the folder.
    pub fn create(folder: &Path) -> Result<Self, OutputError> {
        let mut output = Output::reading(folder);
        let fail = |source| OutputError::Write { path: folder.to_owned(), source };
        create_folder(folder).map_err(fail)?;
        drop(Partial::create(&folder.join(".probe")).map_err(fail)?);
        output.leftover = output.sweep()?;
        Ok(output)
    }

    /// A folder to read from: nothing in it is touched.
    pub(crate) fn reading(folder: &Path) -> Self {
        Output { folder: folder.to_owned(), seed: None, scenario_sha256: None, leftover: None }
    }

    /// A half-written file of which nobody can say whether its writer still lives: the file system has no locks.
    pub fn leftover(&self) -> Option<&Path> {
        self.leftover.as_deref()
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

    /// The same folder for results of a scenario, given as its text.
    pub fn of_scenario(self, text: &str) -> Self {
        Output { scenario_sha256: Some(sha256([text.as_bytes()])), ..self }
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
        self.refuse_elsewhere(name)?;
        create_folder(folder).map_err(fail)?;
        let written = Partial::create(&path).and_then(|mut partial| {
            let value = fill(partial.file())?;
            partial.finish()?;
            sync_folder(folder)?;
            Ok(value)
        });
        written.map_err(fail)
    }

    /// Refuses a name that leads out of the output folder, and one in a folder that is a link: the file would be written elsewhere.
    fn refuse_elsewhere(&self, name: &str) -> Result<(), OutputError> {
        let inside = !name.is_empty() && Path::new(name).components().all(|part| matches!(part, Normal(_)));
        Invalid::unless(inside, "name of a file", format!("{name:?}"), "one in the folder")
            .map_err(|refused| OutputError::Content { path: self.path(""), reason: refused.to_string() })?;
        let mut inner = Path::new(name).ancestors().skip(1).map(|above| self.folder.join(above));
        match inner.find(|path| *path != self.folder && path.is_symlink()) {
            Some(path) => {
                let reason = Invalid::new("kind of entry", "a link", "a folder").to_string();
                Err(OutputError::Content { path, reason })
            }
            None => Ok(()),
        }
    }

    /// Removes what writers that no longer live left half-written in the folder and the folders in it; a file that may be such a one.
    fn sweep(&self) -> Result<Option<PathBuf>, OutputError> {
        let fail = |path: &Path| {
            let path = path.to_owned();
            move |source| OutputError::Write { path, source }
        };
        let (mut folders, mut unknown) = (vec![self.folder.clone()], None);
        while let Some(folder) = folders.pop() {
            let entries = match std::fs::read_dir(&folder) {
                Err(_) if folder != self.folder => continue, // somebody else's
                entries => entries.map_err(fail(&folder))?,
            };
            for entry in entries {
                let entry = entry.map_err(fail(&folder))?;
                let path = entry.path();
                if folder == self.folder && entry.file_type().is_ok_and(|kind| kind.is_dir()) {
                    folders.push(path);
                } else if sweep(&path).map_err(fail(&path))? == Swept::Unknown {
                    unknown = Some(path);
                }
            }
        }
        Ok(unknown)
    }

    /// Writes a value as JSON.
    ///
    /// # Errors
    ///
    /// [`OutputError::Write`] naming the file.
    pub fn write_json(&self, name: &str, value: &impl Serialize) -> Result<PathBuf, OutputError> {
        self.write(name, format!("{}\n", to_json(value)).as_bytes())
    }

    /// Writes a result as JSON that begins with `provenance`: program, its commit and the commit's date where they are known, seed, scenario,
    /// digest. It must be an object, no list.
    ///
    /// # Errors
    ///
    /// [`OutputError::Write`] naming the file.
    pub fn write_result(&self, name: &str, result: &impl Serialize) -> Result<PathBuf, OutputError> {
        let provenance = Provenance {
            program: PROGRAM.into(),
            commit: COMMIT.map(Into::into),
            commit_date: COMMIT_DATE.map(Into::into),
            seed: self.seed,
            scenario_sha256: self.scenario_sha256.clone(),
            sha256: String::new(),
        };
        let open = to_json(&Stated { provenance, result }) + "\n";
        self.write(name, sealed(&open).as_bytes())
    }

    /// Reads a result that [`Self::write_result`] wrote, and what made it.
    ///
    /// # Errors
    ///
    /// [`OutputError::Read`], or [`OutputError::Content`]: no result, or one that was changed.
    pub(crate) fn read_result<T: DeserializeOwned>(
        &self,
        name: &str,
        hint: &'static str,
    ) -> Result<(T, Provenance), OutputError> {
        let refuse = |reason: String| OutputError::Content { path: self.path(name), reason };
        let text = String::from_utf8(self.read(name, hint)?).map_err(|error| refuse(error.to_string()))?;
        let Head { provenance } = serde_json::from_str(&text).map_err(|error| refuse(error.to_string()))?;
        unseal(&text, &provenance.sha256).map_err(|reason| refuse(format!("changed: {reason}; {hint}")))?;
        Ok((serde_json::from_str(&text).map_err(|error| refuse(error.to_string()))?, provenance))
    }

    /// Reads a file.
    ///
    /// # Errors
    ///
    /// [`OutputError::Read`] naming the file and, by `hint`, what makes it.
    pub fn read(&self, name: &str, hint: &'static str) -> Result<Vec<u8>, OutputError> {
        let path = self.path(name);
        limited::read(&path, limited::RESULT).map_err(|source| OutputError::Read { path, source, hint })
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
        let (read, provenance) = output.read_result::<Found>("found.json", "").unwrap();
        assert_eq!((&read, provenance.scenario_sha256), (&found, None));
        let text = String::from_utf8(output.read("found.json", "").unwrap()).unwrap();
        for (from, to) in
            [("1,", "3,"), ("\"seed\": 7", "\"seed\": 8"), ("\"sha256\": \"", "\"sha256\": \"0")]
        {
            assert!(text.contains(from), "{from}");
            output.write("edited.json", text.replacen(from, to, 1).as_bytes()).unwrap();
            let error =
                output.read_result::<Found>("edited.json", "a new run makes it").unwrap_err().to_string();
            assert!(error.contains("edited.json: changed: sha256") && error.contains("a new run"), "{error}");
        }
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
        let elsewhere = ["../x", "models/../../x", "/x", ""].map(|name| output.write(name, b"").unwrap_err());
        assert!(elsewhere.iter().all(|error| error.to_string().contains("name of a file")), "{elsewhere:?}");
        let error = Output::create(Path::new("/proc/nowhere")).unwrap_err().to_string();
        assert!(error.contains("/proc/nowhere") && error.contains("--out"), "{error}");
    }

    #[test]
    fn leftovers_are_swept_in_the_folder_and_those_in_it() {
        let folder = tempfile::tempdir().unwrap();
        let output = Output::create(folder.path()).unwrap();
        std::fs::create_dir_all(output.path("models/deeper")).unwrap();
        let left = |name: &str| output.path(&format!("{name}.sdp3-partial-0123456789abcdef"));
        let names = ["a.npz", "models/b", "models/deeper/c"];
        names.iter().for_each(|name| std::fs::write(left(name), b"").unwrap());
        let again = Output::create(folder.path()).unwrap();
        assert_eq!(names.map(|name| left(name).exists()), [false, false, true]);
        assert_eq!(again.leftover(), None);
    }
}
