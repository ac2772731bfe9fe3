//! Reads FlatBuffers from untrusted bytes: every access is checked, nothing is copied.
//!
//! FlatBuffers binary format ("Internals" of its documentation). A damaged reference is an error that names the
//! field; the tables of a vector are counted against a limit before they are looked at.

use super::TfliteError;

/// A table: its bytes are read only where its vtable says a field is.
#[derive(Debug, Clone, Copy)]
pub struct Table<'a> {
    file: &'a [u8],
    at: usize,
    vtable: &'a [u8],
}

fn damaged(field: &str, what: impl Into<String>) -> TfliteError {
    TfliteError::Damaged { field: field.into(), what: what.into() }
}

fn word<const N: usize>(file: &[u8], at: usize) -> Option<[u8; N]> {
    file.get(at..)?.first_chunk().copied()
}

fn u32_at(file: &[u8], at: usize, field: &str) -> Result<u32, TfliteError> {
    let value =
        word(file, at).ok_or_else(|| damaged(field, format!("lies at byte {at} of {}", file.len())))?;
    Ok(u32::from_le_bytes(value))
}

/// Position a reference at `at` points to.
fn follow(file: &[u8], at: usize, field: &str) -> Result<usize, TfliteError> {
    Ok(at.saturating_add(u32_at(file, at, field)? as usize))
}

impl<'a> Table<'a> {
    /// The root table of a file with this identifier.
    ///
    /// # Errors
    /// Another identifier, or a root outside the file.
    pub fn root(file: &'a [u8], identifier: [u8; 4]) -> Result<Self, TfliteError> {
        match word::<4>(file, 4) {
            Some(found) if found == identifier => Self::new(file, follow(file, 0, "root")?, "root"),
            Some(found) => Err(TfliteError::value(
                "file identifier",
                found.escape_ascii(),
                format!("{}", identifier.escape_ascii()),
            )),
            None => Err(damaged("file", format!("has {} bytes, needs at least 8", file.len()))),
        }
    }

    fn new(file: &'a [u8], at: usize, field: &str) -> Result<Self, TfliteError> {
        let distance = u32_at(file, at, field)? as i32;
        let outside = || damaged(field, format!("has its vtable {distance} bytes before byte {at}"));
        let start = usize::try_from(at as i64 - i64::from(distance)).map_err(|_| outside())?;
        let length = word(file, start).map(u16::from_le_bytes).ok_or_else(outside)?;
        let end = start.saturating_add(usize::from(length));
        let vtable = file.get(start..end).filter(|v| v.len() >= 4).ok_or_else(outside)?;
        Ok(Table { file, at, vtable })
    }

    /// Where a field's value lies; `None` where it is absent.
    fn place(&self, slot: usize) -> Option<usize> {
        match u16::from_le_bytes(word(self.vtable, 4 + 2 * slot)?) {
            0 => None,
            offset => Some(self.at.saturating_add(usize::from(offset))),
        }
    }

    /// A `byte`, `ubyte` or `bool`.
    ///
    /// # Errors
    /// It lies outside the file.
    pub fn u8(&self, slot: usize, default: u8, field: &str) -> Result<u8, TfliteError> {
        let Some(at) = self.place(slot) else { return Ok(default) };
        self.file.get(at).copied().ok_or_else(|| damaged(field, format!("lies at byte {at}")))
    }

    /// An `int` or `uint`.
    ///
    /// # Errors
    /// It lies outside the file.
    pub fn i32(&self, slot: usize, default: i32, field: &str) -> Result<i32, TfliteError> {
        self.place(slot).map_or(Ok(default), |at| Ok(u32_at(self.file, at, field)? as i32))
    }

    /// Whether a field is present.
    pub fn has(&self, slot: usize) -> bool {
        self.place(slot).is_some()
    }

    /// A table.
    ///
    /// # Errors
    /// It lies outside the file.
    pub fn table(&self, slot: usize, field: &str) -> Result<Option<Table<'a>>, TfliteError> {
        let Some(at) = self.place(slot) else { return Ok(None) };
        Table::new(self.file, follow(self.file, at, field)?, field).map(Some)
    }

    /// Position of a vector's first element and their number, all inside the file; (0, 0) where it is absent.
    fn span(&self, slot: usize, size: usize, field: &str) -> Result<(usize, usize), TfliteError> {
        let Some(at) = self.place(slot) else { return Ok((0, 0)) };
        let start = follow(self.file, at, field)?;
        let count = u32_at(self.file, start, field)? as usize;
        let first = start.saturating_add(4);
        if self.file.len().saturating_sub(first) / size.max(1) < count {
            let have = self.file.len();
            return Err(damaged(
                field,
                format!("has {count} elements at byte {first}, the file has {have} bytes"),
            ));
        }
        Ok((first, count))
    }

    /// Elements of a vector, `size` bytes each, as bytes; empty where it is absent.
    ///
    /// # Errors
    /// It lies outside the file.
    pub fn vector(&self, slot: usize, size: usize, field: &str) -> Result<&'a [u8], TfliteError> {
        let (first, count) = self.span(slot, size, field)?;
        Ok(self.file.get(first..first + count * size).unwrap_or(&[]))
    }

    /// A vector of 32-bit words, at most `most`.
    ///
    /// # Errors
    /// It lies outside the file or is longer.
    pub fn words(&self, slot: usize, most: usize, field: &str) -> Result<Vec<[u8; 4]>, TfliteError> {
        let (words, _) = self.vector(slot, 4, field)?.as_chunks::<4>();
        limit(words.len(), most, field)?;
        Ok(words.to_vec())
    }

    /// A vector of tables, at most `most`.
    ///
    /// # Errors
    /// It or one of them lies outside the file, or there are more.
    pub fn tables(&self, slot: usize, most: usize, field: &str) -> Result<Vec<Table<'a>>, TfliteError> {
        let (first, count) = self.span(slot, 4, field)?;
        limit(count, most, field)?;
        let position = |i: usize| follow(self.file, first + 4 * i, field);
        (0..count).map(|i| Table::new(self.file, position(i)?, field)).collect()
    }

    /// A string; empty where it is absent, its bytes that are no UTF-8 replaced.
    ///
    /// # Errors
    /// It lies outside the file.
    pub fn text(&self, slot: usize, field: &str) -> Result<String, TfliteError> {
        let bytes = self.vector(slot, 1, field)?;
        // long enough for any name that is shown to people
        Ok(String::from_utf8_lossy(bytes.get(..256).unwrap_or(bytes)).into_owned())
    }
}

fn limit(count: usize, most: usize, field: &str) -> Result<(), TfliteError> {
    if count <= most {
        return Ok(());
    }
    Err(TfliteError::value(format!("number of {field}"), count, format!("0 to {most}")))
}
