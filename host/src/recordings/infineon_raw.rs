//! Raw recordings of Infineon's radar tools: as text (`.raw.txt`), a header of `# Name = value`, then every frame's number and its values; and
//! the same in binary (`.raw.bin`).
//!
//! Text begins with `IFRT`, binary files with `IFRB`. Values are counts of the converter or shares of its full scale, chirp by chirp. Of a
//! chirp the antennas follow one another, or alternate from sample to sample; I and Q likewise. Recordings of FMCW modules are read,
//! and those of Doppler modules with frames that leave no pause. Source: the parsers and the file that come with Infineon's 24 GHz tools.

use super::array::{Array, Numbers};
use super::cube::{Chirps, Cube};
use super::{Contents, MeasuredError, Samples, Source, Stated};
use crate::results::Sensor;
use crate::store::limited;
use std::collections::HashMap;
use std::io::{BufRead, BufReader, Read};

pub(super) const FORMAT: &str = "Infineon raw data";
/// How such files begin, text and binary.
pub(super) const MAGIC: [&[u8]; 2] = [b"IFRT", b"IFRB"];
/// Share by which the samples of a Doppler frame may differ from filling it.
const UNIFORM: f64 = 0.01;
/// What every frame begins with.
const FRAME: &str = "Frame_Number";
/// The words of a binary header behind its first four bytes, big-endian, and which of them are f32; the others are i32.
const WORDS: [(&str, bool); 21] = [
    ("Version", true),
    ("Header_Size", false),
    ("Num_Tx_Antennas", false),
    ("Num_Rx_Antennas", false),
    ("Mask_Tx_Antennas", false),
    ("Mask_Rx_Antennas", false),
    ("Are_Rx_Antennas_Interleaved", false),
    ("Modulation_Type_Enum", false),
    ("Chirp_Shape_Enum", false),
    ("Lower_RF_Frequency_kHz", true),
    ("Upper_RF_Frequency_kHz", true),
    ("Sampling_Frequency_kHz", true),
    ("ADC_Resolution_Bits", false),
    ("Are_ADC_Samples_Normalized", false),
    ("Data_Format_Enum", false),
    ("Chirps_per_Frame", false),
    ("Samples_per_Chirp", false),
    ("Samples_per_Frame", false),
    ("Chirp_Time_sec", true),
    ("Pulse_Repetition_Time_sec", true),
    ("Frame_Period_sec", true),
];

/// The numbers of a header by name.
type Fields = HashMap<String, f64>;

/// How I and Q of a chirp lie.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Parts {
    Real,
    /// All of I, then all of Q.
    Separate,
    Alternating,
}

/// What the header says.
struct Header {
    sensor: Sensor,
    doppler: bool,
    interleaved: bool,
    parts: Parts,
    normalised: bool,
}

/// Reads text or a binary file.
pub(super) fn read(source: Source, stated: &Stated) -> Result<Contents, MeasuredError> {
    let mut file =
        limited::open(source.0, limited::WHOLE).map_err(|error| source.unreadable(FORMAT, error))?;
    let size = file.metadata().map_or(0, |about| about.len());
    // a number and its line's end take two bytes at least
    source.fits("size (bytes)", size, size / 2)?;
    let mut magic = [0; 4];
    file.read_exact(&mut magic).map_err(|error| source.unreadable(FORMAT, error))?;
    let (header, values) = if magic == *MAGIC[0] { text(source, file) } else { binary(source, file) }?;
    header.contents(source, stated, &values)
}

/// Refuses frames that do not follow one another; `at` says where.
fn follow(source: Source, before: &mut Option<i64>, number: i64, at: &str) -> Result<(), MeasuredError> {
    match before.replace(number) {
        Some(before) if before + 1 != number => {
            let legal = format!("{}: a frame is missing", before + 1);
            Err(source.value(format!("{FRAME}, {at}"), number, legal))
        }
        _ => Ok(()),
    }
}

fn text(source: Source, file: impl Read) -> Result<(Header, Vec<f64>), MeasuredError> {
    let (mut header, mut fields, mut values, mut frame) = (None, Fields::new(), Vec::new(), None);
    for (n, line) in BufReader::new(file).lines().enumerate() {
        let (line, at) = (line.map_err(|error| source.unreadable(FORMAT, error))?, format!("line {}", n + 1));
        let line = line.trim();
        let number =
            |text: &str| text.parse::<f64>().map_err(|_| source.value(&at, format!("{text:?}"), "a number"));
        if let Some(text) = line.strip_prefix('#') {
            let Some((name, value)) = text.split_once('=') else { continue };
            let (name, value) = (name.trim_matches(['#', ' ']), value.trim());
            if name == FRAME {
                if header.is_none() {
                    header = Some(Header::of(source, &fields)?);
                }
                follow(source, &mut frame, number(value)? as i64, &at)?;
            } else if let Ok(value) = value.parse::<f64>() {
                fields.insert(name.to_owned(), value);
            }
        } else if !line.is_empty() {
            values.push(number(line)?);
        }
    }
    let header = header.ok_or_else(|| source.unreadable(FORMAT, "it holds no frame"))?;
    Ok((header, values))
}

