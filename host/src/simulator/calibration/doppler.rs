//! Doppler over time of a whole recording, to be drawn.

use super::comparison::slow_time;
use super::conditioning::remove_mean;
use super::intensity::Intensity;
use crate::error::Invalid;
use crate::recordings::Signal;
use crate::results::Spectrogram;
use crate::scenario::Radar;
use crate::simulator::channel::Complex64;

/// Most columns of a picture.
pub const COLUMNS: usize = 800;
/// Samples of its windows, and their least distance.
pub const WINDOW: usize = 128;
const HOP: usize = 8;

/// The spectrogram of a measured signal, raw slots as this radar's module receives them.
///
/// # Errors
///
/// Slots of another radar.
pub fn of_signal(title: &str, signal: &Signal, radar: &Radar) -> Result<Spectrogram, Invalid> {
    let slow = slow_time(signal, radar)?;
    Ok(of_cells(title, vec![slow.signal], slow.rate_hz, slow.real, signal.carrier_hz))
}

/// The spectrogram of the slow time of range cells, each without its mean, of as many columns as are drawn.
pub fn of_cells(
    title: &str,
    mut cells: Vec<Vec<Complex64>>,
    rate_hz: f64,
    real: bool,
    carrier_hz: f64,
) -> Spectrogram {
    cells.iter_mut().for_each(|slow| remove_mean(slow));
    let length = cells.first().map_or(0, Vec::len);
    let intensity = Intensity::new(WINDOW.min(length), HOP.max(length / COLUMNS));
    let decibels = intensity.mean_decibels(cells.iter().map(Vec::as_slice), real);
    intensity.picture(title, &decibels, real, rate_hz, carrier_hz)
}
