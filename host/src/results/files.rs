//! What commands about files and scenarios answer.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The files a command has written.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Files(pub Vec<String>);

/// A built-in scenario.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Listed {
    /// Its name, which `--scenario` takes.
    pub name: String,
    /// What it is for.
    pub about: String,
}

/// A scenario file that was checked.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Checked {
    /// The file.
    pub file: String,
    /// Everything that is wrong with it; nothing if it may be used.
    pub errors: Vec<String>,
}
