//! Why a scenario cannot be used.

use crate::error::Invalid;
use std::path::PathBuf;

/// Why a scenario cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum ScenarioError {
    /// The file cannot be read.
    #[error("{file}: {source}")]
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
