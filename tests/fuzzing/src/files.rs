//! Bytes as a file, for readers that open one.

use std::path::{Path, PathBuf};

/// Where a process keeps its files: in memory where the system has such a folder.
pub fn place(name: &str) -> PathBuf {
    let memory = Path::new("/dev/shm");
    let folder = if memory.is_dir() { memory.to_owned() } else { std::env::temp_dir() };
    folder.join(format!("sdp3-fuzz-{}{name}", std::process::id()))
}

/// A file; each process has one of every extension.
#[derive(Debug)]
pub struct File(PathBuf);

impl File {
    /// Writes it.
    pub fn new(extension: &str, bytes: &[u8]) -> Self {
        let path = place(&format!(".{extension}"));
        std::fs::write(&path, bytes).expect("a file for the reader");
        File(path)
    }

    /// Where it lies.
    pub fn path(&self) -> &Path {
        &self.0
    }
}

/// A folder of files; each process has one.
#[derive(Debug)]
pub struct Folder(PathBuf);

impl Folder {
    /// Makes it with these files in it; others of before may be there too.
    pub fn new(files: &[(&str, &[u8])]) -> Self {
        let folder = place("");
        for (name, bytes) in files {
            let file = folder.join(name);
            std::fs::create_dir_all(file.parent().expect("a file in the folder"))
                .expect("a folder for the reader");
            std::fs::write(file, bytes).expect("a file for the reader");
        }
        Folder(folder)
    }

    /// Where it lies.
    pub fn path(&self) -> &Path {
        &self.0
    }
}
