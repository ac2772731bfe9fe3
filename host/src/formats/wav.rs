//! Mono WAV recordings of CW Doppler sensors.
//!
//! Integer (8 to 32 bits) and float samples, scaled to -1..=1.

use std::path::{Path, PathBuf};

/// A recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Wav {
    /// Samples in -1..=1.
    pub samples: Vec<f64>,
    /// Sampling rate in Hz.
    pub rate_hz: f64,
}

/// Why a file is not a usable recording.
#[derive(Debug, thiserror::Error)]
pub enum WavError {
    /// It cannot be opened or is not a WAV file.
    #[error("{file}: not a readable WAV file: {source}")]
    NotWav {
        /// The file.
        file: PathBuf,
        /// What the reader says.
        source: hound::Error,
    },
    /// A property is outside what can be used.
    #[error("{file}: {field} = {value} is outside its legal range: {legal}")]
    Value {
        /// The file.
        file: PathBuf,
        /// Channels, sample rate or length.
        field: &'static str,
        /// The value.
        value: String,
        /// The legal range.
        legal: &'static str,
    },
}

/// Reads a mono WAV file of at least 1.5 s at 2 kHz or more.
///
/// # Errors
///
/// [`WavError`] naming the file and what is wrong with it.
pub fn read(file: &Path) -> Result<Wav, WavError> {
    let broken = |source| WavError::NotWav { file: file.to_owned(), source };
    let mut reader = hound::WavReader::open(file).map_err(broken)?;
    let spec = reader.spec();
    let refuse = |field, value: String, legal| WavError::Value { file: file.to_owned(), field, value, legal };
    if spec.channels != 1 {
        return Err(refuse("channels", spec.channels.to_string(), "1 (mono)"));
    }
    let rate_hz = f64::from(spec.sample_rate);
    if !(2_000.0..=400_000.0).contains(&rate_hz) {
        return Err(refuse("sample rate (Hz)", spec.sample_rate.to_string(), "2000..=400000"));
    }
    let samples: Vec<f64> = match spec.sample_format {
        hound::SampleFormat::Float => {
            reader.samples::<f32>().map(|s| s.map(f64::from)).collect::<Result<_, _>>().map_err(broken)?
        }
        hound::SampleFormat::Int => {
            let scale = f64::from(1_u32 << (spec.bits_per_sample - 1));
            let samples = reader.samples::<i32>().map(|s| s.map(|s| f64::from(s) / scale));
            samples.collect::<Result<_, _>>().map_err(broken)?
        }
    };
    if samples.iter().any(|s| !s.is_finite()) {
        return Err(refuse("sample", "NaN or infinite".into(), "finite numbers"));
    }
    let seconds = samples.len() as f64 / rate_hz;
    if seconds < 1.5 {
        return Err(refuse("length (s)", format!("{seconds:.3}"), "at least 1.5"));
    }
    Ok(Wav { samples, rate_hz })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_recording_is_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("noise.wav");
        std::fs::write(&file, b"not a wav at all").unwrap();
        let error = read(&file).unwrap_err().to_string();
        assert!(error.contains("noise.wav") && error.contains("not a readable WAV"), "{error}");
        let spec = hound::WavSpec {
            channels: 1,
            sample_rate: 8000,
            bits_per_sample: 16,
            sample_format: hound::SampleFormat::Int,
        };
        let mut writer = hound::WavWriter::create(&file, spec).unwrap();
        (0..100).for_each(|n| writer.write_sample(n as i16).unwrap());
        writer.finalize().unwrap();
        let error = read(&file).unwrap_err().to_string();
        assert!(error.contains("length (s) = 0.013") && error.contains("at least 1.5"), "{error}");
    }
}
