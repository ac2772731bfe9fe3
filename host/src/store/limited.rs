//! Whole files in memory, of a stated size at most: a folder, a device that never ends or an absurdly large file is refused before
//! anything is allocated for it.

use std::fs::File;
use std::io::{self, Error, ErrorKind, Read};
use std::path::Path;

const MIB: u64 = 1 << 20;
/// Most bytes of a text that a person may have written: scenario, plan, points, description of a recording.
pub const TEXT: u64 = 16 * MIB;
/// Most bytes of a network, in any format.
pub const NETWORK: u64 = 256 * MIB;
/// Most bytes of a result or a record, in JSON.
pub const RESULT: u64 = 256 * MIB;
/// Most bytes of a recording, a part of a dataset or its manifest, which are not held whole.
pub const WHOLE: u64 = 4096 * MIB;

/// Opens a regular file of at most `most` bytes.
///
/// # Errors
/// What the system says; the kind or the size that is refused, with what is legal.
pub fn open(file: &Path, most: u64) -> io::Result<File> {
    // asked before it is opened: to open a pipe would wait for its writer
    let about = std::fs::metadata(file)?;
    if !about.is_file() {
        return Err(Error::new(ErrorKind::InvalidInput, "not a regular file"));
    }
    refuse_more(about.len(), most)?;
    File::open(file)
}

/// Reads such a file.
///
/// # Errors
/// As [`open`].
pub fn read(file: &Path, most: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    // it may have grown since it was asked
    open(file, most)?.take(most + 1).read_to_end(&mut bytes)?;
    refuse_more(bytes.len() as u64, most)?;
    Ok(bytes)
}

/// Reads such a file of UTF-8.
///
/// # Errors
/// As [`open`]; bytes that are no UTF-8.
pub fn read_text(file: &Path, most: u64) -> io::Result<String> {
    String::from_utf8(read(file, most)?)
        .map_err(|error| Error::new(ErrorKind::InvalidData, format!("not UTF-8: {}", error.utf8_error())))
}

fn refuse_more(bytes: u64, most: u64) -> io::Result<()> {
    if bytes <= most {
        return Ok(());
    }
    Err(Error::new(ErrorKind::FileTooLarge, format!("{bytes} bytes, at most {most} are read")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_read_up_to_the_limit_and_nothing_else_is() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        std::fs::write(&file, b"12345").unwrap();
        assert_eq!(read(&file, 5).unwrap(), b"12345");
        assert_eq!(read(&file, 4).unwrap_err().to_string(), "5 bytes, at most 4 are read");
        assert_eq!(read(folder.path(), 5).unwrap_err().to_string(), "not a regular file");
        assert_eq!(read(&folder.path().join("none"), 5).unwrap_err().kind(), ErrorKind::NotFound);
        #[cfg(unix)]
        assert_eq!(read(Path::new("/dev/zero"), 5).unwrap_err().to_string(), "not a regular file");
        std::fs::write(&file, b"\xff").unwrap();
        assert!(read_text(&file, 5).unwrap_err().to_string().starts_with("not UTF-8"));
        // a hole of a terabyte costs nothing to refuse
        File::create(&file).unwrap().set_len(1 << 40).unwrap();
        assert_eq!(read(&file, TEXT).unwrap_err().kind(), ErrorKind::FileTooLarge);
    }
}
