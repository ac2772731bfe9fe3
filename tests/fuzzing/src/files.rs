//! Bytes as a file, for readers that open one.

use std::path::{Path, PathBuf};

/// A file in memory where the system has such a folder; each process has one of every extension.
#[derive(Debug)]
pub struct File(PathBuf);

impl File {
    /// Writes it.
    pub fn new(extension: &str, bytes: &[u8]) -> Self {
        let memory = Path::new("/dev/shm");
        let folder = if memory.is_dir() { memory.to_owned() } else { std::env::temp_dir() };
        let path = folder.join(format!("sdp3-fuzz-{}.{extension}", std::process::id()));
        std::fs::write(&path, bytes).expect("a file for the reader");
        File(path)
    }

    /// Where it lies.
    pub fn path(&self) -> &Path {
        &self.0
    }
}
