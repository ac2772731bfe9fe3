//! Whether a folder may be gone on with: what it says of itself must be what is asked for.

use super::difference::difference;
use super::output::{Output, OutputError};
use serde_json::Value;

const CURE: &str = "use another --out, or remove this folder";

/// Refuses a file that is there and says something else than `asked`; nothing in the folder is touched.
///
/// # Errors
///
/// [`OutputError::Read`] and [`OutputError::Content`], which names the first field that differs, with both values.
pub fn ensure_same_config(
    output: &Output,
    name: &str,
    asked: &Value,
    parse: impl Fn(&str) -> Result<Value, String>,
) -> Result<(), OutputError> {
    if !output.path(name).exists() {
        return Ok(());
    }
    let refuse = |reason: String| OutputError::Content { path: output.path(name), reason };
    let text = output.read(name, CURE)?;
    let found = parse(&String::from_utf8_lossy(&text)).map_err(|e| refuse(format!("{e}; {CURE}")))?;
    match difference("", &found, asked) {
        None => Ok(()),
        Some((field, found, asked)) => Err(refuse(format!(
            "{field} = {found}, but this command says {asked}: only the same options resume what is there; {CURE}"
        ))),
    }
}
