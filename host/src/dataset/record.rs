//! What is said of a dataset's files and recordings: length and SHA-256, label and truth.

use crate::scenario::Class;
use crate::simulator::body::motion::GroundTruth;
use crate::store::output::{Output, OutputError};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::fs::File;
use std::io::{self, Write};

/// A file of the dataset.
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
        FileRecord { name, bytes: content.len() as u64, sha256: sha256(content) }
    }

    /// Describes a file that is there.
    ///
    /// # Errors
    ///
    /// [`OutputError::Read`] naming the file.
    pub fn of(output: &Output, name: &str) -> Result<Self, OutputError> {
        let path = output.path(name);
        let read = || {
            let mut hash = Hash(Sha256::new());
            let bytes = io::copy(&mut File::open(&path)?, &mut hash)?;
            Ok(FileRecord { name: name.to_owned(), bytes, sha256: hex(&hash.0.finalize()) })
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

/// A running SHA-256 that is written to.
pub(super) struct Hash(pub Sha256);

impl Write for Hash {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.update(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// What is true of a recording.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(from = "Row", into = "Row")]
pub struct TruthRecord {
    /// Its number in the dataset.
    pub index: u32,
    /// Its label, an index into the classes.
    pub label: u8,
    /// The person.
    pub truth: GroundTruth,
}

/// The same as one flat object. serde's `flatten` would read no number where another crate of the program has turned on
/// serde_json's `arbitrary_precision`.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Row {
    index: u32,
    label: u8,
    class: Class,
    child: bool,
    height_m: f64,
    speed_m_s: f64,
    heading_deg: f64,
    phase: f64,
    start_m: [f64; 2],
}

impl From<Row> for TruthRecord {
    fn from(row: Row) -> Self {
        let Row { index, label, class, child, height_m, speed_m_s, heading_deg, phase, start_m } = row;
        let truth = GroundTruth { class, child, height_m, speed_m_s, heading_deg, phase, start_m };
        TruthRecord { index, label, truth }
    }
}

impl From<TruthRecord> for Row {
    fn from(record: TruthRecord) -> Self {
        let TruthRecord { index, label, truth } = record;
        let GroundTruth { class, child, height_m, speed_m_s, heading_deg, phase, start_m } = truth;
        Row { index, label, class, child, height_m, speed_m_s, heading_deg, phase, start_m }
    }
}

/// SHA-256 of content, in hexadecimal.
pub fn sha256(content: &[u8]) -> String {
    hex(&Sha256::digest(content))
}

/// Bytes in hexadecimal.
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
