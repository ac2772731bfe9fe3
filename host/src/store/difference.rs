//! Where two values of JSON differ.

use serde_json::Value;
use std::collections::BTreeSet;

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
