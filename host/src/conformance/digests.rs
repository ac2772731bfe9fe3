//! Other processors against this one: the digest of every stage of every case must be the same.

use super::compare::{CaseError, play_schedule, run_core};
use super::suite::Suite;
use super::transcript::{StageDigest, Transcript};
use crate::results::{StageVerdict, TargetVerdict};
use rayon::prelude::*;
use sdp3_core::digest::{Digest, DigestProbe};

/// What the core on this machine computes for a suite.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Digests {
    /// Stages of every case.
    pub cases: Vec<Vec<StageDigest>>,
    /// Number of slots and digest of the schedule.
    pub schedule: (u64, u64),
}

/// Digests of every stage on this machine.
///
/// # Errors
///
/// [`CaseError`] if a case cannot be run.
pub fn digests(suite: &Suite) -> Result<Digests, CaseError> {
    let case = |case| {
        let mut probe = DigestProbe::new();
        run_core(case, &mut probe)?;
        Ok(probe.stages().map(|(name, d)| (name.to_owned(), d.count(), d.hash())).collect())
    };
    let cases = suite.cases.par_iter().map(case).collect::<Result<_, _>>()?;
    let mut schedule = Digest::new();
    play_schedule(suite).into_iter().for_each(|slot| schedule.value([slot]));
    Ok(Digests { cases, schedule: (schedule.count(), schedule.hash()) })
}

/// A verdict on a target, and the first case and stage that differ.
pub type Compared = (TargetVerdict, Option<(usize, String)>);

/// Holds a target's digests to this machine's.
pub fn compare(name: &str, here: &Digests, there: &Transcript) -> Compared {
    let mut first = None;
    let mut detail = None;
    let mut stages: Vec<StageVerdict> = Vec::new();
    let mut count = |stage: &str, equal: bool, difference: &dyn Fn() -> String| {
        if !equal {
            detail.get_or_insert_with(|| format!("stage {stage}, {}", difference()));
        }
        let mismatch = u64::from(!equal);
        match stages.iter_mut().find(|s| s.stage == stage) {
            Some(s) => {
                s.compared += 1;
                s.mismatches += mismatch;
            }
            None => stages.push(StageVerdict {
                stage: stage.to_owned(),
                compared: 1,
                mismatches: mismatch,
                rule: "bits".into(),
                largest_error: None,
            }),
        }
    };
    for (index, expected) in here.cases.iter().enumerate() {
        for (position, stage) in expected.iter().enumerate() {
            let found = there.cases.get(index).and_then(|case| case.stages.get(position));
            let equal = found == Some(stage);
            count(&stage.0, equal, &|| match found {
                Some((_, n, digest)) => {
                    format!(
                        "case {index}: expected {} values {:016x}, found {n} values {digest:016x}",
                        stage.1, stage.2
                    )
                }
                None => format!("case {index}: nothing came back"),
            });
            if !equal {
                first.get_or_insert_with(|| (index, stage.0.clone()));
            }
        }
    }
    let (expected, found) = (here.schedule, there.schedule);
    count("schedule", found == expected, &|| format!("one period: expected {expected:x?}, found {found:x?}"));
    let verdict = TargetVerdict {
        name: name.to_owned(),
        compared: stages.iter().map(|s| s.compared).sum(),
        mismatches: stages.iter().map(|s| s.mismatches).sum(),
        instructions: there.cases.iter().map(|case| case.instructions).max(),
        recognitions: Vec::new(),
        detail,
        stages,
    };
    (verdict, first)
}

/// The verdict on a target that could not run: it counts as a mismatch.
pub fn not_run(name: &str, reason: String) -> TargetVerdict {
    TargetVerdict {
        name: name.to_owned(),
        compared: 0,
        mismatches: 1,
        instructions: None,
        recognitions: Vec::new(),
        detail: Some(format!("not run: {reason}")),
        stages: Vec::new(),
    }
}
