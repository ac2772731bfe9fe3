//! A measured cell in its file, which says what it belongs to and whether it is whole.
//!
//! `cells/00000.json` holds the program, the plan's digest, the measurement, and the SHA-256 of the file's own text with an empty
//! `sha256`. Whole is a file that is, byte for byte, what its content would be written as.

use super::plan::Sweep;
use crate::PROGRAM;
use crate::dataset::sha256;
use crate::results::{Cell, Measurement};
use crate::store::limited;
use crate::store::output::{Output, OutputError, to_json};
use serde::{Deserialize, Serialize};
use std::io;
use std::path::{Path, PathBuf};

/// Folder of the cells.
pub const CELLS: &str = "cells";

/// What a cell's file holds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Kept {
    program: String,
    plan: String,
    sha256: String,
    measurement: Measurement,
}

impl Kept {
    fn new(plan: &str, measurement: Measurement) -> Self {
        let open = Kept { program: PROGRAM.into(), plan: plan.into(), sha256: String::new(), measurement };
        open.sealed()
    }

    fn sealed(self) -> Self {
        let open = Kept { sha256: String::new(), ..self };
        Kept { sha256: sha256(open.text().as_bytes()), ..open }
    }

    fn text(&self) -> String {
        format!("{}\n", to_json(self))
    }
}

/// Why a cell cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Fault {
    /// There is no file.
    #[error("missing")]
    Missing,
    /// The file is not what was written.
    #[error("damaged: {0}")]
    Damaged(String),
    /// The file is whole, and of another plan, program or cell.
    #[error("foreign: {0}")]
    Foreign(String),
}

/// Name of a cell's file in [`CELLS`].
fn name(index: u32) -> String {
    format!("{index:05}.json")
}

/// The folder of a sweep's cells.
#[derive(Debug)]
pub struct Store<'a> {
    sweep: &'a Sweep,
    cells: PathBuf,
}

impl<'a> Store<'a> {
    /// The cells in a folder that is known to belong to `sweep`.
    pub fn of(sweep: &'a Sweep, folder: &Path) -> Self {
        Store { sweep, cells: folder.join(CELLS) }
    }

    /// Path of a cell's file.
    pub fn path(&self, cell: &Cell) -> PathBuf {
        self.cells.join(name(cell.index))
    }

    /// Keeps a measurement in the sweep's folder.
    ///
    /// # Errors
    ///
    /// [`OutputError::Write`] naming the file.
    pub fn keep(&self, output: &Output, measurement: Measurement) -> Result<(), OutputError> {
        let file = format!("{CELLS}/{}", name(measurement.cell.index));
        output.write(&file, Kept::new(&self.sweep.digest, measurement).text().as_bytes())?;
        Ok(())
    }

    /// The measurement of a cell, or what is wrong with its file.
    ///
    /// # Errors
    ///
    /// [`OutputError::Read`] naming a file that is there and cannot be read.
    pub fn read(&self, cell: &Cell) -> Result<Result<Measurement, Fault>, OutputError> {
        let path = self.path(cell);
        match limited::read(&path, limited::TEXT) {
            Ok(bytes) => Ok(self.check(&bytes, cell)),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(Err(Fault::Missing)),
            Err(source) => Err(OutputError::Read { path, source, hint: "a shard of the sweep wrote it" }),
        }
    }

    fn check(&self, bytes: &[u8], cell: &Cell) -> Result<Measurement, Fault> {
        let kept: Kept = serde_json::from_slice(bytes).map_err(|error| Fault::Damaged(error.to_string()))?;
        let sealed = kept.clone().sealed();
        if sealed.text().as_bytes() != bytes {
            let found = sha256(Kept { sha256: String::new(), ..kept.clone() }.text().as_bytes());
            return Err(Fault::Damaged(format!("sha256 = {:?}, its content's is {found}", kept.sha256)));
        }
        let differs = |field: &str, found: &str, legal: &str| match found == legal {
            true => Ok(()),
            false => Err(Fault::Foreign(format!("{field} = {found:?}, this sweep's is {legal:?}"))),
        };
        differs("program", &kept.program, PROGRAM)?;
        differs("plan", &kept.plan, &self.sweep.digest)?;
        let [found, legal] =
            [&kept.measurement.cell, cell].map(|cell| serde_json::to_string(cell).unwrap_or_default());
        differs("cell", &found, &legal)?;
        Ok(kept.measurement)
    }

    /// Files of the folder that look like cells and are none of the plan's; none where there is no folder.
    ///
    /// # Errors
    ///
    /// [`OutputError::Read`] naming the folder.
    pub fn unexpected_files(&self) -> Result<Vec<String>, OutputError> {
        let fail = |source| OutputError::Read {
            path: self.cells.clone(),
            source,
            hint: "shards of the sweep make it",
        };
        let mut names = Vec::new();
        if !self.cells.exists() {
            return Ok(names);
        }
        for entry in std::fs::read_dir(&self.cells).map_err(fail)? {
            let file = entry.map_err(fail)?.file_name().to_string_lossy().into_owned();
            let number = file.strip_suffix(".json").and_then(|number| number.parse::<usize>().ok());
            let known = number.is_some_and(|n| n < self.sweep.cells.len() && file == name(n as u32));
            if file.ends_with(".json") && !known {
                names.push(file);
            }
        }
        names.sort();
        Ok(names)
    }
}
