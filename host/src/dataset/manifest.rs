//! `manifest.json`: what a dataset is, file by file and recording by recording; the last file to appear.
//!
//! It is put together from the sidecars, one at a time, so that its length needs no memory.

use super::{Work, part};
use crate::error::Invalid;
use crate::scenario::{Class, Scenario};
use crate::store::difference::difference;
use crate::store::digest::Hash;
use crate::store::file_record::FileRecord;
use crate::store::output::{Output, OutputError};
use sdp3_core::config::SampleFormat;
use serde::ser::{Error, SerializeSeq};
use serde::{Serialize, Serializer};
use std::io::{self, Write};

pub const NAME: &str = "manifest.json";

#[derive(Clone, Copy, Serialize)]
struct Array {
    name: &'static str,
    dtype: &'static str,
    axes: &'static [&'static str],
    meaning: &'static str,
}

const ARRAYS: [Array; 4] = [
    Array {
        name: "image",
        dtype: "int8",
        axes: &["recording", "doppler", "frame"],
        meaning: "intensity minus 128 of the Doppler spectrogram: what the network sees",
    },
    Array {
        name: "beat",
        dtype: "int32",
        axes: &["recording", "slot", "fast_time", "re/im"],
        meaning: "range samples: dechirped sums of blocks of a sweep (of 125 samples, 1000 are one ADC LSB of echo), or cells of the range gate",
    },
    Array { name: "label", dtype: "uint8", axes: &["recording"], meaning: "index into classes" },
    Array {
        name: "raw",
        dtype: "int16",
        axes: &["recording", "slot", "sample", "i/q"],
        meaning: "converter output in ADC LSB at the sampling rate of the scenario's radar",
    },
];

#[derive(Serialize)]
struct Manifest<'a, F: Serialize, T: Serialize> {
    program: String,
    scenario: &'a Scenario,
    rho: f64,
    seed: u64,
    recordings: u32,
    recordings_per_part: u32,
    sensing_slots: u32,
    classes: &'a [Class],
    arrays: &'a [Array],
    files: F,
    truth: T,
}

/// The rows of all parts, read while they are written.
struct Rows<F> {
    parts: u32,
    of: F,
}

impl<R: Serialize, F: Fn(u32) -> Result<Vec<R>, OutputError>> Serialize for Rows<F> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut sequence = serializer.serialize_seq(None)?;
        for part in 0..self.parts {
            for row in (self.of)(part).map_err(S::Error::custom)? {
                sequence.serialize_element(&row)?;
            }
        }
        sequence.end()
    }
}

fn print(work: &Work, output: &Output, mut file: impl Write) -> io::Result<()> {
    let files_of = |number: u32| {
        let (sidecar, bytes) = part::sidecar(number, output)?;
        let mut files = sidecar.files;
        files.push(FileRecord::new(part::sidecar_name(number), &bytes));
        if number == 0 {
            // as this work has them: another command in the folder may have written its own
            files
                .splice(0..0, work.texts().map(|(name, text)| FileRecord::new(name.into(), text.as_bytes())));
        }
        Ok(files)
    };
    let mut arrays = ARRAYS;
    if work.scenario.radar.config().format == SampleFormat::Real {
        arrays[3].axes = &["recording", "slot", "sample"];
    }
    let arrays = if work.request.raw { &arrays[..] } else { &arrays[..3] };
    let manifest = Manifest {
        program: format!("sdp3 {}", work.request.version),
        scenario: work.scenario,
        rho: work.rho,
        seed: work.request.seed,
        recordings: work.recordings(),
        recordings_per_part: part::RECORDINGS,
        sensing_slots: work.slots(),
        classes: &work.request.classes,
        arrays,
        files: Rows { parts: work.parts(), of: files_of },
        truth: Rows { parts: work.parts(), of: |part| Ok(part::sidecar(part, output)?.0.truth) },
    };
    serde_json::to_writer_pretty(&mut file, &manifest)?;
    file.write_all(b"\n")
}

/// Writes the manifest of a complete dataset; a correct one is not written again.
///
/// # Errors
///
/// A sidecar that cannot be read, or a manifest that cannot be written.
pub fn write(work: &Work, output: &Output) -> Result<(), OutputError> {
    if output.path(NAME).exists() && is_current(work, output)? {
        return Ok(());
    }
    output.fill(NAME, |file| print(work, output, file))
}

fn is_current(work: &Work, output: &Output) -> Result<bool, OutputError> {
    let mut hash = Hash::default();
    print(work, output, &mut hash).map_err(broken(output))?;
    Ok(FileRecord::of(output, NAME)?.sha256 == hash.hex())
}

fn broken(output: &Output) -> impl Fn(io::Error) -> OutputError {
    let path = output.path(NAME);
    move |error| OutputError::Content { path: path.clone(), reason: error.to_string() }
}

/// Refuses a manifest with any field that does not follow from request, scenario and sidecars.
///
/// # Errors
///
/// The first such field; a sidecar that cannot be read.
pub fn check(work: &Work, output: &Output) -> Result<(), OutputError> {
    if is_current(work, output)? {
        return Ok(());
    }
    let mut text = Vec::new();
    print(work, output, &mut text).map_err(broken(output))?;
    let must = serde_json::from_slice(&text).map_err(|error| broken(output)(error.into()))?;
    let found = output.read_json(NAME, part::REMAKE)?;
    let (field, found, must) = difference("", &found, &must).unwrap_or((
        "its text".into(),
        "another".into(),
        "as it was written".into(),
    ));
    let legal = format!("{must}, by {}, {} and the parts' sidecars", super::REQUEST, Scenario::FILE);
    Err(OutputError::Content {
        path: output.path(NAME),
        reason: Invalid::new(field, found, legal).to_string(),
    })
}
