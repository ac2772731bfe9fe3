//! One part of a dataset: an NPZ of up to 100 recordings, their SigMF files, and the sidecar that says all of them are there.
//!
//! The sidecar is written last and holds the SHA-256 of the others. Whatever kills a run, a part with a sidecar that matches
//! is whole, and one without is made again, with the same bytes. It is no [`crate::store::record`]: its bytes are listed in the
//! manifest, by length and SHA-256 like the others'.

use super::record::TruthRecord;
use super::{Work, sigmf};
use crate::formats::numpy;
use crate::formats::slots::{Slots, to_le_bytes};
use crate::network::spectrograms::image_of_beats;
use crate::simulator::body::motion::GroundTruth;
use crate::simulator::dataset::{Recorder, Set, beats};
use crate::store::digest::Hash;
use crate::store::file_record::FileRecord;
use crate::store::output::{Output, OutputError};
use rayon::prelude::*;
use sdp3_core::config::SampleFormat;
use sdp3_core::dims::{BEATS, Beat, ROWS};
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{self, BufWriter, Seek, Write};
use std::iter;
use std::ops::Range;
use std::panic::resume_unwind;
use std::sync::Mutex;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread;
use zip::{CompressionMethod, DateTime, ZipWriter, write::SimpleFileOptions};

/// Recordings in a part; the last may have fewer.
pub const RECORDINGS: u32 = 100;
/// Values that are turned into bytes at a time: they stay in the cache.
const VALUES: usize = 1 << 15;
/// Recordings of a batch and thread, without their raw slots.
const TOGETHER: usize = 16;
/// Batches of recordings that may wait to be written.
const BATCHES: usize = 2;
/// Bytes of an archive that may be written and not yet on the disk.
const SYNCED: usize = 1 << 23;
/// What makes a sidecar.
pub(super) const REMAKE: &str = "`sdp3 simulate` with the same options makes it again";

/// What a part's files are and what is true of its recordings: `part-00000.json`.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sidecar {
    /// The part's files but this one.
    pub files: Vec<FileRecord>,
    /// Its recordings.
    pub truth: Vec<TruthRecord>,
}

/// Name of a part's NPZ.
pub fn npz_name(part: u32) -> String {
    format!("part-{part:05}.npz")
}

/// Name of a part's sidecar.
pub fn sidecar_name(part: u32) -> String {
    format!("part-{part:05}.json")
}

/// One recording as it is stored.
#[derive(Debug, Clone)]
pub struct One {
    /// Raw slots, if they are wanted.
    pub slots: Option<Slots>,
    /// `[64, frames]`, of the largest N_s.
    pub image: Vec<i8>,
    /// `[slow_time, fast_time]`.
    pub beat: Vec<Beat>,
    /// Its class's place among those of the dataset.
    pub label: u8,
    /// What is true of it.
    pub truth: GroundTruth,
}

/// Memory of raw slots that have been written: fresh memory costs a fault a page.
type Spare = Mutex<Vec<Vec<i16>>>;

/// Recording `index`: a function of (scenario, classes, rho, seed, index) alone.
pub fn recording(work: &Work, index: u32) -> One {
    one(work, index, &Spare::default())
}

/// As [`recording`], in memory that is used again. Raw slots are made where they are stored, and beats and image are then theirs; else
/// the beats are made directly.
fn one(work: &Work, index: u32, spare: &Spare) -> One {
    let Work { scenario, rho, request, .. } = work;
    let count = request.classes.len() as u32;
    let (class, n) = (request.classes[(index % count) as usize], index / count);
    let slots = work.slots();
    let (slots, beats, truth) = if request.raw || request.sigmf {
        let memory = spare.lock().ok().and_then(|mut spare| spare.pop()).unwrap_or_default();
        let mut recorder = Recorder::new(scenario, *rho, request.seed, Set::Train, class, n);
        let raw = recorder.slots(memory, slots);
        let beats = raw.beats(scenario.radar.config()).unwrap_or_default();
        (Some(raw), beats, recorder.truth().clone())
    } else {
        let (beats, truth) = beats(scenario, *rho, request.seed, Set::Train, class, n, slots);
        (None, beats, truth)
    };
    let image = image_of_beats(scenario, &beats);
    One { slots, image, beat: beats, label: (index % count) as u8, truth }
}

