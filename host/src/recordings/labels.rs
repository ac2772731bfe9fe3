//! Labels of a folder of recordings: by a table in it, by the annotations of SigMF recordings, or by the folders in it.
//!
//! `labels.csv` has the columns `file` and `class`, and may have `person` and, both in s, `from_s` and `to_s`: parts of a recording may
//! have classes of their own. Without it the annotations of a SigMF recording that have a label are its parts, and the first folder on
//! the way to any other recording is its class.

use super::{annotations, infineon};
use crate::error::{Failure, Invalid};
use crate::formats::slots::Slots;
use crate::formats::table;
use crate::store::limited;
use std::path::{Path, PathBuf};

/// The table's name.
const TABLE: &str = "labels.csv";
const HEADER: &str = "file,class, then any of person,from_s,to_s";
/// Endings of recordings; a SigMF recording is its description.
const ENDINGS: [&str; 9] = ["wav", "csv", "npy", "npz", "mat", "sigmf-meta", "h5", "hdf5", "bin"];
/// Folders within folders that are looked into.
const DEPTH: u32 = 16;

/// Where a recording is.
#[derive(Debug, Clone, PartialEq)]
pub enum Held {
    /// In a file or folder that [`super::open`] reads.
    File(PathBuf),
    /// In memory.
    Slots(Slots),
}

/// A recording, or a part of one, and what it shows.
#[derive(Debug, Clone, PartialEq)]
pub struct Labelled {
    /// Its path below the folder, or what else it is called.
    pub name: String,
    /// Where it is.
    pub held: Held,
    /// What it shows.
    pub class: String,
    /// Who is in it, if that is known.
    pub person: Option<String>,
    /// Beginning and end in s; absent: all of it.
    pub span_s: Option<(f64, f64)>,
}

impl Labelled {
    /// A whole recording that is named as its path.
    #[cfg(test)]
    pub fn example(name: &str, class: &str, person: Option<&str>) -> Self {
        let person = person.map(str::to_owned);
        let held = Held::File(name.into());
        Labelled { name: name.into(), held, class: class.into(), person, span_s: None }
    }

    /// What must not be both learned from and tested with: the person, else the recording.
    pub fn group(&self) -> &str {
        self.person.as_deref().unwrap_or(&self.name)
    }
}

/// The labelled recordings of a folder, in the order of the table or of their names, and the files without a class.
///
/// # Errors
///
/// A folder or table that cannot be read; no labelled recording.
pub fn read(folder: &Path) -> Result<(Vec<Labelled>, Vec<PathBuf>), Failure> {
    let path = folder.join(TABLE);
    let (found, left_out) =
        if path.exists() { (by_table(folder, &path)?, Vec::new()) } else { by_folders(folder)? };
    if found.is_empty() {
        let value = match left_out.first() {
            Some(first) => format!("0 with a class, {} without ({})", left_out.len(), first.display()),
            None => "0".into(),
        };
        let legal = format!("at least 2, in folders named as their class, annotated (SigMF) or in {TABLE}");
        return Err(Invalid::new("recordings", value, legal).at(folder.display()).into());
    }
    if let Some((one, other)) = contradiction(&found) {
        let value = format!("{} and {} at the same time", one.class, other.class);
        return Err(Invalid::new("class", value, "one").at(&one.name).at(folder.display()).into());
    }
    Ok((found, left_out))
}

/// Parts of a recording that overlap and are of different classes.
fn contradiction(found: &[Labelled]) -> Option<(&Labelled, &Labelled)> {
    let mut parts: Vec<_> =
        found.iter().map(|one| (one, one.span_s.unwrap_or((0.0, f64::INFINITY)))).collect();
    parts.sort_by(|(a, (begin, _)), (b, (other, _))| a.name.cmp(&b.name).then(begin.total_cmp(other)));
    // the part that lasts longest of those before
    let mut last: Option<(&Labelled, (f64, f64))> = None;
    for (one, span) in parts {
        match last.filter(|(before, _)| before.name == one.name) {
            Some((before, (_, end))) if span.0 < end && before.class != one.class => {
                return Some((before, one));
            }
            Some((_, (_, end))) if span.1 <= end => {}
            _ => last = Some((one, span)),
        }
    }
    None
}

fn by_table(folder: &Path, path: &Path) -> Result<Vec<Labelled>, Failure> {
    let text = limited::read_text(path, limited::TEXT).map_err(|e| format!("{}: {e}", path.display()))?;
    let mut lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    let refuse = |line: usize, field: &str, value: &str, legal: &str| -> Failure {
        Invalid::new(field, format!("{value:?}"), legal).at(format!("line {line}")).at(path.display()).into()
    };
    let (_, header) = lines.next().unwrap_or((0, ""));
    let names = table::cells(header);
    let known = |name: &String| ["file", "class", "person", "from_s", "to_s"].contains(&name.as_str());
    let column = |name: &str| names.iter().position(|own| own == name);
    let (Some(file), Some(class)) = (column("file"), column("class")) else {
        return Err(refuse(1, "header", header, HEADER));
    };
    if !names.iter().all(known) || column("from_s").is_some() != column("to_s").is_some() {
        return Err(refuse(1, "header", header, HEADER));
    }
    lines
        .map(|(index, line)| {
            let cells = table::cells(line);
            let cell = |k: usize| cells.get(k).map_or("", String::as_str);
            let refuse = |field: &str, value: &str, legal: &str| refuse(index + 1, field, value, legal);
            if cells.len() != names.len() {
                return Err(refuse("cells", line, "as many as the header has"));
            }
            for (k, name) in [(file, "file"), (class, "class")] {
                if cell(k).is_empty() {
                    return Err(refuse(name, "", "not empty"));
                }
            }
            let second = |k: usize, name: &str| {
                let value = cell(k).parse::<f64>().ok().filter(|t| t.is_finite() && *t >= 0.0);
                value.ok_or_else(|| refuse(name, cell(k), "a time in s, 0 and more"))
            };
            let span_s = match column("from_s").zip(column("to_s")) {
                Some((from, to)) if !(cell(from).is_empty() && cell(to).is_empty()) => {
                    let (begin, end) = (second(from, "from_s")?, second(to, "to_s")?);
                    if end <= begin {
                        return Err(refuse("to_s", cell(to), "after from_s"));
                    }
                    Some((begin, end))
                }
                _ => None,
            };
            Ok(Labelled {
                name: cell(file).to_owned(),
                held: Held::File(folder.join(cell(file))),
                class: cell(class).to_owned(),
                person: column("person").map(|k| cell(k).to_owned()).filter(|person| !person.is_empty()),
                span_s,
            })
        })
        .collect()
}

