//! Records what a program does to the files of a folder: preloaded by `LD_PRELOAD`, it appends every open, write, seek, sync, rename,
//! removal and new folder under `SDP3_RECORD_FOLDER` to the file `SDP3_RECORD_LOG`, in the order in which they take effect.
//!
//! A record is a line of fields between tabs; the bytes of a write follow its line. The functions are the ones that Rust's
//! library calls on Linux; the reader (`main.rs`) refuses a program that imports others.

#![allow(unsafe_code, reason = "functions of the C library are replaced")]

use libc::{c_char, c_int, c_long, c_void, iovec, mode_t, off64_t, size_t, ssize_t};
use std::collections::BTreeSet;
use std::ffi::{CStr, CString, OsStr};
use std::fmt::Arguments;
use std::os::unix::ffi::{OsStrExt, OsStringExt};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

struct Recorder {
    folder: PathBuf,
    log: c_int,
    /// Open files and folders under the folder. One operation at a time: the order of the log is that of the effects.
    open: Mutex<BTreeSet<c_int>>,
}

fn recorder() -> Option<&'static Recorder> {
    static RECORDER: OnceLock<Option<Recorder>> = OnceLock::new();
    RECORDER
        .get_or_init(|| {
            let folder = std::env::var_os("SDP3_RECORD_FOLDER")?.into();
            let log = CString::new(std::env::var_os("SDP3_RECORD_LOG")?.into_vec()).ok()?;
            let flags = libc::O_WRONLY | libc::O_CREAT | libc::O_APPEND | libc::O_CLOEXEC;
            // SAFETY: a path that ends with NUL, and plain numbers.
            let log = unsafe { libc::syscall(libc::SYS_openat, libc::AT_FDCWD, log.as_ptr(), flags, 0o600) };
            (log >= 0).then_some(Recorder { folder, log: log as c_int, open: Mutex::default() })
        })
        .as_ref()
}

impl Recorder {
    fn lock(&self) -> MutexGuard<'_, BTreeSet<c_int>> {
        self.open.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The path as an absolute one, if it is in the folder.
    ///
    /// # Safety
    ///
    /// `path` is a text that ends with NUL.
    unsafe fn inside(&self, path: *const c_char) -> Option<String> {
        // SAFETY: the caller's
        let path = Path::new(OsStr::from_bytes(unsafe { CStr::from_ptr(path) }.to_bytes()));
        let path = std::env::current_dir().map_or(path.to_owned(), |here| here.join(path));
        path.starts_with(&self.folder).then(|| path.to_string_lossy().into_owned())
    }

    /// Appends a record. The program ends if it cannot: a log with a gap would be read as another run.
    fn write(&self, line: Arguments, data: &[u8]) {
        let mut record = format!("{line}\n").into_bytes();
        record.extend_from_slice(data);
        let mut rest = &record[..];
        while !rest.is_empty() {
            // SAFETY: the bytes of a slice.
            let written = unsafe { libc::syscall(libc::SYS_write, self.log, rest.as_ptr(), rest.len()) };
            match usize::try_from(written) {
                Ok(written) => rest = &rest[written..],
                Err(_) => std::process::abort(),
            }
        }
    }
}

/// Makes a system call, and records it if it went well and concerns the folder. `errno` is that of the call.
fn record(
    concerns: impl FnOnce(&Recorder, &BTreeSet<c_int>) -> bool,
    call: impl FnOnce() -> c_long,
    note: impl FnOnce(&Recorder, &mut BTreeSet<c_int>, c_long),
) -> c_long {
    let Some(recorder) = recorder() else { return call() };
    let mut open = recorder.lock();
    if !concerns(recorder, &open) {
        // a write to a pipe may wait for another thread's
        drop(open);
        return call();
    }
    let done = call();
    if done >= 0 {
        note(recorder, &mut open, done);
    }
    done
}

/// # Safety
///
/// That of `open(2)`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn open64(path: *const c_char, flags: c_int, mode: mode_t) -> c_int {
    // SAFETY: the caller's
    let inside = recorder().and_then(|recorder| unsafe { recorder.inside(path) });
    record(
        |_, _| inside.is_some(),
        // SAFETY: the caller's
        || unsafe { libc::syscall(libc::SYS_openat, libc::AT_FDCWD, path, flags, mode) },
        |recorder, open, file| {
            open.insert(file as c_int);
            let truncated = if flags & libc::O_TRUNC != 0 { "truncated" } else { "" };
            recorder.write(
                format_args!("open\t{file}\t{truncated}\t{}", inside.as_deref().unwrap_or_default()),
                &[],
            );
        },
    ) as c_int
}