/// Appends bytes to an array.
type Put<'a> = &'a mut dyn FnMut(&[u8]) -> io::Result<()>;
/// An array of all recordings: name, element type and size, shape, and what writes a recording's bytes.
type Column<'a> = (&'a str, (&'a str, usize), Vec<usize>, &'a dyn Fn(&mut One, Put) -> io::Result<()>);

/// Adds an array to the archive: its header, then what `rows` gives, which must be as many bytes as the shape says.
///
/// Entries are stored and carry no time, so that equal arrays are equal bytes.
fn array<W: Write + Seek>(
    archive: &mut ZipWriter<W>,
    name: &str,
    (descr, size): (&str, usize),
    shape: &[usize],
    rows: impl FnOnce(Put) -> io::Result<()>,
) -> io::Result<()> {
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Stored)
        .last_modified_time(DateTime::default())
        .unix_permissions(0o644);
    archive.start_file(format!("{name}.npy"), options)?;
    archive.write_all(&numpy::header(descr, shape))?;
    let (mut written, expected) = (0, shape.iter().product::<usize>() * size);
    rows(&mut |bytes| {
        written += bytes.len();
        archive.write_all(bytes)
    })?;
    match written == expected {
        true => Ok(()),
        false => {
            Err(io::Error::other(format!("{name} has {written} bytes where {shape:?} needs {expected}")))
        }
    }
}

/// Makes a part: SigMF files, NPZ, sidecar. `tick` is called after each recording. Recordings are written while the next are made.
///
/// # Errors
///
/// Files that cannot be written.
pub fn make(work: &Work, part: u32, output: &Output, tick: &(dyn Fn() + Sync)) -> Result<(), OutputError> {
    let (range, name) = (work.recordings_of(part), npz_name(part));
    let (sender, receiver) = sync_channel(BATCHES);
    let spare = Spare::default();
    let (described, written) = thread::scope(|scope| {
        let write = || {
            output.fill(&name, |file| {
                let mut sink = Sink { file, hash: Hash::default(), bytes: 0, unsynced: 0 };
                let all = write(work, range.len(), &mut sink, receiver, &spare)?;
                Ok((FileRecord { name: name.clone(), bytes: sink.bytes, sha256: sink.hash.hex() }, all))
            })
        };
        let writer = thread::Builder::new().spawn_scoped(scope, write).map_err(|error| {
            let source = io::Error::other(format!("no thread can be started: {error}"));
            OutputError::Write { path: output.path(&name), source }
        })?;
        let described = simulate(work, range.clone(), output, tick, sender, &spare);
        Ok((described, writer.join().unwrap_or_else(|panic| resume_unwind(panic))))
    })?;
    let (described, (npz, all)) = (described?, written?);
    let record = |(index, one): (u32, One)| TruthRecord { index, label: one.label, truth: one.truth };
    let files = iter::once(npz).chain(described).collect();
    let sidecar = Sidecar { files, truth: range.zip(all).map(record).collect() };
    output.write_json(&sidecar_name(part), &sidecar)?;
    Ok(())
}

