//! SHA-256: of bytes, of what is written, of JSON within itself.

use sha2::{Digest, Sha256};
use std::io::{self, Write};

/// A running SHA-256, which is written to.
#[derive(Default)]
pub struct Hash(Sha256);

impl Hash {
    /// The digest of what was written, in hexadecimal.
    pub fn hex(self) -> String {
        hex(&self.0.finalize())
    }
}

impl Write for Hash {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.update(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// SHA-256 of parts, one after the other, in hexadecimal.
pub fn sha256<'a>(parts: impl IntoIterator<Item = &'a [u8]>) -> String {
    let mut hash = Hash::default();
    parts.into_iter().for_each(|part| hash.0.update(part));
    hash.hex()
}

/// Bytes in hexadecimal.
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// A digest as a field of JSON.
fn stated(sha256: &str) -> String {
    format!("\"sha256\": \"{sha256}\"")
}

/// JSON with an empty first `sha256`, and there the digest of this text.
pub fn sealed(open: &str) -> String {
    open.replacen(&stated(""), &stated(&sha256([open.as_bytes()])), 1)
}

/// Refuses JSON that was changed after it was [`sealed`] with a digest; the reason.
///
/// # Errors
///
/// The digest that it has now.
pub fn unseal(text: &str, digest: &str) -> Result<(), String> {
    let found = sha256([text.replacen(&stated(digest), &stated(""), 1).as_bytes()]);
    if found == digest { Ok(()) } else { Err(format!("sha256 = {digest:?}, its content's is {found}")) }
}
