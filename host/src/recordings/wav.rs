//! WAV recordings: mono of a CW Doppler sensor, or two channels, I and Q.
//!
//! Integer (8 to 32 bits) and 32-bit float samples, scaled to -1 to 1.

use super::{Contents, MeasuredError, Samples, Source};
use crate::results::About;
use crate::store::limited;
use rustfft::num_complex::Complex64;
use std::io::BufReader;

pub(super) fn read(source: Source) -> Result<Contents, MeasuredError> {
    let broken = |error| source.unreadable("WAV", error);
    let file = limited::open(source.0, limited::WHOLE).map_err(|error| broken(error.into()))?;
    let mut reader = hound::WavReader::new(BufReader::new(file)).map_err(broken)?;
    let spec = reader.spec();
    source.fits("samples", reader.len(), u64::from(reader.len()))?;
    if !(1..=2).contains(&spec.channels) {
        return Err(source.value("channels", spec.channels, "1 (real) or 2 (I and Q)"));
    }
    let samples: Vec<f64> = match spec.sample_format {
        hound::SampleFormat::Float => {
            reader.samples::<f32>().map(|s| s.map(f64::from)).collect::<Result<_, _>>().map_err(broken)?
        }
        hound::SampleFormat::Int => {
            let scale = libm::exp2(f64::from(spec.bits_per_sample) - 1.0);
            let samples = reader.samples::<i32>().map(|s| s.map(|s| f64::from(s) / scale));
            samples.collect::<Result<_, _>>().map_err(broken)?
        }
    };
    let (axes, shape) = match spec.channels {
        1 => ("[time], real", vec![samples.len()]),
        _ => ("[time], complex", vec![samples.len() / 2]),
    };
    let samples = match spec.channels {
        1 => Samples::Real(samples),
        _ => {
            Samples::Complex(samples.as_chunks::<2>().0.iter().map(|&[i, q]| Complex64::new(i, q)).collect())
        }
    };
    let about = About::new("WAV", axes, shape);
    Ok(Contents { samples, rate_hz: Some(f64::from(spec.sample_rate)), carrier_hz: None, about })
}
