//! Recordings classified, and drawn: class and confidence over time below their spectrograms.

use super::inspect::doppler_over_time;
use crate::error::{Failure, Invalid};
use crate::network::classify::Classify;
use crate::report::classes_over_time::{self, MOST_RECORDINGS, MOST_WINDOWS};
use crate::results::Classified;
use crate::simulator::calibration::slots_without_clutter;
use std::path::PathBuf;

/// Classifies recordings, and draws class and confidence over time below their spectrograms, as SVG.
///
/// # Errors
///
/// As [`Classify::files`]; more recordings or windows than fit a picture.
pub fn picture(request: &Classify, files: &[PathBuf]) -> Result<(Classified, String), Failure> {
    let refuse = |count: usize, most: usize, what: &str| {
        let value = format!("of {count} {what}");
        let unless = Invalid::unless(count <= most, "--picture", value, format!("of at most {most}"));
        unless.map_err(|invalid| invalid.at("command line"))
    };
    refuse(files.len(), MOST_RECORDINGS, "recordings")?;
    let mut spectrograms = Vec::new();
    let found = request.each_file(files, &mut |signal, slots, model| {
        let slow = slots_without_clutter(slots, model.radar()).unwrap_or_default();
        let (real, rate_hz) = (model.radar().one_sided(), signal.slot_rate_hz(slots));
        spectrograms.push(doppler_over_time(&signal.title, slow, real, rate_hz, signal.carrier_hz));
    })?;
    let windows = found.recordings.iter().map(|recording| recording.windows.len()).sum();
    refuse(windows, MOST_WINDOWS, "windows")?;
    let svg = classes_over_time::picture(&found, &spectrograms);
    Ok((found, svg))
}