fn binary(source: Source, mut file: impl Read) -> Result<(Header, Vec<f64>), MeasuredError> {
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes).map_err(|error| source.unreadable(FORMAT, error))?;
    let (words, rest) = bytes.as_chunks::<4>();
    let frames = words.get(WORDS.len()..).filter(|_| rest.is_empty());
    let frames =
        frames.ok_or_else(|| source.value("size (bytes)", bytes.len() + 4, "a whole number of words"))?;
    let fields: Fields = WORDS
        .iter()
        .zip(words)
        .map(|(&(name, float), &word)| {
            // the shortest decimal that is stored so: 0.1 is meant, not 0.10000000149
            let decimal = |value: f32| value.to_string().parse().unwrap_or(f64::NAN);
            let value =
                if float { decimal(f32::from_be_bytes(word)) } else { f64::from(i32::from_be_bytes(word)) };
            (name.to_owned(), value)
        })
        .collect();
    let header = Header::of(source, &fields)?;
    let (mut values, mut frame) = (Vec::with_capacity(frames.len()), None);
    for (n, words) in frames.chunks(1 + header.per_frame()).enumerate() {
        let (number, data) = (words[0], &words[1..]);
        follow(source, &mut frame, i64::from(i32::from_be_bytes(number)), &format!("frame {}", n + 1))?;
        values.extend(data.iter().map(|&word| f64::from(f32::from_be_bytes(word))));
    }
    Ok((header, values))
}

impl Header {
    fn of(source: Source, fields: &Fields) -> Result<Self, MeasuredError> {
        let number = |name: &str| {
            fields.get(name).copied().ok_or_else(|| source.value(name, "missing", "a number in the header"))
        };
        let one_of = |name: &str, legal: &[u32]| -> Result<u32, MeasuredError> {
            let value = number(name)?;
            let found = legal.iter().find(|&&legal| f64::from(legal) == value);
            found.copied().ok_or_else(|| {
                let legal: Vec<String> = legal.iter().map(u32::to_string).collect();
                source.value(name, value, legal.join(" or "))
            })
        };
        let count = |name: &str, most: u32| -> Result<u32, MeasuredError> {
            let value = number(name)?;
            let whole = value.fract() == 0.0 && (1.0..=f64::from(most)).contains(&value);
            if whole { Ok(value as u32) } else { Err(source.value(name, value, format!("1 to {most}"))) }
        };
        let positive = |name: &str, scale: f64| -> Result<f64, MeasuredError> {
            let value = number(name)? * scale;
            source.positive(name, value).map(|()| value)
        };
        let doppler = one_of("Modulation_Type_Enum", &[0, 1])? == 0;
        one_of("Chirp_Shape_Enum", &[0])?;
        let parts = match one_of("Data_Format_Enum", &[0, 1, 2])? {
            0 => Parts::Real,
            1 => Parts::Separate,
            _ => Parts::Alternating,
        };
        let (antennas, interleaved) =
            (count("Num_Rx_Antennas", 16)?, one_of("Are_Rx_Antennas_Interleaved", &[0, 1])? == 1);
        if interleaved && antennas > 1 && parts == Parts::Alternating {
            return Err(source.value("Data_Format_Enum", 2, "0 or 1 where the antennas are interleaved"));
        }
        let low = positive("Lower_RF_Frequency_kHz", 1e3)?;
        let bandwidth_hz = number("Upper_RF_Frequency_kHz")? * 1e3 - low;
        let chirps = count("Chirps_per_Frame", 4096)?;
        let sample_rate_hz = positive("Sampling_Frequency_kHz", 1e3)?;
        let samples = count("Samples_per_Chirp", 65_536)?;
        let frame_s = positive("Frame_Period_sec", 1.0)?;
        if !doppler {
            source.positive("Upper_RF_Frequency_kHz less Lower_RF_Frequency_kHz", bandwidth_hz)?;
        }
        // a Doppler module has no chirps: its samples follow one another
        let chirp_s = if doppler {
            f64::from(samples) / sample_rate_hz
        } else if chirps == 1 {
            frame_s
        } else {
            positive("Pulse_Repetition_Time_sec", 1.0)?
        };
        let sensor = Sensor {
            name: "Infineon".to_owned(),
            carrier_hz: if doppler { low + bandwidth_hz / 2.0 } else { low },
            bandwidth_hz: if doppler { 0.0 } else { bandwidth_hz },
            sample_rate_hz,
            samples,
            complex: parts != Parts::Real,
            converter_bits: count("ADC_Resolution_Bits", 16)? as u8,
            antennas,
            chirps,
            transmitters: vec![count("Mask_Tx_Antennas", 255)?],
            chirp_s,
            frame_s,
        };
        let normalised = one_of("Are_ADC_Samples_Normalized", &[0, 1])? == 1;
        Ok(Header { sensor, doppler, interleaved, parts, normalised })
    }

