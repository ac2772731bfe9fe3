//! A dataset read back: complete, every file that is read held to the digest in its manifest.

use super::part::RECORDINGS;
use super::{PER_CLASS, REQUEST, Request, Work, manifest};
use crate::error::Invalid;
use crate::formats::numpy;
use crate::scenario::{Class, Scenario, ScenarioError};
use crate::store::difference::difference;
use crate::store::digest::{Hash, sha256};
use crate::store::file_record::FileRecord;
use crate::store::limited;
use crate::store::output::{Output, OutputError};
use sdp3_core::dims::{BEATS, Beat, Complex};
use serde::de::{DeserializeOwned, Error, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};
use std::collections::BTreeMap;
use std::fmt::{self, Display};
use std::fs::File;
use std::io::{self, BufReader, Seek};
use std::path::{Component, Path, PathBuf};

/// Why a dataset cannot be learned from.
#[derive(Debug, thiserror::Error)]
pub enum StoredError {
    /// A file cannot be read.
    #[error("{file}: {source}; {CURE}")]
    Read {
        /// The file.
        file: PathBuf,
        /// What the system or the format says.
        source: io::Error,
    },
    /// A field that may not be what it is.
    #[error(transparent)]
    Invalid(#[from] Invalid),
    /// Its scenario.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// A manifest that does not follow from the other files.
    #[error(transparent)]
    Manifest(#[from] OutputError),
}

/// What completes or repairs a dataset.
const CURE: &str = "`sdp3 simulate` with the same options and --out makes it";

/// What is needed of a manifest.
#[derive(Deserialize)]
struct Manifest {
    #[serde(deserialize_with = "needed")]
    files: BTreeMap<String, FileRecord>,
}

/// Most files that are needed of a manifest: the parts, numbered with five digits, and what they are of.
const MOST_FILES: usize = 100_002;

/// The files that are learned from, each once; of the others, which may be millions, only the names are looked at.
fn needed<'de, D: Deserializer<'de>>(deserializer: D) -> Result<BTreeMap<String, FileRecord>, D::Error> {
    struct Needed;
    impl<'de> Visitor<'de> for Needed {
        type Value = BTreeMap<String, FileRecord>;

        fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
            f.write_str("a list of files")
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Self::Value, A::Error> {
            let mut found = BTreeMap::new();
            let refuse = |value: &str, legal: &str| {
                Err(A::Error::custom(Invalid::new("files: name", format!("{value:?}"), legal)))
            };
            while let Some(record) = list.next_element::<FileRecord>()? {
                let name = record.name.clone();
                if !Path::new(&name).components().all(|part| matches!(part, Component::Normal(_))) {
                    return refuse(&name, "a path that stays in the folder");
                }
                if !name.ends_with(".npz") && name != REQUEST && name != Scenario::FILE {
                    continue;
                }
                if found.len() == MOST_FILES || found.insert(name.clone(), record).is_some() {
                    return refuse(&name, &format!("there once, with at most {MOST_FILES} others"));
                }
            }
            Ok(found)
        }
    }
    deserializer.deserialize_seq(Needed)
}

/// A recording: its class and its beats.
pub type Labelled = (Class, Vec<Beat>);

/// A complete dataset.
#[derive(Debug)]
pub struct Stored {
    files: Files,
    scenario: Scenario,
    request: Request,
}

impl Stored {
    /// Opens a folder that `sdp3 simulate` completed.
    ///
    /// # Errors
    ///
    /// A file that is missing or is not the manifest's; a field of request or manifest that is not legal; other classes than the paper's.
    pub fn open(folder: &Path) -> Result<Self, StoredError> {
        let files = Files::open(folder)?;
        let request: Request = parsed(&folder.join(REQUEST), &files.read(REQUEST)?)?;
        let text = files.read(Scenario::FILE)?;
        let scenario = Scenario::load(&folder.join(Scenario::FILE))?;
        let classes = &request.classes;
        if classes.len() != Class::ALL.len() || Class::ALL.iter().any(|class| !classes.contains(class)) {
            let names = |classes: &[Class]| classes.iter().map(|c| c.name()).collect::<Vec<_>>().join(", ");
            let legal = format!("{}, in any order", names(&Class::ALL));
            return Err(files.value(REQUEST, "classes", names(classes), legal));
        }
        if request.per_class < 2 || !PER_CLASS.contains(&request.per_class) {
            let legal = format!("2 to {}", PER_CLASS.end());
            return Err(files.value(REQUEST, "per_class", request.per_class, legal));
        }
        if !(0.0..=1.0).contains(&request.rho) {
            return Err(files.value(REQUEST, "rho", request.rho, "0 to 1".into()));
        }
        let digest = sha256([text.as_slice()]);
        if request.scenario_sha256 != digest {
            return Err(files.value(
                REQUEST,
                "scenario_sha256",
                request.scenario_sha256,
                format!("{digest}, that of {}", Scenario::FILE),
            ));
        }
        let work = Work { scenario: &scenario, rho: request.rho, request: request.clone() };
        manifest::check(&work, &Output::reading(folder))?;
        Ok(Stored { files, scenario, request })
    }

    /// Recordings.
    pub fn recordings(&self) -> u32 {
        self.request.per_class * self.request.classes.len() as u32
    }

    /// Sensing slots of every recording.
    pub fn slots(&self) -> u32 {
        self.scenario.largest_sensing_slots()
    }

    /// The scenario that the dataset was made in.
    pub fn own_scenario(&self) -> &Scenario {
        &self.scenario
    }

    /// The scenario to learn in: the dataset's, with its rho; the learning settings, the N_s and the links are those of `asked`, which
    /// must be of the same room, radar and people. Training recordings have at most the stored slots.
    ///
    /// # Errors
    ///
    /// What differs; more sensing slots than the recordings have.
    pub fn scenario(&self, asked: &Scenario) -> Result<Scenario, StoredError> {
        let mut found = self.scenario.clone();
        found.channel.rho = Some(self.request.rho);
        found.learning = asked.learning.clone();
        found.learning.train_per_class = self.request.per_class;
        (found.name, found.communication) = (asked.name.clone(), asked.communication.clone());
        (found.optimizer, found.frame.sensing_slots) =
            (asked.optimizer.clone(), asked.frame.sensing_slots.clone());
        found.frame.period_slots = asked.frame.period_slots;
        let mut same = asked.clone();
        same.channel.rho = asked.channel.rho.or(found.channel.rho);
        same.learning.train_per_class = self.request.per_class;
        let json = |s: &Scenario| serde_json::to_value(s).unwrap_or_default();
        if let Some((field, found, asked)) = difference("", &json(&found), &json(&same)) {
            let legal = format!("{asked}, as --scenario or --set says, or stay out of it");
            return Err(self.files.value(Scenario::FILE, &field, found, legal));
        }
        let longest = found.largest_sensing_slots();
        if longest > self.slots() {
            let legal = format!("at least {longest}, the largest N_s that --scenario asks for");
            return Err(self.files.value(Scenario::FILE, "frame.sensing_slots", self.slots(), legal));
        }
        found.learning.recording_slots = found.learning.recording_slots.min(self.slots());
        Ok(found)
    }

    /// Gives every recording to `take`, part by part.
    ///
    /// # Errors
    ///
    /// A part that is missing, damaged or of another shape; classes that are not there as often as they should.
    pub fn each(&self, mut take: impl FnMut(Vec<Labelled>)) -> Result<(), StoredError> {
        let mut counts = [0_u32; Class::ALL.len()];
        for name in self.files.records.keys().filter(|name| name.ends_with(".npz")) {
            let recordings = self.part(name)?;
            recordings.iter().for_each(|(class, _)| counts[*class as usize] += 1);
            take(recordings);
        }
        let want = self.request.per_class;
        match Class::ALL.into_iter().zip(counts).find(|(_, count)| *count != want) {
            None => Ok(()),
            Some((class, count)) => {
                let field = format!("recordings of {}", class.name());
                Err(self.files.value(
                    manifest::NAME,
                    &field,
                    count,
                    format!("{want}, per_class of {REQUEST}"),
                ))
            }
        }
    }

    fn part(&self, name: &str) -> Result<Vec<Labelled>, StoredError> {
        let broken = |source| StoredError::Read { file: self.files.folder.join(name), source };
        let mut archive = numpy::archive(self.files.open_part(name)?).map_err(broken)?;
        let labels: Vec<u8> = self.array(name, &mut archive, "label", "|u1", &[])?;
        let (slots, wide) = (self.slots() as usize, 2 * BEATS);
        let shape = [slots as u64, BEATS as u64, 2];
        let beats: Vec<i32> = self.array(name, &mut archive, "beat", "<i4", &shape)?;
        if beats.len() != labels.len() * slots * wide {
            let legal = format!("{}, as many as label has", labels.len());
            return Err(self.files.value(name, "beat: recordings", beats.len() / (slots * wide), legal));
        }
        let complex = |z: &[i32]| Complex { re: z[0], im: z[1] };
        let beat = |slot: &[i32]| -> Beat { std::array::from_fn(|b| complex(&slot[2 * b..])) };
        let one = |(k, (&label, beats)): (usize, (&u8, &[i32]))| {
            let class = self.request.classes.get(usize::from(label)).ok_or_else(|| {
                let legal = format!("below {}", self.request.classes.len());
                self.files.value(name, &format!("label of recording {k}"), label, legal)
            })?;
            Ok((*class, beats.chunks_exact(wide).map(beat).collect()))
        };
        labels.iter().zip(beats.chunks_exact(slots * wide)).enumerate().map(one).collect()
    }

    /// An array of a part: `[recording]` by `shape`.
    fn array<T: numpy::Value>(
        &self,
        name: &str,
        archive: &mut zip::ZipArchive<BufReader<File>>,
        array: &str,
        dtype: &str,
        shape: &[u64],
    ) -> Result<Vec<T>, StoredError> {
        let broken = |source| StoredError::Read { file: self.files.folder.join(name), source };
        let Some(found) = numpy::by_name(archive, array).map_err(broken)? else {
            return Err(self.files.value(name, array, "missing", "an array".into()));
        };
        if found.dtype() != dtype {
            let field = format!("{array}: dtype");
            return Err(self.files.value(name, &field, found.descr, format!("'{dtype}'")));
        }
        let own = &found.shape;
        if own.len() != shape.len() + 1 || own[1..] != *shape || found.fortran_order {
            let legal = format!("recordings by {shape:?}, in C order");
            return Err(self.files.value(name, &format!("{array}: shape"), format!("{own:?}"), legal));
        }
        if own[0] > u64::from(RECORDINGS) {
            let legal = format!("at most {RECORDINGS} recordings");
            return Err(self.files.value(name, &format!("{array}: shape"), format!("{own:?}"), legal));
        }
        found.into_vec().map_err(broken)
    }
}

/// The files of a dataset as its manifest names them.
#[derive(Debug)]
struct Files {
    folder: PathBuf,
    records: BTreeMap<String, FileRecord>,
}

impl Files {
    fn open(folder: &Path) -> Result<Self, StoredError> {
        let file = folder.join(manifest::NAME);
        let broken = |source| StoredError::Read { file: file.clone(), source };
        let text = BufReader::new(limited::open(&file, limited::WHOLE).map_err(broken)?);
        let Manifest { files } = serde_json::from_reader(text).map_err(|error| broken(error.into()))?;
        Ok(Files { folder: folder.to_owned(), records: files })
    }

    /// A small file, if it is the one that the manifest names.
    fn read(&self, name: &str) -> Result<Vec<u8>, StoredError> {
        let file = self.folder.join(name);
        let bytes =
            limited::read(&file, limited::TEXT).map_err(|source| StoredError::Read { file, source })?;
        self.check(FileRecord::new(name.to_owned(), &bytes))?;
        Ok(bytes)
    }

    /// A part, if it is the one that the manifest names. It is read through once for that and not held.
    fn open_part(&self, name: &str) -> Result<BufReader<File>, StoredError> {
        let path = self.folder.join(name);
        let read = || {
            let mut file = limited::open(&path, limited::WHOLE)?;
            let mut hash = Hash::default();
            let bytes = io::copy(&mut file, &mut hash)?;
            file.rewind()?;
            Ok((file, FileRecord { name: name.to_owned(), bytes, sha256: hash.hex() }))
        };
        let (file, found) = read().map_err(|source| StoredError::Read { file: path.clone(), source })?;
        self.check(found)?;
        Ok(BufReader::new(file))
    }

    /// Refuses a file that is not as the manifest says.
    fn check(&self, found: FileRecord) -> Result<(), StoredError> {
        let name = &found.name;
        let Some(record) = self.records.get(name) else {
            let (value, legal) = (format!("without {name}"), format!("with it; {CURE}"));
            return Err(self.value(manifest::NAME, "files", value, legal));
        };
        if *record != found {
            let legal = format!("{}, as {} says; {CURE}", record.sha256, manifest::NAME);
            return Err(self.value(name, "SHA-256", &found.sha256, legal));
        }
        Ok(())
    }

    fn value(&self, name: &str, field: &str, value: impl Display, legal: String) -> StoredError {
        Invalid::new(field, value, legal).at(self.folder.join(name).display()).into()
    }
}

fn parsed<T: DeserializeOwned>(file: &Path, bytes: &[u8]) -> Result<T, StoredError> {
    serde_json::from_slice(bytes).map_err(|e| StoredError::Read { file: file.to_owned(), source: e.into() })
}
