//! NumPy arrays from anywhere: `npyz` behind a look at the header.
//!
//! Its parser takes twice as long for every bracket within a bracket and reserves what the header says of its own length. A header
//! that this program writes or reads has brackets two deep and a hundred bytes.

use npyz::NpyFile;
use std::io::{Chain, Cursor, Error, ErrorKind, Read, Result, Seek};
use zip::{ZipArchive, result::ZipError};

/// Most bytes of a header: what version 1 of the format can state.
const LONGEST: u32 = 1 << 16;
/// Most brackets within each other: records of records would have more.
const DEEPEST: usize = 4;
/// Magic and version.
const PREFIX: usize = 8;

/// An array with its header read.
pub type Checked<R> = NpyFile<Chain<Cursor<Vec<u8>>, R>>;

/// An array.
///
/// # Errors
///
/// What the reader says; a header that is none, longer than 64 KiB, or deeper than four brackets.
pub fn array<R: Read>(mut reader: R) -> Result<Checked<R>> {
    let mut header = vec![0; PREFIX];
    reader.read_exact(&mut header)?;
    let mut size = [0; 4];
    // later versions have four bytes of length, in which the upper ones may be anything
    let width = if header[6] == 1 { 2 } else { 4 };
    reader.read_exact(&mut size[..width])?;
    header.extend(&size[..width]);
    let length = u32::from_le_bytes(size);
    if length > LONGEST {
        return Err(invalid(format!("header of {length} bytes, at most {LONGEST} are read")));
    }
    header.resize(header.len() + length as usize, 0);
    reader.read_exact(&mut header[PREFIX + width..])?;
    let mut depth = 0_usize;
    for byte in &header[PREFIX + width..] {
        match byte {
            b'(' | b'[' | b'{' => depth += 1,
            b')' | b']' | b'}' => depth = depth.saturating_sub(1),
            _ => (),
        }
        if depth > DEEPEST {
            return Err(invalid(format!("header with more than {DEEPEST} brackets within each other")));
        }
    }
    NpyFile::new(Cursor::new(header).chain(reader))
}

/// The archive of a `.npz` file.
///
/// # Errors
///
/// What the reader says; bytes that are no archive.
pub fn archive<R: Read + Seek>(reader: R) -> Result<ZipArchive<R>> {
    ZipArchive::new(reader).map_err(|error| match error {
        ZipError::Io(error) => error,
        error => invalid(error),
    })
}

/// The array of this name in an archive, if there is one.
///
/// # Errors
///
/// As [`array()`]; an archive that is none.
pub fn by_name<'a, R: Read + Seek>(
    archive: &'a mut ZipArchive<R>,
    name: &str,
) -> Result<Option<Checked<impl Read + use<'a, R>>>> {
    match archive.by_name(&format!("{name}.npy")) {
        Ok(file) => array(file).map(Some),
        Err(ZipError::FileNotFound) => Ok(None),
        Err(ZipError::Io(error)) => Err(error),
        Err(error) => Err(invalid(error)),
    }
}

fn invalid(reason: impl ToString) -> Error {
    Error::new(ErrorKind::InvalidData, reason.to_string())
}

/// Adds an array to an archive.
#[cfg(test)]
pub fn write<T: npyz::AutoSerialize + Copy>(
    archive: &mut zip::ZipWriter<std::fs::File>,
    name: &str,
    shape: &[u64],
    values: &[T],
) {
    use npyz::WriterBuilder;
    archive.start_file(format!("{name}.npy"), zip::write::FileOptions::default()).unwrap();
    let mut writer =
        npyz::WriteOptions::new().default_dtype().shape(shape).writer(archive).begin_nd().unwrap();
    writer.extend(values.iter().copied()).unwrap();
    writer.finish().unwrap();
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(version: u8, length: u32, header: &str) -> Vec<u8> {
        let size = length.to_le_bytes();
        let size = if version == 1 { &size[..2] } else { &size[..] };
        [b"\x93NUMPY".as_slice(), &[version, 0], size, header.as_bytes(), &[7, 0, 9, 0]].concat()
    }

    #[test]
    fn plain_arrays_of_both_versions_are_read() {
        let header = "{'descr': '<i2', 'fortran_order': False, 'shape': (2,), }\n";
        for version in [1, 2] {
            let bytes = file(version, header.len() as u32, header);
            let found = array(bytes.as_slice()).unwrap();
            assert_eq!(found.shape(), [2]);
            assert_eq!(found.into_vec::<i16>().unwrap(), [7, 9]);
        }
    }

    #[test]
    fn headers_that_would_take_for_ever_are_refused_at_once() {
        let refused = |bytes: Vec<u8>| array(bytes.as_slice()).err().map(|e| e.to_string());
        for bracket in ["{", "[", "("] {
            let deep = bracket.repeat(60);
            let words = refused(file(1, 60, &deep));
            assert_eq!(words.as_deref(), Some("header with more than 4 brackets within each other"));
        }
        assert_eq!(
            refused(file(2, u32::MAX, "")).as_deref(),
            Some("header of 4294967295 bytes, at most 65536 are read")
        );
        assert!(refused(file(1, 90, "{}")).is_some());
        assert!(refused(b"\x93NUM".to_vec()).is_some());
        assert!(refused(file(1, 2, "{}")).is_some());
    }
}
