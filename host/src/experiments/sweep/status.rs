//! Where a sweep stands: which cells are there, shard by shard, and how long the others will take.

use super::plan::Sweep;
use super::store::{CELLS, Store};
use crate::dataset::Shard;
use crate::error::Failure;
use crate::results::{ShardStatus, SweepStatus};
use crate::store::record::Fault;
use std::path::Path;
use std::time::SystemTime;

/// Cells by which the pace is judged: the last ones, so that an interruption before them does not count.
const RECENT: usize = 20;

/// Reads every cell of a folder, which is not changed.
///
/// # Errors
///
/// A folder or a cell that is there and cannot be read.
pub fn status(sweep: &Sweep, folder: &Path, shards: u32) -> Result<SweepStatus, Failure> {
    let store = Store::of(sweep, folder);
    let shard = |index| Shard::new(index, shards).map_or_else(String::new, |shard| shard.to_string());
    let empty = |index| ShardStatus { shard: shard(index), cells: 0, done: 0, missing: 0, unusable: 0 };
    let mut each: Vec<ShardStatus> = (1..=shards).map(empty).collect();
    let (mut whole, mut faults, mut times) = (empty(1), Vec::new(), Vec::new());
    for (cell, _) in &sweep.cells {
        let found = store.read(cell)?;
        for counts in [&mut whole, &mut each[(cell.index % shards) as usize]] {
            counts.cells += 1;
            match &found {
                Ok(_) => counts.done += 1,
                Err(Fault::Missing) => counts.missing += 1,
                Err(_) => counts.unusable += 1,
            }
        }
        match found {
            Ok(_) => times.extend(std::fs::metadata(store.path(cell)).and_then(|file| file.modified())),
            Err(Fault::Missing) => (),
            Err(fault) => faults.push(format!("{}: {fault}", store.path(cell).display())),
        }
    }
    for file in store.unexpected_files()? {
        faults.push(format!("{}: foreign: no cell of the plan", folder.join(CELLS).join(file).display()));
    }
    let ShardStatus { cells, done, missing, unusable, .. } = whole;
    let left_s = pace_s(times).map(|pace| pace * f64::from(missing + unusable));
    Ok(SweepStatus {
        plan: sweep.digest.clone(),
        cells,
        done,
        missing,
        unusable,
        faults,
        shards: each,
        left_s,
    })
}

/// Mean time between the last cells, by when their files were written; `None` for fewer than three.
fn pace_s(mut times: Vec<SystemTime>) -> Option<f64> {
    times.sort();
    let recent = &times[times.len().saturating_sub(RECENT)..];
    let [first, .., last] = recent else { return None };
    let span = last.duration_since(*first).ok()?.as_secs_f64();
    (recent.len() > 2).then(|| span / (recent.len() - 1) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn the_pace_is_that_of_the_last_cells() {
        let at = |seconds: u64| SystemTime::UNIX_EPOCH + Duration::from_secs(seconds);
        assert_eq!(pace_s(vec![at(0), at(5)]), None);
        assert_eq!(pace_s(vec![at(20), at(0), at(10)]), Some(10.0));
        // a night between two attempts
        let times = (0..30).map(|k| at(if k < 10 { k } else { 40_000 + 7 * k }));
        assert_eq!(pace_s(times.collect()), Some(7.0));
    }
}