/// Makes recordings, and of each its SigMF files if asked for; `made` receives them in order. A batch has one recording a thread if raw slots
/// are wanted, which are large, else [`TOGETHER`]. Stops early where `made` is no longer received: the writer reports why.
fn simulate(
    work: &Work,
    range: Range<u32>,
    output: &Output,
    tick: &(dyn Fn() + Sync),
    made: SyncSender<Vec<One>>,
    spare: &Spare,
) -> Result<Vec<FileRecord>, OutputError> {
    let one = |index: u32| {
        let mut one = one(work, index, spare);
        let mut described = Vec::new();
        if work.request.sigmf {
            let raw = one.slots.as_ref().map(Slots::to_le_bytes).unwrap_or_default();
            described = sigmf::write(work, index, &one.truth, &raw, output)?;
        }
        if !work.request.raw {
            one.slots = None;
        }
        tick();
        Ok((one, described))
    };
    let step = rayon::current_num_threads() * if work.request.raw { 1 } else { TOGETHER };
    let mut files = Vec::new();
    for from in range.clone().step_by(step) {
        let batch = (from..range.end.min(from + step as u32)).into_par_iter().map(one);
        let (ones, described): (Vec<_>, Vec<_>) =
            batch.collect::<Result<Vec<_>, OutputError>>()?.into_iter().unzip();
        files.extend(described.into_iter().flatten());
        if made.send(ones).is_err() {
            break;
        }
    }
    Ok(files)
}

/// Writes the archive of `count` recordings as they come; what they still hold comes back.
fn write(
    work: &Work,
    count: usize,
    file: impl Write,
    made: Receiver<Vec<One>>,
    spare: &Spare,
) -> io::Result<Vec<One>> {
    // streamed: nothing that was written is written again, so that it can be hashed on its way
    let mut archive = ZipWriter::new_stream(UntilError { file, failed: false });
    let all = arrays(work, count, &mut archive, made, spare)?;
    archive.finish()?;
    Ok(all)
}

/// Where an archive goes: the file, its length and its digest. The disk gets it while more is made.
struct Sink<'a> {
    file: &'a mut BufWriter<File>,
    hash: Hash,
    bytes: u64,
    unsynced: usize,
}

impl Write for Sink<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.unsynced >= SYNCED {
            self.file.flush()?;
            self.file.get_ref().sync_all()?;
            self.unsynced = 0;
        }
        let written = self.file.write(bytes)?;
        self.bytes += written as u64;
        self.unsynced += written;
        self.hash.write_all(&bytes[..written])?;
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// Writes up to the first error, and nothing after it: a dropped archive tries to end itself once more, and would print that it cannot.
struct UntilError<W> {
    file: W,
    failed: bool,
}

impl<W> UntilError<W> {
    /// What the file says, or `after` once it has failed.
    fn attempt<T>(&mut self, after: T, act: impl FnOnce(&mut W) -> io::Result<T>) -> io::Result<T> {
        if self.failed {
            return Ok(after);
        }
        let done = act(&mut self.file);
        // interrupted, it is tried again
        self.failed = done.as_ref().is_err_and(|error| error.kind() != io::ErrorKind::Interrupted);
        done
    }
}

impl<W: Write> Write for UntilError<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.attempt(bytes.len(), |file| file.write(bytes))
    }

    fn flush(&mut self) -> io::Result<()> {
        self.attempt((), W::flush)
    }
}

