//! Measured signals to calibrate on: WAV, NPY, NPZ, SigMF and, with the feature `hdf5`, HDF5.
//!
//! What a file does not say about itself (carrier, rate) the user states; what both say, the user decides. Levels are relative:
//! calibration compares spectrograms on their own mean power, so a gain only changes the power that is printed.

mod array;
#[cfg(feature = "hdf5")]
mod hdf5;
mod npy;
mod sigmf;
mod wav;

use crate::error::Invalid;
use crate::formats::slots::Slots;
use crate::scenario::budget::{Budget, Need};
use rustfft::num_complex::Complex64;
use std::fmt::Display;
use std::path::{Path, PathBuf};

/// Most memory that a number takes while it is read, in bytes: as it is in the file, and as half of a complex one that is copied once.
const BYTES_PER_NUMBER: f64 = 24.0;

/// A measured signal.
#[derive(Debug, Clone)]
pub struct Signal {
    /// The samples.
    pub samples: Samples,
    /// Their rate in Hz; of slots, the slow-time rate.
    pub rate_hz: f64,
    /// Carrier in Hz.
    pub carrier_hz: f64,
    /// Name of the file.
    pub title: String,
}

/// Samples.
#[derive(Debug, Clone)]
pub enum Samples {
    /// One number a time: a CW Doppler sensor.
    Real(Vec<f64>),
    /// Complex slow time of one range cell.
    Complex(Vec<Complex64>),
    /// Raw FMCW slots of the scenario's radar.
    Slots(Slots),
}

impl Samples {
    /// How many moments they show.
    pub fn len(&self) -> usize {
        match self {
            Self::Real(x) => x.len(),
            Self::Complex(z) => z.len(),
            Self::Slots(slots) => slots.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The first sample that is no finite number, and what it is.
    fn not_finite(&self) -> Option<(usize, f64)> {
        let first = |values: &mut dyn Iterator<Item = f64>| values.enumerate().find(|(_, v)| !v.is_finite());
        match self {
            Self::Real(x) => first(&mut x.iter().copied()),
            // NaN or infinite where one of the two is
            Self::Complex(z) => first(&mut z.iter().map(|z| if z.re.is_finite() { z.im } else { z.re })),
            Self::Slots(_) => None,
        }
    }

    /// Mean power; of slots, of their complex samples, or those that real ones stand for, against full scale.
    fn power(&self) -> f64 {
        let mean = |sum: f64, n: usize| sum / n.max(1) as f64;
        match self {
            Self::Real(x) => mean(x.iter().map(|x| x * x).sum(), x.len()),
            Self::Complex(z) => mean(z.iter().map(|z| z.norm_sqr()).sum(), z.len()),
            Self::Slots(slots) => {
                let square = |v: i16| (f64::from(v) / 32768.0).powi(2);
                2.0 * mean(slots.values.iter().map(|&v| square(v)).sum(), slots.values.len())
            }
        }
    }
}

/// What the user states about a file.
#[derive(Debug, Clone, Default)]
pub struct Stated {
    /// Carrier in Hz.
    pub carrier_hz: Option<f64>,
    /// Rate of the samples, or of the slots, in Hz.
    pub rate_hz: Option<f64>,
    /// Gain of the sensor in dB, taken off.
    pub gain_db: Option<f64>,
    /// Which array of an NPZ, which dataset of an HDF5 file.
    pub dataset: Option<String>,
    /// What reading may take.
    pub budget: Budget,
}

/// What a file holds, before it is checked.
struct Contents {
    samples: Samples,
    rate_hz: Option<f64>,
    carrier_hz: Option<f64>,
}

/// Why a file is not a usable measurement.
#[derive(Debug, thiserror::Error)]
pub enum MeasuredError {
    /// It cannot be opened or is not what its name says.
    #[error("{file}: not a readable {format} file: {reason}")]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// What its name says.
        format: &'static str,
        /// What the reader says.
        reason: String,
    },
    /// A field that may not be what it is.
    #[error(transparent)]
    Invalid(#[from] Invalid),
}

/// Names the file in errors, and holds it to a budget.
#[derive(Clone, Copy)]
struct Source<'a>(&'a Path, Budget);

impl Source<'_> {
    fn unreadable(self, format: &'static str, reason: impl ToString) -> MeasuredError {
        MeasuredError::Unreadable { file: self.0.to_owned(), format, reason: reason.to_string() }
    }