/// # Safety
///
/// That of `open(2)`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn open(path: *const c_char, flags: c_int, mode: mode_t) -> c_int {
    // SAFETY: the caller's
    unsafe { open64(path, flags, mode) }
}

/// # Safety
///
/// That of `close(2)`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn close(file: c_int) -> c_int {
    record(
        |_, open| open.contains(&file),
        // SAFETY: the caller's
        || unsafe { libc::syscall(libc::SYS_close, file) },
        |recorder, open, _| {
            open.remove(&file);
            recorder.write(format_args!("close\t{file}"), &[]);
        },
    ) as c_int
}

/// # Safety
///
/// That of `write(2)`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn write(file: c_int, bytes: *const c_void, length: size_t) -> ssize_t {
    record(
        |_, open| open.contains(&file),
        // SAFETY: the caller's
        || unsafe { libc::syscall(libc::SYS_write, file, bytes, length) },
        |recorder, _, written| {
            // SAFETY: the system has read so many bytes there.
            let bytes = unsafe { std::slice::from_raw_parts(bytes.cast::<u8>(), written as usize) };
            recorder.write(format_args!("write\t{file}\t{written}"), bytes);
        },
    ) as ssize_t
}

/// # Safety
///
/// That of `writev(2)`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn writev(file: c_int, parts: *const iovec, count: c_int) -> ssize_t {
    record(
        |_, open| open.contains(&file),
        // SAFETY: the caller's
        || unsafe { libc::syscall(libc::SYS_writev, file, parts, count) },
        |recorder, _, written| {
            // SAFETY: the caller's, and the system has read so many bytes there.
            let mut bytes = unsafe { std::slice::from_raw_parts(parts, count as usize) }
                .iter()
                .flat_map(|part| unsafe {
                    std::slice::from_raw_parts(part.iov_base.cast::<u8>(), part.iov_len).to_vec()
                })
                .collect::<Vec<u8>>();
            bytes.truncate(written as usize);
            recorder.write(format_args!("write\t{file}\t{written}"), &bytes);
        },
    ) as ssize_t
}

/// # Safety
///
/// That of `lseek(2)`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lseek64(file: c_int, offset: off64_t, from: c_int) -> off64_t {
    record(
        |_, open| open.contains(&file),
        // SAFETY: the caller's
        || unsafe { libc::syscall(libc::SYS_lseek, file, offset, from) },
        |recorder, _, position| recorder.write(format_args!("seek\t{file}\t{position}"), &[]),
    )
}

/// # Safety
///
/// That of `fsync(2)`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fsync(file: c_int) -> c_int {
    record(
        |_, open| open.contains(&file),
        // SAFETY: the caller's
        || unsafe { libc::syscall(libc::SYS_fsync, file) },
        |recorder, _, _| recorder.write(format_args!("sync\t{file}"), &[]),
    ) as c_int
}

/// # Safety
///
/// That of `rename(2)`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rename(from: *const c_char, to: *const c_char) -> c_int {
    // SAFETY: the caller's
    let paths = recorder().map(|recorder| unsafe { (recorder.inside(from), recorder.inside(to)) });
    record(
        |_, _| matches!(&paths, Some((Some(_), _) | (_, Some(_)))),
        // SAFETY: the caller's
        || unsafe { libc::syscall(libc::SYS_renameat2, libc::AT_FDCWD, from, libc::AT_FDCWD, to, 0) },
        |recorder, _, _| {
            let (from, to) = paths.clone().unwrap_or_default();
            recorder
                .write(format_args!("rename\t{}\t{}", from.unwrap_or_default(), to.unwrap_or_default()), &[]);
        },
    ) as c_int
}

/// # Safety
///
/// That of `unlink(2)`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn unlink(path: *const c_char) -> c_int {
    // SAFETY: the caller's
    let inside = recorder().and_then(|recorder| unsafe { recorder.inside(path) });
    record(
        |_, _| inside.is_some(),
        // SAFETY: the caller's
        || unsafe { libc::syscall(libc::SYS_unlinkat, libc::AT_FDCWD, path, 0) },
        |recorder, _, _| {
            recorder.write(format_args!("remove\t{}", inside.as_deref().unwrap_or_default()), &[]);
        },
    ) as c_int
}

/// # Safety
///
/// That of `mkdir(2)`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mkdir(path: *const c_char, mode: mode_t) -> c_int {
    // SAFETY: the caller's
    let inside = recorder().and_then(|recorder| unsafe { recorder.inside(path) });
    record(
        |_, _| inside.is_some(),
        // SAFETY: the caller's
        || unsafe { libc::syscall(libc::SYS_mkdirat, libc::AT_FDCWD, path, mode) },
        |recorder, _, _| {
            recorder.write(format_args!("folder\t{}", inside.as_deref().unwrap_or_default()), &[]);
        },
    ) as c_int
}