/// Writes the arrays. The largest is first and is written while recordings are made: the raw slots if they are wanted, else the beats.
fn arrays<W: Write + Seek>(
    work: &Work,
    n: usize,
    archive: &mut ZipWriter<W>,
    made: Receiver<Vec<One>>,
    spare: &Spare,
) -> io::Result<Vec<One>> {
    let slots = work.slots() as usize;
    let config = work.scenario.radar.config();
    let samples = usize::from(config.samples);
    let raw_shape = match config.format {
        SampleFormat::Complex => vec![n, slots, samples, 2],
        SampleFormat::Real => vec![n, slots, samples],
    };
    let raw_bytes = |one: &mut One, put: Put| {
        let values = one.slots.take().map(|slots| slots.values).unwrap_or_default();
        values.chunks(VALUES).try_for_each(|values| put(&to_le_bytes(values)))?;
        if let Ok(mut spare) = spare.lock() {
            spare.push(values);
        }
        Ok(())
    };
    let beat_bytes = |one: &mut One, put: Put| {
        let parts = std::mem::take(&mut one.beat).into_iter().flatten().flat_map(|z| [z.re, z.im]);
        put(parts.map(i32::to_le_bytes).collect::<Vec<_>>().as_flattened())
    };
    let raw: Column = ("raw", ("<i2", 2), raw_shape, &raw_bytes);
    let beat: Column = ("beat", ("<i4", 4), vec![n, slots, BEATS, 2], &beat_bytes);
    let ((name, format, shape, bytes), later) =
        if work.request.raw { (raw, Some(beat)) } else { (beat, None) };
    let mut all = Vec::with_capacity(n);
    array(archive, name, format, &shape, |put| {
        for mut ones in made {
            ones.iter_mut().try_for_each(|one| bytes(one, put))?;
            all.extend(ones);
        }
        Ok(())
    })?;
    let frames = work.scenario.spectrogram.preprocessing().frames(slots);
    array(archive, "image", ("|i1", 1), &[n, ROWS, frames], |put| {
        all.iter_mut().try_for_each(|one| {
            put(&std::mem::take(&mut one.image).into_iter().map(i8::cast_unsigned).collect::<Vec<_>>())
        })
    })?;
    if let Some((name, format, shape, bytes)) = later {
        array(archive, name, format, &shape, |put| all.iter_mut().try_for_each(|one| bytes(one, put)))?;
    }
    array(archive, "label", ("|u1", 1), &[n], |put| all.iter().try_for_each(|one| put(&[one.label])))?;
    Ok(all)
}

/// The sidecar of a part and its bytes.
///
/// # Errors
///
/// A sidecar that is missing or no JSON.
pub fn sidecar(part: u32, output: &Output) -> Result<(Sidecar, Vec<u8>), OutputError> {
    let name = sidecar_name(part);
    let bytes = output.read(&name, REMAKE)?;
    match serde_json::from_slice(&bytes) {
        Ok(sidecar) => Ok((sidecar, bytes)),
        Err(error) => {
            Err(OutputError::Content { path: output.path(&name), reason: format!("{error}; {REMAKE}") })
        }
    }
}

/// Whether a part is there; `read` also hashes its files, otherwise their sizes must do.
pub fn is_whole(work: &Work, part: u32, output: &Output, read: bool) -> bool {
    let Ok((sidecar, _)) = sidecar(part, output) else { return false };
    let range = work.recordings_of(part);
    let mut names = vec![npz_name(part)];
    if work.request.sigmf {
        names.extend(range.clone().flat_map(sigmf::names));
    }
    sidecar.files.iter().map(|file| &file.name).eq(&names)
        && sidecar.truth.iter().map(|record| record.index).eq(range)
        && sidecar.files.iter().all(|file| file.is_there(output, read))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{Cursor, ErrorKind};

    /// Interrupted once, then full after so many bytes.
    struct Full {
        file: Cursor<Vec<u8>>,
        left: usize,
        interrupted: bool,
    }

    impl Write for Full {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            if !std::mem::replace(&mut self.interrupted, true) {
                return Err(ErrorKind::Interrupted.into());
            }
            let most = bytes.len().min(self.left);
            self.left -= most;
            if most == 0 { Err(ErrorKind::StorageFull.into()) } else { self.file.write(&bytes[..most]) }
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_full_disk_is_an_error_once_and_an_interruption_is_none() {
        let file = Full { file: Cursor::default(), left: 3, interrupted: false };
        let mut writer = UntilError { file, failed: false };
        let error = writer.write_all(b"array").unwrap_err();
        assert_eq!(error.kind(), ErrorKind::StorageFull);
        assert_eq!(writer.file.file.get_ref(), b"arr");
        writer.write_all(b"the end").unwrap();
        assert_eq!(writer.file.file.get_ref(), b"arr");
    }
}
