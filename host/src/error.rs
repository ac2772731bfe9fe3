//! Why a command fails.

/// Any refusal or failure of a command: exit code 2.
pub type Failure = Box<dyn std::error::Error + Send + Sync>;
