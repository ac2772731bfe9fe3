//! `schedule --faults`: the core's guards against faults on purpose.

use super::models;
use crate::cli::context::Context;
use crate::cli::simulator::rho;
use sdp3::conformance::faults::{guards, recordings, spoiled};
use sdp3::pipeline::{Failure, Job};
use sdp3::results::{FaultTable, Faults};
use std::fmt::Write;

/// Faults by themselves for one disturbed recording.
const RECORDING: u64 = 1000;

pub fn faults(context: &Context, mut job: Job, events: u64, per_class: u32) -> Result<bool, Failure> {
    job.scenario = context.trained(&job)?;
    let files = models(&job)?;
    let model = files.first().ok_or("frame.sensing_slots is empty: no model")?;
    let stage = job.progress.stage("faults", "on purpose");
    let (guards, guarded) = guards(job.seed, events, model, &|all| stage.step(all));
    stage.finish(&format!("{events} faults on purpose"));
    let stage = job.progress.stage("faults", "disturbed recordings");
    let disturbed = events.div_ceil(RECORDING);
    let (recordings, recorded) = recordings(job.seed, disturbed, model, &|all| stage.step(all))?;
    stage.finish(&format!("{disturbed} disturbed recordings"));
    let stage = job.progress.stage("faults", "spoiled samples");
    let rho = rho(&job.scenario);
    let (accuracy, spoiled) =
        spoiled::cost(&job.scenario, rho, job.seed, model, per_class, &|all| stage.step(all))?;
    stage.finish(&format!("spoiled samples in {per_class} recordings of each class"));
    let found = Faults { seed: job.seed, guards, recordings, accuracy, spoiled, held: guarded && recorded };
    job.output.write_json("faults.json", &found)?;
    context.print(&found, || words(&found))?;
    Ok(found.held)
}

fn table(text: &mut String, name: &str, seed: u64, found: &FaultTable) {
    let _ = writeln!(
        text,
        "{name:<30}{:>12}{:>12}{:>12}{:>10}{:>8}",
        "injected", "detected", "recovered", "silent", "broken"
    );
    for r in &found.rows {
        let _ = writeln!(
            text,
            "{:<30}{:>12}{:>12}{:>12}{:>10}{:>8}",
            r.kind, r.injected, r.detected, r.recovered, r.silent, r.broken
        );
    }
    let _ = writeln!(
        text,
        "digest of the first {} from seed {seed}: {}\n",
        found.events_of_part, found.digest_of_part
    );
}

fn words(found: &Faults) -> String {
    let mut text = String::new();
    table(&mut text, "fault", found.seed, &found.guards);
    table(&mut text, "recording disturbed by", found.seed, &found.recordings);
    let _ = writeln!(
        text,
        "untouched recordings recognised: {:.3}\n{:<12}{:>12}{:>14}{:>10}{:>12}{:>10}{:>16}",
        found.accuracy,
        "spoiled",
        "recordings",
        "slots spoiled",
        "refused",
        "unguarded",
        "guarded",
        "without verdict"
    );
    for r in &found.spoiled {
        let _ = writeln!(
            text,
            "{:<12}{:>12}{:>14.4}{:>10.3}{:>12.3}{:>10.3}{:>16.3}",
            r.kind, r.recordings, r.slots, r.refused, r.unguarded, r.guarded, r.without_verdict
        );
    }
    text += if found.held { "nothing certain was silent, every promise held" } else { "NOT HELD" };
    text
}
