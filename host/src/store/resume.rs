//! Whether a folder may be gone on with: what it says of itself must be what is asked for.

use crate::store::output::{Output, OutputError};
use serde_json::Value;
use std::collections::BTreeSet;

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

/// The first field that differs, with both values.
pub fn difference(field: &str, found: &Value, asked: &Value) -> Option<(String, String, String)> {
    match (found, asked) {
        (Value::Object(found), Value::Object(asked)) => {
            let keys: BTreeSet<&String> = found.keys().chain(asked.keys()).collect();
            keys.into_iter().find_map(|key| {
                let name = if field.is_empty() { key.clone() } else { format!("{field}.{key}") };
                let value = |of: &serde_json::Map<String, Value>| of.get(key).cloned().unwrap_or_default();
                difference(&name, &value(found), &value(asked))
            })
        }
        (Value::Array(found), Value::Array(asked)) if found.len() == asked.len() => {
            let pairs = found.iter().zip(asked).enumerate();
            pairs.filter_map(|(k, (found, asked))| difference(&format!("{field}[{k}]"), found, asked)).next()
        }
        _ if found == asked => None,
        _ => Some((field.to_owned(), found.to_string(), asked.to_string())),
    }
}
