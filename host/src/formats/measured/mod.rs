//! Measured signals.

use rustfft::num_complex::Complex;
use sdp3_core::frame::Slot;

/// A measured signal.
#[derive(Debug, Clone)]
pub struct Signal {
    /// The samples.
    pub samples: Samples,
    /// Their rate in Hz.
    pub rate_hz: f64,
    /// Carrier in Hz.
    pub carrier_hz: f64,
    /// What it is called.
    pub title: String,
}

/// Samples.
#[derive(Debug, Clone)]
pub enum Samples {
    /// Real.
    Real(Vec<f64>),
    /// Complex.
    Complex(Vec<Complex<f64>>),
    /// Raw slots.
    Slots(Vec<Slot>),
}

/// What the user states.
#[derive(Debug, Clone, Default)]
pub struct Stated {
    /// Carrier in Hz.
    pub carrier_hz: Option<f64>,
    /// Rate in Hz.
    pub rate_hz: Option<f64>,
    /// Gain in dB to take off.
    pub gain_db: Option<f64>,
    /// Array or dataset in the file.
    pub dataset: Option<String>,
}

/// Reads one.
pub fn read(file: &std::path::Path, stated: &Stated) -> Result<Signal, crate::pipeline::Failure> {
    let wav = super::wav::read(file)?;
    Ok(Signal { samples: Samples::Real(wav.samples), rate_hz: wav.rate_hz, carrier_hz: stated.carrier_hz.unwrap_or(24e9), title: String::new() })
}