fn by_folders(folder: &Path) -> Result<(Vec<Labelled>, Vec<PathBuf>), Failure> {
    let mut paths = Vec::new();
    recordings(folder, DEPTH, &mut paths).map_err(|e| format!("{}: {e}", folder.display()))?;
    let (mut found, mut left_out) = (Vec::new(), Vec::new());
    for path in paths {
        let below = path.strip_prefix(folder).unwrap_or(&path);
        let name = below.display().to_string();
        let labelled = |class: String, span_s| Labelled {
            name: name.clone(),
            held: Held::File(path.clone()),
            class,
            person: None,
            span_s,
        };
        let sigmf = path.extension().is_some_and(|ending| ending == "sigmf-meta");
        let parts = if sigmf { annotations::read(&path)? } else { Vec::new() };
        let mut folders = below.iter();
        let class = folders.next().filter(|_| folders.next().is_some());
        match class.map(|class| class.to_string_lossy().into_owned()) {
            _ if !parts.is_empty() => {
                found.extend(parts.into_iter().map(|part| labelled(part.label, Some(part.span_s))));
            }
            Some(class) => found.push(labelled(class, None)),
            None => left_out.push(path),
        }
    }
    Ok((found, left_out))
}

fn recordings(folder: &Path, depth: u32, found: &mut Vec<PathBuf>) -> std::io::Result<()> {
    let mut entries = std::fs::read_dir(folder)?.collect::<Result<Vec<_>, _>>()?;
    entries.sort_by_key(std::fs::DirEntry::file_name);
    for path in entries.into_iter().map(|entry| entry.path()) {
        let ending = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        if infineon::holds(&path) {
            found.push(path);
        } else if path.is_dir() {
            if depth > 0 {
                recordings(&path, depth - 1, found)?;
            }
        } else if ENDINGS.contains(&ending.as_str()) || path.to_string_lossy().ends_with(".raw.txt") {
            found.push(path);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(files: &[(&str, &str)]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in files {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        }
        folder
    }

    #[test]
    fn folders_name_classes_and_a_radar_sdk_folder_is_one_recording() {
        let files = [
            "wave/a.npy",
            "wave/b/c.bin",
            "wave/b/c.cfg",
            "wave/module/config.json",
            "wave/module/radar.npy",
        ];
        let folder = folder(&files.map(|name| (name, "")));
        let (found, left_out) = read(folder.path()).unwrap();
        assert!(left_out.is_empty());
        let names: Vec<&str> = found.iter().map(|l| l.name.as_str()).collect();
        assert_eq!(names, ["wave/a.npy", "wave/b/c.bin", "wave/module"]);
        assert!(found.iter().all(|l| l.class == "wave" && l.group() == l.name));
        std::fs::write(folder.path().join("alone.npy"), "").unwrap();
        assert_eq!(read(folder.path()).unwrap().1, [folder.path().join("alone.npy")]);
    }

    #[test]
    fn a_table_gives_classes_persons_and_parts() {
        let table =
            "file,class,person,from_s,to_s\na.npy,sit,Ada,0,2.5\na.npy,fall,Ada,2.5,4\nb.npy,sit,,,\n";
        let folder = folder(&[("labels.csv", table)]);
        let (found, _) = read(folder.path()).unwrap();
        assert_eq!(found.len(), 3);
        assert_eq!(
            (found[1].class.as_str(), found[1].group(), found[1].span_s),
            ("fall", "Ada", Some((2.5, 4.0)))
        );
        assert_eq!((found[2].group(), found[2].span_s), ("b.npy", None));
        let cases = [
            ("file,klass\na,b\n", "header"),
            ("file,class,from_s\na,b,1\n", "header"),
            ("file,class\na\n", "line 2: cells"),
            ("file,class\na,\n", "line 2: class"),
            ("file,class,from_s,to_s\na,b,2,1\n", "line 2: to_s"),
            ("file,class,from_s,to_s\na,b,x,1\n", "line 2: from_s"),
            ("file,class\n", "recordings is 0"),
            ("file,class\na,b\nc,b\na,d\n", "class is b and d at the same time"),
            ("file,class,from_s,to_s\na,b,0,2\na,b,0.5,1\na,d,1.5,3\n", "class is b and d at the same time"),
        ];
        for (text, field) in cases {
            std::fs::write(folder.path().join("labels.csv"), text).unwrap();
            let error = read(folder.path()).unwrap_err().to_string();
            assert!(error.contains(field), "{text:?}: {error}");
        }
    }
}
