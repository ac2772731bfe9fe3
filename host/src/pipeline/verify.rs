//! Verify: the core against its reference on this machine, and the firmware under an emulator against the core.

use super::Job;
use crate::conformance::compare::verify_host;
use crate::conformance::digests::not_run;
use crate::conformance::qemu;
use crate::conformance::suite::{Case, ScheduleCase, Suite, Transform, stimuli};
use crate::conformance::verification::Verification;
use crate::error::Failure;
use crate::formats::slots::Slots;
use crate::results::{OperatingPoint, Verify};
use crate::scenario::Class;
use crate::simulator::dataset::{Set, recording};
use sdp3_core::dsn::Model;
use std::path::PathBuf;
use std::time::Duration;

/// The target that needs no emulator: the core against its reference on this machine. The others are [`qemu::MACHINES`].
pub const REFERENCE: &str = "host-reference";
/// The targets unless others are named: the reference, a processor with an FPU and one without.
pub const TARGETS: [&str; 3] = [REFERENCE, "cortex-m4f", "riscv32imac"];

/// What is compared.
#[derive(Debug, Clone)]
pub struct Targets {
    /// [`REFERENCE`] and names of [`qemu::MACHINES`].
    pub names: Vec<String>,
    /// Folder of ready-built firmware; `None`: it is built.
    pub firmware: Option<PathBuf>,
}

fn schedule_case(p: &OperatingPoint) -> ScheduleCase {
    ScheduleCase {
        period: p.period_slots,
        spacing: p.spacing_slots,
        sensing: p.sensing_slots,
        shares: p.communication_slots.clone(),
    }
}

impl Job {
    /// Compares on the models and the operating point of the run in the output folder.
    ///
    /// # Errors
    ///
    /// A run that is not there, or of another scenario or seed than those given.
    pub fn verify_run(self, targets: &Targets) -> Result<Verify, Failure> {
        let run = self.run()?;
        let (scenario, seed) = (self.run_scenario()?, self.seed_of(run.seed, super::stored::RUN)?);
        let job = Job { scenario, seed, ..self };
        job.verify(run.rho, &job.models(super::stored::RUN_FIRST)?, &run.operating_point, targets)
    }

    /// Compares the core with the reference and the firmware with the core, on these models and this operating point.
    ///
    /// # Errors
    ///
    /// A suite that cannot be run at all; a target that cannot run counts as a mismatch instead.
    pub(super) fn verify(
        &self,
        rho: f64,
        models: &[Vec<u8>],
        point: &OperatingPoint,
        targets: &Targets,
    ) -> Result<Verify, Failure> {
        let suite = &self.suite(rho, models, schedule_case(point))?;
        let mut verdicts = Vec::new();
        let wanted = |name: &str| targets.names.iter().any(|target| target == name);
        if wanted(REFERENCE) {
            let stage = self.progress.stage("verify", "the core against the reference");
            let verdict = verify_host(suite)?;
            stage.finish(&format!("{} values, {} mismatches", verdict.compared, verdict.mismatches));
            verdicts.push(verdict);
        }
        let names: Vec<&str> = qemu::MACHINES.into_iter().filter(|name| wanted(name)).collect();
        if !names.is_empty() {
            let folder = qemu::folder(targets.firmware.as_deref());
            let built = match targets.firmware {
                Some(_) => Ok(()),
                None => qemu::build(&folder, "conformance", &names, &mut |line| {
                    self.progress.note("verify", line)
                }),
            };
            let stage = self.progress.stage("verify", "firmware under QEMU");
            let found = match built {
                Err(error) => names.iter().map(|name| not_run(name, error.to_string())).collect(),
                Ok(()) => {
                    let machines = qemu::machines(&folder, "conformance");
                    let machines: Vec<_> = machines.into_iter().filter(|m| wanted(m.name)).collect();
                    let verification =
                        Verification::new(suite, self.output.folder(), Duration::from_secs(240))?;
                    verification.firmware(&machines, &|_| ())?
                }
            };
            let words: Vec<String> =
                found.iter().map(|v| format!("{} {}/{} differ", v.name, v.mismatches, v.compared)).collect();
            stage.finish(&words.join(", "));
            verdicts.extend(found);
        }
        Ok(Verify {
            compared: verdicts.iter().map(|v| v.compared).sum(),
            mismatches: verdicts.iter().map(|v| v.mismatches).sum(),
            targets: verdicts,
        })
    }
    /// The suite for these models: one recording of every class for the largest, one for each other, and stimuli.
    fn suite(&self, rho: f64, models: &[Vec<u8>], schedule: ScheduleCase) -> Result<Suite, Failure> {
        let mut cases = Vec::new();
        for (index, bytes) in models.iter().enumerate() {
            let model = Model::parse(bytes).map_err(|e| format!("model {index}: {e}"))?;
            let slots = model.sensing_slots();
            let take = |class: Class, n: u32| -> Slots {
                recording(&self.scenario, rho, self.seed, Set::Demo, class, n, slots as u32).slots
            };
            let largest = index + 1 == models.len();
            let classes = if largest { &Class::ALL[..] } else { &Class::ALL[index % 5..=index % 5] };
            cases.extend(classes.iter().map(|&class| Case {
                name: format!("{} N_s={slots}", class.name()),
                model: bytes.clone(),
                transform: Transform::Fixed, // a microcontroller's
                slots: take(class, 2),
            }));
            if index == 0 {
                cases.extend(stimuli(bytes, slots, self.seed));
            }
        }
        Ok(Suite { cases, schedule })
    }
}
