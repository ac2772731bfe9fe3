//! The recorder's log as operations, and whether a program does only what the recorder sees.

use crate::Result;
use object::{Object, ObjectSymbol};
use std::path::PathBuf;

/// Functions of the C library that the recorder replaces.
const RECORDED: [&str; 10] =
    ["open", "open64", "close", "write", "writev", "lseek64", "fsync", "rename", "unlink", "mkdir"];

/// Others that change files, folders or their names.
const CHANGING: [&str; 34] = [
    "creat",
    "creat64",
    "openat",
    "openat64",
    "fopen",
    "fopen64",
    "freopen64",
    "mkstemp64",
    "pwrite",
    "pwrite64",
    "pwritev",
    "pwritev64",
    "lseek",
    "ftruncate",
    "ftruncate64",
    "truncate",
    "truncate64",
    "fallocate",
    "fallocate64",
    "posix_fallocate",
    "posix_fallocate64",
    "copy_file_range",
    "sendfile",
    "sendfile64",
    "splice",
    "fdatasync",
    "sync_file_range",
    "renameat",
    "renameat2",
    "unlinkat",
    "mkdirat",
    "link",
    "linkat",
    "symlink",
];

/// What the program did. Paths are absolute, files are numbers that are valid until they are closed.
pub enum Operation {
    /// A file or folder was opened; one that was not there is new and empty.
    Open {
        file: u32,
        truncated: bool,
        path: PathBuf,
    },
    Close {
        file: u32,
    },
    Write {
        file: u32,
        bytes: Vec<u8>,
    },
    Seek {
        file: u32,
        position: u64,
    },
    Sync {
        file: u32,
    },
    Rename {
        from: PathBuf,
        to: PathBuf,
    },
    Remove {
        path: PathBuf,
    },
    Folder {
        path: PathBuf,
    },
}

/// Refuses a program that changes files by functions which are not recorded.
pub fn all_are_recorded(program: &[u8]) -> Result<()> {
    let program = object::File::parse(program)?;
    let imported: Vec<_> = program
        .dynamic_symbols()
        .filter(|symbol| symbol.is_undefined())
        .filter_map(|s| s.name().ok())
        .collect();
    if !imported.iter().any(|name| RECORDED.contains(name)) {
        return Err("the program imports nothing: it is not linked dynamically".into());
    }
    match imported.iter().find(|name| CHANGING.contains(name)) {
        Some(name) => Err(format!("the program calls {name}, which is not recorded").into()),
        None => Ok(()),
    }
}

/// Reads a log.
pub fn read(mut log: &[u8]) -> Result<Vec<Operation>> {
    let mut operations = Vec::new();
    while let Some(end) = log.iter().position(|&byte| byte == b'\n') {
        let (line, rest) = log.split_at(end);
        log = &rest[1..];
        let fields: Vec<&str> = str::from_utf8(line)?.split('\t').collect();
        operations.push(match fields[..] {
            ["open", file, truncated, path] => Operation::Open {
                file: file.parse()?,
                truncated: truncated == "truncated",
                path: path.into(),
            },
            ["close", file] => Operation::Close { file: file.parse()? },
            ["write", file, length] => {
                let (bytes, rest) = log.split_at_checked(length.parse()?).ok_or("the log is cut off")?;
                log = rest;
                Operation::Write { file: file.parse()?, bytes: bytes.to_vec() }
            }
            ["seek", file, position] => Operation::Seek { file: file.parse()?, position: position.parse()? },
            ["sync", file] => Operation::Sync { file: file.parse()? },
            ["rename", from, to] => Operation::Rename { from: from.into(), to: to.into() },
            ["remove", path] => Operation::Remove { path: path.into() },
            ["folder", path] => Operation::Folder { path: path.into() },
            _ => return Err(format!("no operation: {}", fields.join(" ")).into()),
        });
    }
    if operations.is_empty() {
        return Err("nothing was recorded".into());
    }
    Ok(operations)
}
