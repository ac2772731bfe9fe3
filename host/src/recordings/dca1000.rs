//! Captures of TI's DCA1000 board: 16-bit words as the sensor's LVDS lanes sent them, described by a file beside them.
//!
//! The description is the sensor's command file (`.cfg`, mmWave SDK user's guide) or mmWave Studio's `.mmwave.json`. Words, by TI's
//! application report SWRA581:
//!
//! | sensor | order within a chirp |
//! |---|---|
//! | two lanes, complex (16xx, 18xx, 68xx) | antenna by antenna: I, I, Q, Q of two samples |
//! | two lanes, real | antenna by antenna |
//! | four lanes, complex (12xx, 14xx) | sample by sample: I of every antenna, then Q of every antenna |
//! | four lanes, real | sample by sample: every antenna |
//!
//! Four lanes always send four antennas; those that are off are zero.

use super::cube::Cube;
use super::{MeasuredError, Source, Stated};
use crate::results::Sensor;
use crate::store::limited;
use serde_json::Value;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

pub(super) const FORMAT: &str = "TI DCA1000";
/// Lanes, and so antennas, of an interleaved capture.
const LANES: usize = 4;
/// Most chirps of a loop, and most samples of a chirp and chirps of a frame.
const CHIRPS: u32 = 512;
const MOST: u32 = 1 << 16;

/// What a description says.
struct Description {
    /// Mask of the receive antennas.
    receivers: u32,
    /// Mask of the transmit antennas of every chirp of a loop.
    transmitters: Vec<u32>,
    loops: u32,
    frame_ms: f64,
    start_ghz: f64,
    idle_us: f64,
    first_sample_us: f64,
    ramp_end_us: f64,
    slope_mhz_us: f64,
    samples: u32,
    rate_ksps: f64,
    bits: u8,
    complex: bool,
    interleaved: bool,
    /// Whether Q comes before I.
    swapped: bool,
}

/// Reads a capture.
pub(super) fn read(source: Source, stated: &Stated) -> Result<Cube, MeasuredError> {
    let file = match &stated.config {
        Some(file) => file.clone(),
        None => description_file(source)?,
    };
    let at = Source(&file, source.1);
    let text = limited::read_text(&file, limited::TEXT).map_err(|e| at.unreadable("description", e))?;
    let d = if text.trim_start().starts_with('{') { of_json(at, &text)? } else { of_commands(at, &text)? };
    let sensor = d.sensor(at)?;
    let bytes_of = |error| source.unreadable(FORMAT, error);
    let size = std::fs::metadata(source.0).map_err(bytes_of)?.len();
    source.fits("size (bytes)", size, size / 2)?;
    let antennas = sensor.antennas as usize;
    let sent = if d.interleaved { LANES } else { antennas };
    let per_chirp = sent * sensor.samples as usize * if d.complex { 2 } else { 1 };
    let frame_bytes = 2 * per_chirp * sensor.chirps as usize;
    if size == 0 || !size.is_multiple_of(frame_bytes as u64) {
        let legal = format!("a multiple of {frame_bytes}, a frame by {}", file.display());
        return Err(source.value("size (bytes)", size, legal));
    }
    let bytes = limited::read(source.0, limited::WHOLE).map_err(bytes_of)?;
    let unused = 16 - u32::from(d.bits);
    let words: Vec<i16> =
        bytes.as_chunks().0.iter().map(|&pair| (i16::from_le_bytes(pair) << unused) >> unused).collect();
    let mut values = Vec::with_capacity(words.len());
    let on: Vec<usize> = (0..LANES).filter(|n| d.receivers >> n & 1 == 1).collect();
    for chirp in words.chunks_exact(per_chirp) {
        if d.interleaved {
            on.iter().for_each(|&antenna| d.lanes(chirp, antenna, &mut values));
        } else {
            chirp.chunks_exact(per_chirp / antennas).for_each(|one| d.pairs(one, &mut values));
        }
    }
    Ok(Cube { values, sensor })
}

impl Description {
    fn sensor(&self, source: Source) -> Result<Sensor, MeasuredError> {
        let legal = |holds: bool, field: &str, value: String, legal: &str| {
            if holds { Ok(()) } else { Err(source.value(field, value, legal)) }
        };
        source.positive("start frequency (GHz)", self.start_ghz)?;
        source.positive("slope (MHz/us)", self.slope_mhz_us)?;
        source.positive("sampling rate (ksps)", self.rate_ksps)?;
        source.positive("ramp end time (us)", self.ramp_end_us)?;
        source.positive("frame period (ms)", self.frame_ms)?;
        let chirps = self.loops.saturating_mul(self.transmitters.len() as u32);
        legal((1..=MOST).contains(&chirps), "chirps of a frame", chirps.to_string(), "1 to 65536")?;
        let even = (2..=MOST).contains(&self.samples) && self.samples.is_multiple_of(2);
        legal(even, "samples", self.samples.to_string(), "an even number of 2 to 65536")?;
        legal(
            (1..16).contains(&self.receivers),
            "receive antennas (mask)",
            self.receivers.to_string(),
            "1 to 15",
        )?;
        legal([12, 14, 16].contains(&self.bits), "converter bits", self.bits.to_string(), "12, 14 or 16")?;
        let rate_hz = 1e3 * self.rate_ksps;
        let slope_hz_s = 1e12 * self.slope_mhz_us;
        Ok(Sensor {
            name: "TI mmWave".to_owned(),
            carrier_hz: 1e9 * self.start_ghz + slope_hz_s * 1e-6 * self.first_sample_us,
            bandwidth_hz: slope_hz_s * f64::from(self.samples) / rate_hz,
            sample_rate_hz: rate_hz,
            samples: self.samples,
            complex: self.complex,
            converter_bits: self.bits,
            antennas: self.receivers.count_ones(),
            chirps,
            transmitters: self.transmitters.clone(),
            chirp_s: 1e-6 * (self.idle_us + self.ramp_end_us),
            frame_s: 1e-3 * self.frame_ms,
        })
    }

