//! A folder of measured recordings: found in any depth, each with the motion in its name.

use crate::error::Failure;
use crate::recordings::{Samples, Signal, Stated};
use crate::simulator::randomised::Motion;
use crate::store::digest::sha256;
use sdp3_core::config::RadarConfig;
use std::path::{Path, PathBuf};

/// Endings that are read; raw SigMF samples come with their meta file.
const ENDINGS: [&str; 4] = ["wav", "npy", "npz", "sigmf-meta"];
/// Folders within folders that are looked into.
const DEPTH: u32 = 16;

pub struct Measured {
    /// Its path below the folder.
    pub name: String,
    pub motion: Motion,
    pub signal: Signal,
    /// Twelve digits that change with content, motion and carrier.
    pub key: String,
}

/// A file that is not used, and why.
pub type LeftOut = (String, String);

/// The files that are not used as a section of a page; nothing without any.
pub fn left_out_section(left_out: &[LeftOut]) -> String {
    let lines: String = left_out.iter().map(|(name, why)| format!("- {name}: {why}\n")).collect();
    if lines.is_empty() { lines } else { format!("\n## Left out\n\n{lines}") }
}

/// The motion in a path: its file's name, else the nearest folder's. Words begin at capitals and after anything but letters.
pub fn motion(path: &Path) -> Option<Motion> {
    path.iter().rev().find_map(|part| {
        let part = part.to_string_lossy();
        let mut words = vec![String::new()];
        let mut small = false;
        for c in part.chars() {
            if !c.is_alphabetic() || (c.is_uppercase() && small) {
                words.push(String::new());
            }
            small = c.is_lowercase();
            if let (true, Some(word)) = (c.is_alphabetic(), words.last_mut()) {
                word.extend(c.to_lowercase());
            }
        }
        let motion_of = |word: &String| match word.as_str() {
            w if w.starts_with("walk") => Some(Motion::Walking),
            w if w.starts_with("runn") || w.starts_with("jog") => Some(Motion::Running),
            "run" | "runs" => Some(Motion::Running),
            "still" | "stand" | "stands" | "standing" | "sit" | "sits" | "sitting" => Some(Motion::Still),
            _ => None,
        };
        let mut found: Vec<Motion> = words.iter().filter_map(motion_of).collect();
        found.dedup();
        // two motions in one name say nothing
        (found.len() == 1).then(|| found[0])
    })
}

fn files(folder: &Path, depth: u32, found: &mut Vec<PathBuf>) -> std::io::Result<()> {
    let mut entries = std::fs::read_dir(folder)?.collect::<Result<Vec<_>, _>>()?;
    entries.sort_by_key(std::fs::DirEntry::file_name);
    for entry in entries {
        let path = entry.path();
        if path.is_dir() {
            if depth > 0 {
                files(&path, depth - 1, found)?;
            }
        } else {
            let ending = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
            if ENDINGS.contains(&ending.as_str()) {
                found.push(path);
            }
        }
    }
    Ok(())
}

/// Every usable recording below `folder`, in the order of their names, and those left out.
///
/// # Errors
///
/// A folder that cannot be read or holds no usable recording.
pub fn read(folder: &Path, stated: &Stated) -> Result<(Vec<Measured>, Vec<LeftOut>), Failure> {
    let mut paths = Vec::new();
    files(folder, DEPTH, &mut paths).map_err(|e| format!("--measured: {}: {e}", folder.display()))?;
    let (mut used, mut left_out) = (Vec::new(), Vec::new());
    for path in paths {
        let below = path.strip_prefix(folder).unwrap_or(&path).to_owned();
        let name = below.display().to_string();
        let Some(motion) = motion(&below) else {
            left_out.push((name, "its name has no motion: walk, run, still, stand or sit".into()));
            continue;
        };
        let other = |signal: &Signal| {
            let values = RadarConfig::PAPER.values_per_slot();
            matches!(&signal.samples, Samples::Slots(slots) if slots.per_slot != values)
        };
        match crate::recordings::read(&path, stated) {
            Ok(signal) if other(&signal) => {
                left_out.push((name, "raw slots of another radar than the paper's".into()))
            }
            Ok(signal) => {
                let known = format!("{} {} {}", motion.name(), signal.carrier_hz, signal.rate_hz);
                let mut key = sha256([&std::fs::read(&path)?[..], known.as_bytes()]);
                key.truncate(12);
                used.push(Measured { name, motion, signal, key });
            }
            Err(error) => left_out.push((name, error.to_string())),
        }
    }
    if used.is_empty() {
        let first = left_out.first().map_or_else(|| "it holds none".into(), |(n, e)| format!("{n}: {e}"));
        return Err(format!("--measured: {}: no usable recording ({first})", folder.display()).into());
    }
    Ok((used, left_out))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_have_motions_and_ambiguous_ones_do_not() {
        let cases = [
            ("White_Lab_walking.wav", Some(Motion::Walking)),
            ("run03.wav", Some(Motion::Running)),
            ("personStanding2.npy", Some(Motion::Still)),
            ("walks/0001.wav", Some(Motion::Walking)),
            ("running/walk_1.wav", Some(Motion::Walking)),
            ("walk_then_run.wav", None),
            ("position_trunk_standard.wav", None),
        ];
        for (name, expected) in cases {
            assert_eq!(motion(Path::new(name)), expected, "{name}");
        }
    }

    #[test]
    fn a_folder_without_recordings_says_what_it_holds() {
        let folder = tempfile::tempdir().unwrap();
        let refusal = |folder: &Path| read(folder, &Stated::default()).map(|_| ()).unwrap_err().to_string();
        assert!(refusal(folder.path()).contains("it holds none"));
        std::fs::write(folder.path().join("walk.wav"), b"nothing").unwrap();
        assert!(refusal(folder.path()).contains("walk.wav"), "{}", refusal(folder.path()));
        assert!(refusal(&folder.path().join("none")).contains("--measured"));
    }
}
