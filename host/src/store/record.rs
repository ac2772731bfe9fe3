//! A result in a file that says what made it, what it belongs to, and whether it is whole.
//!
//! The file is an object of `program`, `sha256`, `identity` and `content`. `sha256` is the SHA-256 of the file's own text with an
//! empty `sha256`.

use super::difference::difference;
use super::digest::{sealed, unseal};
use super::limited;
use super::output::{Output, OutputError, to_json};
use crate::PROGRAM;
use crate::error::Invalid;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::io::ErrorKind;
use std::path::Path;

/// What a record belongs to: names and values, in the order in which they are compared.
pub type Identity = Vec<(&'static str, Value)>;

/// A value of an [`Identity`].
pub fn value(of: &impl Serialize) -> Value {
    serde_json::to_value(of).unwrap_or_default()
}

/// A record as it is written.
#[derive(Serialize)]
struct Written<'a, T> {
    program: &'a str,
    sha256: &'a str,
    identity: Map<String, Value>,
    content: &'a T,
}

/// What is read of a record before its content.
#[derive(Deserialize)]
struct Head {
    program: String,
    sha256: String,
    identity: Map<String, Value>,
}

/// What is read of it then.
#[derive(Deserialize)]
struct Body<T> {
    content: T,
}

/// Why a record cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Fault {
    /// There is no file.
    #[error("missing")]
    Missing,
    /// The file is not what was written.
    #[error("damaged: {0}")]
    Damaged(String),
    /// The file is whole, and of another program or of something else.
    #[error("foreign: {0}")]
    Foreign(Invalid),
}

impl Fault {
    /// The refusal of a file with this fault; `cure` says what helps.
    pub fn refusal(self, path: &Path, cure: &str) -> OutputError {
        OutputError::Content { path: path.to_owned(), reason: format!("{self}; {cure}") }
    }
}

/// Writes a record, whole or not at all.
///
/// # Errors
///
/// [`OutputError::Write`] naming the file.
pub fn write(
    output: &Output,
    name: &str,
    identity: &Identity,
    content: &impl Serialize,
) -> Result<(), OutputError> {
    let identity = identity.iter().map(|(field, value)| ((*field).to_owned(), value.clone())).collect();
    let open = to_json(&Written { program: PROGRAM, sha256: "", identity, content }) + "\n";
    output.write(name, sealed(&open).as_bytes())?;
    Ok(())
}

/// The content of a record that belongs to `identity`, or what is wrong with it.
///
/// # Errors
///
/// [`OutputError::Read`] naming a file that is there and cannot be read.
pub fn read<T: DeserializeOwned>(path: &Path, identity: &Identity) -> Result<Result<T, Fault>, OutputError> {
    match limited::read(path, limited::RESULT) {
        Ok(bytes) => Ok(content(&bytes, identity)),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(Err(Fault::Missing)),
        Err(source) => {
            let hint = "the command that needs it writes it";
            Err(OutputError::Read { path: path.to_owned(), source, hint })
        }
    }
}

fn content<T: DeserializeOwned>(bytes: &[u8], identity: &Identity) -> Result<T, Fault> {
    let damaged = |error: &dyn std::fmt::Display| Fault::Damaged(error.to_string());
    let text = str::from_utf8(bytes).map_err(|error| damaged(&error))?;
    let head: Head = serde_json::from_str(text).map_err(|error| damaged(&error))?;
    unseal(text, &head.sha256).map_err(Fault::Damaged)?;
    let mut known = head.identity;
    let fields =
        identity.iter().map(|(field, legal)| (*field, known.remove(*field).unwrap_or_default(), legal));
    let program = [("program", Value::from(head.program), &Value::from(PROGRAM))];
    let different =
        program.into_iter().chain(fields).find_map(|(name, value, legal)| difference(name, &value, legal));
    if let Some((field, value, legal)) = different {
        return Err(Fault::Foreign(Invalid::new(field, value, legal)));
    }
    let body: Body<T> = serde_json::from_str(text).map_err(|error| damaged(&error))?;
    Ok(body.content)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn identity(seed: u64) -> Identity {
        vec![("study", value(&"curve")), ("seed", value(&seed))]
    }

    fn folder() -> (tempfile::TempDir, Output) {
        let folder = tempfile::tempdir().unwrap();
        let output = Output::create(folder.path()).unwrap();
        (folder, output)
    }

    #[test]
    fn a_record_is_read_back_with_every_bit() {
        let (_folder, output) = folder();
        let content = (vec![0.1 + 0.2, f64::MIN_POSITIVE], 0.1_f32, u64::MAX, "\"sha256\": \"\"".to_owned());
        write(&output, "a.json", &identity(u64::MAX), &content).unwrap();
        let path = output.path("a.json");
        assert_eq!(read(&path, &identity(u64::MAX)).unwrap(), Ok(content));
        assert_eq!(read::<u8>(&output.path("b.json"), &identity(1)).unwrap(), Err(Fault::Missing));
        assert!(read::<u8>(output.folder(), &identity(1)).is_err());
    }

    #[test]
    fn every_changed_byte_is_seen() {
        let (_folder, output) = folder();
        write(&output, "a.json", &identity(1), &[1.5, 2.5]).unwrap();
        let path = output.path("a.json");
        let bytes = std::fs::read(&path).unwrap();
        for position in 0..bytes.len() {
            let mut changed = bytes.clone();
            changed[position] ^= 1 << (position % 7);
            let found = content::<[f64; 2]>(&changed, &identity(1));
            assert!(matches!(found, Err(Fault::Damaged(_))), "byte {position}: {found:?}");
            assert!(matches!(content::<[f64; 2]>(&bytes[..position], &identity(1)), Err(Fault::Damaged(_))));
        }
        let longer = [&bytes[..], b"\n"].concat();
        assert!(matches!(content::<[f64; 2]>(&longer, &identity(1)), Err(Fault::Damaged(_))));
    }

    #[test]
    fn a_foreign_record_is_refused_by_field_value_and_legal_value() {
        let (_folder, output) = folder();
        write(&output, "a.json", &identity(1), &1).unwrap();
        let refusal = |identity: &Identity| {
            read::<i32>(&output.path("a.json"), identity).unwrap().unwrap_err().to_string()
        };
        assert_eq!(refusal(&identity(2)), "foreign: seed is 1, must be 2");
        let other = vec![("study", value(&"other")), ("seed", value(&2))];
        assert_eq!(refusal(&other), "foreign: study is \"curve\", must be \"other\"");
        let text = std::fs::read_to_string(output.path("a.json")).unwrap();
        assert!(text.starts_with(&format!("{{\n  \"program\": \"{PROGRAM}\",\n  \"sha256\": \"")), "{text}");
    }
}
