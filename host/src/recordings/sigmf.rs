//! SigMF recordings: `NAME.sigmf-meta` and `NAME.sigmf-data`, or what `core:dataset` names.
//!
//! <https://sigmf.org>. Datatypes ri8, ri16, ri32, rf32, rf64 and ci8 to cf64, either byte order; the rate is `core:sample_rate`,
//! the carrier the first capture's `core:frequency`. Recordings that say `sdp3:slot_samples` and `sdp3:slot_rate` in their
//! global object hold raw slots, one after the other.

use super::array::SAMPLES;
use super::{Contents, MeasuredError, Samples, Source};
use crate::formats::slots::Slots;
use crate::results::About;
use crate::store::limited;
use rustfft::num_complex::Complex64;
use serde::Deserialize;
use std::path::Path;

#[derive(Deserialize)]
struct Meta {
    global: Global,
    #[serde(default)]
    captures: Vec<Capture>,
}

#[derive(Deserialize)]
struct Global {
    #[serde(rename = "core:datatype")]
    datatype: String,
    #[serde(rename = "core:sample_rate")]
    sample_rate: Option<f64>,
    #[serde(rename = "core:num_channels", default = "one")]
    num_channels: u32,
    #[serde(rename = "core:dataset")]
    dataset: Option<String>,
    #[serde(rename = "core:trailing_bytes", default)]
    trailing_bytes: usize,
    #[serde(rename = "sdp3:slot_samples")]
    slot_samples: Option<usize>,
    #[serde(rename = "sdp3:slot_rate")]
    slot_rate_hz: Option<f64>,
}

#[derive(Deserialize)]
struct Capture {
    #[serde(rename = "core:frequency")]
    frequency: Option<f64>,
    #[serde(rename = "core:header_bytes", default)]
    header_bytes: usize,
}

fn one() -> u32 {
    1
}

/// How a number is stored.
#[derive(Clone, Copy)]
struct Datatype {
    complex: bool,
    float: bool,
    bytes: usize,
    big_endian: bool,
}

impl Datatype {
    fn parse(name: &str) -> Option<Self> {
        let (stem, big_endian) = match name.strip_suffix("_be") {
            Some(stem) => (stem, true),
            None => (name.strip_suffix("_le").unwrap_or(name), false),
        };
        let complex = stem.starts_with('c');
        let (float, bytes) = match stem.strip_prefix(['c', 'r'])? {
            "i8" => (false, 1),
            "i16" => (false, 2),
            "i32" => (false, 4),
            "f32" => (true, 4),
            "f64" => (true, 8),
            _ => return None,
        };
        // eight bits have no order and every other size must say its own
        let ordered = stem.len() != name.len();
        (ordered == (bytes > 1)).then_some(Self { complex, float, bytes, big_endian })
    }

    /// Integers are taken against full scale.
    fn number(self, bytes: &[u8]) -> f64 {
        let mut eight = [0; 8];
        eight[..bytes.len()].copy_from_slice(bytes);
        if self.big_endian {
            eight[..bytes.len()].reverse();
        }
        let four = [eight[0], eight[1], eight[2], eight[3]];
        match (self.float, self.bytes) {
            (false, 1) => f64::from(eight[0] as i8) / 128.0,
            (false, 2) => f64::from(i16::from_le_bytes([eight[0], eight[1]])) / 32768.0,
            (false, _) => f64::from(i32::from_le_bytes(four)) / 2_147_483_648.0,
            (true, 4) => f64::from(f32::from_le_bytes(four)),
            (true, _) => f64::from_le_bytes(eight),
        }
    }
}

/// Reads a recording by the name of either of its files.
pub(super) fn read(source: Source) -> Result<Contents, MeasuredError> {
    let broken = |reason: String| source.unreadable("SigMF", reason);
    let meta_file = source.0.with_extension("sigmf-meta");
    let text = limited::read_text(&meta_file, limited::TEXT)
        .map_err(|e| broken(format!("{}: {e}", meta_file.display())))?;
    let Meta { global, captures } = serde_json::from_str(&text).map_err(|e| broken(e.to_string()))?;
    let legal =
        "ri8, ri16_le, ri32_le, rf32_le, rf64_le, ci8, ci16_le, ci32_le, cf32_le, cf64_le, or big-endian";
    let datatype = Datatype::parse(&global.datatype)
        .ok_or_else(|| source.value("core:datatype", format!("{:?}", global.datatype), legal))?;
    if global.num_channels != 1 {
        return Err(source.value("core:num_channels", global.num_channels, "1"));
    }
    let (data_file, header) = match &global.dataset {
        Some(name) => {
            // a file beside the description, never elsewhere
            let plain = Path::new(name).file_name().is_some_and(|file| file == name.as_str());
            if !plain {
                return Err(source.value(
                    "core:dataset",
                    format!("{name:?}"),
                    "the name of a file beside it",
                ));
            }
            (meta_file.with_file_name(name), captures.first().map_or(0, |c| c.header_bytes))
        }
        None => (meta_file.with_extension("sigmf-data"), 0),
    };
    let named = |e: std::io::Error| broken(format!("{}: {e}", data_file.display()));
    let size = std::fs::metadata(&data_file).map_err(named)?.len();
    source.fits("size (bytes)", size, size / datatype.bytes as u64)?;
    let bytes = limited::read(&data_file, limited::WHOLE).map_err(named)?;
    let end = bytes.len().saturating_sub(global.trailing_bytes);
    let Some(bytes) = bytes.get(header..end) else {
        return Err(source.value("core:header_bytes", header, format!("at most {end}")));
    };
    let item = datatype.bytes * if datatype.complex { 2 } else { 1 };
    if bytes.len() % item != 0 {
        return Err(source.value("size (bytes)", bytes.len(), format!("a multiple of {item}")));
    }
    let carrier_hz = captures.first().and_then(|c| c.frequency);
    if let Some(samples) = global.slot_samples {
        let sixteen = matches!(global.datatype.as_str(), "ci16_le" | "ri16_le");
        if !(1..=*SAMPLES.end()).contains(&samples) || !sixteen || bytes.len() % (item * samples) != 0 {
            let what = format!("{samples} of {} in {} bytes", global.datatype, bytes.len());
            return Err(source.value(
                "sdp3:slot_samples",
                what,
                "whole slots of 1 to 2048 ci16_le or ri16_le",
            ));
        }
        let values: Vec<i16> = bytes.as_chunks().0.iter().map(|&pair| i16::from_le_bytes(pair)).collect();
        let slots = Slots { values, per_slot: samples * item / 2 };
        let axes = format!("[slot, sample], {}", global.datatype);
        return Ok(Contents {
            about: About::new("SigMF", axes, vec![slots.len(), samples]),
            samples: Samples::Slots(slots),
            rate_hz: global.slot_rate_hz,
            carrier_hz,
        });
    }
    let numbers = bytes.chunks_exact(datatype.bytes).map(|bytes| datatype.number(bytes));
    let samples = if datatype.complex {
        let numbers: Vec<f64> = numbers.collect();
        Samples::Complex(numbers.as_chunks::<2>().0.iter().map(|&[i, q]| Complex64::new(i, q)).collect())
    } else {
        Samples::Real(numbers.collect())
    };
    let about = About::new("SigMF", format!("[time], {}", global.datatype), vec![samples.len()]);
    Ok(Contents { samples, rate_hz: global.sample_rate, carrier_hz, about })
}
