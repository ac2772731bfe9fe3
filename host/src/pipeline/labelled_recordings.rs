//! Labelled recordings of raw slots, read to the beats that networks learn from.

use super::Job;
use crate::error::{Failure, Invalid};
use crate::recordings::labels::Labelled;
use crate::recordings::{self, Expected, Stated};
use sdp3_core::dims::Beat;

/// A recording's beats and label.
pub struct Recording {
    pub labelled: Labelled,
    pub label: u8,
    pub fold: usize,
    pub beats: Vec<Beat>,
}

impl Job {
    /// The recordings' beats, of the scenario's radar and at least the longest window long.
    ///
    /// # Errors
    ///
    /// A recording that cannot be read, of another radar or too short; a part beyond its end.
    pub(super) fn read_recordings(
        &self,
        labelled: Vec<Labelled>,
        folds: &[usize],
        classes: &[String],
        stated: &Stated,
    ) -> Result<Vec<Recording>, Failure> {
        let radar = self.scenario.radar.config();
        let expected = Expected {
            owner: "the scenario's",
            radar,
            interval_us: 1e6 * self.scenario.interval_s(),
            carrier_hz: self.scenario.radar.carrier_hz,
        };
        let longest = self.scenario.largest_sensing_slots() as usize;
        let stage = self.progress.stage("read", "recordings");
        let (total, mut found) = (labelled.len() as u64, Vec::new());
        for (labelled, &fold) in labelled.into_iter().zip(folds) {
            let refuse = |invalid: Invalid| invalid.at(labelled.path.display());
            let signal = recordings::open(&labelled.path, stated)?;
            let slots = expected.slots(&signal, longest).map_err(refuse)?;
            let mut beats = slots.beats(radar).ok_or("a radar that the core refuses")?;
            if let Some((from_s, to_s)) = labelled.span_s {
                // of a Doppler sensor the slots are fewer than the samples
                let slot_rate_hz = signal.rate_hz * slots.len() as f64 / signal.samples.len() as f64;
                let slot = |t: f64| (t * slot_rate_hz).round() as usize;
                let (first, end) = (slot(from_s), slot(to_s));
                let length = signal.samples.len() as f64 / signal.rate_hz;
                Invalid::unless(end <= beats.len(), "to_s", to_s, format!("at most {length:.3}, its length"))
                    .map_err(refuse)?;
                let legal = format!("at least {longest}, the longest window");
                Invalid::unless(end - first >= longest, "slots from from_s to to_s", end - first, legal)
                    .map_err(refuse)?;
                beats = beats[first..end].to_vec();
            }
            let label = classes.iter().position(|class| *class == labelled.class).unwrap_or(0) as u8;
            found.push(Recording { labelled, label, fold, beats });
            stage.step(total);
        }
        stage.finish(&format!("{total} recordings of {} classes", classes.len()));
        Ok(found)
    }
}
