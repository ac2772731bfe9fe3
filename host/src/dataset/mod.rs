//! Datasets: parts that `numpy.load` reads, SigMF on request, and a manifest; made in shards, resumed after any interruption.
//!
//! Written in this order, each file whole or not at all: `scenario.toml`, `request.json`, the parts, `manifest.json`. A part is the
//! SigMF files of its recordings, then `part-00000.npz`, then the sidecar `part-00000.json` that says it is whole. The bytes of
//! every file depend on scenario, rho, seed and options alone.
//!
//! An NPZ holds `image` int8 `[recording, 64, frames]`, `beat` int32 `[recording, slot, 8, 2]` (re, im), `label` uint8
//! `[recording]` and, if asked for, `raw` int16 `[recording, slot, samples, 2]` (I, Q), or `[recording, slot, samples]` of a real
//! converter; `beat` then holds its beats.

mod manifest;
pub mod part;
mod record;
mod sigmf;
mod stored;

use crate::scenario::{Class, Scenario};
use crate::store::digest::sha256;
use crate::store::output::{Output, OutputError};
use crate::store::resume::ensure_same_config;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt::{self, Display, Formatter};
use std::ops::{Range, RangeInclusive};
use std::str::FromStr;
use std::sync::atomic::{AtomicU64, Ordering};

pub use record::TruthRecord;
pub use stored::{Labelled, Stored, StoredError};

/// Legal recordings of each class: their parts are numbered with five digits.
pub const PER_CLASS: RangeInclusive<u32> = 1..=2_000_000;

const REQUEST: &str = "request.json";

/// What a dataset is besides its scenario: `request.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Request {
    /// Version of the program that began it.
    pub version: String,
    /// SHA-256 of `scenario.toml`.
    pub scenario_sha256: String,
    /// AR(1) coefficient rho of the room channel.
    pub rho: f64,
    /// Seed.
    pub seed: u64,
    /// Recordings of each class, within [`PER_CLASS`].
    pub per_class: u32,
    /// The classes, in the order of their labels; recordings take turns.
    pub classes: Vec<Class>,
    /// Whether the parts hold raw slots.
    pub raw: bool,
    /// Whether there are SigMF recordings.
    pub sigmf: bool,
}

/// Which pieces to make: those of which the number leaves `index - 1` when divided by `count`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    index: u32,
    count: u32,
}

impl Shard {
    /// All pieces.
    pub const ALL: Shard = Shard { index: 1, count: 1 };

    /// The `index`-th of `count`, 1 to count.
    pub fn new(index: u32, count: u32) -> Option<Self> {
        (1..=count).contains(&index).then_some(Shard { index, count })
    }

    /// Whether the piece of this number, from 0, is one of the shard's.
    pub fn has(self, number: u32) -> bool {
        number % self.count == self.index - 1
    }
}

impl Display for Shard {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = text.split_once('/').and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
        let shard = numbers.and_then(|(index, count)| Shard::new(index, count));
        shard.ok_or_else(|| format!("{text} is not in 1/N to N/N: the I-th of N shards, for example 2/3"))
    }
}

/// A dataset to be made.
#[derive(Debug)]
pub struct Work<'a> {
    scenario: &'a Scenario,
    rho: f64,
    request: Request,
}

impl<'a> Work<'a> {
    /// `per_class` recordings of each of `classes`, with raw slots in the parts or as SigMF if asked for.
    pub fn new(
        scenario: &'a Scenario,
        rho: f64,
        seed: u64,
        per_class: u32,
        classes: Vec<Class>,
        raw: bool,
        sigmf: bool,
    ) -> Work<'a> {
        let request = Request {
            version: env!("CARGO_PKG_VERSION").into(),
            scenario_sha256: sha256([scenario.to_toml().as_bytes()]),
            rho,
            seed,
            per_class,
            classes,
            raw,
            sigmf,
        };
        Work { scenario, rho, request }
    }

    /// Recordings of all classes.
    pub fn recordings(&self) -> u32 {
        self.request.per_class.saturating_mul(self.request.classes.len() as u32)
    }

    /// The files that say what the dataset is, by name.
    fn texts(&self) -> [(&'static str, String); 2] {
        let request = format!("{}\n", crate::store::output::to_json(&self.request));
        [(Scenario::FILE, self.scenario.to_toml()), (REQUEST, request)]
    }

    fn parts(&self) -> u32 {
        self.recordings().div_ceil(part::RECORDINGS)
    }

    fn recordings_of(&self, part: u32) -> Range<u32> {
        let first = part * part::RECORDINGS;
        first..self.recordings().min(first + part::RECORDINGS)
    }

    /// Sensing slots of a recording: the largest N_s.
    pub fn slots(&self) -> u32 {
        self.scenario.largest_sensing_slots()
    }

    /// Makes what is missing of the shard's parts, then the manifest if no part of any shard is missing.
    ///
    /// # Errors
    ///
    /// A folder that holds another dataset; files that cannot be written.
    pub fn write(
        &self,
        shard: Shard,
        output: &Output,
        progress: &(dyn Fn(u64, u64) + Sync),
    ) -> Result<Written, OutputError> {
        self.ensure_same_config(output)?;
        for (name, text) in self.texts() {
            if std::fs::read(output.path(name)).ok().is_none_or(|found| found != text.as_bytes()) {
                output.write(name, text.as_bytes())?;
            }
        }
        let mine: Vec<u32> = (0..self.parts()).filter(|part| shard.has(*part)).collect();
        let total = mine.iter().map(|part| self.recordings_of(*part).len() as u64).sum();
        let done = AtomicU64::new(0);
        let more =
            |recordings: u64| progress(done.fetch_add(recordings, Ordering::Relaxed) + recordings, total);
        let missing: Vec<u32> = mine
            .par_iter()
            .copied()
            .filter(|part| {
                let whole = part::is_whole(self, *part, output, true);
                if whole {
                    more(self.recordings_of(*part).len() as u64);
                }
                !whole
            })
            .collect();
        for part in &missing {
            part::make(self, *part, output, &|| more(1))?;
        }
        let complete = (0..self.parts())
            .into_par_iter()
            .all(|part| shard.has(part) || part::is_whole(self, part, output, false));
        if complete {
            manifest::write(self, output)?;
        }
        Ok(Written {
            recordings: self.recordings(),
            parts: self.parts(),
            made: missing.len() as u32,
            kept: (mine.len() - missing.len()) as u32,
            manifest: complete.then_some(manifest::NAME),
        })
    }

    /// Refuses a folder of another scenario or request.
    fn ensure_same_config(&self, output: &Output) -> Result<(), OutputError> {
        let asked = toml::from_str(&self.scenario.to_toml()).unwrap_or_default();
        ensure_same_config(output, Scenario::FILE, &asked, |text| {
            toml::from_str(text).map_err(|e| e.to_string())
        })?;
        let asked = serde_json::to_value(&self.request).unwrap_or_default();
        ensure_same_config(output, REQUEST, &asked, |text| {
            serde_json::from_str(text).map_err(|e| e.to_string())
        })
    }
}

/// What was done.
#[derive(Debug, PartialEq, Serialize, JsonSchema)]
pub struct Written {
    /// Recordings of the whole dataset.
    pub recordings: u32,
    /// Parts of the whole dataset.
    pub parts: u32,
    /// Parts made now.
    pub made: u32,
    /// Parts of this shard that were there.
    pub kept: u32,
    /// The manifest, if the dataset is complete.
    pub manifest: Option<&'static str>,
}

#[cfg(test)]
mod tests;
