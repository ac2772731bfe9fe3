//! The networks that classify: a model alone, or the early exits of a folder up to it.

use super::{fitted, unfitted};
use crate::error::{Failure, Invalid};
use crate::formats::model_file::{self, QUANTIZE_FIRST};
use crate::results::{EarlyExitResult, UsedExits};
use crate::scenario::Scenario;
use crate::store::limited;
use crate::store::output::{Output, OutputError};
use sdp3_core::dsn::Model;
use sdp3_core::early_exit::{EXITS, EarlyExit};
use std::path::{Path, PathBuf};

/// What `sdp3 early-exits` writes.
const FITTED: &str = "early-exits.json";

/// A threshold that no confidence reaches.
const NEVER: f64 = 2.0;

/// The early exits of a folder.
#[derive(Debug, Clone)]
pub struct EarlyExits {
    /// A folder with the models of several N_s, and with what `sdp3 early-exits` fitted to them, if it did.
    pub folder: PathBuf,
    /// Confidence that stops, 0 to 2, above 1 never; absent: the fitted operating point's.
    pub threshold: Option<f64>,
}

/// A model file, on disk or in memory.
#[derive(Debug, Clone)]
pub enum ModelFile {
    /// Its path.
    Path(PathBuf),
    /// Its bytes.
    Bytes(Vec<u8>),
}

impl From<PathBuf> for ModelFile {
    fn from(path: PathBuf) -> Self {
        ModelFile::Path(path)
    }
}

impl ModelFile {
    /// Its path, or `model` of one in memory.
    pub(crate) fn name(&self) -> &Path {
        match self {
            ModelFile::Path(path) => path,
            ModelFile::Bytes(_) => Path::new("model"),
        }
    }

    fn bytes(&self) -> Result<Vec<u8>, Failure> {
        match self {
            ModelFile::Path(path) => Ok(limited::read(path, limited::NETWORK)
                .map_err(|error| format!("{}: {error}", path.display()))?),
            ModelFile::Bytes(bytes) => Ok(bytes.clone()),
        }
    }
}

/// What `sdp3 early-exits` fitted to the models of a folder.
///
/// # Errors
///
/// A file that is not there, or not such a result.
pub(crate) fn fit_of(folder: &Output) -> Result<EarlyExitResult, OutputError> {
    Ok(folder.read_result(FITTED, "`sdp3 early-exits` with the same --out makes it")?.0)
}

/// Model files, fewest sensing slots first, and when they stop.
pub(crate) struct StoredExits {
    files: Vec<(PathBuf, Vec<u8>)>,
    /// Weights of every exit's evidence, if they were fitted.
    weights: Option<Vec<Vec<i32>>>,
    /// Confidence that stops.
    pub(crate) threshold: f64,
}

impl StoredExits {
    /// A model, and the exits before it.
    ///
    /// # Errors
    ///
    /// Files that cannot be read; a model that is none of the folder's exits, or the first; no threshold.
    pub(crate) fn read(model: &ModelFile, exits: Option<&EarlyExits>) -> Result<Self, Failure> {
        let (model, bytes) = (model.name(), model.bytes()?);
        let own = parsed(model, &bytes)?.sensing_slots() as u32;
        let file = (model.to_owned(), bytes);
        let Some(EarlyExits { folder, threshold }) = exits else {
            return Ok(StoredExits { files: vec![file], weights: None, threshold: NEVER });
        };
        let stored = Output::reading(folder);
        let known = if stored.path(FITTED).exists() { Some(fit_of(&stored)?) } else { None };
        let threshold = threshold.or(known.as_ref().map(|known| known.operating_point.point.threshold));
        let legal = format!("stated, 0 to {NEVER}: {} is not there", stored.path(FITTED).display());
        let threshold = threshold.ok_or_else(|| Invalid::option("--threshold", "missing", legal))?;
        if !(0.0..=NEVER).contains(&threshold) {
            return Err(Invalid::option("--threshold", threshold, format!("0 to {NEVER}")).into());
        }
        let slots: Vec<u32> = match &known {
            Some(known) => known.exits.iter().map(|exit| exit.sensing_slots).collect(),
            None => Scenario::load(&stored.path(Scenario::FILE))?.frame.sensing_slots,
        };
        let before: Vec<u32> = slots.iter().copied().take_while(|&n| n < own).collect();
        let name = model_file::name(own);
        if !slots.contains(&own) || stored.read(&name, QUANTIZE_FIRST)? != file.1 {
            let names: Vec<String> = slots.iter().map(|&n| model_file::name(n)).collect();
            let legal = format!("{} of {}", names.join(" or "), folder.display());
            return Err(Invalid::option("MODEL with --early-exits", model.display(), legal).into());
        }
        if !(1..EXITS).contains(&before.len()) {
            let legal = format!("1 to {} models of fewer than {own} slots, MODEL's", EXITS - 1);
            let value = format!("{} with {}", folder.display(), before.len());
            return Err(Invalid::option("--early-exits", value, legal).into());
        }
        let read = |&n: &u32| {
            Ok((stored.path(&model_file::name(n)), stored.read(&model_file::name(n), QUANTIZE_FIRST)?))
        };
        let mut files = before.iter().map(read).collect::<Result<Vec<_>, OutputError>>()?;
        files.push(file);
        let weights = known.map(|known| known.exits.into_iter().map(|exit| exit.weights).collect());
        Ok(StoredExits { files, weights, threshold })
    }

    /// The exits, fewest sensing slots first.
    ///
    /// # Errors
    ///
    /// A model that the core refuses.
    pub(crate) fn exits(&self) -> Result<Vec<EarlyExit<'_>>, Failure> {
        let models = self.files.iter().map(|(path, bytes)| parsed(path, bytes));
        let models = models.collect::<Result<Vec<_>, Failure>>()?.into_iter();
        Ok(match &self.weights {
            Some(weights) => models.zip(weights).map(|(model, weights)| fitted(model, weights)).collect(),
            None => models.enumerate().map(|(number, model)| unfitted(model, number)).collect(),
        })
    }

    /// What was used of a folder's exits, by as many windows with so many slots together.
    pub(crate) fn used(&self, folder: &Path, exits: &[EarlyExit], windows: u64, slots: u64) -> UsedExits {
        UsedExits {
            folder: folder.display().to_string(),
            sensing_slots: exits.iter().map(|exit| exit.model.sensing_slots() as u32).collect(),
            threshold: self.threshold,
            fitted: self.weights.is_some(),
            mean_slots_used: slots as f64 / windows.max(1) as f64,
        }
    }
}

fn parsed<'m>(path: &Path, bytes: &'m [u8]) -> Result<Model<'m>, Failure> {
    Ok(Model::parse(bytes).map_err(|error| format!("{}: {error}", path.display()))?)
}
