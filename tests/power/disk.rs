//! A disk that forgets what was not synced.

use crate::Result;
use crate::record::Operation;
use std::collections::{BTreeMap, BTreeSet};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};

/// Files and folders (`None`) by their path below the folder.
pub type Tree = BTreeMap<PathBuf, Option<Vec<u8>>>;

/// What of the operations that were not synced is found after the cut.
#[derive(Debug, Clone, Copy)]
pub enum Persisted {
    All,
    Nothing,
    /// Names of files, without the bytes.
    Names,
    /// Bytes, without the names.
    Bytes,
    /// Each operation by chance, a write also in part.
    Random(u64),
}

/// Bytes that a disk writes at once.
const SECTOR: usize = 512;

#[derive(Clone, Copy)]
enum Node {
    File(usize),
    Folder(usize),
}

/// A change of a file's bytes: at a place, or to nothing.
enum Change {
    Write(usize, Vec<u8>),
    Truncate,
}

/// Names that a folder loses and gets at once.
struct Renaming {
    without: Option<String>,
    with: Option<(String, Node)>,
}

#[derive(Default)]
struct File {
    synced: Vec<u8>,
    since: Vec<Change>,
}

#[derive(Default)]
struct Folder {
    synced: BTreeMap<String, Node>,
    since: Vec<Renaming>,
}

/// The folder as programs see it, and as it lies on the disk.
pub struct Disk {
    root: PathBuf,
    files: Vec<File>,
    folders: Vec<Folder>,
    /// As programs see it; the root is the empty path.
    now: BTreeMap<PathBuf, Node>,
    /// Open files and folders, and the position in each.
    open: BTreeMap<u32, (Node, usize)>,
}

impl Disk {
    /// A disk on which `before` is synced in the folder `root`.
    pub fn new(root: &Path, before: &Tree) -> Self {
        let mut disk = Disk {
            root: root.to_owned(),
            files: Vec::new(),
            folders: vec![Folder::default()],
            now: BTreeMap::from([(PathBuf::new(), Node::Folder(0))]),
            open: BTreeMap::new(),
        };
        for (path, bytes) in before {
            let node = disk.new_node(bytes.is_none());
            if let (Node::File(file), Some(bytes)) = (node, bytes) {
                disk.files[file].synced.clone_from(bytes);
            }
            let (folder, name) = disk.entry(path);
            disk.folders[folder].synced.insert(name, node);
            disk.now.insert(path.clone(), node);
        }
        disk
    }

    fn new_node(&mut self, folder: bool) -> Node {
        if folder {
            self.folders.push(Folder::default());
            Node::Folder(self.folders.len() - 1)
        } else {
            self.files.push(File::default());
            Node::File(self.files.len() - 1)
        }
    }

    /// The folder of a path, and the name in it.
    fn entry(&self, path: &Path) -> (usize, String) {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        match self.now.get(path.parent().unwrap_or(Path::new(""))) {
            Some(&Node::Folder(folder)) => (folder, name),
            _ => (0, name), // cannot be: the program has just used it
        }
    }

    fn add(&mut self, path: &Path, node: Node) {
        let (folder, name) = self.entry(path);
        self.folders[folder].since.push(Renaming { without: None, with: Some((name, node)) });
        self.now.insert(path.to_owned(), node);
    }

