//! HDF5: one dataset of a file; files of Acconeer's A121 and of MATLAB (version 7.3) are known.
//!
//! Complex numbers are compounds of two numbers, `real` and `imag` (or `r` and `i`), as h5py and MATLAB write them. The dataset's
//! attributes `rate_hz` and `carrier_hz`, if there, are believed. Shapes: see [`super::array`]. In an A121 file the frames are
//! found, their rate is that of the session, or of the ticks of the frames if the session states none, and the carrier is the sensor's
//! 60.5 GHz (its data sheet). A MATLAB file's variables are datasets of its root, stored column by column; `rate_hz` and `carrier_hz` are
//! variables too.

use super::array::{Array, Numbers, checked_shape};
use super::matlab::Variable;
use super::{Contents, MeasuredError, Source};
use crate::store::limited;
use hdf5_pure::{AttrValue, Datatype, DatatypeByteOrder, File, FixedPointLayout, Group};
use rustfft::num_complex::Complex64;

const FORMAT: &str = "HDF5";
/// Where an A121 file keeps its first session; those of older libraries have only one.
const A121_SESSIONS: [&str; 2] = ["sessions/session_0", "session"];
/// What the session's first sensor measured.
const A121_RESULT: &str = "group_0/entry_0/result";
/// How much the time between two frames may differ from its mean, as a share of it, besides a tick.
const A121_UNIFORM: f64 = 0.1;
/// What a file of the older A111 has in its root.
const A111: [&str; 3] = ["data", "sensor_config_dump", "session_info"];
const A121_CARRIER_HZ: f64 = 60.5e9;
/// Deepest group searched for datasets.
const DEPTH: usize = 8;

/// Reads the dataset named, the frames of an A121 file, or the file's only dataset; of a MATLAB file the variable named, or the only one that
/// is an array of numbers.
pub(super) fn read(source: Source, name: Option<&str>, matlab: bool) -> Result<Contents, MeasuredError> {
    let format = if matlab { "MATLAB 7.3" } else { FORMAT };
    let broken = |error: hdf5_pure::Error| source.unreadable(format, error);
    limited::open(source.0, limited::WHOLE).map_err(|error| source.unreadable(format, error))?;
    let file = File::open(source.0).map_err(broken)?;
    let a121 = file.dataset("generation").and_then(|d| d.read_string()).is_ok_and(|s| s == ["a121"]);
    let frames = |session: &str| format!("{session}/{A121_RESULT}/frame");
    let has_frames = |session: &&&str| file.dataset(&frames(session)).is_ok();
    let session = A121_SESSIONS.iter().find(has_frames).filter(|_| a121);
    let names = || -> Result<Vec<String>, MeasuredError> {
        let mut names = Vec::new();
        datasets(&file.root(), "", if matlab { 0 } else { DEPTH }, &mut names).map_err(broken)?;
        names.retain(|name| !matlab || is_array(&file, name));
        if names.is_empty() {
            return Err(source.unreadable(format, "it holds no array of numbers"));
        }
        Ok(names)
    };
    let name = match name {
        Some(name) => name.to_owned(),
        None if a121 => match session {
            Some(session) => frames(session),
            None => {
                let why = file.dataset(&frames(A121_SESSIONS[0])).err().map(|e| e.to_string());
                let reason = format!("it has no frames of an A121 session: {}", why.unwrap_or_default());
                return Err(source.unreadable(format, reason));
            }
        },
        None if A111.iter().all(|name| file.dataset(name).is_ok()) => {
            let reason = "it is a session of Acconeer's A111, and only those of the A121 are read; --dataset data reads complex data of one sensor";
            return Err(source.unreadable(format, reason));
        }
        None => match names()?.as_slice() {
            [only] => only.clone(),
            all => {
                let legal = format!("one of {}", all.join(", "));
                return Err(source.value("--dataset", "not given", legal));
            }
        },
    };
    let dataset = file.dataset(&name).ok().filter(|_| !matlab || is_array(&file, &name));
    let Some(dataset) = dataset else {
        return Err(source.value(
            "--dataset",
            format!("{name:?}"),
            format!("one of {}", names()?.join(", ")),
        ));
    };
    let stored = dataset.shape().map_err(broken)?;
    let shape = checked_shape(source, &stored)?;
    let datatype = dataset.datatype().map_err(broken)?;
    let Some(number) = Number::of(&datatype) else {
        let legal = "integers, floats, or compounds of two such, real and imag";
        return Err(source.value(format!("type of {name}"), format!("{datatype:?}"), legal));
    };
    let numbers = number.numbers(&dataset.read_raw().map_err(broken)?);
    if matlab {
        let mut contents =
            variable(name, &stored, number, numbers).array(source)?.contents(source, format)?;
        (contents.rate_hz, contents.carrier_hz) =
            (scalar_of(&file, "rate_hz"), scalar_of(&file, "carrier_hz"));
        return Ok(contents);
    }
    let mut contents =
        Array { shape, numbers }.contents(source, if a121 { "Acconeer A121 (HDF5)" } else { FORMAT })?;
    let attributes = dataset.attrs().map_err(broken)?;
    let attribute = |name: &str| attributes.get(name).and_then(number_of);
    contents.rate_hz = attribute("rate_hz");
    contents.carrier_hz = attribute("carrier_hz");
    if a121 {
        contents.rate_hz = contents.rate_hz.or_else(|| frame_rate(&file, session?, &stored));
        contents.carrier_hz = contents.carrier_hz.or(Some(A121_CARRIER_HZ));
    }
    Ok(contents)
}

