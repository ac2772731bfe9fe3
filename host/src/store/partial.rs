//! Files while they are written: beside the name they will have, under a random one, locked for as long as their writer lives.
//!
//! The lock says who lives where process numbers do not: between containers, and on network file systems that have locks. A writer that
//! was killed holds none, and the next command in the folder removes what it left. Where the file system has no locks nothing is
//! removed.

use std::collections::BTreeSet;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Between the name that a file will have and 16 random hexadecimal digits.
const INFIX: &str = ".sdp3-partial-";

/// Names that are tried.
const TRIES: usize = 100;

/// Files of this process that are not whole yet.
static UNFINISHED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

fn unfinished() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes what is half-written, and holds every thread that would begin or finish a file until the process ends: for a
/// program that is about to.
pub fn abandon() {
    let unfinished = unfinished();
    for file in unfinished.iter() {
        let _ = std::fs::remove_file(file);
    }
    std::mem::forget(unfinished);
}

/// A file that is not whole yet; dropped, it is removed.
#[derive(Debug)]
pub struct Partial {
    target: PathBuf,
    path: PathBuf,
    file: BufWriter<File>,
}

impl Partial {
    /// Begins a file that will be `target`. An entry of its random name, a link too, is not opened: another name is.
    ///
    /// # Errors
    ///
    /// What the system says.
    pub fn create(target: &Path) -> io::Result<Self> {
        for _ in 0..TRIES {
            let random = getrandom::u64().map_err(|error| io::Error::other(error.to_string()))?;
            let mut path = target.to_owned().into_os_string();
            path.push(format!("{INFIX}{random:016x}"));
            let path = PathBuf::from(path);
            let mut unfinished = unfinished();
            let file = match OpenOptions::new().write(true).create_new(true).open(&path) {
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => continue,
                file => file?,
            };
            unfinished.insert(path.clone());
            drop(unfinished);
            let partial =
                Partial { target: target.to_owned(), path, file: BufWriter::with_capacity(1 << 16, file) };
            // another command may have taken it for a leftover before it was locked
            let taken = matches!(partial.file.get_ref().try_lock(), Err(TryLockError::WouldBlock));
            if !taken && is_at(partial.file.get_ref(), &partial.path) {
                return Ok(partial);
            }
        }
        Err(io::Error::new(io::ErrorKind::AlreadyExists, format!("{TRIES} random names were taken")))
    }

    /// Where its bytes go.
    pub fn file(&mut self) -> &mut BufWriter<File> {
        &mut self.file
    }

    /// Syncs the bytes and gives the file its name; the lock is held until then.
    ///
    /// # Errors
    ///
    /// What the system says; an entry of its random name that is another file by now.
    pub fn finish(mut self) -> io::Result<()> {
        // the name must not be there before the bytes are
        self.file.flush()?;
        self.file.get_ref().sync_all()?;
        let mut unfinished = unfinished();
        if !is_at(self.file.get_ref(), &self.path) {
            return Err(io::Error::other(format!(
                "{} was taken away while it was written",
                self.path.display()
            )));
        }
        std::fs::rename(&self.path, &self.target)?;
        unfinished.remove(&self.path);
        Ok(())
    }
}

impl Drop for Partial {
    fn drop(&mut self) {
        let mut unfinished = unfinished();
        if unfinished.remove(&self.path) && is_at(self.file.get_ref(), &self.path) {
            let _ = std::fs::remove_file(&self.path);
        }
    }
}

/// Whether a path still leads to this file, and not by way of a link.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let both = file.metadata().and_then(|own| Ok((own, path.symlink_metadata()?)));
    both.is_ok_and(|(own, at)| (own.dev(), own.ino()) == (at.dev(), at.ino()))
}

/// Whether a path leads to a file: an open one is not replaced here.
#[cfg(not(unix))]
fn is_at(_: &File, path: &Path) -> bool {
    path.is_file()
}

/// Whether a name is that of a partial file.
fn is_partial(name: &str) -> bool {
    let digits = |text: &str| text.len() == 16 && text.bytes().all(|byte| byte.is_ascii_hexdigit());
    name.rsplit_once(INFIX).is_some_and(|(_, random)| digits(random))
}

/// What became of a leftover.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Swept {
    /// It is none, or its writer lives, or it is gone.
    Done,
    /// The file system has no locks: nobody can say.
    Unknown,
}

/// Removes a file that a writer which no longer lives left half-written.
///
/// # Errors
///
/// One that cannot be removed.
pub fn sweep(path: &Path) -> io::Result<Swept> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    if !is_partial(&name) || !path.symlink_metadata().is_ok_and(|entry| entry.is_file()) {
        return Ok(Swept::Done);
    }
    // somebody else's, or gone
    let Ok(file) = OpenOptions::new().write(true).open(path) else { return Ok(Swept::Done) };
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => Ok(Swept::Done),
        Err(TryLockError::Error(_)) => Ok(Swept::Unknown),
        Ok(()) if !is_at(&file, path) => Ok(Swept::Done),
        Ok(()) => match std::fs::remove_file(path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
            _ => Ok(Swept::Done),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = std::fs::read_dir(folder).unwrap().flatten();
        let mut names: Vec<_> =
            entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_living_writer_keeps_its_file_and_a_dead_one_does_not() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("a.npz");
        let mut writer = Partial::create(&target).unwrap();
        writer.file().write_all(b"half").unwrap();
        let own = writer.path.clone();
        assert_eq!(sweep(&own).unwrap(), Swept::Done);
        assert!(own.exists());
        // a dead writer holds no lock
        let dead = folder.path().join("a.npz.sdp3-partial-0123456789abcdef");
        std::fs::write(&dead, b"").unwrap();
        sweep(&dead).unwrap();
        assert!(!dead.exists());
        writer.finish().unwrap();
        assert_eq!(names(folder.path()), ["a.npz"]);
        assert_eq!(std::fs::read(&target).unwrap(), b"half");
        drop(Partial::create(&target).unwrap());
        assert_eq!(names(folder.path()), ["a.npz"]);
    }

    #[test]
    fn other_names_and_links_stay() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["a.npz", "a.sdp3-partial-", "a.sdp3-partial-12@host", "a.sdp3-partial-0123456789abcdeg"]
        {
            let path = folder.path().join(name);
            std::fs::write(&path, b"").unwrap();
            sweep(&path).unwrap();
            assert!(path.exists(), "{name}");
        }
        #[cfg(unix)]
        {
            let link = folder.path().join("a.sdp3-partial-0123456789abcdef");
            std::os::unix::fs::symlink(folder.path().join("a.npz"), &link).unwrap();
            sweep(&link).unwrap();
            assert!(link.symlink_metadata().is_ok() && folder.path().join("a.npz").exists());
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_file_that_was_taken_away_does_not_get_the_name() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("a.npz");
        let mut writer = Partial::create(&target).unwrap();
        writer.file().write_all(b"ours").unwrap();
        let path = writer.path.clone();
        std::fs::remove_file(&path).unwrap();
        std::fs::write(&path, b"theirs").unwrap();
        let error = writer.finish().unwrap_err().to_string();
        assert!(error.contains("taken away"), "{error}");
        assert!(!target.exists());
        assert_eq!(std::fs::read(&path).unwrap(), b"theirs");
    }
}
