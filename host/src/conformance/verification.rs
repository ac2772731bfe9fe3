//! One suite through many machines: run, compare, and where one differs, find the first value that does.

use super::compare::CaseError;
use super::digests::{Digests, compare, digests, not_run};
use super::locate::{first_difference, values};
use super::qemu::{Firmware, QemuError, run};
use super::suite::Suite;
use super::transcript::{Transcript, parse};
use crate::results::{Counted, TargetVerdict};
use rayon::prelude::*;
use sdp3_core::values::Stage;
use std::collections::BTreeMap;
use std::path::Path;
use std::time::Duration;

/// Firmware to be held to this machine.
#[derive(Debug)]
pub struct Verification<'a> {
    suite: &'a Suite,
    here: Digests,
    /// Files for the emulators lie here; their names begin with this process's number.
    folder: &'a Path,
    limit: Duration,
}

impl<'a> Verification<'a> {
    /// Computes what this machine makes of the suite. An emulator gets `limit` for it.
    ///
    /// # Errors
    ///
    /// [`CaseError`] if a case cannot be run.
    pub fn new(suite: &'a Suite, folder: &'a Path, limit: Duration) -> Result<Self, CaseError> {
        Ok(Verification { suite, here: digests(suite)?, folder, limit })
    }

    /// The verdict on every machine, in their order; `done` is called with each.
    ///
    /// # Errors
    ///
    /// If the suite's file cannot be written; a machine that cannot run is a verdict, not an error.
    pub fn firmware(
        &self,
        machines: &[Firmware],
        done: &(dyn Fn(&TargetVerdict) + Sync),
    ) -> std::io::Result<Vec<TargetVerdict>> {
        let name = file_name("conformance.sdps");
        let file = self.folder.join(&name);
        std::fs::write(&file, self.suite.to_bytes())?;
        let verdict = |machine: &Firmware| {
            let verdict = match self.transcript(machine, std::slice::from_ref(&name)) {
                Ok(transcript) => self.judge(machine, &transcript),
                Err(error) => not_run(machine.name, error.to_string()),
            };
            done(&verdict);
            verdict
        };
        let verdicts = machines.par_iter().map(verdict).collect();
        std::fs::remove_file(&file)?;
        Ok(verdicts)
    }

    fn transcript(&self, machine: &Firmware, arguments: &[String]) -> Result<Transcript, QemuError> {
        let text = run(machine, self.folder, arguments, self.limit)?;
        parse(&text).map_err(|error| QemuError::Output { name: machine.name, reason: error.to_string() })
    }

    fn judge(&self, machine: &Firmware, transcript: &Transcript) -> TargetVerdict {
        let (mut verdict, first) = compare(machine.name, &self.here, transcript);
        verdict.recognitions = self.recognitions(transcript);
        let Some((index, stage)) = first else { return verdict };
        let Some((case, stage)) = self.suite.cases.get(index).zip(Stage::named(&stage)) else {
            return verdict;
        };
        let place =
            self.locate(machine, index, stage).unwrap_or_else(|reason| format!("not located: {reason}"));
        verdict.detail = Some(format!("stage {}, case {index} ({}), {place}", stage.name(), case.name));
        verdict
    }

    /// The costliest recognition for each N_s.
    fn recognitions(&self, transcript: &Transcript) -> Vec<Counted> {
        let mut most = BTreeMap::new();
        for (case, report) in self.suite.cases.iter().zip(&transcript.cases) {
            let count = most.entry(case.slots.len() as u32).or_insert(0);
            *count = report.instructions.max(*count);
        }
        most.into_iter()
            .map(|(sensing_slots, instructions)| Counted { sensing_slots, instructions })
            .collect()
    }

    /// The first value of a stage that differs.
    fn locate(&self, machine: &Firmware, index: usize, stage: Stage) -> Result<String, String> {
        let case = self.suite.cases.get(index).ok_or("no such case")?;
        let expected = values(case, stage).map_err(|error| error.to_string())?;
        let (suite, dumped) = (file_name(machine.name), file_name(&format!("{}.values", machine.name)));
        let (file, dump) = (self.folder.join(&suite), self.folder.join(&dumped));
        let alone = Suite { cases: vec![case.clone()], schedule: self.suite.schedule.clone() };
        std::fs::write(&file, alone.to_bytes()).map_err(|error| error.to_string())?;
        let arguments = [suite, format!("dump={}:{dumped}", stage.name())];
        let found = self
            .transcript(machine, &arguments)
            .map_err(|error| error.to_string())
            .and_then(|_| std::fs::read(&dump).map_err(|error| error.to_string()));
        let _ = std::fs::remove_file(&file);
        let _ = std::fs::remove_file(&dump);
        first_difference(stage, &expected, &found?).ok_or_else(|| "alone, the case agrees".to_owned())
    }
}

/// Name of a file for the emulators.
fn file_name(what: &str) -> String {
    format!("{}-{what}", std::process::id())
}
