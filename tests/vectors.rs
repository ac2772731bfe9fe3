//! Oracles' vectors as their JSON holds them.

use base64::Engine;
use serde_json::Value;

/// Bytes, from Base64.
///
/// # Panics
///
/// If it is something else.
pub fn bytes(value: &Value) -> Vec<u8> {
    base64::engine::general_purpose::STANDARD.decode(value.as_str().expect("base64 text")).expect("base64")
}

/// Signed bytes, from Base64.
///
/// # Panics
///
/// If it is something else.
pub fn signed(value: &Value) -> Vec<i8> {
    bytes(value).into_iter().map(u8::cast_signed).collect()
}

/// A list.
///
/// # Panics
///
/// If it is something else.
pub fn list(value: &Value) -> &Vec<Value> {
    value.as_array().expect("a list")
}
