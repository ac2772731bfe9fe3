//! Files by name, length and digest.

use super::digest::{Hash, sha256};
use super::output::{Output, OutputError};
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{self, BufReader};

/// Bytes of a file that are read at a time: they stay in the cache.
const PIECE: usize = 1 << 17;

/// A file by name, length and digest.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FileRecord {
    /// Its name in the folder.
    pub name: String,
    /// Its length.
    pub bytes: u64,
    /// SHA-256 of its content.
    pub sha256: String,
}

impl FileRecord {
    /// Describes content.
    pub fn new(name: String, content: &[u8]) -> Self {
        FileRecord { name, bytes: content.len() as u64, sha256: sha256([content]) }
    }

    /// Describes a file that is there.
    ///
    /// # Errors
    ///
    /// [`OutputError::Read`] naming the file.
    pub fn of(output: &Output, name: &str) -> Result<Self, OutputError> {
        let path = output.path(name);
        let read = || {
            let mut hash = Hash::default();
            let mut file = BufReader::with_capacity(PIECE, File::open(&path)?);
            let bytes = io::copy(&mut file, &mut hash)?;
            Ok(FileRecord { name: name.to_owned(), bytes, sha256: hash.hex() })
        };
        read().map_err(|source| OutputError::Read {
            path: path.clone(),
            source,
            hint: "the dataset was just written there",
        })
    }

    /// Whether the file is as described; without `read`, its length must do.
    pub fn is_there(&self, output: &Output, read: bool) -> bool {
        std::fs::metadata(output.path(&self.name)).is_ok_and(|found| found.len() == self.bytes)
            && (!read || Self::of(output, &self.name).is_ok_and(|found| found == *self))
    }
}
