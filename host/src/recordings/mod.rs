//! Measured signals: WAV, CSV, NPY, NPZ, MATLAB, SigMF, HDF5 (feature `hdf5`), recordings of Infineon's radar SDK and raw data, and captures
//! of TI's DCA1000. What a file is, its first bytes say, or its name where they cannot.
//!
//! What a file does not say about itself (carrier, rate) the user states; what both say, the user decides. Levels are relative:
//! calibration compares spectrograms on their own mean power, so a gain only changes the power that is printed.

pub(crate) mod annotations;
mod array;
mod cube;
mod dca1000;
pub(crate) mod doppler;
mod expected;
#[cfg(feature = "hdf5")]
mod hdf5;
mod infineon;
mod infineon_raw;
pub(crate) mod labels;
mod matlab;
mod npy;
mod sigmf;
mod table;
mod wav;

use crate::error::Invalid;
use crate::formats::slots::Slots;
use crate::results::About;
use crate::scenario::budget::{Budget, Need};
use crate::store::limited;
use rustfft::num_complex::Complex64;
use std::fmt::Display;
use std::io::Read;
use std::path::{Path, PathBuf};

pub use cube::Chirps;
pub use expected::Expected;

/// Most memory that a number takes while it is read, in bytes: as it is in the file, and as half of a complex one that is copied once.
const BYTES_PER_NUMBER: f64 = 24.0;

/// Shortest recording in s to calibrate on.
const SHORTEST_S: f64 = 1.5;

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
    /// Mean power in dB, the gain stated taken off.
    pub power_db: f64,
    /// What the file is.
    pub about: About,
}

impl Signal {
    /// The rate in Hz of slots made of its samples ([`Expected::slots`]): of a Doppler sensor they are fewer than these.
    pub fn slot_rate_hz(&self, slots: &Slots) -> f64 {
        self.rate_hz * slots.len() as f64 / self.samples.len() as f64
    }
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

    /// The samples as bytes: int16 of slots, else f64, complex ones as two, little-endian.
    pub fn to_le_bytes(&self) -> Vec<u8> {
        match self {
            Self::Real(x) => x.iter().flat_map(|x| x.to_le_bytes()).collect(),
            Self::Complex(z) => z.iter().flat_map(|z| [z.re, z.im]).flat_map(f64::to_le_bytes).collect(),
            Self::Slots(slots) => slots.to_le_bytes(),
        }
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
    /// Which array of an NPZ or MATLAB file, which dataset of an HDF5 file.
    pub dataset: Option<String>,
    /// Receive antenna of a radar module, from 1.
    pub antenna: Option<u32>,
    /// Chirps of a frame of a radar module.
    pub chirp: Option<Chirps>,
    /// Description of a DCA1000 capture, if it is not beside it.
    pub config: Option<PathBuf>,
    /// Take the first antenna and chirp where none is stated.
    pub first: bool,
    /// What reading may take.
    pub budget: Budget,
}

/// What a file holds, before it is checked.
struct Contents {
    samples: Samples,
    rate_hz: Option<f64>,
    carrier_hz: Option<f64>,
    about: About,
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