/// Whether a dataset of a MATLAB file is an array of numbers, not text, a scalar or empty.
fn is_array(file: &File, name: &str) -> bool {
    let Ok(dataset) = file.dataset(name) else { return false };
    let text = dataset.attrs().is_ok_and(|attributes| match attributes.get("MATLAB_class") {
        Some(AttrValue::String(class) | AttrValue::AsciiString(class)) => class == "char",
        _ => false,
    });
    let empty = dataset.attrs().is_ok_and(|attributes| attributes.contains_key("MATLAB_empty"));
    let numbers = dataset.datatype().is_ok_and(|datatype| Number::of(&datatype).is_some());
    !text && !empty && numbers && dataset.shape().is_ok_and(|shape| shape.iter().any(|&n| n > 1))
}

/// A variable of a MATLAB file: HDF5 states the axes the other way round.
fn variable(name: String, stored: &[u64], number: Number, numbers: Numbers) -> Variable {
    let (real, imaginary) = match numbers {
        Numbers::Int16(values) => (values.into_iter().map(f64::from).collect(), None),
        Numbers::Real(values) => (values, None),
        Numbers::Complex(values) => {
            let (real, imaginary) = values.into_iter().map(|z| (z.re, z.im)).unzip();
            (real, Some(imaginary))
        }
    };
    Variable {
        name,
        shape: stored.iter().rev().copied().collect(),
        int16: number.is_int16(),
        real,
        imaginary,
    }
}

/// The only number of a dataset.
fn scalar_of(file: &File, name: &str) -> Option<f64> {
    let dataset = file.dataset(name).ok()?;
    dataset.shape().ok()?.iter().all(|&n| n == 1).then_some(())?;
    match Number::of(&dataset.datatype().ok()?)?.numbers(&dataset.read_raw().ok()?) {
        Numbers::Int16(values) => values.first().copied().map(f64::from),
        Numbers::Real(values) => values.first().copied(),
        Numbers::Complex(_) => None,
    }
}

/// Names of all datasets below a group.
fn datasets(
    group: &Group,
    path: &str,
    depth: usize,
    names: &mut Vec<String>,
) -> Result<(), hdf5_pure::Error> {
    names.extend(group.datasets()?.into_iter().map(|name| format!("{path}{name}")));
    if depth > 0 {
        for name in group.groups()? {
            datasets(&group.group(&name)?, &format!("{path}{name}/"), depth - 1, names)?;
        }
    }
    Ok(())
}

fn number_of(value: &AttrValue) -> Option<f64> {
    match value {
        AttrValue::F64(value) => Some(*value),
        AttrValue::F32(value) => Some(f64::from(*value)),
        AttrValue::I64(value) => Some(*value as f64),
        _ => None,
    }
}

