//! Why a scenario cannot be used.

use crate::error::Invalid;
use std::path::{Path, PathBuf};

/// Why a scenario cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum ScenarioError {
    /// The file cannot be read.
    #[error("{file}: {source}{}", hint(file))]
    Read {
        /// The file.
        file: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The file is not TOML, or has a key or a type that a scenario does not have.
    #[error("{file}: {message}")]
    Syntax {
        /// The file.
        file: PathBuf,
        /// Line, key and the keys there are.
        message: String,
    },
    /// A field that may not be what it is.
    #[error(transparent)]
    Invalid(#[from] Invalid),
}

/// What may be meant by a word that is no file.
fn hint(file: &Path) -> &'static str {
    match file.extension().is_none() && file.components().count() == 1 {
        true => "; `sdp3 scenario list` has the names of scenarios that come with the tool",
        false => "",
    }
}