    fn value(self, field: impl Display, value: impl Display, legal: impl Display) -> MeasuredError {
        Invalid::new(field, value, legal).at(self.0.display()).into()
    }

    /// Refuses more numbers than fit the memory; `field` with `value` states them.
    fn fits(self, field: &'static str, value: impl Display, numbers: u64) -> Result<(), MeasuredError> {
        let need = Need::new(field, value.to_string(), BYTES_PER_NUMBER * numbers as f64);
        Ok(self.1.check_memory(&[need]).map_err(|invalid| invalid.at(self.0.display()))?)
    }

    /// What the user states or the file says, within its range.
    fn known(
        self,
        (stated, said): (Option<f64>, Option<f64>),
        (field, flag): (&'static str, &'static str),
        (range, legal): (std::ops::RangeInclusive<f64>, &'static str),
    ) -> Result<f64, MeasuredError> {
        let missing = || self.value(field, "missing", format!("in the file or stated with {flag}: {legal}"));
        let value = stated.or(said).ok_or_else(missing)?;
        if range.contains(&value) { Ok(value) } else { Err(self.value(field, value, legal)) }
    }
}

/// Reads a measured signal: at least 1.5 s at 10 Hz to 400 kHz of a carrier between 0.5 and 100 GHz, finite and not silent.
///
/// The file's extension decides how it is read. See [`Stated`] for what the user may add.
///
/// # Errors
///
/// [`MeasuredError`] naming the file and what is wrong with it.
pub fn read(file: &Path, stated: &Stated) -> Result<Signal, MeasuredError> {
    let source = Source(file, stated.budget);
    let extension = file.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    let contents = match extension.as_str() {
        "wav" => wav::read(source)?,
        "npy" => npy::read(source)?,
        "npz" => npy::read_archive(source, stated.dataset.as_deref())?,
        "sigmf-meta" | "sigmf-data" | "sigmf" => sigmf::read(source)?,
        #[cfg(feature = "hdf5")]
        "h5" | "hdf5" => hdf5::read(source, stated.dataset.as_deref())?,
        #[cfg(not(feature = "hdf5"))]
        "h5" | "hdf5" => {
            let reason = "this program was built without HDF5; build it with --features hdf5";
            return Err(source.unreadable("HDF5", reason));
        }
        _ => {
            let legal = ".wav, .npy, .npz, .sigmf-meta, .h5";
            return Err(source.value("extension", format!("{extension:?}"), legal));
        }
    };
    checked(source, contents, stated)
}

/// A signal that is in memory, held to the same limits as one in a file; `name` stands for the file in errors.
///
/// # Errors
///
/// As [`read`].
pub fn signal(name: &str, samples: Samples, stated: &Stated) -> Result<Signal, MeasuredError> {
    checked(
        Source(Path::new(name), stated.budget),
        Contents { samples, rate_hz: None, carrier_hz: None },
        stated,
    )
}

fn checked(source: Source, contents: Contents, stated: &Stated) -> Result<Signal, MeasuredError> {
    let rate_hz = source.known(
        (stated.rate_hz, contents.rate_hz),
        ("rate (Hz)", "--rate"),
        (10.0..=400e3, "10 to 400000 Hz"),
    )?;
    let carrier_hz = source.known(
        (stated.carrier_hz, contents.carrier_hz),
        ("carrier (Hz)", "--carrier"),
        (0.5e9..=100e9, "0.5e9 to 100e9 Hz"),
    )?;
    let gain_db = stated.gain_db.unwrap_or(0.0);
    if !(-200.0..=200.0).contains(&gain_db) {
        return Err(source.value("--gain", gain_db, "-200 to 200 dB"));
    }
    if let Some((n, value)) = contents.samples.not_finite() {
        return Err(source.value(format!("sample {n}"), value, "finite numbers"));
    }
    let power = contents.samples.power();
    if !power.is_finite() {
        return Err(source.value("mean power", power, "a finite number"));
    }
    let seconds = contents.samples.len() as f64 / rate_hz;
    if seconds < 1.5 {
        return Err(source.value("length (s)", format!("{seconds:.3}"), "at least 1.5"));
    }
    if power == 0.0 {
        return Err(source.value("mean power", 0, "above 0: nothing was recorded"));
    }
    let name = source.0.file_name().unwrap_or_default().to_string_lossy();
    let title = format!("{name} (mean power {:.1} dB)", 10.0 * libm::log10(power) - gain_db);
    Ok(Signal { samples: contents.samples, rate_hz, carrier_hz, title })
}

#[cfg(test)]
mod tests;