    /// I and Q of a complex sample in the order of [`Cube`].
    fn sample(&self, first: i16, second: i16) -> [i16; 2] {
        if self.swapped { [second, first] } else { [first, second] }
    }

    /// A chirp of one antenna over two lanes.
    fn pairs(&self, words: &[i16], values: &mut Vec<i16>) {
        if !self.complex {
            return values.extend_from_slice(words);
        }
        for &[a, b, c, d] in words.as_chunks().0 {
            values.extend(self.sample(a, c).into_iter().chain(self.sample(b, d)));
        }
    }

    /// A chirp of one antenna over four lanes.
    fn lanes(&self, words: &[i16], antenna: usize, values: &mut Vec<i16>) {
        if self.complex {
            let each = words.as_chunks::<{ 2 * LANES }>().0.iter();
            values.extend(each.flat_map(|w| self.sample(w[antenna], w[LANES + antenna])));
        } else {
            values.extend(words.as_chunks::<LANES>().0.iter().map(|w| w[antenna]));
        }
    }
}

/// The description beside a capture: of the same name, or the only one in the folder.
fn description_file(source: Source) -> Result<PathBuf, MeasuredError> {
    let is_one = |path: &Path| {
        let name = path.file_name().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        name.ends_with(".cfg") || name.ends_with(".mmwave.json")
    };
    let same = ["cfg", "mmwave.json"].map(|extension| source.0.with_extension(extension));
    if let Some(file) = same.iter().find(|file| file.is_file()) {
        return Ok(file.clone());
    }
    let folder = source.0.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let listed = folder.read_dir().map_err(|error| source.unreadable(FORMAT, error))?;
    let found: Vec<PathBuf> =
        listed.flatten().map(|entry| entry.path()).filter(|path| is_one(path)).collect();
    match found.as_slice() {
        [only] => Ok(only.clone()),
        _ => {
            let value = format!("not given, {} in the folder", found.len());
            Err(source.value("--config", value, "a sensor's .cfg or mmWave Studio's .mmwave.json"))
        }
    }
}

/// Chirps of a frame's loop, of which a sensor knows at most 512.
fn chirps(source: Source, first: f64, last: f64) -> Result<RangeInclusive<u32>, MeasuredError> {
    if 0.0 <= first && first <= last && last < f64::from(CHIRPS) {
        return Ok(first as u32..=last as u32);
    }
    Err(source.value("first and last chirp", format!("{first} to {last}"), "0 to 511, ascending"))
}

/// The words of the only command of this name.
fn command<'a>(
    source: Source,
    text: &'a str,
    name: &'static str,
    fewest: usize,
) -> Result<Vec<&'a str>, MeasuredError> {
    let lines = text.lines().filter_map(|line| {
        let mut words = line.split_whitespace();
        (words.next()? == name).then(|| words.collect::<Vec<&str>>())
    });
    let mut lines: Vec<_> = lines.collect();
    let words = match (lines.pop(), lines.len()) {
        (Some(words), 0) => words,
        (None, _) => return Err(source.value(name, "missing", "a line of the file")),
        (_, others) => return Err(source.value(name, format!("in {} lines", others + 1), "in one line")),
    };
    if words.len() < fewest {
        return Err(source.value(name, words.join(" "), format!("at least {fewest} numbers")));
    }
    Ok(words)
}

/// A sensor's command file.
fn of_commands(source: Source, text: &str) -> Result<Description, MeasuredError> {
    let number = |name: &'static str, word: &str| -> Result<f64, MeasuredError> {
        word.parse().map_err(|_| source.value(name, word, "a number"))
    };
    let channel = command(source, text, "channelCfg", 2)?;
    let adc = command(source, text, "adcCfg", 2)?;
    let buffer = command(source, text, "adcbufCfg", 4)?;
    let profile = command(source, text, "profileCfg", 11)?;
    let frame = command(source, text, "frameCfg", 5)?;
    let p = |n: usize| number("profileCfg", profile[n]);
    let chirps = chirps(source, number("frameCfg", frame[0])?, number("frameCfg", frame[1])?)?;
    // newer SDKs name the subframe first: -1 or its number
    let b = |n: usize| number("adcbufCfg", buffer[buffer.len() - 4 + n]);
    let transmitters: Result<Vec<u32>, _> = chirps.map(|chirp| transmit_mask(source, text, chirp)).collect();
    Ok(Description {
        receivers: number("channelCfg", channel[0])? as u32,
        transmitters: transmitters?,
        loops: number("frameCfg", frame[2])? as u32,
        frame_ms: number("frameCfg", frame[4])?,
        start_ghz: p(1)?,
        idle_us: p(2)?,
        first_sample_us: p(3)?,
        ramp_end_us: p(4)?,
        slope_mhz_us: p(7)?,
        samples: p(9)? as u32,
        rate_ksps: p(10)?,
        bits: bits(number("adcCfg", adc[0])?),
        // of adcbufCfg: 0 complex, 1 real
        complex: b(0)? == 0.0,
        // 1: I in the upper half, so that Q is the first word
        swapped: b(1)? == 1.0,
        interleaved: b(2)? == 0.0,
    })
}