    /// Does what a program did.
    pub fn apply(&mut self, operation: &Operation) -> Result<()> {
        let inside =
            |path: &Path| Ok::<_, Box<dyn std::error::Error>>(path.strip_prefix(&self.root)?.to_owned());
        let opened = |file: &u32| self.open.get(file).copied().ok_or(format!("file {file} is not open"));
        match operation {
            Operation::Open { file, truncated, path } => {
                let path = inside(path)?;
                let node = match self.now.get(&path) {
                    Some(&node) => node,
                    None => {
                        let node = self.new_node(false);
                        self.add(&path, node);
                        node
                    }
                };
                if let (Node::File(number), true) = (node, truncated) {
                    self.files[number].since.push(Change::Truncate);
                }
                self.open.insert(*file, (node, 0));
            }
            Operation::Close { file } => _ = self.open.remove(file),
            Operation::Write { file, bytes } => {
                let (node, at) = opened(file)?;
                let Node::File(number) = node else { return Err("bytes in a folder".into()) };
                self.files[number].since.push(Change::Write(at, bytes.clone()));
                self.open.insert(*file, (node, at + bytes.len()));
            }
            Operation::Seek { file, position } => {
                let (node, _) = opened(file)?;
                self.open.insert(*file, (node, usize::try_from(*position)?));
            }
            Operation::Sync { file } => match opened(file)?.0 {
                Node::File(number) => {
                    let file = &mut self.files[number];
                    file.synced = bytes_of(file, |_| Some(usize::MAX));
                    file.since.clear();
                }
                Node::Folder(number) => {
                    let folder = &mut self.folders[number];
                    folder.synced = names_of(folder, |_| true);
                    folder.since.clear();
                }
            },
            Operation::Rename { from, to } => {
                let (from, to) = (inside(from)?, inside(to)?);
                let node = self.now.remove(&from).ok_or("a file that is not there was renamed")?;
                let ((folder, without), (other, name)) = (self.entry(&from), self.entry(&to));
                if folder != other || matches!(node, Node::Folder(_)) {
                    return Err("only files are renamed, and in their folder".into());
                }
                self.folders[folder]
                    .since
                    .push(Renaming { without: Some(without), with: Some((name, node)) });
                self.now.insert(to, node);
            }
            Operation::Remove { path } => {
                let path = inside(path)?;
                let (folder, name) = self.entry(&path);
                self.folders[folder].since.push(Renaming { without: Some(name), with: None });
                self.now.remove(&path);
            }
            Operation::Folder { path } => {
                let path = inside(path)?;
                let node = self.new_node(true);
                self.add(&path, node);
            }
        }
        Ok(())
    }

    /// What is found after a cut now.
    pub fn state(&self, kept: Persisted) -> Tree {
        let mut random = match kept {
            Persisted::Random(seed) => seed,
            _ => 0,
        };
        let mut chance = move || splitmix(&mut random);
        let mut tree = Tree::new();
        let mut folders = vec![(PathBuf::new(), 0)];
        while let Some((path, folder)) = folders.pop() {
            let names = names_of(&self.folders[folder], |_| match kept {
                Persisted::All | Persisted::Names => true,
                Persisted::Nothing | Persisted::Bytes => false,
                Persisted::Random(_) => chance() % 2 == 0,
            });
            for (name, node) in names {
                let path = path.join(name);
                match node {
                    Node::Folder(folder) => {
                        tree.insert(path.clone(), None);
                        folders.push((path, folder));
                    }
                    Node::File(file) => {
                        let bytes = bytes_of(&self.files[file], |length| match kept {
                            Persisted::All | Persisted::Bytes => Some(usize::MAX),
                            Persisted::Nothing | Persisted::Names => None,
                            Persisted::Random(_) => match chance() % 3 {
                                0 => None,
                                1 => Some(chance() as usize % (length / SECTOR + 1) * SECTOR),
                                _ => Some(usize::MAX),
                            },
                        });
                        tree.insert(path, Some(bytes));
                    }
                }
            }
        }
        tree
    }
}

/// A file's bytes with the changes since the last sync; `kept`: how many bytes of one of a length are kept, if it is.
fn bytes_of(file: &File, mut kept: impl FnMut(usize) -> Option<usize>) -> Vec<u8> {
    let mut bytes = file.synced.clone();
    for change in &file.since {
        match change {
            Change::Truncate => {
                if kept(0).is_some() {
                    bytes.clear();
                }
            }
            Change::Write(at, new) => {
                let Some(length) = kept(new.len()) else { continue };
                let new = &new[..length.min(new.len())];
                if bytes.len() < at + new.len() {
                    bytes.resize(at + new.len(), 0);
                }
                bytes[*at..at + new.len()].copy_from_slice(new);
            }
        }
    }
    bytes
}

