//! Recordings of Infineon's radar SDK: a folder with `config.json` and `radar.npy`.
//!
//! `radar.npy` is `[frame, antenna, chirp, sample]`: counts of the 12-bit converter, 0 to 4095, or the same as a share of its full
//! scale, 0 to 1. `config.json` describes the chirps in `device_config.fmcw_single_shape`. Older versions name the ends of the sweep
//! `lower_frequency_Hz` and `upper_frequency_Hz`, newer ones `start_frequency_Hz` and `end_frequency_Hz`.

use super::array::{Array, Numbers};
use super::cube::Cube;
use super::{MeasuredError, Source, npy};
use crate::results::Sensor;
use crate::store::limited;
use serde::Deserialize;
use std::path::{Path, PathBuf};

pub(super) const FORMAT: &str = "Infineon radar SDK";
/// Bits of the converter, and its counts.
const BITS: u8 = 12;
const COUNTS: f64 = 4096.0;

#[derive(Deserialize)]
struct Config {
    device_config: DeviceConfig,
}

#[derive(Deserialize)]
struct DeviceConfig {
    fmcw_single_shape: ChirpConfig,
}

#[derive(Deserialize)]
struct ChirpConfig {
    rx_antennas: Vec<u32>,
    tx_antennas: Option<Vec<u32>>,
    #[serde(rename = "start_frequency_Hz", alias = "lower_frequency_Hz")]
    start_hz: f64,
    #[serde(rename = "end_frequency_Hz", alias = "upper_frequency_Hz")]
    end_hz: f64,
    num_chirps_per_frame: u32,
    num_samples_per_chirp: u32,
    chirp_repetition_time_s: f64,
    frame_repetition_time_s: f64,
    #[serde(rename = "sample_rate_Hz")]
    sample_rate_hz: f64,
}

/// Whether a folder is a recording of this kind.
pub(super) fn holds(folder: &Path) -> bool {
    ["config.json", "radar.npy"].iter().all(|name| folder.join(name).is_file())
}

/// The folder of a recording of this kind: the one named, the only one of the SDK in it, or the one that holds the file named.
pub(super) fn folder(path: &Path) -> Option<PathBuf> {
    if !path.is_dir() {
        let beside = path.file_name().is_some_and(|name| name == "radar.npy" || name == "config.json");
        return path.parent().filter(|folder| beside && holds(folder)).map(Path::to_owned);
    }
    if holds(path) {
        return Some(path.to_owned());
    }
    let mut inside = path.read_dir().ok()?.flatten().map(|entry| entry.path()).filter(|folder| holds(folder));
    inside.next().filter(|_| inside.next().is_none())
}

/// Reads the recording in a folder.
pub(super) fn read(folder: &Path, source: Source) -> Result<Cube, MeasuredError> {
    let [config_file, data_file] = ["config.json", "radar.npy"].map(|name| folder.join(name));
    let at_config = Source(&config_file, source.1);
    let text =
        limited::read_text(&config_file, limited::TEXT).map_err(|e| at_config.unreadable("JSON", e))?;
    let config: Config = serde_json::from_str(&text).map_err(|e| at_config.unreadable(FORMAT, e))?;
    let sensor = sensor(at_config, config.device_config.fmcw_single_shape)?;
    let at_data = Source(&data_file, source.1);
    let Array { shape, numbers } = npy::array(at_data)?;
    let said = [sensor.antennas, sensor.chirps, sensor.samples].map(|n| n as usize);
    if shape.len() != 4 || shape[1..] != said {
        let [antennas, chirps, samples] = said;
        let legal = format!("[frame, {antennas}, {chirps}, {samples}], as config.json says");
        return Err(at_data.value("shape", format!("{shape:?}"), legal));
    }
    let numbers = match numbers {
        Numbers::Int16(values) => values.into_iter().map(f64::from).collect(),
        Numbers::Real(values) => values,
        Numbers::Complex(_) => return Err(at_data.value("dtype", "complex", "integers or floats")),
    };
    let counts = counts(at_data, numbers)?;
    let [antennas, chirps, samples] = said;
    let mut values = Vec::with_capacity(counts.len());
    for frame in counts.chunks_exact(antennas * chirps * samples) {
        for chirp in 0..chirps {
            for antenna in 0..antennas {
                values.extend_from_slice(&frame[(antenna * chirps + chirp) * samples..][..samples]);
            }
        }
    }
    Ok(Cube { values, sensor })
}

fn sensor(source: Source, chirp: ChirpConfig) -> Result<Sensor, MeasuredError> {
    source.positive("start_frequency_Hz", chirp.start_hz)?;
    source.positive("end_frequency_Hz less start_frequency_Hz", chirp.end_hz - chirp.start_hz)?;
    source.positive("sample_rate_Hz", chirp.sample_rate_hz)?;
    source.positive("chirp_repetition_time_s", chirp.chirp_repetition_time_s)?;
    source.positive("frame_repetition_time_s", chirp.frame_repetition_time_s)?;
    source.positive("num_chirps_per_frame", f64::from(chirp.num_chirps_per_frame))?;
    source.positive("num_samples_per_chirp", f64::from(chirp.num_samples_per_chirp))?;
    source.positive("length of rx_antennas", chirp.rx_antennas.len() as f64)?;
    let mask =
        |antennas: Vec<u32>| antennas.iter().fold(0, |mask, n| mask | 1 << n.saturating_sub(1).min(31));
    Ok(Sensor {
        name: "Infineon BGT60".to_owned(),
        carrier_hz: chirp.start_hz,
        bandwidth_hz: chirp.end_hz - chirp.start_hz,
        sample_rate_hz: chirp.sample_rate_hz,
        samples: chirp.num_samples_per_chirp,
        complex: false,
        converter_bits: BITS,
        antennas: chirp.rx_antennas.len() as u32,
        chirps: chirp.num_chirps_per_frame,
        transmitters: vec![mask(chirp.tx_antennas.unwrap_or_else(|| vec![1]))],
        chirp_s: chirp.chirp_repetition_time_s,
        frame_s: chirp.frame_repetition_time_s,
    })
}

/// Signed counts of the converter, from unsigned ones or shares of full scale.
fn counts(source: Source, numbers: Vec<f64>) -> Result<Vec<i16>, MeasuredError> {
    let (low, high) = numbers.iter().fold((f64::MAX, f64::MIN), |(low, high), &v| (low.min(v), high.max(v)));
    // a recording of counts that never leaves 0 and 1 would be one of a converter that stands still
    let scale = if high <= 1.0 { COUNTS - 1.0 } else { 1.0 };
    let (low, high) = (low * scale, high * scale);
    if !(low >= 0.0 && high <= COUNTS - 1.0) {
        let legal = "counts of 0 to 4095, or shares of 0 to 1";
        return Err(source.value("values", format!("{low} to {high}"), legal));
    }
    Ok(numbers.into_iter().map(|v| (libm::round(v * scale) - COUNTS / 2.0) as i16).collect())
}
