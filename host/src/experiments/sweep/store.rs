//! A measured cell in its file: a [`record`] that belongs to a plan's digest and a cell, `cells/00000.json`.

use super::plan::Sweep;
use crate::results::{Cell, Measurement};
use crate::store::output::{Output, OutputError};
use crate::store::record::{self, Fault, Identity, value};
use std::path::{Path, PathBuf};

/// Folder of the cells.
pub const CELLS: &str = "cells";

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

    fn identity(&self, cell: &Cell) -> Identity {
        vec![("plan", value(&self.sweep.digest)), ("cell", value(cell))]
    }

    /// Keeps a measurement in the sweep's folder.
    ///
    /// # Errors
    ///
    /// [`OutputError::Write`] naming the file.
    pub fn keep(&self, output: &Output, measurement: &Measurement) -> Result<(), OutputError> {
        let file = format!("{CELLS}/{}", name(measurement.cell.index));
        record::write(output, &file, &self.identity(&measurement.cell), measurement)
    }

    /// The measurement of a cell, or what is wrong with its file.
    ///
    /// # Errors
    ///
    /// [`OutputError::Read`] naming a file that is there and cannot be read.
    pub fn read(&self, cell: &Cell) -> Result<Result<Measurement, Fault>, OutputError> {
        record::read(&self.path(cell), &self.identity(cell))
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