/// A folder's names with those changes since the last sync that are kept.
fn names_of(folder: &Folder, mut kept: impl FnMut(&Renaming) -> bool) -> BTreeMap<String, Node> {
    let mut names = folder.synced.clone();
    for change in folder.since.iter().filter(|change| kept(change)) {
        if let Some(name) = &change.without {
            names.remove(name);
        }
        if let Some((name, node)) = &change.with {
            names.insert(name.clone(), *node);
        }
    }
    names
}

/// Random numbers from a counter (Steele, Lea, Flood: Fast Splittable Pseudorandom Number Generators, 2014).
fn splitmix(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut mixed = *state;
    mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    mixed ^ (mixed >> 31)
}

/// A number that equal trees share. Half-written files are the same by any of their random names.
pub fn fingerprint(tree: &Tree) -> u64 {
    let mut hasher = DefaultHasher::new();
    let plain = |path: &Path| path.to_string_lossy().split(crate::PARTIAL).next().map(str::to_owned);
    let distinct: BTreeSet<_> = tree.iter().map(|(path, bytes)| (plain(path), bytes)).collect();
    distinct.hash(&mut hasher);
    hasher.finish()
}

/// The files and folders below a folder.
pub fn read_tree(root: &Path) -> Result<Tree> {
    let (mut tree, mut folders) = (Tree::new(), vec![root.to_owned()]);
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder)? {
            let path = entry?.path();
            let is_folder = path.is_dir();
            let bytes = if is_folder { None } else { Some(std::fs::read(&path)?) };
            tree.insert(path.strip_prefix(root)?.to_owned(), bytes);
            if is_folder {
                folders.push(path);
            }
        }
    }
    Ok(tree)
}

/// Makes a folder with these files and folders in it.
pub fn write_tree(tree: &Tree, into: &Path) -> Result<()> {
    std::fs::create_dir(into)?;
    // a folder's path is less than those of what is in it
    for (path, bytes) in tree {
        match bytes {
            None => std::fs::create_dir(into.join(path))?,
            Some(bytes) => std::fs::write(into.join(path), bytes)?,
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn disk(operations: &[Operation]) -> Disk {
        let mut disk = Disk::new(Path::new("/f"), &Tree::new());
        operations.iter().for_each(|operation| disk.apply(operation).unwrap());
        disk
    }

    fn write(bytes: &[u8], synced: bool, named: bool) -> Disk {
        let mut operations = vec![
            Operation::Open { file: 3, truncated: false, path: "/f/part".into() },
            Operation::Write { file: 3, bytes: bytes.to_vec() },
        ];
        if synced {
            operations.push(Operation::Sync { file: 3 });
        }
        operations.push(Operation::Rename { from: "/f/part".into(), to: "/f/whole".into() });
        if named {
            // the folder
            operations.push(Operation::Open { file: 4, truncated: false, path: "/f".into() });
            operations.push(Operation::Sync { file: 4 });
        }
        disk(&operations)
    }

    fn tree(files: &[(&str, &[u8])]) -> Tree {
        files.iter().map(|(name, bytes)| ((*name).into(), Some(bytes.to_vec()))).collect()
    }

    #[test]
    fn what_was_not_synced_may_be_lost() {
        assert_eq!(write(b"abc", false, true).state(Persisted::Nothing), tree(&[("whole", b"")]));
        assert_eq!(write(b"abc", false, false).state(Persisted::Names), tree(&[("whole", b"")]));
        assert_eq!(write(b"abc", true, false).state(Persisted::Nothing), tree(&[]));
        assert_eq!(write(b"abc", true, false).state(Persisted::Names), tree(&[("whole", b"abc")]));
        for kept in
            [Persisted::Nothing, Persisted::Names, Persisted::Bytes, Persisted::All, Persisted::Random(1)]
        {
            assert_eq!(write(b"abc", true, true).state(kept), tree(&[("whole", b"abc")]));
        }
    }

    #[test]
    fn writes_are_lost_each_for_itself_and_in_part() {
        let long = [7; 2000];
        let disk = write(&long, false, true);
        let lengths: BTreeSet<usize> = (0..200)
            .map(|seed| disk.state(Persisted::Random(seed))[Path::new("whole")].as_ref().unwrap().len())
            .collect();
        assert_eq!(lengths, BTreeSet::from([0, 512, 1024, 1536, 2000]));
    }
}
