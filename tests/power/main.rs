//! Power cuts: reads what the recorder wrote, and makes every state in which the folder may be found when the power fails.
//!
//! A cut is between any two operations. What was synced before it is there: a file's bytes after `fsync` of the file, a name after
//! `fsync` of its folder. Of the rest anything may be: all in order, nothing, names without bytes, bytes without names, and of each
//! write and each change of a name by chance all, a part or nothing, whatever the order. So POSIX allows, and file systems do.
//!
//! `power-cuts PROGRAM LOG FOLDER BEFORE MOST INTO` checks every state and prints how many differ: a file under its final name must be
//! one that the program had finished, or one that was there before. It makes MOST of the states, or all, evenly chosen, in folders of
//! their numbers in INTO. Without the syncs of the record files must be torn, or the check finds nothing. Exit code 0; 1: a file is torn;
//! 2: the record is not one.

mod disk;
mod record;

use disk::{Disk, Persisted, Tree};
use record::Operation;
use std::collections::{BTreeMap, BTreeSet};
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// Random states at each cut.
const RANDOM: u64 = 4;

/// In the name of a file that is not finished.
const PARTIAL: &str = ".sdp3-partial-";

/// Contents that a file may have, by path.
type Finished = BTreeMap<PathBuf, BTreeSet<Vec<u8>>>;

fn finish(finished: &mut Finished, tree: &Tree, path: &Path) {
    if let Some(Some(bytes)) = tree.get(path) {
        finished.entry(path.to_owned()).or_default().insert(bytes.clone());
    }
}

/// Files of a state under their final names that are none of the finished ones.
fn torn(state: &Tree, finished: &Finished) -> Vec<PathBuf> {
    let files = state.iter().filter_map(|(path, bytes)| Some((path, bytes.as_ref()?)));
    let torn = files.filter(|(path, bytes)| {
        !path.to_string_lossy().contains(PARTIAL)
            && !finished.get(*path).is_some_and(|whole| whole.contains(*bytes))
    });
    torn.map(|(path, _)| path.clone()).collect()
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let done = match words[..] {
        [program, log, folder, before, most, into] => match most.parse() {
            Ok(most) => check([program, log, folder, before], most, Path::new(into)),
            Err(_) => Err(format!("MOST is {most:?}; legal: a number").into()),
        },
        _ => Err("usage: power-cuts PROGRAM LOG FOLDER BEFORE MOST INTO".into()),
    };
    match done {
        Ok(whole) => ExitCode::from(u8::from(!whole)),
        Err(error) => {
            eprintln!("power-cuts: {error}");
            ExitCode::from(2)
        }
    }
}

/// Reads a record and gives `each` every state that differs from those before, until it says no: the state's number, the operations before
/// the cut, the state, and the contents that files may have. Returns how many states there are. `synced`: with the syncs of the record.
fn read_states(
    [program, log, folder, before]: [&str; 4],
    synced: bool,
    mut each: impl FnMut(usize, usize, &Tree, &Finished) -> Result<bool>,
) -> Result<usize> {
    record::all_are_recorded(&std::fs::read(program)?)?;
    let operations = record::read(&std::fs::read(log)?)?;
    let before = disk::read_tree(Path::new(before))?;
    let mut finished = Finished::new();
    before.keys().for_each(|path| finish(&mut finished, &before, path));
    let mut disk = Disk::new(Path::new(folder), &before);
    let mut seen = BTreeSet::new();
    for (cut, operation) in (1..).zip(&operations) {
        if !synced && matches!(operation, Operation::Sync { .. }) {
            continue;
        }
        disk.apply(operation)?;
        if let Operation::Rename { to, .. } = operation {
            finish(&mut finished, &disk.state(Persisted::All), to.strip_prefix(folder)?);
        }
        let random = (0..RANDOM).map(|n| Persisted::Random(cut as u64 * RANDOM + n));
        let all = [Persisted::All, Persisted::Nothing, Persisted::Names, Persisted::Bytes]
            .into_iter()
            .chain(random);
        for state in all.map(|persisted| disk.state(persisted)) {
            let number = seen.len();
            if seen.insert(disk::fingerprint(&state)) && !each(number, cut, &state, &finished)? {
                return Ok(seen.len());
            }
        }
    }
    if disk.state(Persisted::All) != disk::read_tree(Path::new(folder))? {
        let all = operations.len();
        return Err(format!("{folder} is not what its {all} operations make: one was not recorded").into());
    }
    Ok(seen.len())
}

fn check(record: [&str; 4], most: usize, into: &Path) -> Result<bool> {
    let mut found = false;
    read_states(record, false, |_, _, state, finished| {
        found |= !torn(state, finished).is_empty();
        Ok(!found)
    })?;
    if !found {
        return Err("without its syncs no file is torn either: this check finds nothing".into());
    }
    let mut whole = true;
    let states = read_states(record, true, |number, cut, state, finished| {
        for path in torn(state, finished) {
            println!("FAILED: state {number}, after operation {cut}: {} is torn", path.display());
            whole = false;
        }
        Ok(true)
    })?;
    std::fs::create_dir(into)?;
    let part = |number: usize| number * most.min(states) / states;
    read_states(record, true, |number, _, state, _| {
        if number == 0 || part(number) != part(number - 1) {
            disk::write_tree(state, &into.join(number.to_string()))?;
        }
        Ok(true)
    })?;
    println!("{states}");
    Ok(whole)
}
