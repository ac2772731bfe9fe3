//! Accuracy points as CSV: `sensing_slots,accuracy[,tested]` with a header line.

use crate::results::CurvePoint;
use std::path::{Path, PathBuf};

/// Why a file of points cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum PointsError {
    /// It cannot be read.
    #[error("{file}: {source}")]
    Read {
        /// The file.
        file: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A line or field is not what it should be.
    #[error("{file}, line {line}: {field} = {value:?} is outside its legal range: {legal}")]
    Value {
        /// The file.
        file: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Field.
        field: &'static str,
        /// What stands there.
        value: String,
        /// The legal range.
        legal: &'static str,
    },
}

/// Reads points.
///
/// # Errors
///
/// [`PointsError`] names file, line, field, value and legal range.
pub fn read(file: &Path) -> Result<Vec<CurvePoint>, PointsError> {
    let text = std::fs::read_to_string(file)
        .map_err(|source| PointsError::Read { file: file.to_owned(), source })?;
    let refuse = |line: usize, field, value: &str, legal| PointsError::Value {
        file: file.to_owned(),
        line,
        field,
        value: value.to_owned(),
        legal,
    };
    let mut lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    let header = lines.next().map_or("", |(_, line)| line.trim());
    if !matches!(header, "sensing_slots,accuracy" | "sensing_slots,accuracy,tested") {
        return Err(refuse(1, "header", header, "sensing_slots,accuracy or sensing_slots,accuracy,tested"));
    }
    lines
        .map(|(index, line)| {
            let cells: Vec<&str> = line.split(',').map(str::trim).collect();
            let cell = |k: usize| cells.get(k).copied().unwrap_or("");
            let number = |k: usize| cell(k).parse::<f64>().ok().filter(|x| x.is_finite());
            let slots = number(0).filter(|&n| n > 1.0);
            let accuracy = number(1).filter(|a| (0.0..=1.0).contains(a));
            let tested = number(2).filter(|&n| n >= 2.0);
            if cells.len() > 2 && tested.is_none() {
                return Err(refuse(index + 1, "tested", cell(2), "a number of recordings, at least 2"));
            }
            Ok(CurvePoint {
                sensing_slots: slots.ok_or_else(|| {
                    refuse(index + 1, "sensing_slots", cell(0), "a number of slots above 1")
                })?,
                accuracy: accuracy.ok_or_else(|| refuse(index + 1, "accuracy", cell(1), "0..=1"))?,
                tested,
            })
        })
        .collect()
}
