//! Labelled recordings of raw slots, read to the beats that networks learn from.

use super::Job;
use crate::error::{Failure, Invalid};
use crate::recordings::labels::{self, Held, Labelled};
use crate::recordings::{self, Expected, Stated};
use sdp3_core::dims::Beat;
use std::path::Path;

/// A recording's beats and label.
pub struct Recording {
    pub name: String,
    pub class: String,
    pub person: Option<String>,
    pub label: u8,
    pub fold: usize,
    pub beats: Vec<Beat>,
}

impl Job {
    /// The labelled recordings of a folder; those without a class are noted.
    ///
    /// # Errors
    ///
    /// A folder or table that cannot be read; no labelled recording.
    pub fn labelled(&self, folder: &Path) -> Result<Vec<Labelled>, Failure> {
        let (labelled, left_out) = labels::read(folder)?;
        for path in left_out {
            self.progress.note("read", &format!("left out, it has no class: {}", path.display()));
        }
        Ok(labelled)
    }

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
        // slots in memory are the scenario's where nothing else is stated
        let of_scenario = Stated {
            rate_hz: stated.rate_hz.or(Some(1.0 / self.scenario.interval_s())),
            carrier_hz: stated.carrier_hz.or(Some(expected.carrier_hz)),
            ..stated.clone()
        };
        let longest = self.scenario.largest_sensing_slots() as usize;
        let stage = self.progress.stage("read", "recordings");
        let (total, mut found) = (labelled.len() as u64, Vec::new());
        for (labelled, &fold) in labelled.into_iter().zip(folds) {
            let Labelled { name, held, class, person, span_s } = labelled;
            let (signal, origin) = match held {
                Held::File(path) => (recordings::open(&path, stated)?, path.display().to_string()),
                Held::Slots(slots) => (recordings::raw_slots(&name, slots, &of_scenario)?, name.clone()),
            };
            let refuse = |invalid: Invalid| invalid.at(&origin);
            let slots = expected.slots(&signal, longest).map_err(refuse)?;
            let mut beats = slots.beats(radar).ok_or("a radar that the core refuses")?;
            if let Some((from_s, to_s)) = span_s {
                let slot_rate_hz = signal.slot_rate_hz(&slots);
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
            let label = classes.iter().position(|known| *known == class).unwrap_or(0) as u8;
            found.push(Recording { name, class, person, label, fold, beats });
            stage.step(total);
        }
        stage.finish(&format!("{total} recordings of {} classes", classes.len()));
        Ok(found)
    }
}
