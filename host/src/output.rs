//! The output folder: files appear whole or not at all.
//!
//! Every file is written beside its name and renamed over it.

use serde::Serialize;
use serde::de::DeserializeOwned;
use std::path::{Path, PathBuf};

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

/// An output folder that is known to be writable.
#[derive(Debug, Clone)]
pub struct Output {
    folder: PathBuf,
}

impl Output {
    /// Makes the folder if need be and tries to write to it.
    ///
    /// # Errors
    ///
    /// [`OutputError::Write`] naming the folder.
    pub fn create(folder: &Path) -> Result<Self, OutputError> {
        let output = Output { folder: folder.to_owned() };
        let fail = |source| OutputError::Write { path: folder.to_owned(), source };
        std::fs::create_dir_all(folder).map_err(fail)?;
        let probe = folder.join(format!(".sdp3-probe-{}", std::process::id()));
        std::fs::write(&probe, b"").and_then(|()| std::fs::remove_file(&probe)).map_err(fail)?;
        Ok(output)
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
        let path = self.path(name);
        let fail = |source| OutputError::Write { path: path.clone(), source };
        if let Some(parent) = path.parent() {
            std::fs::create_dir_all(parent).map_err(fail)?;
        }
        let mut partial = path.clone().into_os_string();
        partial.push(format!(".partial-{}", std::process::id()));
        let partial = PathBuf::from(partial);
        let written = std::fs::write(&partial, bytes).and_then(|()| std::fs::rename(&partial, &path));
        if written.is_err() {
            let _ = std::fs::remove_file(&partial);
        }
        written.map_err(fail)?;
        Ok(path)
    }

    /// Writes a value as JSON.
    ///
    /// # Errors
    ///
    /// [`OutputError::Write`] naming the file.
    pub fn write_json(&self, name: &str, value: &impl Serialize) -> Result<PathBuf, OutputError> {
        self.write(name, format!("{}\n", to_json(value)).as_bytes())
    }

    /// Reads a file.
    ///
    /// # Errors
    ///
    /// [`OutputError::Read`] naming the file and, by `hint`, what makes it.
    pub fn read(&self, name: &str, hint: &'static str) -> Result<Vec<u8>, OutputError> {
        let path = self.path(name);
        std::fs::read(&path).map_err(|source| OutputError::Read { path, source, hint })
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
    fn files_appear_whole_and_leave_nothing_beside_them() {
        let folder = tempfile::tempdir().unwrap();
        let output = Output::create(&folder.path().join("a/b")).unwrap();
        output.write("models/x.bin", b"1").unwrap();
        output.write("models/x.bin", b"22").unwrap();
        assert_eq!(output.read("models/x.bin", "").unwrap(), b"22");
        assert_eq!(std::fs::read_dir(output.path("models")).unwrap().count(), 1);
        let error = Output::create(Path::new("/proc/nowhere")).unwrap_err().to_string();
        assert!(error.contains("/proc/nowhere") && error.contains("--out"), "{error}");
    }
}