/// The frame rate that an A121 session was configured with, or that of its frames' ticks.
fn frame_rate(file: &File, session: &str, frames: &[u64]) -> Option<f64> {
    let json = |name: &str| -> Option<serde_json::Value> {
        serde_json::from_str(file.dataset(name).ok()?.read_string().ok()?.first()?).ok()
    };
    let config = json(&format!("{session}/session_config"))?;
    let sensor = config.get("groups")?.get(0)?.as_object()?.values().next()?;
    sensor.get("frame_rate").and_then(serde_json::Value::as_f64).or_else(|| {
        let ticks = file.dataset(&format!("{session}/{A121_RESULT}/tick")).ok()?;
        // one a frame, so that no more is read than the frames that fit
        ticks.shape().is_ok_and(|shape| shape == frames[..1]).then_some(())?;
        rate_of(&ticks.read_i64().ok()?, json("server_info")?.get("ticks_per_second")?.as_f64()?)
    })
}

/// The rate of frames that follow one another at the same distance.
fn rate_of(ticks: &[i64], per_second: f64) -> Option<f64> {
    let steps: Vec<f64> = ticks.windows(2).map(|pair| pair[1] as f64 - pair[0] as f64).collect();
    let mean = steps.iter().sum::<f64>() / steps.len() as f64;
    let uniform = steps.iter().all(|step| (step - mean).abs() <= A121_UNIFORM * mean + 1.0);
    (mean > 0.0 && uniform).then_some(per_second / mean)
}

/// A scalar's layout in its bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Scalar {
    Signed(usize),
    Unsigned(usize),
    Float(usize),
}

/// How an element is stored, little-endian.
#[derive(Debug, Clone, Copy)]
enum Number {
    Real(Scalar),
    /// Bytes of an element, and where its parts lie.
    Complex(usize, Scalar, [usize; 2]),
}

impl Number {
    fn of(datatype: &Datatype) -> Option<Self> {
        let Datatype::Compound { size, members } = datatype else { return scalar(datatype).map(Self::Real) };
        let member = |names: [&str; 2]| members.iter().find(|m| names.contains(&m.name.as_str()));
        let (re, im) = (member(["real", "r"])?, member(["imag", "i"])?);
        let (part, size) = (scalar(&re.datatype)?, *size as usize);
        let at = [re.byte_offset as usize, im.byte_offset as usize];
        let same = re.datatype == im.datatype;
        (same && at.iter().all(|at| at + part.bytes() <= size)).then_some(Self::Complex(size, part, at))
    }

    fn is_int16(self) -> bool {
        let (Self::Real(part) | Self::Complex(_, part, _)) = self;
        part == Scalar::Signed(2)
    }

    fn numbers(self, bytes: &[u8]) -> Numbers {
        match self {
            Self::Real(Scalar::Signed(2)) => {
                Numbers::Int16(bytes.as_chunks().0.iter().map(|&b| i16::from_le_bytes(b)).collect())
            }
            Self::Real(scalar) => {
                Numbers::Real(bytes.chunks_exact(scalar.bytes()).map(|b| scalar.value(b)).collect())
            }
            Self::Complex(size, part, [re, im]) => {
                let element = |b: &[u8]| Complex64::new(part.value(&b[re..]), part.value(&b[im..]));
                Numbers::Complex(bytes.chunks_exact(size).map(element).collect())
            }
        }
    }
}

fn scalar(datatype: &Datatype) -> Option<Scalar> {
    match *datatype {
        Datatype::FixedPoint {
            size: size @ (1 | 2 | 4 | 8),
            byte_order: DatatypeByteOrder::LittleEndian,
            layout: FixedPointLayout { signed, .. },
        } => Some(if signed { Scalar::Signed(size as usize) } else { Scalar::Unsigned(size as usize) }),
        Datatype::FloatingPoint {
            size: size @ (4 | 8), byte_order: DatatypeByteOrder::LittleEndian, ..
        } => Some(Scalar::Float(size as usize)),
        _ => None,
    }
}

impl Scalar {
    fn bytes(self) -> usize {
        let (Self::Signed(bytes) | Self::Unsigned(bytes) | Self::Float(bytes)) = self;
        bytes
    }

    /// The number at the start of these bytes.
    fn value(self, bytes: &[u8]) -> f64 {
        let mut eight = [0; 8];
        eight[..self.bytes()].copy_from_slice(&bytes[..self.bytes()]);
        let word = u64::from_le_bytes(eight);
        match self {
            Self::Float(4) => f64::from(f32::from_bits(word as u32)),
            Self::Float(_) => f64::from_bits(word),
            Self::Unsigned(_) => word as f64,
            Self::Signed(bytes) => {
                let unused = 64 - 8 * bytes as u32;
                ((word << unused).cast_signed() >> unused) as f64
            }
        }
    }
}
