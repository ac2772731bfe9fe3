//! Point targets: the person of a recording as tables, one for every class, and what describes them.

use super::{Job, budget};
use crate::dataset::PER_CLASS;
use crate::error::{Failure, Invalid};
use crate::scenario::Class;
use crate::simulator::dataset::{Set, target_of};
use crate::simulator::targets::{PARTS, PointTargetFile, PointTargets, write_table};
use std::ops::RangeInclusive;

/// Legal seconds between two instants, and seconds in all; a walk is drawn for the latter.
const EVERY_S: RangeInclusive<f64> = 1e-5..=100.0;
const DURATION_S: RangeInclusive<f64> = 1e-5..=120.0;

/// Legal numbers of a recording within its class.
pub const INDEX: RangeInclusive<u32> = 0..=*PER_CLASS.end() - 1;

/// Point targets to write.
#[derive(Debug, Clone)]
pub struct Targets {
    /// Absent: the paper's five.
    pub classes: Option<Vec<Class>>,
    /// Number of the recording within its class, within [`INDEX`].
    pub index: u32,
    /// Seconds between two instants; absent: from one sensing slot to the next.
    pub every_s: Option<f64>,
    /// Seconds in all; absent: those of a recording.
    pub duration_s: Option<f64>,
}

impl Job {
    /// Writes `targets-CLASS.csv` of every class, and `targets.json`, which describes them.
    ///
    /// # Errors
    ///
    /// An illegal option, more rows than the budget allows, a folder that cannot be written.
    pub fn targets(&self, asked: Targets) -> Result<PointTargets, Failure> {
        let Targets { classes, index, every_s, duration_s } = asked;
        let s = &self.scenario;
        let legal = |name: &str, value: Option<f64>, range: RangeInclusive<f64>| match value {
            Some(value) if !range.contains(&value) => {
                Err(Invalid::option(name, value, format!("{} to {} s", range.start(), range.end())))
            }
            _ => Ok(()),
        };
        legal("--every-s", every_s, EVERY_S)?;
        legal("--duration-s", duration_s, DURATION_S)?;
        let every_s = every_s.unwrap_or(s.interval_s());
        let duration_s = duration_s.unwrap_or(f64::from(s.largest_sensing_slots()) * s.interval_s());
        // a whole number of intervals may differ from one by rounding
        let instants = (duration_s / every_s - 1e-6).ceil().max(1.0) as u64;
        let mut once: Vec<Class> = Vec::new();
        for class in classes.unwrap_or_else(|| Class::ALL.to_vec()) {
            if !once.contains(&class) {
                once.push(class);
            }
        }
        let classes = once;
        budget::targets(self.budget, duration_s, every_s, instants * classes.len() as u64)?;
        let stage = self.progress.stage("targets", "point targets");
        self.record("targets")?;
        let mut files = Vec::new();
        for (done, class) in classes.iter().enumerate() {
            let target = target_of(s, self.seed, Set::Train, *class, index);
            let file = format!("targets-{}.csv", class.name());
            self.output.fill(&file, |to| write_table(to, s, &target, every_s, instants))?;
            files.push(PointTargetFile { file, person: target.person.truth });
            stage.at(done as u64 + 1, classes.len() as u64);
        }
        let written = PointTargets {
            radar_m: s.radar.position_m,
            carrier_hz: s.radar.carrier_hz,
            centre_hz: s.radar.centre_hz(),
            index,
            every_s,
            instants,
            parts: PARTS,
            files,
        };
        self.output.write_result("targets.json", &written)?;
        let folder = self.output.folder().display();
        stage.finish(&format!("{} files of {instants} instants in {folder}", written.files.len()));
        Ok(written)
    }
}