    /// Refuses what is no positive number.
    fn positive(self, field: &str, value: f64) -> Result<(), MeasuredError> {
        if value.is_finite() && value > 0.0 {
            Ok(())
        } else {
            Err(self.value(field, value, "a number above 0"))
        }
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

/// Formats.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Format {
    Wav,
    Csv,
    Npy,
    Npz,
    Matlab,
    Hdf5 { matlab: bool },
    SigMf,
    Infineon(PathBuf),
    InfineonRaw,
    Dca1000,
}

/// What is read, for errors.
const FORMATS: &str = "WAV, CSV, NPY, NPZ, MATLAB (.mat), SigMF (.sigmf-meta), HDF5 (.h5), a folder of Infineon's radar SDK (config.json and radar.npy), \
     Infineon's raw data (.raw.txt, .raw.bin) or a DCA1000 capture (.bin)";

/// What a path is: by the names in a folder, by a file's first bytes, or by its extension.
fn recognised(source: Source) -> Result<Format, MeasuredError> {
    if let Some(folder) = infineon::folder(source.0) {
        return Ok(Format::Infineon(folder));
    }
    let extension = source.0.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    if extension.starts_with("sigmf") {
        return Ok(Format::SigMf);
    }
    if source.0.is_dir() {
        return Err(source.value("folder", "none of a recording", "one with config.json and radar.npy"));
    }
    let unreadable = |error| source.unreadable("recording", error);
    let file = limited::open(source.0, limited::WHOLE).map_err(unreadable)?;
    let mut first = Vec::new();
    file.take(64).read_to_end(&mut first).map_err(unreadable)?;
    let begins = |magic: &[u8]| first.starts_with(magic);
    Ok(match extension.as_str() {
        _ if begins(b"RIFF") => Format::Wav,
        _ if begins(b"\x93NUMPY") => Format::Npy,
        _ if begins(b"PK\x03\x04") => Format::Npz,
        _ if begins(matlab::MAGIC) => Format::Matlab,
        _ if begins(b"MATLAB 7.3 MAT-file") => Format::Hdf5 { matlab: true },
        _ if infineon_raw::MAGIC.into_iter().any(begins) => Format::InfineonRaw,
        _ if begins(b"\x89HDF") => Format::Hdf5 { matlab: false },
        "wav" => Format::Wav,
        "npy" => Format::Npy,
        "npz" => Format::Npz,
        "mat" => Format::Matlab,
        "h5" | "hdf5" => Format::Hdf5 { matlab: false },
        "csv" => Format::Csv,
        "bin" => Format::Dca1000,
        _ => return Err(source.value("extension", format!("{extension:?}"), FORMATS)),
    })
}

/// Reads a measured signal to calibrate on: as [`open`], and at least 1.5 s long.
///
/// # Errors
///
/// [`MeasuredError`] naming the file and what is wrong with it.
pub fn read(file: &Path, stated: &Stated) -> Result<Signal, MeasuredError> {
    let source = Source(file, stated.budget);
    checked(source, contents(source, stated)?, stated, SHORTEST_S)
}

/// Reads a recording: 10 Hz to 400 kHz of a carrier between 0.5 and 100 GHz, finite and not silent.
///
/// See [`Stated`] for what the user may add.
///
/// # Errors
///
/// [`MeasuredError`] naming the file and what is wrong with it.
pub fn open(file: &Path, stated: &Stated) -> Result<Signal, MeasuredError> {
    let source = Source(file, stated.budget);
    checked(source, contents(source, stated)?, stated, 0.0)
}

fn contents(source: Source, stated: &Stated) -> Result<Contents, MeasuredError> {
    let dataset = stated.dataset.as_deref();
    Ok(match recognised(source)? {
        Format::Wav => wav::read(source)?,
        Format::Csv => table::read(source)?,
        Format::Npy => npy::read(source)?,
        Format::Npz => npy::read_archive(source, dataset)?,
        Format::Matlab => matlab::read(source, dataset)?,
        Format::SigMf => sigmf::read(source)?,
        Format::Infineon(folder) => {
            infineon::read(&folder, source)?.contents(source, stated, infineon::FORMAT)?
        }
        Format::InfineonRaw => infineon_raw::read(source, stated)?,
        Format::Dca1000 => dca1000::read(source, stated)?.contents(source, stated, dca1000::FORMAT)?,
        #[cfg(feature = "hdf5")]
        Format::Hdf5 { matlab } => hdf5::read(source, dataset, matlab)?,
        #[cfg(not(feature = "hdf5"))]
        Format::Hdf5 { .. } => {
            let reason = "this program was built without HDF5; build it with --features hdf5";
            return Err(source.unreadable("HDF5", reason));
        }
    })
}

/// A signal that is in memory, held to the same limits as one in a file; `name` stands for the file in errors.
///
/// # Errors
///
/// As [`read`].
pub fn signal(name: &str, samples: Samples, stated: &Stated) -> Result<Signal, MeasuredError> {
    in_memory(name, samples, stated, SHORTEST_S)
}

/// Raw slots that are in memory, held to the same limits as those of a file; `name` stands for the file in errors.
///
/// # Errors
///
/// As [`open`].
pub fn raw_slots(name: &str, slots: Slots, stated: &Stated) -> Result<Signal, MeasuredError> {
    in_memory(name, Samples::Slots(slots), stated, 0.0)
}

fn in_memory(
    name: &str,
    samples: Samples,
    stated: &Stated,
    shortest_s: f64,
) -> Result<Signal, MeasuredError> {
    let about = About::new("array", "", vec![samples.len()]);
    let source = Source(Path::new(name), stated.budget);
    let contents = Contents { samples, rate_hz: None, carrier_hz: None, about };
    checked(source, contents, stated, shortest_s)
}

fn checked(
    source: Source,
    contents: Contents,
    stated: &Stated,
    shortest_s: f64,
) -> Result<Signal, MeasuredError> {
    if contents.about.sensor.is_none() {
        let legal = || format!("not given: {} has neither antennas nor chirps", contents.about.format);
        if let Some(antenna) = stated.antenna {
            return Err(source.value("--antenna", antenna, legal()));
        }
        if let Some(chirp) = stated.chirp {
            return Err(source.value("--chirp", chirp, legal()));
        }
    }
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
    if seconds < shortest_s {
        return Err(source.value("length (s)", format!("{seconds:.3}"), format!("at least {shortest_s}")));
    }
    if power == 0.0 {
        return Err(source.value("mean power", 0, "above 0: nothing was recorded"));
    }
    let name = source.0.file_name().unwrap_or_default().to_string_lossy();
    let power_db = 10.0 * libm::log10(power) - gain_db;
    let title = format!("{name} (mean power {power_db:.1} dB)");
    Ok(Signal { samples: contents.samples, rate_hz, carrier_hz, title, power_db, about: contents.about })
}

#[cfg(test)]
mod tests;