    /// Values of a frame.
    fn per_frame(&self) -> usize {
        let Sensor { antennas, samples, chirps, complex, .. } = self.sensor;
        [antennas, samples, chirps, 1 + u32::from(complex)].map(|n| n as usize).into_iter().product()
    }

    /// Place of a sample's part in its chirp.
    fn place(&self, antenna: usize, sample: usize, part: usize) -> usize {
        let (antennas, samples) = (self.sensor.antennas as usize, self.sensor.samples as usize);
        match (self.interleaved, self.parts) {
            (true, _) => (part * samples + sample) * antennas + antenna,
            (false, Parts::Real) => antenna * samples + sample,
            (false, Parts::Separate) => (2 * antenna + part) * samples + sample,
            (false, Parts::Alternating) => 2 * (antenna * samples + sample) + part,
        }
    }

    fn contents(self, source: Source, stated: &Stated, values: &[f64]) -> Result<Contents, MeasuredError> {
        let (antennas, samples) = (self.sensor.antennas as usize, self.sensor.samples as usize);
        let (parts, per_frame) = (if self.sensor.complex { 2 } else { 1 }, self.per_frame());
        let per_chirp = antennas * samples * parts;
        if !values.len().is_multiple_of(per_frame) || values.is_empty() {
            let legal = format!("a multiple of {per_frame}, those of a frame");
            return Err(source.value("number of values", values.len(), legal));
        }
        let full = f64::from((1_u32 << self.sensor.converter_bits) - 1);
        let (scale, legal) =
            if self.normalised { (full, "0 to 1".to_owned()) } else { (1.0, format!("0 to {full}")) };
        if let Some(value) = values.iter().find(|&&value| !(0.0..=full).contains(&(value * scale))) {
            return Err(source.value("value", value, legal));
        }
        let middle = f64::from(1_u32 << (self.sensor.converter_bits - 1));
        let mut counts = Vec::with_capacity(values.len());
        for chirp in values.chunks_exact(per_chirp) {
            for (antenna, sample) in (0..antennas).flat_map(|a| (0..samples).map(move |s| (a, s))) {
                for part in 0..parts {
                    counts.push(
                        (libm::round(chirp[self.place(antenna, sample, part)] * scale) - middle) as i16,
                    );
                }
            }
        }
        let cube = Cube { values: counts, sensor: self.sensor };
        if self.doppler { doppler(source, stated, cube) } else { cube.contents(source, stated, FORMAT) }
    }
}

/// The samples of one antenna of a Doppler module with frames that follow one another.
fn doppler(source: Source, stated: &Stated, cube: Cube) -> Result<Contents, MeasuredError> {
    let Sensor { chirps, samples, sample_rate_hz, carrier_hz, frame_s, complex, .. } = cube.sensor;
    let filled = f64::from(chirps * samples) / sample_rate_hz;
    if (filled - frame_s).abs() > UNIFORM * frame_s {
        let legal = format!(
            "{filled}, what its samples fill: frames with a pause have no Doppler spectrum over time"
        );
        return Err(source.value("Frame_Period_sec", frame_s, legal));
    }
    if let Some(chirp) = stated.chirp {
        return Err(source.value("--chirp", chirp, "not given: a Doppler module has no chirps"));
    }
    let every = Stated { chirp: Some(Chirps::All), ..stated.clone() };
    let sensor = cube.sensor.clone();
    let Samples::Slots(slots) = cube.contents(source, &every, FORMAT)?.samples else {
        return Err(source.unreadable(FORMAT, "it holds no samples"));
    };
    let values: Vec<f64> = slots.values.into_iter().map(f64::from).collect();
    let shape = if complex { vec![values.len() / 2, 2] } else { vec![values.len()] };
    let mut contents = Array { shape, numbers: Numbers::Real(values) }.contents(source, FORMAT)?;
    contents.about.sensor = Some(sensor);
    (contents.rate_hz, contents.carrier_hz) = (Some(sample_rate_hz), Some(carrier_hz));
    Ok(contents)
}