/// Transmit antennas of a chirp by the command file.
fn transmit_mask(source: Source, text: &str, chirp: u32) -> Result<u32, MeasuredError> {
    let lines = text.lines().filter_map(|line| line.trim().strip_prefix("chirpCfg"));
    for line in lines {
        let words: Result<Vec<f64>, _> = line.split_whitespace().map(str::parse).collect();
        match words.as_deref() {
            Ok(&[from, to, .., mask]) if (from..=to).contains(&f64::from(chirp)) => return Ok(mask as u32),
            Ok(_) => (),
            Err(_) => return Err(source.value("chirpCfg", line.trim(), "numbers")),
        }
    }
    Err(source.value("chirpCfg", "missing", format!("a line for chirp {chirp} of frameCfg")))
}

/// Bits that 0, 1 and 2 stand for.
fn bits(code: f64) -> u8 {
    match code as i64 {
        0 => 12,
        1 => 14,
        2 => 16,
        _ => 0,
    }
}

/// mmWave Studio's description, of its first device and first profile.
fn of_json(source: Source, text: &str) -> Result<Description, MeasuredError> {
    let root: Value = serde_json::from_str(text).map_err(|error| source.unreadable("JSON", error))?;
    let at = |pointer: &str| {
        let missing = || source.value(pointer.trim_start_matches("/mmWaveDevices/0/"), "missing", "a value");
        root.pointer(pointer).ok_or_else(missing)
    };
    // numbers, and masks written as "0xF"
    let number = |pointer: &str| -> Result<f64, MeasuredError> {
        let value = at(pointer)?;
        let hexadecimal = || u32::from_str_radix(value.as_str()?.strip_prefix("0x")?, 16).ok().map(f64::from);
        let found = value.as_f64().or_else(hexadecimal);
        found.ok_or_else(|| source.value(pointer.trim_start_matches("/mmWaveDevices/0/"), value, "a number"))
    };
    let rf = |rest: &str| number(&format!("/mmWaveDevices/0/rfConfig/{rest}"));
    let profile = |rest: &str| rf(&format!("rlProfiles/0/rlProfileCfg_t/{rest}"));
    let capture = |rest: &str| number(&format!("/mmWaveDevices/0/rawDataCaptureConfig/{rest}"));
    let chirps = chirps(source, rf("rlFrameCfg_t/chirpStartIdx")?, rf("rlFrameCfg_t/chirpEndIdx")?)?;
    let count = at("/mmWaveDevices/0/rfConfig/rlChirps")?.as_array().map_or(0, Vec::len);
    let mask = |chirp: u32| {
        for n in 0..count {
            let of = |name: &str| rf(&format!("rlChirps/{n}/rlChirpCfg_t/{name}"));
            if (of("chirpStartIdx")?..=of("chirpEndIdx")?).contains(&f64::from(chirp)) {
                return Ok(of("txEnable")? as u32);
            }
        }
        Err(source.value("rfConfig/rlChirps", "missing", format!("an entry for chirp {chirp}")))
    };
    let transmitters: Result<Vec<u32>, _> = chirps.map(mask).collect();
    Ok(Description {
        receivers: rf("rlChanCfg_t/rxChannelEn")? as u32,
        transmitters: transmitters?,
        loops: rf("rlFrameCfg_t/numLoops")? as u32,
        frame_ms: rf("rlFrameCfg_t/framePeriodicity_msec")?,
        start_ghz: profile("startFreqConst_GHz")?,
        idle_us: profile("idleTimeConst_usec")?,
        first_sample_us: profile("adcStartTimeConst_usec")?,
        ramp_end_us: profile("rampEndTime_usec")?,
        slope_mhz_us: profile("freqSlopeConst_MHz_usec")?,
        samples: profile("numAdcSamples")? as u32,
        rate_ksps: profile("digOutSampleRate")?,
        bits: bits(rf("rlAdcOutCfg_t/fmt/b2AdcBits")?),
        complex: rf("rlAdcOutCfg_t/fmt/b2AdcOutFmt")? != 0.0,
        interleaved: capture("rlDevDataFmtCfg_t/chInterleave")? == 0.0,
        swapped: capture("rlDevDataFmtCfg_t/iqSwapSel")? == 1.0,
    })
}
